//! What the window asks of the state.

use super::{Mode, REST, Viewer};
use crate::camera::CourseCamera;
use crate::session::{Settings, Setup, Source};

impl Viewer {
    /// Width of the picture by its height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.size[0].max(1)) / f64::from(self.size[1].max(1))
    }

    /// What `r` would render now.
    pub fn setup(&self) -> Setup {
        let size = self.size.map(|edge| edge.max(1));
        Setup { size, camera: self.camera, settings: self.settings.clone() }
    }

    /// Seconds until the next [`super::Input::Tick`] should come: the live render waits for the camera to rest. `None` while
    /// a tick would start nothing.
    pub fn next_tick(&self, now: f64) -> Option<f64> {
        let able = self.live && !self.wireframe && self.source.is_some();
        let able = able && self.mode == Mode::Raster && !self.size.contains(&0);
        let rests_at = match self.resting_since {
            _ if self.moved => now,
            Some(since) => since + REST,
            None => return None,
        };
        able.then_some((rests_at - now).max(0.0))
    }

    /// True while samples are taken.
    pub fn is_busy(&self) -> bool {
        self.running.is_some_and(|r| r.busy)
    }

    /// True if there is an image to save.
    pub fn has_picture(&self) -> bool {
        matches!(self.mode, Mode::Rendering(Some(_)) | Mode::Rendered(_))
    }

    /// What the picture shows.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The camera.
    pub fn camera(&self) -> &CourseCamera {
        &self.camera
    }

    /// The panel's changes.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The scene that is shown.
    pub fn source(&self) -> Option<&Source> {
        self.source.as_ref()
    }

    /// The scene that is being loaded, while the old one is still shown.
    pub fn loading(&self) -> Option<&Source> {
        self.loading.as_ref()
    }

    /// What a person must be told.
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// What was done last, for a person: where an image was written.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// True if a render starts whenever the camera rests.
    pub fn is_live(&self) -> bool {
        self.live
    }

    /// True if renders go on beyond the samples per pixel.
    pub fn goes_beyond(&self) -> bool {
        self.beyond
    }

    /// True if edges are drawn instead of surfaces.
    pub fn is_wireframe(&self) -> bool {
        self.wireframe
    }

    /// True if the picture fills the screen.
    pub fn is_fullscreen(&self) -> bool {
        self.fullscreen
    }

    /// True if the help is shown.
    pub fn shows_help(&self) -> bool {
        self.help
    }
}
