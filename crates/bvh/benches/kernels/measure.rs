//! Building, timing and comparing.

use crate::embree::{self, Build, Embree, Scene, Shared};
use crate::meshes::Mesh;
use crate::ours;
use crate::rays::Kind;
use penombre_bvh::{Bvh, Hit, Ray};
use std::time::Instant;

/// Builds of each kind; their median counts.
const BUILDS: usize = 3;
/// Distances that differ by a smaller share are equal.
const TOLERANCE: f32 = 1e-5;

/// Something that answers rays.
pub trait Kernel {
    /// The closest hit of each ray.
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]);
    /// Whether each ray hits anything.
    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]);
}

/// Build times in seconds and memory in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildFigures {
    /// Ours: fast. Embree's: medium.
    pub quick: f64,
    /// Ours and Embree's: high.
    pub high: f64,
    /// Ours: the high build's. Embree's: the smaller of the medium and the high build's.
    pub bytes: usize,
}

/// Embree's scenes of one mesh.
pub struct Scenes<'a> {
    robust: Scene<'a>,
    medium: Scene<'a>,
    high: Scene<'a>,
}

/// Embree's scenes and how they were built.
pub struct Theirs<'a> {
    pub scenes: Scenes<'a>,
    pub build: BuildFigures,
}

/// Builds our hierarchy in both ways; rays go to the one of high quality.
pub fn build_ours(mesh: &Mesh) -> Result<(Bvh, BuildFigures), String> {
    let geometry = mesh.geometry();
    let timed = |build: fn(_) -> Result<Bvh, String>| {
        let geometry = geometry.clone();
        let start = Instant::now();
        build(geometry).map(|bvh| (start.elapsed().as_secs_f64(), bvh))
    };
    let (mut fast, mut high, mut last) = (Vec::new(), Vec::new(), None);
    for _ in 0..BUILDS {
        fast.push(timed(ours::build_fast)?.0);
        last = None;
        let (seconds, bvh) = timed(ours::build_high)?;
        high.push(seconds);
        last.replace(bvh);
    }
    let bvh = last.ok_or("no build")?;
    let figures = BuildFigures { quick: median(fast), high: median(high), bytes: bvh.stats().bytes };
    Ok((bvh, figures))
}

/// Builds Embree's scenes.
pub fn build_embree<'a>(embree: &'a Embree, mesh: &Mesh) -> Result<Theirs<'a>, String> {
    let shared = Shared::new(mesh);
    let several = |how| -> Result<(f64, Scene<'a>), String> {
        let mut seconds = Vec::new();
        for _ in 1..BUILDS {
            seconds.push(embree.build(&shared, how)?.seconds);
        }
        let last = embree.build(&shared, how)?;
        seconds.push(last.seconds);
        Ok((median(seconds), last))
    };
    let (quick, medium) = several(Build::Medium)?;
    let (seconds, high) = several(Build::High)?;
    let robust = embree.build(&shared, Build::Robust)?;
    let bytes = medium.bytes.min(high.bytes);
    Ok(Theirs {
        scenes: Scenes { robust, medium, high },
        build: BuildFigures { quick, high: seconds, bytes },
    })
}

/// Rates in Mrays/s of one mesh and kind.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    /// Rays traced.
    pub rays: usize,
    /// Ours, one ray a call.
    pub one: f64,
    /// Ours, many rays a call.
    pub batch: f64,
    /// Rays on which our two calls differ; none should.
    pub inconsistent: usize,
    /// Embree's.
    pub embree: Option<Peer>,
}

/// Embree's rates in Mrays/s and ours in proportion.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    /// Watertight, one ray a call.
    pub robust: f64,
    /// The faster of high and medium, one ray a call.
    pub best_one: f64,
    /// The faster of high and medium, 16 rays a call.
    pub best_16: f64,
    /// The same where Embree is told that neighbouring rays go the same way: for primary rays alone, 0 otherwise.
    pub coherent_16: f64,
    /// In the order of [`crate::report::RATIOS`].
    pub ratios: [f64; 4],
    /// Rays on which our hit is not that of the robust scene.
    pub differing: Difference,
}

/// Rays on which two kernels differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// One hits, the other misses.
    pub hit_or_miss: usize,
    /// Both hit, at different distances.
    pub distance: usize,
}

impl Difference {
    /// All of them.
    pub fn total(self) -> usize {
        self.hit_or_miss + self.distance
    }
}

/// Seconds of one repetition: ours one, batch; Embree's robust, best of one ray, best of 16, best of 16 coherent ones.
type Times = [f64; 6];

