//! Progress on the terminal, and the way to stop.

use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use penombre::{Event, Observer};
use std::ops::ControlFlow;

/// Shows how far a render is and stops it when the user asks.
pub struct Progress {
    bar: ProgressBar,
    per_pixel: f64,
}

impl Progress {
    /// A bar over so many samples of so many pixels, drawn on standard error if `visible` and a terminal is there.
    pub fn new(samples: u64, pixels: u64, visible: bool) -> Self {
        let target =
            if visible { ProgressDrawTarget::stderr_with_hz(8) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(samples), target);
        let template = "{percent:>3} % {bar:32} {msg}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
        }
        bar.set_message("0 spp");
        Self { bar, per_pixel: 1.0 / pixels.max(1) as f64 }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Progress {
    fn on(&self, event: Event<'_>) -> ControlFlow<()> {
        if let Event::Progress(statistics, _) = event
            && !self.bar.is_hidden()
        {
            self.bar.set_position(statistics.samples);
            let rays_per_s = statistics.rays as f64 / self.bar.elapsed().as_secs_f64().max(1e-3);
            let spp = statistics.samples as f64 * self.per_pixel;
            self.bar.set_message(format!("{spp:.0} spp, {:.1} Mrays/s", rays_per_s / 1e6));
        }
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
