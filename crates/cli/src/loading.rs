//! What is seen while the files of a scene are read.

use crate::args::Verbosity;
use crate::memory::{Budget, bytes};
use crate::terminal;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use penombre_scene::assets::{AssetMemory, FileContent, FileRead, LoadEvent, LoadObserver};
use penombre_scene::{Diagnostic, SceneDescription};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Loading that takes no longer is not worth a word.
const PATIENCE: Duration = Duration::from_millis(500);

/// Shows how far loading is, and keeps to a budget of memory.
pub struct Loading<'a> {
    bar: ProgressBar,
    counts: Arc<Counts>,
    /// A line for each file.
    verbose: bool,
    budget: &'a Budget<'a>,
}

/// Files and bytes: those that were read, and those that are known of.
#[derive(Debug, Default)]
struct Counts {
    files: [AtomicU64; 2],
    bytes: [AtomicU64; 2],
}

impl Counts {
    fn add(&self, which: usize, files: u64, bytes: u64) {
        self.files[which].fetch_add(files, Ordering::Relaxed);
        self.bytes[which].fetch_add(bytes, Ordering::Relaxed);
    }

    fn line(&self) -> String {
        let [files, bytes] = [&self.files, &self.bytes].map(|c| [0, 1].map(|i| c[i].load(Ordering::Relaxed)));
        let megabytes = bytes.map(|n| (n + 500_000) / 1_000_000);
        format!("Loading {} of {} files · {} of {} MB", files[0], files[1], megabytes[0], megabytes[1])
    }
}

impl<'a> Loading<'a> {
    /// Begins now. A line is drawn on standard error if a terminal is there, and no one wants it quiet.
    pub fn new(verbosity: &Verbosity, budget: &'a Budget<'a>) -> Self {
        let visible = !verbosity.quiet && !verbosity.no_progress;
        let target =
            if visible { ProgressDrawTarget::stderr_with_hz(8) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        let counts = Arc::<Counts>::default();
        let shown = counts.clone();
        let line = move |state: &ProgressState, to: &mut dyn std::fmt::Write| {
            if state.elapsed() >= PATIENCE {
                // A line that cannot be drawn is not missed.
                let _ = to.write_str(&shown.line());
            }
        };
        if let Ok(style) = ProgressStyle::with_template("{line}") {
            bar.set_style(style.with_key("line", line));
        }
        Self { bar, counts, verbose: verbosity.verbose > 0, budget }
    }

    /// Removes the line.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl LoadObserver for Loading<'_> {
    fn approve(&self, scene: &SceneDescription, memory: &dyn Fn() -> AssetMemory) -> Option<Diagnostic> {
        self.budget.check(scene, &memory())
    }

    fn on(&self, event: LoadEvent<'_>) {
        match event {
            LoadEvent::Found { files, bytes } => {
                self.counts.add(1, files as u64, bytes);
                if !self.bar.is_hidden() {
                    self.bar.enable_steady_tick(PATIENCE / 2);
                }
            }
            LoadEvent::Read(file) => {
                self.counts.add(0, 1, file.bytes);
                if self.verbose {
                    self.bar.suspend(|| terminal::err(&line_of(&file)));
                }
            }
        }
    }
}

/// `-v`: name, size, what is in it, time.
fn line_of(file: &FileRead<'_>) -> String {
    let content = match file.content {
        FileContent::Mesh { triangles } => format!("{triangles} triangles"),
        FileContent::Image { size: [w, h] } => format!("{w}×{h} pixels"),
        FileContent::Copy => "a copy of another one".to_owned(),
        FileContent::Fault => "not usable".to_owned(),
    };
    let time = file.time.as_secs_f64();
    format!("{}: {}, {content}, {time:.3} s", file.name, bytes(file.bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_in_one_line() {
        let file = |content| {
            line_of(&FileRead { name: "a.ply", bytes: 1536, content, time: Duration::from_millis(12) })
        };
        assert_eq!(file(FileContent::Mesh { triangles: 7 }), "a.ply: 1.5 KiB, 7 triangles, 0.012 s");
        assert_eq!(file(FileContent::Image { size: [4, 3] }), "a.ply: 1.5 KiB, 4×3 pixels, 0.012 s");
    }

    #[test]
    fn counts_are_of_files_and_bytes() {
        let counts = Counts::default();
        counts.add(1, 12, 800_400_000);
        (0..3).for_each(|_| counts.add(0, 1, 40_000_000));
        assert_eq!(counts.line(), "Loading 3 of 12 files · 120 of 800 MB");
    }
}
