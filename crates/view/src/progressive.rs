//! Rendering in the background, coarse picture first.
//!
//! A [`ProgressiveRender`] owns its threads. It begins with pictures of an eighth and a quarter of the size, one
//! ray per pixel, enlarged; then it takes one sample of every pixel after the other. What it has is published as
//! a [`Snapshot`] at most every so often. The image after exactly the job's samples per pixel has the same bits as
//! that of [`penombre::Render::run`]: every sample comes from [`Render::unit_unless`] and is folded by the same
//! [`Film`]. Afterwards it goes on, if asked to, to twice as many samples, and twice as many again.

use penombre::film::Film;
use penombre::integrator::AnyIntegrator;
use penombre::{Job, Plan, Render, Scene, UnitResult};
use penombre_image::Image;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The coarse pictures: parts of the size, in this order.
const COARSE: [u32; 2] = [8, 4];
/// Developing a snapshot may take this part of the time at most.
const MOST_DEVELOPING: u32 = 10;
/// Nobody waits for more samples per pixel.
const MOST_SPP: u32 = 1 << 24;

/// How to render in the background.
#[derive(Clone)]
pub struct Options {
    /// Number of threads; at least one is used.
    pub threads: usize,
    /// Least time between two snapshots.
    pub interval: Duration,
    /// True: go on beyond the job's samples per pixel, to twice as many each time.
    pub beyond: bool,
    /// True: behind the coarse pictures its threads yield to all others, for while all cores render, the window must
    /// answer, and the next render, which the person waits for, must get ahead of one that was cancelled.
    pub yielding: bool,
    /// Called after each snapshot and at the end, from the render's threads: wakes the window.
    pub wake: Arc<dyn Fn() + Send + Sync>,
}

impl Default for Options {
    /// All cores, but yielding; twenty pictures a second, nothing beyond, nobody woken.
    fn default() -> Self {
        Self {
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            interval: Duration::from_millis(50),
            beyond: false,
            yielding: true,
            wake: Arc::new(|| ()),
        }
    }
}

impl std::fmt::Debug for Options {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { threads, interval, beyond, yielding, .. } = self;
        write!(f, "Options {{ threads: {threads}, interval: {interval:?}, beyond: {beyond}, ")?;
        write!(f, "yielding: {yielding} }}")
    }
}

/// How far the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// A small picture, enlarged.
    Coarse,
    /// Some of the job's samples.
    Refining,
    /// Exactly the job's samples: the image that the command gives.
    Complete,
    /// More than the job's samples.
    Beyond,
}

/// Figures of a render in the background.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Samples per pixel taken so far, the mean over all pixels.
    pub spp: f64,
    /// Samples per pixel that are aimed at.
    pub target: u32,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Samples that were dropped because they were not finite.
    pub non_finite: u64,
    /// Seconds since the start.
    pub seconds: f64,
    /// Samples of single pixels per second.
    pub samples_per_second: f64,
    /// Seconds until the target, as far as can be told; infinite before the first sample.
    pub seconds_left: f64,
}

/// The picture so far.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// At the job's size.
    pub image: Arc<Image>,
    /// How far it is.
    pub stage: Stage,
    /// Figures at that moment.
    pub figures: Figures,
}

/// Whether the render goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It does.
    Running,
    /// All is done.
    Finished,
    /// It was cancelled.
    Cancelled,
    /// There was nothing to render; why, for a person.
    Failed(String),
}

/// A render in the background. Dropping it cancels it and waits for its threads.
#[derive(Debug)]
pub struct ProgressiveRender {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl ProgressiveRender {
    /// Starts. `plan` runs on the render's own thread, for building a scene takes time; its error is a text for a
    /// person.
    pub fn start(plan: impl FnOnce() -> Result<Plan, String> + Send + 'static, options: Options) -> Self {
        let shared = Arc::new(Shared::default());
        let theirs = shared.clone();
        let spawned = std::thread::Builder::new().name("render".to_owned()).spawn(move || {
            let state = match plan() {
                Ok(plan) => Worker::new(plan, &theirs, &options).run(),
                Err(message) => State::Failed(message),
            };
            theirs.lock().state = state;
            (options.wake)();
        });
        let thread = spawned
            .map_err(|e| shared.lock().state = State::Failed(format!("the system gives no thread: {e}")))
            .ok();
        Self { shared, thread }
    }

    /// Asks it to stop; it does within some thousand rays.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it goes on.
    pub fn state(&self) -> State {
        let state = self.shared.lock().state.clone();
        if state == State::Running && self.is_over() {
            return State::Failed("the render broke off: this is a fault of the program".to_owned());
        }
        state
    }

    /// True once all its threads have ended.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// The newest picture, if there is one that was not taken yet.
    pub fn take_snapshot(&self) -> Option<Snapshot> {
        self.shared.lock().newest.take()
    }

