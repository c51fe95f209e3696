//! The window's contents, drawn and driven without a window system.

mod common;

use eframe::egui::{self, Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::WgpuTestRenderer;
use penombre_view::camera::{Button, CourseCamera};
use penombre_view::session::Source;
use penombre_view::state::Mode;
use penombre_view::window::{App, PANEL_WIDTH, Start};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Nothing here takes longer, on any machine.
const LIMIT: Duration = Duration::from_secs(60);
const PICTURE: u32 = 96;

struct Window {
    harness: Harness<'static, App>,
    said: Rc<RefCell<Vec<String>>>,
}

impl Window {
    /// A window that shows a scene, with a picture of 96 × 96 pixels; `None` where nothing can draw.
    fn showing(scene: &str) -> Option<Self> {
        let state = common::card()?;
        let said: Rc<RefCell<Vec<String>>> = Rc::default();
        let (theirs, drawn) = (said.clone(), state.clone());
        let start = Start {
            source: Source::builtin(scene),
            size: Some([PICTURE; 2]),
            live: false,
            latency_marker: false,
        };
        let make = move |ctx: &egui::Context| {
            App::new(ctx, Some(&drawn), start, Box::new(move |line| theirs.borrow_mut().push(line.to_owned())))
        };
        let mut make = Some(make);
        let ctx = egui::Context::default();
        let app = make.take()?(&ctx);
        let harness = Harness::builder()
            .with_size(vec2(PICTURE as f32 + PANEL_WIDTH, 640.0_f32.max(PICTURE as f32)))
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
        let mut window = Self { harness, said };
        window.until("the scene is shown", |app| app.viewer().source().is_some());
        Some(window)
    }

    /// Lets frames go by until something is so.
    fn until(&mut self, what: &str, so: impl Fn(&App) -> bool) {
        let begin = Instant::now();
        while !so(self.harness.state()) {
            assert!(begin.elapsed() < LIMIT, "not within {LIMIT:?}: {what}");
            self.harness.step();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn press(&mut self, text: &str) {
        self.harness.event(Event::Text(text.to_owned()));
        self.harness.step();
    }

    fn button(&mut self, at: Pos2, button: PointerButton, pressed: bool) {
        self.harness.event(Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    }

    /// Drags through points, all within one frame.
    fn drag(&mut self, button: PointerButton, points: &[Pos2]) {
        self.harness.event(Event::PointerMoved(points[0]));
        self.harness.step();
        self.button(points[0], button, true);
        points[1..].iter().for_each(|p| self.harness.event(Event::PointerMoved(*p)));
        self.button(points[points.len() - 1], button, false);
        self.harness.step();
    }

    fn camera(&self) -> CourseCamera {
        *self.harness.state().viewer().camera()
    }

    /// Red, green and blue of the picture's pixels, top row first.
    fn picture(&mut self) -> Vec<[u8; 3]> {
        let image = self.harness.render().expect("the card draws");
        let at = |x: u32, y: u32| {
            let [r, g, b, _] = image.get_pixel(x, y).0;
            [r, g, b]
        };
        let size = self.harness.state().viewer().setup().size;
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
    }
}

fn window_point(p: Pos2) -> penombre_math::Vec2 {
    penombre_math::Vec2::new(p.x, p.y)
}

#[test]
fn a_drag_of_several_movements_is_the_course_s_trackball() {
    let Some(mut window) = Window::showing("cornell") else { return };
    let size = window.harness.state().viewer().setup().size;
    assert_eq!(size[0], PICTURE);
    let all = penombre_math::Vec2::new(size[0] as f32, size[1] as f32);
    let points = [pos2(20.0, 30.0), pos2(31.0, 44.0), pos2(52.0, 35.0), pos2(60.0, 60.0)];
    for (egui_button, button) in [
        (PointerButton::Primary, Button::Left),
        (PointerButton::Secondary, Button::Right),
        (PointerButton::Middle, Button::Middle),
    ] {
        let mut expected = window.camera();
        for pair in points.windows(2) {
            expected.drag(button, window_point(pair[0]), window_point(pair[1]), all);
        }
        window.drag(egui_button, &points);
        assert_eq!(window.camera(), expected, "{button:?}");
    }
}