/// Measures all kernels on the same rays.
pub fn rays(ours: &Bvh, scenes: Option<&Scenes<'_>>, kind: Kind, rays: &[Ray], reps: usize) -> Rates {
    let (one, batch) = (ours::One(ours), ours::Batch(ours));
    let mut kernels: Vec<Box<dyn Kernel + '_>> = vec![Box::new(one), Box::new(batch)];
    if let Some(s) = scenes {
        kernels.push(Box::new(embree::One(&s.robust)));
        kernels.extend([&s.high, &s.medium].map(|s| Box::new(embree::One(s)) as Box<dyn Kernel>));
        let sixteen = |coherent| {
            [&s.high, &s.medium].map(|s| Box::new(embree::Sixteen::new(s, coherent)) as Box<dyn Kernel>)
        };
        kernels.extend(sixteen(false));
        kernels.extend((kind == Kind::Primary).then(|| sixteen(true)).into_iter().flatten());
    }
    let mut answers = Answers::new(rays.len());
    let reference = answers.of(&*kernels[0], kind, rays);
    let inconsistent = answers.of(&*kernels[1], kind, rays).differing(&reference, 0.0).total();
    let robust = kernels.get(2).map(|k| answers.of(&**k, kind, rays));
    kernels.iter().skip(3).for_each(|k| answers.fill(&**k, kind, rays));
    let times: Vec<Times> =
        (0..reps).map(|rep| repetition(&kernels, kind, rays, &mut answers, rep)).collect();
    let rate = |i: usize| median(times.iter().map(|t| rays.len() as f64 / t[i] * 1e-6).collect());
    let ratio = |(ours, theirs): (usize, usize)| median(times.iter().map(|t| t[theirs] / t[ours]).collect());
    let embree = robust.map(|robust| Peer {
        robust: rate(2),
        best_one: rate(3),
        best_16: rate(4),
        coherent_16: rate(5),
        ratios: [(0, 2), (0, 3), (1, 3), (1, 4)].map(ratio),
        differing: reference.differing(&robust, TOLERANCE),
    });
    Rates { rays: rays.len(), one: rate(0), batch: rate(1), inconsistent, embree }
}

/// Times every kernel once. Each repetition starts with another one.
fn repetition(
    kernels: &[Box<dyn Kernel + '_>],
    kind: Kind,
    rays: &[Ray],
    answers: &mut Answers,
    rep: usize,
) -> Times {
    let mut seconds = [f64::INFINITY; 9];
    for i in (0..kernels.len()).map(|i| (i + rep) % kernels.len()) {
        let start = thread_seconds();
        answers.fill(&*kernels[i], kind, rays);
        seconds[i] = (thread_seconds() - start).max(1e-9);
    }
    let [one, batch, robust, high, medium, high_16, medium_16, high_coherent, medium_coherent] = seconds;
    let best_coherent = high_coherent.min(medium_coherent);
    [one, batch, robust, high.min(medium), high_16.min(medium_16), best_coherent]
}

/// Places for the answers to one buffer of rays.
#[derive(Clone)]
struct Answers {
    hits: Vec<Hit>,
    blocked: Vec<bool>,
}

impl Answers {
    fn new(rays: usize) -> Self {
        Self { hits: vec![Hit::MISS; rays], blocked: vec![false; rays] }
    }

    fn fill(&mut self, kernel: &dyn Kernel, kind: Kind, rays: &[Ray]) {
        match kind {
            Kind::Primary | Kind::Bounce => kernel.closest(rays, &mut self.hits),
            Kind::Shadow => kernel.occluded(rays, &mut self.blocked),
        }
    }

    fn of(&mut self, kernel: &dyn Kernel, kind: Kind, rays: &[Ray]) -> Self {
        self.fill(kernel, kind, rays);
        self.clone()
    }

    fn differing(&self, other: &Self, tolerance: f32) -> Difference {
        let hits = || self.hits.iter().zip(&other.hits);
        let missing = hits().filter(|(a, b)| a.is_hit() != b.is_hit()).count();
        let blocked = self.blocked.iter().zip(&other.blocked).filter(|(a, b)| a != b).count();
        let far = |a: f32, b: f32| (a - b).abs() > tolerance * a.abs().max(b.abs());
        let distance = hits().filter(|(a, b)| a.is_hit() && b.is_hit() && far(a.t, b.t)).count();
        Difference { hit_or_miss: missing + blocked, distance }
    }
}

/// Middle value; the mean of the two middle ones of an even number.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { (values[(n - 1) / 2] + values[n / 2]) * 0.5 }
}

/// Processor time of this thread.
#[cfg(unix)]
pub fn thread_seconds() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the clock is one that POSIX names, and `time` is writable memory of the type it fills.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Wall time, where the system has no clock for a thread.
#[cfg(not(unix))]
pub fn thread_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}
