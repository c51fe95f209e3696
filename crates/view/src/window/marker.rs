//! A marker in the corner of the window by which a program measures when its inputs are seen.

use crate::state::Mode;
use eframe::egui::{self, Color32, Event};

/// Edge of the marker, pixels.
const EDGE: f32 = 8.0;

/// Counts the inputs that the window took into account and shows the number as a colour.
#[derive(Debug, Default)]
pub struct Marker {
    inputs: u32,
}

impl Marker {
    /// Takes a frame's events.
    pub fn count(&mut self, events: &[Event]) {
        let counts = |event: &&Event| match event {
            Event::Key { pressed, .. } => *pressed,
            Event::PointerMoved(_) | Event::PointerButton { .. } | Event::MouseWheel { .. } => true,
            _ => false,
        };
        self.inputs = self.inputs.wrapping_add(events.iter().filter(counts).count() as u32);
    }

    /// Draws it: red and green are the number of inputs modulo 65536, low byte first; blue is what the picture shows:
    /// 0x20 the preview, 0x60 a coarse image, 0xa0 a refining one, 0xe0 the complete one.
    pub fn draw(&self, ctx: &egui::Context, mode: Mode) {
        let kind = match mode {
            Mode::Raster | Mode::Rendering(None) => 0x20,
            Mode::Rendering(Some(figures)) if figures.spp == 0.0 => 0x60,
            Mode::Rendering(Some(_)) => 0xa0,
            Mode::Rendered(_) => 0xe0,
        };
        let [low, high, ..] = self.inputs.to_le_bytes();
        let layer = egui::LayerId::new(egui::Order::Debug, egui::Id::unique("latency marker"));
        let size = egui::Vec2::splat(EDGE / ctx.pixels_per_point());
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
        ctx.layer_painter(layer).rect_filled(rect, 0.0, Color32::from_rgb(low, high, kind));
    }
}
