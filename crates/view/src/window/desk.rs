//! Carries out what the state machine asks for, in the background, and reports what came of it.

use super::gpu::{Gpu, GpuEdges, GpuMesh};
use super::task::Task;
use crate::progressive::{Options, Renders, Snapshot, State};
use crate::session::{Loading, Session, Settings, Setup, Source};
use crate::state::{Input, RenderEvent};
use penombre_image::WriteOptions;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Least time between two pictures of a render where the processor also draws the window.
const SOFTWARE_INTERVAL: Duration = Duration::from_millis(300);

/// Wakes the window from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// A scene that is shown, on the card.
struct Stage {
    session: Session,
    mesh: Option<Arc<GpuMesh>>,
    edges: Option<GpuEdges>,
    /// Edges on their way.
    finding: Option<Task<GpuEdges>>,
}

/// The render that is shown.
struct Current {
    id: u64,
    session: Session,
    setup: Setup,
    /// The newest picture.
    newest: Option<Snapshot>,
    /// True once its end was reported.
    ended: bool,
}

/// Scene, render and saves.
pub struct Desk {
    gpu: Option<Gpu>,
    wake: Wake,
    stage: Option<Stage>,
    loading: Option<Loading<Option<Arc<GpuMesh>>>>,
    renders: Renders,
    current: Option<Current>,
    saves: Vec<Task<Result<String, String>>>,
    /// What is to be told with the next news.
    pending: Vec<Input>,
}

impl Desk {
    /// An empty desk. Without a card, no preview is drawn.
    pub fn new(gpu: Option<Gpu>, wake: Wake) -> Self {
        let renders = Renders::default();
        let (saves, pending) = (Vec::new(), Vec::new());
        Self { gpu, wake, stage: None, loading: None, renders, current: None, saves, pending }
    }

    /// Loads a scene; `size`: of the picture, pixels; `None`: what the scene says.
    pub fn load(&mut self, source: Source, size: Option<[u32; 2]>) {
        let gpu = self.gpu.clone();
        let prepare = move |session: &Session| gpu.map(|gpu| Arc::new(GpuMesh::new(&gpu, session.preview())));
        self.loading = Some(Loading::start(source, size, prepare, self.wake.clone()));
    }

    /// Forgets the scene that is being loaded.
    pub fn cancel_load(&mut self) {
        self.loading = None;
    }

    /// Starts a render of the scene that is shown.
    pub fn render(&mut self, id: u64, setup: Setup, beyond: bool) {
        let Some(stage) = &self.stage else { return };
        let session = stage.session.clone();
        let mut options = Options { beyond, wake: self.wake.clone(), ..Options::default() };
        if self.gpu.as_ref().is_some_and(Gpu::is_software) {
            options.interval = SOFTWARE_INTERVAL;
        }
        let (theirs, wanted) = (session.clone(), setup.clone());
        self.renders.start(move || theirs.plan(&wanted), options);
        self.current = Some(Current { id, session, setup, newest: None, ended: false });
    }

    /// Waits a moment for the render's first picture, so that the frame that started it can show it.
    pub fn wait_for_picture(&self, most: Duration) {
        if let Some(render) = self.renders.current() {
            render.wait_for_snapshot(most);
        }
    }

    /// Stops the render; its newest picture stays.
    pub fn cancel(&mut self) {
        self.renders.cancel();
    }

    /// Writes the newest image, or with `exact` that of exactly the asked samples, with the tone curve and the exposure of
    /// `shown`. The image may be older than the scene that is shown by now: it is written with the data of its own.
    pub fn save(&mut self, path: PathBuf, exact: bool, shown: &Settings) {
        let complete = self.renders.current().and_then(|render| render.complete()).filter(|_| exact);
        let newest = self.current.as_ref().and_then(|current| current.newest.clone());
        let (Some(current), Some(picture)) = (&self.current, complete.or(newest)) else {
            let message = format!("{} was not written: there is no image", path.display());
            self.pending.push(Input::Saved(Err(message)));
            return;
        };
        let (session, mut setup) = (current.session.clone(), current.setup.clone());
        (setup.settings.tone, setup.settings.exposure) = (shown.tone, shown.exposure);
        let (tone, exposure, course_ppm) = (session.tone(&setup.settings), shown.exposure, exact);
        let write = move || {
            let metadata = session.provenance(&setup, picture.figures.spp);
            let options = WriteOptions { tone, exposure, course_ppm, metadata };
            let name = path.display();
            match penombre_image::save(&path, &picture.image, &options) {
                Ok(()) => Ok(format!("{name} was written")),
                Err(error) => Err(format!("the image was not saved: {error}")),
            }
        };
        self.saves.push(Task::start("save", write, self.wake.clone()));
    }

