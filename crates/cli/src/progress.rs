//! Progress on the terminal, and the way to stop.

use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use penombre::render::Statistics;
use penombre::{Event, Job, Observer};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Steps of the bar.
const STEPS: u64 = 10_000;

/// Shows how far a render is, and stops it when the user asks or its time is up.
pub struct Progress {
    bar: ProgressBar,
    samples: f64,
    pixels: u64,
    /// The job's limit of the error; 0: none.
    noise: f64,
    begin: Instant,
    time: Option<Duration>,
    /// True once every pixel has a sample: time is not up before.
    begun: AtomicBool,
    timed_out: AtomicBool,
}

impl Progress {
    /// Begins now. A bar is drawn on standard error if `visible` and a terminal is there.
    pub fn new(job: &Job, time: Option<Duration>, visible: bool) -> Self {
        let target =
            if visible { ProgressDrawTarget::stderr_with_hz(8) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let template = "{percent:>3} % {bar:32} {msg}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
        }
        bar.set_message("0 spp");
        Self {
            bar,
            samples: job.samples() as f64,
            pixels: u64::from(job.size[0]) * u64::from(job.size[1]),
            noise: f64::from(job.noise),
            begin: Instant::now(),
            time,
            begun: AtomicBool::new(false),
            timed_out: AtomicBool::new(false),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// True if the render was stopped because its time was up.
    pub fn timed_out(&self) -> bool {
        self.timed_out.load(Ordering::Relaxed)
    }

    fn draw(&self, statistics: &Statistics) {
        let error = statistics.estimate.map(|e| e.error);
        self.bar.set_position((self.share(statistics, error) * STEPS as f64) as u64);
        let rays_per_s = statistics.rays as f64 / self.bar.elapsed().as_secs_f64().max(1e-3);
        let spp = statistics.samples as f64 / self.pixels.max(1) as f64;
        let error = error.map(|e| format!(", error {e:.2}")).unwrap_or_default();
        self.bar.set_message(format!("{spp:.0} spp{error}, {:.1} Mrays/s", rays_per_s / 1e6));
    }

    /// How far it is to the limit that will come first, as far as can be told: 0 to 1.
    fn share(&self, statistics: &Statistics, error: Option<f64>) -> f64 {
        let by_samples = statistics.samples as f64 / self.samples.max(1.0);
        let by_time = self.time.map_or(0.0, |time| self.begin.elapsed().as_secs_f64() / time.as_secs_f64());
        // The square of the error falls with the number of samples.
        let by_error = error.map_or(0.0, |error| {
            let ratio = self.noise / error.max(1e-12);
            ratio * ratio
        });
        by_samples.max(by_time).max(by_error).min(1.0)
    }

    fn is_time_up(&self) -> bool {
        self.begun.load(Ordering::Relaxed) && self.time.is_some_and(|time| self.begin.elapsed() >= time)
    }
}

impl Observer for Progress {
    fn on(&self, event: Event<'_>) -> ControlFlow<()> {
        if let Event::Progress(statistics, _) = event {
            self.begun.store(statistics.samples >= self.pixels, Ordering::Relaxed);
            if !self.bar.is_hidden() {
                self.draw(statistics);
            }
        }
        if interrupt::requested() {
            return ControlFlow::Break(());
        }
        if self.is_time_up() {
            self.timed_out.store(true, Ordering::Relaxed);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_shows_the_limit_that_comes_first() {
        let progress = Progress {
            bar: ProgressBar::hidden(),
            samples: 1000.0,
            pixels: 10,
            noise: 0.02,
            begin: Instant::now(),
            time: None,
            begun: AtomicBool::new(false),
            timed_out: AtomicBool::new(false),
        };
        let taken = Statistics { samples: 500, ..Statistics::default() };
        assert_eq!(progress.share(&taken, None), 0.5);
        assert_eq!(progress.share(&taken, Some(0.04)), 0.5);
        assert!((progress.share(&Statistics::default(), Some(0.04)) - 0.25).abs() < 1e-6);
        assert_eq!(progress.share(&taken, Some(0.001)), 1.0);
    }
}
