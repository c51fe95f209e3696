//! The window's behaviour as a state machine: what a person does goes in, what is to be done comes out.
//!
//! A [`Viewer`] knows no window, no thread and no clock. The program around it turns events into [`Input`]s,
//! carries out the [`Action`]s, and draws what [`Viewer::mode`] says.

mod answers;

use crate::camera::{AxisView, Button, CourseCamera};
use crate::keys::{Command, KeyPress, command};
use crate::progressive::{Figures, Stage};
use crate::session::{Settings, Setup, Source};
use penombre_image::ToneCurve;
use penombre_math::{Bounds3, Vec2};
use std::path::PathBuf;

/// The scenes that `+` and `-` go through, in the course's order.
pub const COURSE_SCENES: [&str; 3] = ["sphere", "square", "cornell"];
/// Where `r` writes.
pub const RENDER_FILES: [&str; 2] = ["rendu.ppm", "rendu.png"];
/// The course's window, pixels.
pub const WINDOW_SIZE: [u32; 2] = [480, 480];
/// The live render starts when the camera has rested so long, seconds.
const REST: f64 = 0.05;
/// To a longer notice nothing is added, characters.
const LONG_NOTICE: usize = 60;
/// Largest edge of an image, pixels.
const LARGEST_EDGE: u32 = 65536;

/// What happened.
#[derive(Clone, Debug)]
pub enum Input {
    /// A key went down.
    Key(KeyPress),
    /// The mouse moved with a button held; pixels, y down.
    Drag {
        /// The button.
        button: Button,
        /// Where it was.
        from: Vec2,
        /// Where it is.
        to: Vec2,
        /// Size of the picture.
        window: Vec2,
    },
    /// The wheel turned; positive is away from the hand.
    Wheel(f32),
    /// The picture has another size, pixels; 0 while the window is hidden.
    Resize([u32; 2]),
    /// A file was chosen in the dialogue or named by a program.
    Open(PathBuf),
    /// A file was dropped on the window.
    Drop(PathBuf),
    /// A place for the image was chosen in the dialogue.
    SaveTo(PathBuf),
    /// A dialogue was closed without a choice.
    DialogClosed,
    /// A scene was loaded.
    Loaded {
        /// The source of [`Action::LoadScene`].
        source: Source,
        /// Its camera.
        camera: CourseCamera,
        /// A box around it, metres.
        bounds: Bounds3,
    },
    /// A scene could not be loaded; why, for a person.
    LoadFailed {
        /// The source of [`Action::LoadScene`].
        source: Source,
        /// Why.
        message: String,
    },
    /// News of a render.
    Render {
        /// The number of its [`Action::StartRender`].
        id: u64,
        /// The news.
        event: RenderEvent,
    },
    /// An image was written, or could not be; a text for a person.
    Saved(Result<String, String>),
    /// A value of the panel changed.
    Panel(PanelChange),
    /// Something failed that nobody asked for; why, for a person.
    Fault(String),
    /// The message was read.
    MessageClosed,
    /// Time passed: seconds since any fixed moment. Needed when [`Viewer::next_tick`] says so.
    Tick(f64),
}

/// News of a render.
#[derive(Clone, Debug, PartialEq)]
pub enum RenderEvent {
    /// There is another picture.
    Picture(Stage, Figures),
    /// All is done.
    Finished,
    /// It could not begin; why, for a person.
    Failed(String),
}

/// A value of the panel. `None`: as the scene has it.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelChange {
    /// The scene: a built-in's name.
    Scene(String),
    /// Phase of the course, 1 to 4.
    Phase(Option<u8>),
    /// Area lights act as points.
    HardShadows(Option<bool>),
    /// Name of the integrator.
    Integrator(Option<String>),
    /// Samples per pixel.
    Spp(Option<u32>),
    /// Shadow rays per point of lights that have an area.
    ShadowSamples(Option<u32>),
    /// Brightness, powers of two.
    Exposure(f32),
    /// The tone curve.
    Tone(Option<ToneCurve>),
    /// Render whenever the camera rests.
    Live(bool),
    /// Renders from now on go on beyond the samples per pixel, until they are cancelled.
    Beyond(bool),
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Load this in the background and answer with [`Input::Loaded`] or [`Input::LoadFailed`].
    LoadScene(Source),
    /// Render this in the background and report with [`Input::Render`]. A render that runs is replaced.
    StartRender {
        /// Number of the render; later ones have larger numbers.
        id: u64,
        /// What to render.
        setup: Setup,
        /// Go on beyond the samples per pixel.
        beyond: bool,
    },
    /// Forget the scene that is being loaded.
    CancelLoad,
    /// Stop the render.
    CancelRender,
    /// Write the image and answer with [`Input::Saved`].
    SaveImage {
        /// Where.
        path: PathBuf,
        /// The image of exactly the asked samples, and `.ppm` in the course's way: the files of `r`. Else the newest
        /// image.
        course_ppm: bool,
    },
    /// Ask for a file to open.
    OpenDialog,
    /// Ask for a place for the image.
    SaveDialog,
    /// Draw anew.
    Redraw,
    /// Full screen on or off; off restores [`WINDOW_SIZE`].
    ToggleFullscreen(bool),
    /// Wireframe on or off.
    ToggleWireframe(bool),
    /// Show the help, or hide it.
    ShowHelp(bool),
    /// End the program.
    Quit,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// The raster preview.
    Raster,
    /// A render on its way; `None` before its first picture, while the raster preview is still shown.
    Rendering(Option<Figures>),
    /// The rendered image.
    Rendered(Figures),
}

