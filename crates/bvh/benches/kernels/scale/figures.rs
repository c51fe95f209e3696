//! Building and timing at one size.

use super::memory;
use crate::embree::{self, Build, Embree, Scene, Shared};
use crate::measure::{Kernel, median, thread_seconds};
use crate::meshes::Mesh;
use crate::ours::{Batch, One};
use crate::rays::{Kind, Rays};
use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Quality, Ray};

/// A build of one quality.
#[derive(Clone, Copy, Debug)]
pub struct Built {
    /// Wall time, all threads.
    pub seconds: f64,
    /// The most memory that the process used meanwhile, the mesh and our copy of it included.
    pub peak: Option<u64>,
}

/// Nanoseconds a ray on one thread.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub kind: Kind,
    /// Ours, one ray a call.
    pub one: f64,
    /// Ours, many rays a call.
    pub batch: f64,
    /// Embree's fastest one-ray call.
    pub embree: Option<f64>,
}

/// Embree's build times in seconds.
#[derive(Clone, Copy, Debug)]
pub struct EmbreeBuilt {
    pub medium: f64,
    pub high: f64,
    /// Of the high build, by Embree's own count.
    pub bytes: usize,
}

/// Builds several times if that is soon done; the last hierarchy and the median of the times.
pub fn build(geometries: &[Geometry], quality: Quality, times: usize) -> Result<(Bvh, Built), String> {
    let options = BuildOptions::with_quality(quality);
    let once = || Bvh::build(geometries.to_vec(), &options).map_err(|e| e.to_string());
    let mut seconds = Vec::new();
    for _ in 1..times {
        seconds.push(once()?.build_time().as_secs_f64());
    }
    memory::forget_peak();
    let bvh = once()?;
    seconds.push(bvh.build_time().as_secs_f64());
    Ok((bvh, Built { seconds: median(seconds), peak: memory::peak() }))
}

/// Both ways in which Embree builds for speed.
pub fn build_embree<'a>(embree: &'a Embree, mesh: &Mesh) -> Result<([Scene<'a>; 2], EmbreeBuilt), String> {
    let shared = Shared::new(mesh);
    let (medium, high) = (embree.build(&shared, Build::Medium)?, embree.build(&shared, Build::High)?);
    let built = EmbreeBuilt { medium: medium.seconds, high: high.seconds, bytes: high.bytes };
    Ok(([medium, high], built))
}

/// Costs of all kinds of rays: medians over `reps` repetitions, in each of which every kernel traces the whole buffer.
pub fn costs(bvh: &Bvh, embree: Option<&[Scene<'_>; 2]>, rays: &Rays, reps: usize) -> [Cost; 3] {
    let mut kernels: Vec<Box<dyn Kernel + '_>> = vec![Box::new(One(bvh)), Box::new(Batch(bvh))];
    for scene in embree.into_iter().flatten() {
        kernels.push(Box::new(embree::One(scene)));
    }
    rays.each().map(|(kind, rays)| {
        let times = times(&kernels, kind, rays, reps);
        let theirs = times[2..].iter().copied().fold(f64::INFINITY, f64::min);
        let embree = (times.len() > 2).then_some(theirs);
        Cost { kind, one: times[0], batch: times[1], embree }
    })
}

/// Nanoseconds a ray of each kernel.
fn times(kernels: &[Box<dyn Kernel + '_>], kind: Kind, rays: &[Ray], reps: usize) -> Vec<f64> {
    let (mut hits, mut blocked) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    let mut seconds = vec![Vec::new(); kernels.len()];
    // The first repetition warms the caches.
    for rep in 0..=reps {
        for i in (0..kernels.len()).map(|i| (i + rep) % kernels.len()) {
            let start = thread_seconds();
            match kind {
                Kind::Shadow => kernels[i].occluded(rays, &mut blocked),
                _ => kernels[i].closest(rays, &mut hits),
            }
            seconds[i].extend((rep > 0).then(|| thread_seconds() - start));
        }
    }
    seconds.into_iter().map(|s| median(s) / rays.len().max(1) as f64 * 1e9).collect()
}
