//! The window: a thin layer of eframe, egui and wgpu over the state machine.

mod app;
mod browse;
mod canvas;
mod desk;
pub mod gpu;
mod marker;
mod panel;
mod screen;
mod task;

use eframe::egui;
use eframe::egui_wgpu::{self, SurfaceConfig};
use std::cell::RefCell;
use std::rc::Rc;

pub use app::{App, Say, Start};
pub use panel::WIDTH as PANEL_WIDTH;

/// Where the processor draws, waiting for a screen's refresh only delays.
const SOFTWARE_SURFACE: SurfaceConfig =
    SurfaceConfig { present_mode: eframe::wgpu::PresentMode::AutoNoVsync, ..SurfaceConfig::LOW_LATENCY };
/// The smallest window that a person can drag to, points.
const LEAST_SIZE: [f32; 2] = [1.0, 1.0];

/// Shows the window until it is closed.
///
/// # Errors
///
/// A text for a person: there is no display or no way to draw on it, or an image could not be written at the end.
pub fn run(start: Start, say: Say) -> Result<(), String> {
    let [width, height] = start.size.unwrap_or(crate::state::WINDOW_SIZE).map(|edge| edge as f32);
    let viewport = egui::ViewportBuilder::default()
        .with_title("penombre")
        .with_app_id("penombre-view")
        .with_inner_size([width + PANEL_WIDTH, height])
        .with_min_inner_size(LEAST_SIZE)
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions {
        viewport,
        wgpu_options: egui_wgpu::WgpuConfiguration {
            surface: SurfaceConfig::LOW_LATENCY,
            ..Default::default()
        },
        // The picture's bytes are to be shown as they are.
        dithering: false,
        ..Default::default()
    };
    let shared: Rc<RefCell<Option<App>>> = Rc::default();
    let theirs = shared.clone();
    let made = eframe::run_native(
        "penombre",
        options,
        Box::new(move |context| {
            // The picture's colours must not depend on the desktop's theme.
            context.egui_ctx.set_theme(egui::Theme::Dark);
            let app = App::new(&context.egui_ctx, context.wgpu_render_state.as_ref(), start, say);
            *theirs.borrow_mut() = Some(app);
            Ok(Box::new(Shell(theirs)))
        }),
    );
    made.map_err(|error| explain(&error))?;
    let failed = shared.borrow_mut().as_mut().map(App::finish).unwrap_or_default();
    if failed.is_empty() { Ok(()) } else { Err(failed.join("\n")) }
}

/// What eframe owns: the app lives on when the window is closed.
struct Shell(Rc<RefCell<Option<App>>>);

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        if let Some(app) = self.0.borrow_mut().as_mut() {
            if app.is_software() {
                frame.set_wgpu_surface_config(SOFTWARE_SURFACE);
            }
            app.ui(ui);
        }
    }
}

/// Why there is no window, and what to do.
fn explain(error: &eframe::Error) -> String {
    let what = match error {
        eframe::Error::Wgpu(_) => {
            "no graphics driver can draw the window. Any for Vulkan or OpenGL can, one in software too (Debian, Ubuntu: \
             apt-get install mesa-vulkan-drivers libgl1-mesa-dri)"
        }
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
            "there is no display to draw on: start it in a desktop, with `ssh -X`, or under Xvfb"
        }
        _ => "the window could not be made",
    };
    let text = error.to_string();
    let help = "`penombre render SCENE` needs neither display nor graphics driver";
    format!("{what}\n  cause: {}\n  help: {help}", cause(&text))
}

/// The message of an error without the place in a library's source at which it arose.
fn cause(message: &str) -> &str {
    let place = message.rfind(".rs:").map_or(0, |at| message[at..].find(": ").map_or(0, |end| at + end + 2));
    &message[place..]
}

#[cfg(test)]
mod tests {
    #[test]
    fn places_in_libraries_are_of_no_interest() {
        assert_eq!(super::cause("os error at /a/b.rs:12: no display"), "no display");
        assert_eq!(super::cause("os error at /a/b.rs:12"), "os error at /a/b.rs:12");
        assert_eq!(super::cause("no display"), "no display");
    }
}
