//! Running a job on threads.

use super::intake::Intake;
use super::unit::{DroppedSample, UnitResult};
use super::{Job, Plan};
use crate::film::{Estimate, Film, FilmLayer};
use crate::integrator::AnyIntegrator;
use crate::scene::Scene;
use penombre_image::{Image, Layers};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Dropped samples that a render names; the rest is only counted.
const MOST_NAMED: usize = 16;

/// What happens while a job runs.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Units were merged: the figures and the film so far.
    Progress(&'a Statistics, &'a Film),
    /// Asked between pieces of work, many times a second on every thread.
    Tick,
}

/// Hears of what happens and may stop the job.
pub trait Observer: Sync {
    /// Called from the threads of the render. `Break` stops the job as soon as possible.
    fn on(&self, event: Event<'_>) -> ControlFlow<()>;
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All samples were taken.
    Finished,
    /// The error is below the job's limit.
    Converged,
    /// The observer stopped it.
    Stopped,
}

/// Figures of a render so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Camera samples taken, dropped ones included.
    pub samples: u64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Samples that were dropped because they were not finite.
    pub non_finite: u64,
    /// The first few of them.
    pub dropped: Vec<DroppedSample>,
    /// The error at the last check point or the end of a run, if it is estimated.
    pub estimate: Option<Estimate>,
}

/// A job in progress.
#[derive(Debug)]
pub struct Render {
    scene: Arc<Scene>,
    integrator: Box<dyn AnyIntegrator>,
    job: Job,
    film: Film,
    statistics: Statistics,
    intake: Intake,
}

impl Render {
    /// A job of which nothing is done.
    pub fn new(plan: Plan) -> Self {
        let Plan { scene, integrator, job } = plan;
        let film = Film::new(job.size[0], job.size[1], job.tiles());
        Self {
            scene,
            integrator,
            job,
            film,
            statistics: Statistics::default(),
            intake: Intake::new(job.tiles(), job.whole_passes),
        }
    }

    /// Computes what is left to do on `threads` threads (at least one). At check points all threads wait for the last
    /// of them, so that the film is that of so many samples when its error is looked at, whatever their number.
    pub fn run(&mut self, threads: usize, observer: &dyn Observer) -> Outcome {
        loop {
            if self.is_converged() {
                return Outcome::Converged;
            }
            if self.intake.below() == self.job.units() {
                self.statistics.estimate = self.film.estimate();
                return Outcome::Finished;
            }
            if !self.compute(self.next_check(), threads, observer) {
                for result in self.intake.stop() {
                    merge(&mut self.film, &mut self.statistics, result);
                }
                self.statistics.estimate = self.film.estimate();
                return Outcome::Stopped;
            }
        }
    }

    /// The unit before which the film is looked at next.
    fn next_check(&self) -> usize {
        let units = self.job.units();
        if self.job.noise <= 0.0 {
            return units;
        }
        let samples = Job::next_check(self.job.samples_before(self.intake.below()));
        self.job.units_of(samples).min(units)
    }

    /// Looks at the error, if this is a check point.
    fn is_converged(&mut self) -> bool {
        let below = self.intake.below();
        let samples = self.job.samples_before(below);
        let at_check = samples > 0 && samples == Job::next_check(samples - 1);
        if self.job.noise <= 0.0 || !at_check || below != self.job.units_of(samples) {
            return false;
        }
        self.statistics.estimate = self.film.estimate();
        self.statistics.estimate.is_some_and(|e| e.bound < f64::from(self.job.noise))
    }

    /// Computes all units before one that are not done; false if it was stopped.
    fn compute(&mut self, until: usize, threads: usize, observer: &dyn Observer) -> bool {
        let before = self.intake.clone();
        let next = AtomicUsize::new(before.below());
        let take = || loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= until || !before.is_done(index) {
                return (index < until).then_some(index);
            }
        };
        let stopped = AtomicBool::new(false);
        let (scene, job) = (self.scene.clone(), self.job);
        let shared = Mutex::new((&mut self.film, &mut self.statistics, &mut self.intake));
        let integrator = &*self.integrator;
        let stop = || {
            if !stopped.load(Ordering::Relaxed) && observer.on(Event::Tick).is_break() {
                stopped.store(true, Ordering::Relaxed);
            }
            stopped.load(Ordering::Relaxed)
        };
        let work = || {
            while let Some(index) = take() {
                let Some(result) = Self::unit_unless(&scene, integrator, &job, job.unit(index), &stop) else {
                    return;
                };
                // A panic of another thread ends the whole run; its lock is of no interest then.
                let Ok(mut guard) = shared.lock() else { return };
                let (film, statistics, intake) = &mut *guard;
                for result in intake.take(index, result) {
                    merge(film, statistics, result);
                }
                if observer.on(Event::Progress(statistics, film)).is_break() {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
        };
        std::thread::scope(|scope| {
            let helpers: Vec<_> = (1..threads.max(1)).map(|_| scope.spawn(work)).collect();
            work();
            for helper in helpers {
                if let Err(panic) = helper.join() {
                    std::panic::resume_unwind(panic);
                }
            }
        });
        let stopped = stopped.into_inner() && until < job.units();
        self.intake.below() >= until && !stopped
    }

    /// Adds the result of a unit that was computed elsewhere.
    pub fn merge(&mut self, result: UnitResult) {
        for result in self.intake.take(self.job.index_of(&result.unit), result) {
            merge(&mut self.film, &mut self.statistics, result);
        }
    }

    /// The image so far.
    pub fn image(&self) -> Image {
        self.film.develop()
    }

    /// The image and those layers so far.
    pub fn layers(&self, wanted: &[FilmLayer]) -> Layers {
        let mut layers = Layers::from_image(&self.image());
        for layer in wanted {
            // A layer that is asked for twice is there once.
            let _ = layers.push(self.film.layer(*layer));
        }
        layers
    }

    /// Figures so far.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The job.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The integrator.
    pub fn integrator(&self) -> &dyn AnyIntegrator {
        &*self.integrator
    }
}

fn merge(film: &mut Film, statistics: &mut Statistics, result: UnitResult) {
    let unit = result.unit;
    statistics.samples += unit.tile.pixels() as u64 * u64::from(unit.count);
    statistics.rays += result.rays;
    statistics.non_finite += result.non_finite;
    let room = MOST_NAMED.saturating_sub(statistics.dropped.len());
    statistics.dropped.extend(result.dropped.into_iter().take(room));
    film.merge(unit.tile_index, unit.tile, unit.first_sample, unit.count, result.sums);
}