/// A render that was started and not cancelled.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Running {
    id: u64,
    /// Write the files of `r` when it is complete.
    save: bool,
    /// True until the last picture.
    busy: bool,
}

/// The state of the window.
#[derive(Clone, Debug)]
pub struct Viewer {
    camera: CourseCamera,
    home: CourseCamera,
    bounds: Bounds3,
    size: [u32; 2],
    settings: Settings,
    source: Option<Source>,
    loading: Option<Source>,
    mode: Mode,
    running: Option<Running>,
    renders: u64,
    live: bool,
    beyond: bool,
    wireframe: bool,
    fullscreen: bool,
    help: bool,
    message: Option<String>,
    notice: Option<String>,
    /// Something that the live render must follow has changed since the last tick.
    moved: bool,
    /// When the rest began, as far as ticks have told.
    resting_since: Option<f64>,
}

impl Viewer {
    /// A window of that size without a scene; the first action loads one.
    pub fn new(size: [u32; 2], first: Source) -> (Self, Vec<Action>) {
        let camera = crate::camera::LookAt {
            position: penombre_math::DVec3::new(0.0, 0.0, 6.1),
            target: penombre_math::DVec3::ZERO,
            up: penombre_math::DVec3::Y,
            lens: crate::camera::Lens::Perspective { fov: 45.0 },
            near: 4.1,
            far: 10000.0,
        };
        let camera = CourseCamera::of_look_at(&camera, &Bounds3::EMPTY);
        let viewer = Self {
            camera,
            home: camera,
            bounds: Bounds3::EMPTY,
            size,
            settings: Settings::default(),
            source: None,
            loading: Some(first.clone()),
            mode: Mode::Raster,
            running: None,
            renders: 0,
            live: false,
            beyond: false,
            wireframe: false,
            fullscreen: false,
            help: false,
            message: None,
            notice: None,
            moved: false,
            resting_since: None,
        };
        (viewer, vec![Action::LoadScene(first)])
    }

    /// Takes what happened and says what is to be done.
    pub fn handle(&mut self, input: Input) -> Vec<Action> {
        match input {
            Input::Key(press) => self.key(press),
            Input::Drag { button, from, to, window } => {
                self.move_camera(|c| c.drag(button, from, to, window))
            }
            Input::Wheel(steps) => self.move_camera(|c| c.wheel(steps)),
            Input::Resize(size) => self.resize(size),
            Input::Open(path) | Input::Drop(path) => match Source::file(&path) {
                Ok(source) => self.load(source),
                Err(message) => self.say(message),
            },
            Input::SaveTo(path) => vec![Action::SaveImage { path, course_ppm: false }],
            Input::DialogClosed => Vec::new(),
            Input::Loaded { source, camera, bounds } => self.loaded(source, camera, bounds),
            Input::LoadFailed { source, message } if self.loading.as_ref() == Some(&source) => {
                self.loading = None;
                self.say(message)
            }
            Input::LoadFailed { .. } => Vec::new(),
            Input::Render { id, event } => self.render_event(id, event),
            Input::Saved(Ok(text)) => {
                let before = self.notice.take().filter(|before| before.len() < LONG_NOTICE);
                self.notice = Some(before.map_or(text.clone(), |before| format!("{before}, {text}")));
                vec![Action::Redraw]
            }
            Input::Saved(Err(message)) | Input::Fault(message) => self.say(message),
            Input::Panel(change) => self.panel(change),
            Input::MessageClosed => {
                self.message = None;
                vec![Action::Redraw]
            }
            Input::Tick(now) => self.tick(now),
        }
    }

