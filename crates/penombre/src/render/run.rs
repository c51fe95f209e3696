//! Running a job on threads.

use super::unit::{DroppedSample, UnitResult};
use super::{Job, Plan};
use crate::film::Film;
use crate::integrator::AnyIntegrator;
use crate::scene::Scene;
use penombre_image::Image;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Dropped samples that a render names; the rest is only counted.
const MOST_NAMED: usize = 16;

/// What happens while a job runs.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A unit was merged: the figures and the film so far.
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
    /// The observer stopped it.
    Stopped,
}

/// Figures of a render so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples taken, dropped ones included.
    pub samples: u64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Samples that were dropped because they were not finite.
    pub non_finite: u64,
    /// The first few of them.
    pub dropped: Vec<DroppedSample>,
}

/// A job in progress.
#[derive(Debug)]
pub struct Render {
    scene: Arc<Scene>,
    integrator: Box<dyn AnyIntegrator>,
    job: Job,
    film: Film,
    statistics: Statistics,
    /// Units of the fixed order that are done.
    done: Vec<bool>,
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
            done: vec![false; job.units()],
        }
    }

    /// Computes what is left to do on `threads` threads (at least one).
    pub fn run(&mut self, threads: usize, observer: &dyn Observer) -> Outcome {
        let todo: Vec<usize> = (0..self.done.len()).filter(|i| !self.done[*i]).collect();
        let next = AtomicUsize::new(0);
        let stopped = AtomicBool::new(false);
        let (scene, job) = (self.scene.clone(), self.job);
        let shared = Mutex::new((&mut self.film, &mut self.statistics, &mut self.done));
        let integrator = &*self.integrator;
        let stop = || {
            if !stopped.load(Ordering::Relaxed) && observer.on(Event::Tick).is_break() {
                stopped.store(true, Ordering::Relaxed);
            }
            stopped.load(Ordering::Relaxed)
        };
        let work = || {
            while let Some(index) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                let Some(result) = Self::unit_unless(&scene, integrator, &job, job.unit(*index), &stop)
                else {
                    return;
                };
                // A panic of another thread ends the whole run; its lock is of no interest then.
                let Ok(mut guard) = shared.lock() else { return };
                let (film, statistics, done) = &mut *guard;
                done[*index] = true;
                merge(film, statistics, result);
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
        if self.done.iter().all(|d| *d) { Outcome::Finished } else { Outcome::Stopped }
    }

    /// Adds the result of a unit that was computed elsewhere.
    pub fn merge(&mut self, result: UnitResult) {
        let index = self.job.index_of(&result.unit);
        if !self.done[index] {
            self.done[index] = true;
            merge(&mut self.film, &mut self.statistics, result);
        }
    }

    /// The image so far.
    pub fn image(&self) -> Image {
        self.film.develop()
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