    /// What came of it since the last call.
    pub fn poll(&mut self) -> Vec<Input> {
        let mut news = std::mem::take(&mut self.pending);
        if let Some(loading) = &mut self.loading
            && let Some(result) = loading.poll()
        {
            let source = loading.source().clone();
            self.loading = None;
            news.push(self.loaded(source, result));
        }
        self.poll_render(&mut news);
        self.saves.retain_mut(|save| match save.poll() {
            None => true,
            Some(result) => {
                news.push(Input::Saved(result.unwrap_or_else(Err)));
                false
            }
        });
        if let Some(stage) = &mut self.stage
            && let Some(result) = stage.finding.as_mut().and_then(Task::poll)
        {
            (stage.finding, stage.edges) = (None, result.ok());
        }
        news
    }

    fn loaded(&mut self, source: Source, result: Result<(Session, Option<Arc<GpuMesh>>), String>) -> Input {
        match result {
            Err(message) => Input::LoadFailed { source, message },
            Ok((session, mesh)) => {
                let (camera, bounds) = (session.start_camera(), session.bounds());
                self.renders.cancel();
                self.stage = Some(Stage { session, mesh, edges: None, finding: None });
                Input::Loaded { source, camera, bounds }
            }
        }
    }

    fn poll_render(&mut self, news: &mut Vec<Input>) {
        let (Some(current), Some(render)) = (&mut self.current, self.renders.current()) else { return };
        let mut tell = |event| news.push(Input::Render { id: current.id, event });
        // The state first: what was published before the end is then seen as well.
        let state = render.state();
        if let Some(snapshot) = render.take_snapshot() {
            tell(RenderEvent::Picture(snapshot.stage, snapshot.figures));
            current.newest = Some(snapshot);
        }
        let end = match state {
            State::Running => return,
            State::Finished | State::Cancelled => RenderEvent::Finished,
            State::Failed(message) => RenderEvent::Failed(message),
        };
        if !std::mem::replace(&mut current.ended, true) {
            tell(end);
        }
    }

    /// The scene that is shown.
    pub fn session(&self) -> Option<&Session> {
        self.stage.as_ref().map(|stage| &stage.session)
    }

    /// What the preview draws.
    pub fn mesh(&self) -> Option<&Arc<GpuMesh>> {
        self.stage.as_ref()?.mesh.as_ref()
    }

    /// The edges of the scene, once they are found; asking begins the search.
    pub fn edges(&mut self) -> Option<&GpuEdges> {
        let (gpu, stage) = (self.gpu.as_ref()?, self.stage.as_mut()?);
        if stage.edges.is_none() && stage.finding.is_none() {
            let (gpu, scene) = (gpu.clone(), stage.session.scene().clone());
            let find = move || GpuEdges::new(&gpu, &scene);
            stage.finding = Some(Task::start("edges", find, self.wake.clone()));
        }
        stage.edges.as_ref()
    }

    /// The newest picture of the render that is shown.
    pub fn picture(&self) -> Option<&Snapshot> {
        self.current.as_ref()?.newest.as_ref()
    }

    /// The command that gives the image of the asked samples, and its setup: what `r` has rendered.
    pub fn rendered_command(&self) -> Option<String> {
        let current = self.current.as_ref()?;
        current.session.command_line(&current.setup).ok()
    }

    /// True while something is written.
    pub fn is_saving(&self) -> bool {
        !self.saves.is_empty()
    }

    /// Waits for everything that is being written; the messages of what could not be.
    pub fn finish_saves(&mut self) -> Vec<String> {
        let results = self.saves.drain(..).map(|save| save.wait().unwrap_or_else(Err));
        results.filter_map(Result::err).collect()
    }
}