    fn key(&mut self, press: KeyPress) -> Vec<Action> {
        match command(press) {
            Command::Render => self.render_key(),
            Command::NextScene => self.step_scene(true),
            Command::PreviousScene => self.step_scene(false),
            Command::Wireframe => {
                self.wireframe = !self.wireframe;
                // Edges are of the preview: an image would hide them.
                let back =
                    if self.mode == Mode::Raster { vec![Action::Redraw] } else { self.back_to_raster() };
                [vec![Action::ToggleWireframe(self.wireframe)], back].concat()
            }
            Command::Fullscreen => {
                self.fullscreen = !self.fullscreen;
                vec![Action::ToggleFullscreen(self.fullscreen)]
            }
            Command::Quit => vec![Action::Quit],
            Command::CancelOrQuit => self.escape(),
            Command::Frame => {
                let (bounds, aspect) = (self.bounds, self.aspect());
                self.move_camera(|c| c.frame(&bounds, aspect))
            }
            Command::Home => {
                let home = self.home;
                self.move_camera(|c| *c = home)
            }
            Command::Front => self.move_camera(|c| c.look_along(AxisView::Front)),
            Command::Right => self.move_camera(|c| c.look_along(AxisView::Right)),
            Command::Top => self.move_camera(|c| c.look_along(AxisView::Top)),
            Command::Open => vec![Action::OpenDialog],
            Command::Save if self.has_picture() => vec![Action::SaveDialog],
            Command::Save => self.say("there is no image yet: press r to render one".to_owned()),
            Command::Help => {
                self.help = !self.help;
                vec![Action::ShowHelp(self.help), Action::Redraw]
            }
        }
    }

    /// Esc: whatever is in front goes first.
    fn escape(&mut self) -> Vec<Action> {
        if self.message.take().is_some() {
            return vec![Action::Redraw];
        }
        if std::mem::take(&mut self.help) {
            return vec![Action::ShowHelp(false), Action::Redraw];
        }
        if self.loading.is_some() && self.source.is_some() {
            self.loading = None;
            return vec![Action::CancelLoad, Action::Redraw];
        }
        if !self.is_busy() {
            return vec![Action::Quit];
        }
        if let (Mode::Rendered(_), Some(running)) = (self.mode, &mut self.running) {
            // The image is complete and stays; only the refinement ends.
            running.busy = false;
            return vec![Action::CancelRender, Action::Redraw];
        }
        // The live render would start again at once.
        self.live = false;
        self.back_to_raster()
    }

    fn render_key(&mut self) -> Vec<Action> {
        if self.source.is_none() {
            // Why there is none has been said, and stays.
            let message = self.message.take().unwrap_or("there is no scene to render".to_owned());
            return self.say(message);
        }
        match (self.mode, &mut self.running) {
            (Mode::Rendering(_), Some(running)) => {
                // The same image is on its way already: it will be saved when it is complete.
                running.save = true;
                return Vec::new();
            }
            (Mode::Rendered(_), Some(running)) if running.busy => {
                // It goes on beyond the image that is asked for, which is there.
                return RENDER_FILES.map(|f| Action::SaveImage { path: f.into(), course_ppm: true }).to_vec();
            }
            _ => {}
        }
        self.start_render(true)
    }

    /// Starts a render; `save`: write the files of `r` when it is complete.
    fn start_render(&mut self, save: bool) -> Vec<Action> {
        if self.source.is_none() || self.size.contains(&0) {
            return Vec::new();
        }
        self.renders += 1;
        self.notice = None;
        (self.moved, self.resting_since) = (false, None);
        self.running = Some(Running { id: self.renders, save, busy: true });
        self.mode = Mode::Rendering(None);
        vec![
            Action::StartRender { id: self.renders, setup: self.setup(), beyond: self.beyond },
            Action::Redraw,
        ]
    }

    fn render_event(&mut self, id: u64, event: RenderEvent) -> Vec<Action> {
        // News of renders that were cancelled in the meantime are of no interest.
        let Some(running) = self.running.as_mut().filter(|r| r.id == id) else { return Vec::new() };
        match event {
            RenderEvent::Picture(Stage::Coarse | Stage::Refining, figures) => {
                self.mode = Mode::Rendering(Some(figures));
                vec![Action::Redraw]
            }
            RenderEvent::Picture(Stage::Complete | Stage::Beyond, figures) => {
                self.mode = Mode::Rendered(figures);
                let save = std::mem::take(&mut running.save);
                let files = RENDER_FILES.iter().filter(|_| save);
                files
                    .map(|f| Action::SaveImage { path: f.into(), course_ppm: true })
                    .chain([Action::Redraw])
                    .collect()
            }
            RenderEvent::Finished => {
                running.busy = false;
                vec![Action::Redraw]
            }
            RenderEvent::Failed(message) => {
                (self.running, self.mode, self.live) = (None, Mode::Raster, false);
                self.say(message)
            }
        }
    }

