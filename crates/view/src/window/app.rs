//! The window: events in, pictures out. What it does is the state machine's; how is the desk's.

use super::browse::{Browser, Choice, Purpose};
use super::canvas::{Canvas, Place};
use super::desk::{Desk, Wake};
use super::gpu::{Gpu, Look};
use super::marker::Marker;
use super::panel::{self, Done, Shown};
use super::screen::Screen;
use crate::keys::help_text;
use crate::session::{Setup, Source};
use crate::state::{Action, Input, Mode, PanelChange, Viewer, WINDOW_SIZE};
use eframe::egui::{self, Color32, ViewportCommand};
use eframe::egui_wgpu::RenderState;
use penombre_image::ToneCurve;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Width of help and messages where there is room, points.
const OVERLAY_WIDTH: f32 = 640.0;
/// How long a frame waits for the first picture of the render that it started.
const FIRST_PICTURE: Duration = Duration::from_millis(20);

/// How the window starts.
#[derive(Clone, Debug)]
pub struct Start {
    /// The first scene.
    pub source: Source,
    /// Size of the picture, pixels; `None`: what the scene says.
    pub size: Option<[u32; 2]>,
    /// Render whenever the camera rests, from the beginning.
    pub live: bool,
    /// Draw the marker by which programs measure the window's answers.
    pub latency_marker: bool,
}

/// Takes lines for standard output: the command of each image that `r` wrote.
pub type Say = Box<dyn Fn(&str)>;

/// The window's contents.
pub struct App {
    viewer: Viewer,
    desk: Desk,
    canvas: Canvas,
    screen: Screen,
    browser: Option<Browser>,
    say: Say,
    marker: Option<Marker>,
    /// Faults of the graphics card, from whatever thread they came.
    faults: Arc<Mutex<Vec<String>>>,
    /// The setup of the command that is shown, and that command.
    command: Option<(Setup, Source, Result<String, String>)>,
    /// True once the window was asked to close.
    closing: bool,
    /// Whether keys were meant for the picture at the end of the frame before.
    keyboard_was_free: bool,
    /// True if this frame started a render.
    started: bool,
    /// True until the first scene has given the window its size.
    fit: bool,
    begin: Instant,
    title: String,
}

impl App {
    /// An app that draws with this card. `state` is `None` only where nothing is drawn.
    pub fn new(ctx: &egui::Context, state: Option<&RenderState>, start: Start, say: Say) -> Self {
        // Ctrl with plus and minus would change the picture's size.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        let faults = Arc::new(Mutex::new(Vec::new()));
        let waker = ctx.clone();
        let wake: Wake = Arc::new(move || waker.request_repaint());
        if let Some(state) = state {
            let (faults, wake) = (faults.clone(), wake.clone());
            state.device.on_uncaptured_error(Arc::new(move |error| {
                faults.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
                wake();
            }));
        }
        let gpu = state.map(Gpu::new);
        let size = start.size.unwrap_or(WINDOW_SIZE);
        let (mut viewer, actions) = Viewer::new(size, start.source);
        if start.live {
            viewer.handle(Input::Panel(PanelChange::Live(true)));
        }
        let mut app = Self {
            viewer,
            desk: Desk::new(gpu.clone(), wake),
            canvas: Canvas::default(),
            screen: Screen::new(gpu),
            browser: None,
            say,
            marker: start.latency_marker.then(Marker::default),
            faults,
            command: None,
            closing: false,
            keyboard_was_free: true,
            started: false,
            fit: start.size.is_none(),
            begin: Instant::now(),
            title: String::new(),
        };
        for action in actions {
            app.perform(action, ctx);
        }
        app
    }