    /// Waits until there is a picture that was not taken yet, at most so long.
    pub fn wait_for_snapshot(&self, most: Duration) {
        let none = |published: &mut Published| published.newest.is_none();
        // The lock comes back either way, and nothing is done with it.
        drop(self.shared.picture.wait_timeout_while(self.shared.lock(), most, none));
    }

    /// The picture of exactly the job's samples, once there is one.
    pub fn complete(&self) -> Option<Snapshot> {
        self.shared.lock().complete.clone()
    }

    /// Waits until it is over.
    pub fn wait(&mut self) -> State {
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            return State::Failed("the render broke off: this is a fault of the program".to_owned());
        }
        self.shared.lock().state.clone()
    }
}

impl Drop for ProgressiveRender {
    fn drop(&mut self) {
        self.cancel();
        self.wait();
    }
}

/// At most one render that is shown, and those that were cancelled and have not ended yet: a window does not wait
/// for them.
#[derive(Debug, Default)]
pub struct Renders {
    current: Option<ProgressiveRender>,
    retired: Vec<ProgressiveRender>,
}

impl Renders {
    /// Cancels the one that runs and starts another.
    pub fn start(&mut self, plan: impl FnOnce() -> Result<Plan, String> + Send + 'static, options: Options) {
        self.cancel();
        self.current = Some(ProgressiveRender::start(plan, options));
    }

    /// Cancels the one that runs, without waiting for it.
    pub fn cancel(&mut self) {
        self.retired.extend(self.current.take().inspect(ProgressiveRender::cancel));
        self.retired.retain(|render| !render.is_over());
    }

    /// The render that is shown.
    pub fn current(&self) -> Option<&ProgressiveRender> {
        self.current.as_ref()
    }

    /// Cancelled renders that have not ended yet.
    pub fn retiring(&mut self) -> usize {
        self.retired.retain(|render| !render.is_over());
        self.retired.len()
    }
}

/// What the window and the render's threads both see.
#[derive(Debug)]
struct Shared {
    cancelled: AtomicBool,
    published: Mutex<Published>,
    /// Told of every picture.
    picture: Condvar,
}

#[derive(Debug)]
struct Published {
    newest: Option<Snapshot>,
    complete: Option<Snapshot>,
    state: State,
}

impl Default for Shared {
    fn default() -> Self {
        let published = Published { newest: None, complete: None, state: State::Running };
        let (published, picture) = (Mutex::new(published), Condvar::new());
        Self { cancelled: AtomicBool::new(false), published, picture }
    }
}

impl Shared {
    /// What is in it is whole at every moment, so a panic elsewhere spoils nothing.
    fn lock(&self) -> MutexGuard<'_, Published> {
        self.published.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// What all threads of one render know.
struct Worker<'a> {
    scene: Arc<Scene>,
    integrator: Box<dyn AnyIntegrator>,
    job: Job,
    shared: &'a Shared,
    options: &'a Options,
    begin: Instant,
}

/// What they add to, one at a time.
struct Sums {
    film: Film,
    samples: u64,
    rays: u64,
    non_finite: u64,
    /// Tiles that have a sample.
    begun: Vec<bool>,
    /// When the next snapshot may be published.
    next: Instant,
}

impl<'a> Worker<'a> {
    fn new(plan: Plan, shared: &'a Shared, options: &'a Options) -> Self {
        let Plan { scene, integrator, job } = plan;
        let job = Job { progressive: true, ..job };
        Self { scene, integrator, job, shared, options, begin: Instant::now() }
    }

    fn run(&self) -> State {
        let sums = Sums::new(&self.job);
        let mut coarse = None;
        for part in COARSE {
            let Some(image) = self.coarse(part) else { return State::Cancelled };
            let image = Arc::new(image);
            self.publish(image.clone(), Stage::Coarse, self.figures(&sums, self.job.spp));
            coarse = Some(image);
        }
        self.yield_to_others();
        let sums = Mutex::new(sums);
        let (mut done, mut target) = (0, self.job.spp);
        loop {
            let stage = if done == 0 { Stage::Refining } else { Stage::Beyond };
            let job = Job { spp: target, ..self.job };
            let units = done as usize * job.tiles()..job.units();
            let merge = |result: UnitResult| {
                let mut sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
                sums.merge(result);
                if Instant::now() >= sums.next {
                    self.publish_so_far(&mut sums, coarse.as_deref(), stage, target);
                }
            };
            self.sweep(&job, units, &merge);
            if self.shared.is_cancelled() {
                return State::Cancelled;
            }
            let sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
            let last = if done == 0 { Stage::Complete } else { Stage::Beyond };
            self.publish(Arc::new(sums.film.develop()), last, self.figures(&sums, target));
            (done, target) = (target, target.saturating_mul(2));
            if !self.options.beyond || target > MOST_SPP {
                return State::Finished;
            }
        }
    }

    /// From now on the calling thread waits for others, if the options say so and the system can.
    fn yield_to_others(&self) {
        if self.options.yielding {
            penombre_sys::lower_thread_priority();
        }
    }

