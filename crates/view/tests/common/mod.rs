//! A card to draw on, for tests of several files.

use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};

/// Set where tests must not be left out: a card, if only in software, was found or installed.
const REQUIRED: &str = "PENOMBRE_WINDOW_TESTS";

/// A card, in software where there is one; `None`, said loudly, where there is none at all.
#[allow(clippy::print_stderr, reason = "what is not run must be said")]
pub fn card() -> Option<RenderState> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let made =
        std::panic::catch_unwind(|| create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE));
    std::panic::set_hook(hook);
    let required = std::env::var_os(REQUIRED).is_some_and(|v| v == "1");
    assert!(made.is_ok() || !required, "no graphics adapter, though {REQUIRED}=1 says that there is one");
    if made.is_err() {
        eprintln!(
            "NOT RUN: tests of the window's drawing: no graphics adapter (Debian: apt-get install mesa-vulkan-drivers)"
        );
    }
    made.ok()
}