    /// Draws the window and takes what happened since the last time.
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.take_news(&ctx);
        let fullscreen = self.viewer.is_fullscreen();
        if !fullscreen {
            self.panel(ui);
        }
        let picture = egui::CentralPanel::no_frame().show(ui, |ui| self.picture(ui)).inner;
        self.dialogues(&ctx);
        self.tick(&ctx);
        self.draw(ui, picture);
        self.name_window(&ctx);
        self.keyboard_was_free = self.keyboard_is_free(&ctx);
    }

    /// True if keys are meant for the picture.
    fn keyboard_is_free(&self, ctx: &egui::Context) -> bool {
        self.browser.is_none() && !ctx.text_edit_focused() && !egui::Popup::is_any_open(ctx)
    }

    /// Starts the live render when the camera has rested. A render that this frame started may show its first picture in
    /// it, if that comes at once: a frame less to wait for.
    fn tick(&mut self, ctx: &egui::Context) {
        let now = self.begin.elapsed().as_secs_f64();
        if self.viewer.next_tick(now).is_some() {
            self.handle(Input::Tick(now), ctx);
        }
        if let Some(left) = self.viewer.next_tick(now) {
            ctx.request_repaint_after(Duration::from_secs_f64(left));
        }
        if std::mem::take(&mut self.started) {
            self.desk.wait_for_picture(FIRST_PICTURE);
            self.take_news(ctx);
        }
    }

    fn handle(&mut self, input: Input, ctx: &egui::Context) {
        for action in self.viewer.handle(input) {
            self.perform(action, ctx);
        }
    }

    fn perform(&mut self, action: Action, ctx: &egui::Context) {
        match action {
            Action::LoadScene(source) => {
                let size = (!self.fit).then(|| self.viewer.setup().size);
                self.desk.load(source, size);
            }
            Action::StartRender { id, setup, beyond } => {
                self.desk.render(id, setup, beyond);
                self.started = true;
            }
            Action::CancelLoad => self.desk.cancel_load(),
            Action::CancelRender => self.desk.cancel(),
            Action::SaveImage { path, course_ppm } => self.save(&path, course_ppm),
            Action::OpenDialog => self.browse(Purpose::Open),
            Action::SaveDialog => self.browse(Purpose::Save),
            Action::ToggleFullscreen(on) => {
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(on));
                if !on {
                    resize(ctx, WINDOW_SIZE);
                }
            }
            Action::Quit => {
                self.closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Action::Redraw | Action::ToggleWireframe(_) | Action::ShowHelp(_) => {}
        }
        ctx.request_repaint();
    }

    /// What happened in the background.
    fn take_news(&mut self, ctx: &egui::Context) {
        for news in self.desk.poll() {
            let loaded = matches!(news, Input::Loaded { .. });
            self.handle(news, ctx);
            if loaded
                && std::mem::take(&mut self.fit)
                && let Some(session) = self.desk.session()
            {
                resize(ctx, session.values().size);
            }
        }
        let faults = std::mem::take(&mut *self.faults.lock().unwrap_or_else(PoisonError::into_inner));
        if let Some(fault) = faults.first() {
            self.handle(Input::Fault(format!("the graphics card failed: {fault}")), ctx);
        }
    }

    fn panel(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.update_command();
        let shown = Shown {
            session: self.desk.session(),
            command: self.command.as_ref().map(|(_, _, command)| command),
            saving: self.desk.is_saving(),
        };
        let done = panel::show(ui, &self.viewer, &shown);
        for done in done.into_iter().filter(|_| is_first_pass(&ctx)) {
            let input = match done {
                Done::Changed(change) => Input::Panel(change),
                Done::Key(press) => Input::Key(press),
            };
            self.handle(input, &ctx);
        }
    }

    /// Keeps the command of the panel that of the picture.
    fn update_command(&mut self) {
        let Some(session) = self.desk.session() else { return };
        let (setup, source) = (self.viewer.setup(), session.source().clone());
        if self.command.as_ref().is_none_or(|(s, from, _)| (s, from) != (&setup, &source)) {
            let command = session.command_line(&setup);
            self.command = Some((setup, source, command));
        }
    }

    /// Takes the picture's room and events. The room in points, its edges on pixels.
    fn picture(&mut self, ui: &mut egui::Ui) -> egui::Rect {
        let ctx = ui.ctx().clone();
        let scale = ctx.pixels_per_point();
        let available = ui.available_rect_before_wrap();
        let edge = |v: f32| (v * scale).round().max(0.0) / scale;
        let rect = egui::Rect::from_min_max(
            egui::pos2(edge(available.min.x), edge(available.min.y)),
            egui::pos2(edge(available.max.x), edge(available.max.y)),
        );
        let size = [rect.width(), rect.height()].map(|v| (v * scale).round().max(0.0) as u32);
        self.handle(Input::Resize(size), &ctx);
        let response = ui.interact(rect, ui.scope_id().with("picture"), egui::Sense::hover());
        let place = Place {
            rect,
            scale,
            hovered: response.contains_pointer() && self.browser.is_none(),
            // What a field or a list had when the keys were pressed is theirs: Esc has closed them by now.
            keyboard: self.keyboard_was_free && self.keyboard_is_free(&ctx),
        };
        let (events, dropped) = ui.input(|i| (i.events.clone(), i.raw.dropped_files.clone()));
        if !is_first_pass(&ctx) {
            return rect;
        }
        if let Some(marker) = &mut self.marker {
            marker.count(&events);
        }
        for input in self.canvas.inputs(&events, &place) {
            self.handle(input, &ctx);
        }
        for path in dropped.into_iter().map(|file| file.path().to_owned()) {
            self.handle(Input::Drop(path), &ctx);
        }
        rect
    }

    fn draw(&mut self, ui: &mut egui::Ui, rect: egui::Rect) {
        let settings = self.viewer.settings();
        let tone = self.desk.session().map_or(ToneCurve::Raw, |session| session.tone(settings));
        let image = match self.viewer.mode() {
            Mode::Raster | Mode::Rendering(None) => None,
            Mode::Rendering(Some(_)) | Mode::Rendered(_) => self.desk.picture().cloned(),
        };
        match &image {
            Some(snapshot) => self.screen.image(ui, rect, snapshot, tone, settings.exposure),
            None => {
                let phase = settings.phase.or(self.desk.session().map(|s| s.values().phase));
                let look = Look {
                    flat: phase == Some(1),
                    // The raster preview has no other curves.
                    srgb: tone != ToneCurve::Raw,
                    exposure: settings.exposure,
                    wireframe: self.viewer.is_wireframe(),
                };
                self.screen.preview(ui, rect, &mut self.desk, &self.viewer, look);
            }
        }
        if let Some(marker) = &self.marker {
            marker.draw(ui.ctx(), self.viewer.mode());
        }
    }

    fn browse(&mut self, purpose: Purpose) {
        let folder = std::env::current_dir().unwrap_or_default();
        let proposal = match (purpose, self.desk.session()) {
            (Purpose::Save, Some(session)) => format!("{}.png", session.name()),
            _ => String::new(),
        };
        self.browser = Some(Browser::new(purpose, &folder, &proposal));
    }

    /// What lies over the picture: files, help, messages.
    fn dialogues(&mut self, ctx: &egui::Context) {
        if let Some(browser) = &mut self.browser
            && let Some(choice) = browser.show(ctx)
        {
            let input = match (choice, browser.purpose()) {
                (Choice::Closed, _) => Input::DialogClosed,
                (Choice::File(path), Purpose::Open) => Input::Open(path),
                (Choice::File(path), Purpose::Save) => Input::SaveTo(path),
            };
            self.browser = None;
            self.handle(input, ctx);
        }
        if self.viewer.shows_help() {
            let help = help_text();
            overlay(ctx, "Keys and mouse", &help);
        }
        if let Some(message) = self.viewer.message().map(str::to_owned)
            && overlay(ctx, "Message", &message)
        {
            self.handle(Input::MessageClosed, ctx);
        }
    }

    fn save(&mut self, path: &Path, course_ppm: bool) {
        // The two files of `r` have one command.
        if course_ppm
            && path.extension().is_some_and(|e| e == "ppm")
            && let Some(command) = self.desk.rendered_command()
        {
            (self.say)(&command);
        }
        self.desk.save(path.to_owned(), course_ppm, self.viewer.settings());
    }

    fn name_window(&mut self, ctx: &egui::Context) {
        let scene = self.desk.session().map(|session| session.name());
        let title = scene.map_or("penombre".to_owned(), |name| format!("penombre – {name}"));
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Waits for what is being written; what could not be, for a person.
    pub fn finish(&mut self) -> Vec<String> {
        self.desk.cancel();
        self.desk.finish_saves()
    }

    /// True if the processor draws the window.
    pub fn is_software(&self) -> bool {
        self.screen.is_software()
    }

    /// True once the window was asked to close.
    pub fn is_closing(&self) -> bool {
        self.closing
    }

    /// The state machine, for tests.
    pub fn viewer(&self) -> &Viewer {
        &self.viewer
    }
}