    /// Computes units on all threads, handing each result to `merge`, until they are done or it is cancelled: then
    /// units that are not whole are dropped.
    fn sweep(&self, job: &Job, units: std::ops::Range<usize>, merge: &(dyn Fn(UnitResult) + Sync)) {
        let next = AtomicUsize::new(units.start);
        let stop = || self.shared.is_cancelled();
        let work = || {
            while !stop() {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= units.end {
                    return;
                }
                let unit = job.unit(index);
                match Render::unit_unless(&self.scene, &*self.integrator, job, unit, &stop) {
                    Some(result) => merge(result),
                    None => return,
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..self.options.threads.clamp(1, units.len().max(1)) {
                scope.spawn(|| {
                    self.yield_to_others();
                    work();
                });
            }
            work();
        });
    }

    /// A picture of a part of the size, one ray through the centre of each pixel, enlarged; `None` if cancelled.
    fn coarse(&self, part: u32) -> Option<Image> {
        let size = self.job.size.map(|edge| edge.div_ceil(part));
        let job = Job { size, spp: 1, pixel_jitter: false, ..self.job };
        let film = Mutex::new(Film::new(size[0], size[1], job.tiles()));
        self.sweep(&job, 0..job.units(), &|r: UnitResult| {
            let mut film = film.lock().unwrap_or_else(PoisonError::into_inner);
            film.merge(r.unit.tile_index, r.unit.tile, r.unit.first_sample, r.unit.count, r.sums);
        });
        let film = film.into_inner().unwrap_or_else(PoisonError::into_inner);
        (!self.shared.is_cancelled()).then(|| enlarge(&film.develop(), self.job.size))
    }

    /// The picture so far; tiles without a sample are those of the coarse picture.
    fn publish_so_far(&self, sums: &mut Sums, coarse: Option<&Image>, stage: Stage, target: u32) {
        let begin = Instant::now();
        let mut image = sums.film.develop();
        if let Some(coarse) = coarse {
            let empty = sums.begun.iter().enumerate().filter(|(_, begun)| !**begun);
            for (index, _) in empty {
                copy_tile(&self.job, index, coarse, &mut image);
            }
        }
        self.publish(Arc::new(image), stage, self.figures(sums, target));
        let end = Instant::now();
        sums.next = end + self.options.interval.max((end - begin) * MOST_DEVELOPING);
    }

    fn publish(&self, image: Arc<Image>, stage: Stage, figures: Figures) {
        let snapshot = Snapshot { image, stage, figures };
        let mut published = self.shared.lock();
        if stage == Stage::Complete {
            published.complete = Some(snapshot.clone());
        }
        published.newest = Some(snapshot);
        drop(published);
        self.shared.picture.notify_all();
        (self.options.wake)();
    }

    fn figures(&self, sums: &Sums, target: u32) -> Figures {
        let pixels = f64::from(self.job.size[0]) * f64::from(self.job.size[1]);
        let (samples, seconds) = (sums.samples as f64, self.begin.elapsed().as_secs_f64());
        let rate = samples / seconds.max(1e-9);
        let left = (pixels * f64::from(target) - samples).max(0.0);
        Figures {
            spp: samples / pixels,
            target,
            rays: sums.rays,
            non_finite: sums.non_finite,
            seconds,
            samples_per_second: rate,
            seconds_left: if rate > 0.0 { left / rate } else { f64::INFINITY },
        }
    }
}

impl Sums {
    fn new(job: &Job) -> Self {
        Self {
            film: Film::new(job.size[0], job.size[1], job.tiles()),
            samples: 0,
            rays: 0,
            non_finite: 0,
            begun: vec![false; job.tiles()],
            next: Instant::now(),
        }
    }

    fn merge(&mut self, result: UnitResult) {
        let unit = result.unit;
        self.samples += unit.tile.pixels() as u64 * u64::from(unit.count);
        self.rays += result.rays;
        self.non_finite += result.non_finite;
        self.begun[unit.tile_index] = true;
        self.film.merge(unit.tile_index, unit.tile, unit.first_sample, unit.count, result.sums);
    }
}

/// The nearest pixel of a small image for each pixel of a larger one.
fn enlarge(small: &Image, [width, height]: [u32; 2]) -> Image {
    let mut image = Image::new(width, height, 3);
    let scaled = |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(to) / u64::from(from)) as u32;
    for y in 0..height {
        let row = scaled(y, height, small.height());
        for x in 0..width {
            let column = scaled(x, width, small.width());
            image.pixel_mut(x, y).copy_from_slice(&small.pixel(column, row));
        }
    }
    image
}

fn copy_tile(job: &Job, index: usize, from: &Image, to: &mut Image) {
    for [x, y] in job.unit(index).tile.iter() {
        to.pixel_mut(x, y).copy_from_slice(&from.pixel(x, y));
    }
}

#[cfg(test)]
mod tests;
