//! What every scene must stand, whatever it says: what the fuzz target calls, and the replay of what it has kept.

use penombre::Plan;
use penombre::render::{Event, Observer, Render};
use penombre_scene::{Assets, Diagnostics, FileId, toml};
use std::ops::ControlFlow;

/// Builds what a scene in TOML asks for, without its files, and renders 4 × 4 pixels of what can be built.
pub fn scene(data: &[u8]) {
    struct Quiet;
    impl Observer for Quiet {
        fn on(&self, _: Event<'_>) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
    }
    let Ok(text) = std::str::from_utf8(data) else { return };
    let mut out = Diagnostics::default();
    let scene = toml::read_toml(text, FileId(0), &mut out);
    if let Some(mut plan) = Plan::new(&scene.description, &Assets::default(), &mut out) {
        (plan.job.size, plan.job.spp) = ([4, 4], 1);
        Render::new(plan).run(1, &Quiet);
    }
}

#[cfg(test)]
mod replayed {
    #[test]
    fn kept_scenes() {
        for (name, data) in penombre_lab::kept_corpus("scene") {
            // A failing test shows the last line.
            eprintln!("scene/{name}");
            super::scene(&data);
        }
    }
}
