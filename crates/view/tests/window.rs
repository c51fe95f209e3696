//! The window's contents, drawn and driven without a window system. What `r` writes goes to a folder of its own.

mod common;

use eframe::egui::{self, Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::WgpuTestRenderer;
use penombre_view::camera::{Button, CourseCamera};
use penombre_view::session::Source;
use penombre_view::state::Mode;
use penombre_view::window::{App, PANEL_WIDTH, Start};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Nothing here takes longer, on any machine.
const LIMIT: Duration = Duration::from_secs(60);
/// Width of the picture, pixels.
const PICTURE: u32 = 96;
/// Height of the window and so of the picture: the whole panel is seen.
const HEIGHT: f32 = 640.0;

/// The folder in which this program runs; the same for all tests, for it is the process's.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let make = || {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        std::env::set_current_dir(folder.path()).expect("a folder that was just made");
        folder
    };
    FOLDER.get_or_init(make).path()
}

struct Window {
    harness: Harness<'static, App>,
    said: Rc<RefCell<Vec<String>>>,
}

impl Window {
    /// A window that shows a scene, with a picture of 96 × 640 pixels; `None` where nothing can draw.
    fn showing(scene: &str) -> Option<Self> {
        folder();
        let state = common::card()?;
        let said: Rc<RefCell<Vec<String>>> = Rc::default();
        let (theirs, drawn) = (said.clone(), state.clone());
        let start = Start {
            source: Source::builtin(scene),
            size: Some([PICTURE, HEIGHT as u32]),
            live: false,
            latency_marker: false,
        };
        let make = move |ctx: &egui::Context| {
            App::new(
                ctx,
                Some(&drawn),
                start,
                Box::new(move |line| theirs.borrow_mut().push(line.to_owned())),
            )
        };
        let app = make(&egui::Context::default());
        // The harness leaves a margin: the app gets the whole window.
        let whole = |ui: &mut egui::Ui, app: &mut App| {
            let window = ui.ctx().content_rect();
            ui.scope_builder(egui::UiBuilder::new().max_rect(window), |ui| {
                ui.set_clip_rect(window);
                app.ui(ui);
            });
        };
        let harness = Harness::builder()
            .with_size(vec2(PICTURE as f32 + PANEL_WIDTH, HEIGHT))
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui_state(whole, app);
        let mut window = Self { harness, said };
        window.until("the scene is shown", |app| app.viewer().source().is_some());
        // The panel's columns find their widths.
        window.harness.run_steps(2);
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

#[test]
fn the_wheel_zooms_over_the_picture_only() {
    let Some(mut window) = Window::showing("square") else { return };
    for (at, zooms) in [(pos2(40.0, 40.0), true), (pos2(250.0, 600.0), false)] {
        let mut expected = window.camera();
        window.harness.event(Event::PointerMoved(at));
        window.harness.step();
        let (unit, delta, modifiers) = (MouseWheelUnit::Line, vec2(0.0, 2.0), Modifiers::NONE);
        let (phase, source) = (egui::TouchPhase::Move, egui::MouseWheelSource::Wheel);
        window.harness.event(Event::MouseWheel { unit, delta, modifiers, phase, source });
        window.harness.step();
        if zooms {
            expected.wheel(2.0);
        }
        assert_eq!(window.camera(), expected);
    }
}

/// `r` renders, shows exactly the bytes that it writes, and says the command.
#[test]
fn r_renders_shows_and_writes_the_same_pixels() {
    let Some(mut window) = Window::showing("cornell") else { return };
    window.press("r");
    window.until("the image is complete and written", |app| {
        matches!(app.viewer().mode(), Mode::Rendered(_)) && app.viewer().notice().is_some()
    });
    window.until("the second file is written", |_| folder().join("rendu.png").exists());
    let shown = window.picture();
    let text = std::fs::read_to_string(folder().join("rendu.ppm")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.by_ref().take(3).collect();
    assert_eq!(header, ["P3", "96 640", "255"]);
    let numbers: Vec<i32> = lines.flat_map(str::split_whitespace).map(|n| n.parse().unwrap()).collect();
    assert_eq!(numbers.len(), 3 * shown.len());
    // The course's format truncates and the screen rounds.
    let apart = |(a, b): (&i32, u8)| i32::from(b) - a;
    let mut apart = numbers.iter().zip(shown.into_iter().flatten()).map(apart);
    assert!(apart.all(|d| d == 0 || d == 1));
    let png = penombre_image::load(&folder().join("rendu.png")).unwrap();
    assert_eq!([png.width(), png.height()], [96, 640]);
    let said = window.said.borrow();
    assert_eq!(*said, ["penombre render cornell --size 96x640"]);
}

#[test]
fn keys_and_buttons_do_what_the_help_says() {
    let Some(mut window) = Window::showing("sphere") else { return };
    for scene in ["square", "cornell", "sphere"] {
        window.press("+");
        window.until(scene, |app| app.viewer().source() == Some(&Source::builtin(scene)));
    }
    window.press("-");
    window.until("cornell", |app| app.viewer().source() == Some(&Source::builtin("cornell")));
    let surfaces = window.picture();
    window.press("w");
    window.until("edges are drawn", |app| app.viewer().is_wireframe());
    let begin = Instant::now();
    while window.picture() == surfaces {
        assert!(begin.elapsed() < LIMIT, "edges are never drawn");
        window.harness.step();
    }
    window.press("w");
    assert!(window.picture() == surfaces, "surfaces come back as they were");
    window.harness.get_by_label("1").click();
    window.harness.run_steps(2);
    assert_eq!(window.harness.state().viewer().settings().phase, Some(1));
    // Flat colours: those of the walls and spheres and the background, nothing between.
    let colors: std::collections::BTreeSet<[u8; 3]> = window.picture().into_iter().collect();
    assert!((2..8).contains(&colors.len()), "{colors:?}");
    window.press("?");
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label_contains("look from above").is_some());
    window.harness.key_press(Key::Escape);
    window.harness.run_steps(2);
    assert!(!window.harness.state().viewer().shows_help());
}

#[test]
fn values_of_the_panel_change_the_command() {
    let Some(mut window) = Window::showing("cornell") else { return };
    window.harness.get_by_label("hard shadows").click();
    window.harness.run_steps(3);
    let command = "penombre render cornell --size 96x640 --hard-shadows";
    assert!(window.harness.query_by_label(command).is_some(), "the panel shows the command");
    window.harness.get_by_label("Copy").click();
    window.harness.step();
    let copied =
        |c: &egui::OutputCommand| matches!(c, egui::OutputCommand::CopyText(text) if text == command);
    assert!(window.harness.output().platform_output.commands.iter().any(copied));
}

#[test]
fn broken_and_missing_files_are_told_and_the_scene_stays() {
    let Some(mut window) = Window::showing("square") else { return };
    let broken = folder().join("broken.toml");
    std::fs::write(&broken, "penombre = 1\n[shape.a]\ntype = \"spere\"\n").unwrap();
    for (name, part) in [("broken.toml", "sphere"), ("gone.obj", "there is no file")] {
        window.harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
        window.harness.run_steps(2);
        window.harness.event(Event::Text(name.to_owned()));
        window.harness.step();
        window.harness.key_press(Key::Enter);
        let begin = Instant::now();
        while window.harness.query_by_label_contains(part).is_none() {
            assert!(begin.elapsed() < LIMIT, "no message says `{part}`");
            window.harness.step();
        }
        window.harness.key_press(Key::Escape);
        window.harness.run_steps(2);
        assert!(window.harness.query_by_label_contains(part).is_none(), "Esc closes it");
        assert_eq!(window.harness.state().viewer().source(), Some(&Source::builtin("square")));
    }
}

#[test]
fn images_are_saved_where_they_should() {
    let Some(mut window) = Window::showing("square") else { return };
    window.press("r");
    window.until("the image is complete", |app| matches!(app.viewer().mode(), Mode::Rendered(_)));
    let type_name = |window: &mut Window, name: &str| {
        window.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        window.harness.run_steps(2);
        window.harness.event(Event::Text(name.to_owned()));
        window.harness.step();
        window.harness.key_press(Key::Enter);
        window.harness.run_steps(2);
    };
    type_name(&mut window, "typed.xyz");
    assert!(window.harness.query_by_label_contains("typed.xyz").is_some(), "the dialogue says what is wrong");
    window.harness.key_press(Key::Escape);
    window.harness.run_steps(2);
    assert!(window.harness.state().viewer().has_picture(), "Esc closed the dialogue and no more");
    type_name(&mut window, "typed.exr");
    window.until("it is told", |app| {
        app.viewer().notice().is_some_and(|n| n.contains("typed.exr was written"))
    });
    assert!(penombre_image::load(&folder().join("typed.exr")).is_ok());
    assert!(!folder().join("typed.xyz").exists());
}

/// Esc leaves a field or closes a list; the program goes on.
#[test]
fn fields_and_lists_keep_their_keys() {
    let Some(mut window) = Window::showing("cornell") else { return };
    let goes_on = |window: &mut Window| {
        window.harness.key_press(Key::Escape);
        window.harness.run_steps(3);
        !window.harness.state().is_closing()
    };
    window.harness.get_by_label("scene").click();
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label("sphere-as-given").is_some(), "the list is open");
    assert!(goes_on(&mut window), "Esc closes the list alone");
    assert!(window.harness.query_by_label("sphere-as-given").is_none(), "the list is closed");
    window.harness.get_by_label("samples per pixel").click();
    window.harness.run_steps(2);
    window.harness.event(Event::Text("3".to_owned()));
    window.harness.step();
    assert!(goes_on(&mut window), "Esc leaves the field alone");
    assert!(!goes_on(&mut window), "then it means what it says");
}

/// A render that goes on beyond the asked samples keeps its image on the screen, can be stopped, and `r` does not begin
/// it anew.
#[test]
fn images_beyond_the_asked_samples() {
    let Some(mut window) = Window::showing("square") else { return };
    window.harness.get_by_label("go on and on").click();
    window.harness.run_steps(2);
    window.press("r");
    window.until(
        "the image has more samples than were asked for",
        |app| matches!(app.viewer().mode(), Mode::Rendered(figures) if figures.spp > 60.0),
    );
    window.press("r");
    assert!(matches!(window.harness.state().viewer().mode(), Mode::Rendered(_)), "it goes on");
    window.harness.get_by_label("Stop").click();
    window.harness.run_steps(3);
    assert!(window.harness.query_by_label("Render").is_some());
    assert!(window.harness.state().viewer().has_picture());
}

#[test]
fn any_size_of_window_is_survived() {
    let Some(mut window) = Window::showing("cornell") else { return };
    for size in [vec2(1.0, 1.0), vec2(PANEL_WIDTH, 2.0), vec2(3000.0, 3.0), vec2(PANEL_WIDTH + 64.0, 64.0)] {
        window.harness.set_size(size);
        window.harness.run_steps(3);
        window.press("w");
        window.press("w");
        window.press("r");
        assert!(window.harness.render().is_ok());
    }
    window.until("the last render is complete", |app| matches!(app.viewer().mode(), Mode::Rendered(_)));
    assert_eq!(window.harness.state().viewer().setup().size, [64, 64]);
}

#[test]
fn full_screen_shows_the_picture_alone() {
    let Some(mut window) = Window::showing("cornell") else { return };
    assert!(window.harness.query_by_label("Render").is_some());
    window.press("f");
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label("Render").is_none());
    assert_eq!(window.harness.state().viewer().setup().size[0], PICTURE + PANEL_WIDTH as u32);
    window.press("f");
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label("Render").is_some());
}

/// A file as the window system drops it.
#[derive(Debug)]
struct Dropped(std::path::PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

/// What was loaded is rendered though its file is gone; opened again, the loss is told.
#[test]
fn a_dropped_file_may_vanish() {
    let Some(mut window) = Window::showing("square") else { return };
    let path = folder().join("dropped.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let drop = |window: &mut Window| {
        window.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.clone())));
        window.harness.step();
    };
    drop(&mut window);
    let shown = Source::file(&path).unwrap();
    window.until("the dropped file is shown", |app| app.viewer().source() == Some(&shown));
    std::fs::remove_file(&path).unwrap();
    window.press("r");
    window.until("the image is complete", |app| matches!(app.viewer().mode(), Mode::Rendered(_)));
    drop(&mut window);
    window.until("the loss is told", |app| app.viewer().message().is_some_and(|m| m.contains("dropped.obj")));
    assert_eq!(window.harness.state().viewer().source(), Some(&shown));
}