    /// Goes back to the raster preview at once; the live render will start when all rests.
    fn back_to_raster(&mut self) -> Vec<Action> {
        (self.moved, self.resting_since) = (true, None);
        let cancel = self.running.take().is_some_and(|r| r.busy);
        self.mode = Mode::Raster;
        cancel.then_some(Action::CancelRender).into_iter().chain([Action::Redraw]).collect()
    }

    fn move_camera(&mut self, change: impl FnOnce(&mut CourseCamera)) -> Vec<Action> {
        let before = self.camera;
        change(&mut self.camera);
        if self.camera == before { Vec::new() } else { self.back_to_raster() }
    }

    fn resize(&mut self, size: [u32; 2]) -> Vec<Action> {
        let size = size.map(|edge| edge.min(LARGEST_EDGE));
        if size == self.size {
            return Vec::new();
        }
        self.size = size;
        self.back_to_raster()
    }

    fn load(&mut self, source: Source) -> Vec<Action> {
        self.loading = Some(source.clone());
        vec![Action::LoadScene(source), Action::Redraw]
    }

    fn loaded(&mut self, source: Source, camera: CourseCamera, bounds: Bounds3) -> Vec<Action> {
        // Another scene was asked for since.
        if self.loading.as_ref() != Some(&source) {
            return Vec::new();
        }
        (self.loading, self.source, self.message, self.notice) = (None, Some(source), None, None);
        (self.camera, self.home, self.bounds) = (camera, camera, bounds);
        // What the panel changed was meant for the scene before; how it is shown stays.
        let Settings { exposure, tone, .. } = self.settings;
        self.settings = Settings { exposure, tone, ..Settings::default() };
        self.back_to_raster()
    }

    fn step_scene(&mut self, forward: bool) -> Vec<Action> {
        // Pressed again while loading, the key goes on from the scene that is being loaded.
        let shown = self.loading.as_ref().or(self.source.as_ref());
        let at = shown.and_then(|s| COURSE_SCENES.iter().position(|name| *name == s.scene));
        let count = COURSE_SCENES.len();
        let next = match (at, forward) {
            (Some(i), true) => (i + 1) % count,
            (Some(i), false) => (i + count - 1) % count,
            (None, true) => 0,
            (None, false) => count - 1,
        };
        self.load(Source::builtin(COURSE_SCENES[next]))
    }

    fn panel(&mut self, change: PanelChange) -> Vec<Action> {
        let before = self.settings.clone();
        match change {
            PanelChange::Scene(name) => return self.load(Source::builtin(&name)),
            PanelChange::Live(live) => {
                (self.live, self.moved) = (live, true);
                self.resting_since = None;
                return vec![Action::Redraw];
            }
            PanelChange::Beyond(beyond) => {
                self.beyond = beyond;
                return vec![Action::Redraw];
            }
            PanelChange::Exposure(v) => {
                self.settings.exposure = if v.is_finite() { v } else { 0.0 };
                return vec![Action::Redraw];
            }
            PanelChange::Tone(v) => {
                self.settings.tone = v;
                return vec![Action::Redraw];
            }
            PanelChange::Phase(v) => self.settings.phase = v.map(|v| v.clamp(1, 4)),
            PanelChange::HardShadows(v) => self.settings.hard_shadows = v,
            PanelChange::Integrator(v) => self.settings.integrator = v,
            PanelChange::Spp(v) => self.settings.spp = v.map(|v| v.clamp(1, 1 << 24)),
            PanelChange::ShadowSamples(v) => self.settings.shadow_samples = v.map(|v| v.clamp(1, 65536)),
        }
        if self.settings == before { Vec::new() } else { self.back_to_raster() }
    }

    fn tick(&mut self, now: f64) -> Vec<Action> {
        if std::mem::take(&mut self.moved) {
            self.resting_since = Some(now);
        }
        let rested = self.resting_since.is_some_and(|since| now - since >= REST);
        if !(rested && self.live && !self.wireframe && self.mode == Mode::Raster) {
            return Vec::new();
        }
        self.start_render(false)
    }

    fn say(&mut self, message: String) -> Vec<Action> {
        self.message = Some(message);
        vec![Action::Redraw]
    }
}

#[cfg(test)]
mod tests;