/// A frame may be laid out again with the same events: what they say counts once.
fn is_first_pass(ctx: &egui::Context) -> bool {
    ctx.current_pass_index() == 0
}

/// Gives the picture that size, pixels, as far as the screen allows.
fn resize(ctx: &egui::Context, [width, height]: [u32; 2]) {
    let scale = ctx.pixels_per_point();
    let mut size = egui::vec2(width as f32 / scale + panel::WIDTH, height as f32 / scale);
    if let Some(screen) = ctx.input(|i| i.viewport().monitor_size).filter(|s| s.min_elem() > 0.0) {
        size = size.min(screen);
    }
    ctx.send_viewport_cmd(ViewportCommand::InnerSize(size));
}

/// A text over the picture that can be selected; true if it was closed.
fn overlay(ctx: &egui::Context, title: &str, text: &str) -> bool {
    let mut open = true;
    let room = ctx.content_rect().size() - egui::vec2(40.0, 80.0);
    let window = egui::Window::new(title).collapsible(false).resizable(false).open(&mut open);
    let place = window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO);
    place.show(ctx, |ui| {
        ui.set_width(room.x.clamp(40.0, OVERLAY_WIDTH));
        egui::ScrollArea::vertical().max_height(room.y.max(40.0)).show(ui, |ui| {
            // Broken files are quoted in messages, whatever they hold.
            let shown = |c: char| match c {
                '\n' => c,
                c if c.is_control() || c == char::REPLACEMENT_CHARACTER => '·',
                c => c,
            };
            let text: String = text.trim_end().chars().map(shown).collect();
            let text = egui::RichText::new(text).monospace().color(Color32::WHITE);
            ui.add(egui::Label::new(text).selectable(true).wrap());
        });
    });
    !open
}
