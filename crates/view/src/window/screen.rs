//! What stands in the picture's room: the preview's texture or a rendered image. Each is made anew only when
//! something that it depends on has changed.

use super::desk::Desk;
use super::gpu::{Gpu, GpuImage, GpuMesh, Look, Picture, Target};
use crate::camera::CourseCamera;
use crate::progressive::Snapshot;
use crate::state::Viewer;
use eframe::egui;
use penombre_image::{Image, ToneCurve, quantise_rgba};
use std::sync::Arc;

/// Textures of the picture.
#[derive(Default)]
pub struct Screen {
    gpu: Option<Gpu>,
    target: Option<(Target, Picture)>,
    /// What the target shows.
    drawn: Option<Drawn>,
    image: Option<Shown>,
}

/// Everything that a preview depends on.
#[derive(Clone, Debug)]
struct Drawn {
    mesh: Option<Arc<GpuMesh>>,
    camera: CourseCamera,
    look: Look,
    /// True if the edges were there.
    edges: bool,
}

/// A rendered image on the card.
struct Shown {
    /// What it was made from.
    image: Arc<Image>,
    tone: ToneCurve,
    exposure: f32,
    texture: GpuImage,
    picture: Picture,
}

impl Screen {
    /// An empty screen. Without a card, nothing is shown.
    pub fn new(gpu: Option<Gpu>) -> Self {
        Self { gpu, ..Self::default() }
    }

    /// True if the processor does the card's work.
    pub fn is_software(&self) -> bool {
        self.gpu.as_ref().is_some_and(Gpu::is_software)
    }

    /// Shows a rendered image.
    pub fn image(
        &mut self,
        ui: &egui::Ui,
        rect: egui::Rect,
        snapshot: &Snapshot,
        tone: ToneCurve,
        exposure: f32,
    ) {
        let current = self.image.as_ref().is_some_and(|shown| {
            Arc::ptr_eq(&shown.image, &snapshot.image) && (shown.tone, shown.exposure) == (tone, exposure)
        });
        if !current {
            self.image = self.uploaded(snapshot, tone, exposure);
        }
        if let Some(shown) = &self.image {
            shown.picture.paint(ui, rect);
        }
    }

    /// The image on the card, in the texture of the one before if that has the size.
    fn uploaded(&mut self, snapshot: &Snapshot, tone: ToneCurve, exposure: f32) -> Option<Shown> {
        let gpu = self.gpu.as_ref()?;
        let image = snapshot.image.clone();
        let size = [image.width(), image.height()];
        if size.into_iter().any(|edge| edge == 0 || edge > gpu.longest_edge()) {
            return None;
        }
        let (texture, picture) = match self.image.take() {
            Some(shown) if shown.texture.size() == size => (shown.texture, shown.picture),
            _ => {
                let texture = GpuImage::new(gpu, size);
                let picture = gpu.picture(&texture.view());
                (texture, picture)
            }
        };
        texture.write(gpu, &quantise_rgba(&image, tone, exposure));
        Some(Shown { image, tone, exposure, texture, picture })
    }

    /// Shows the preview, drawing it if it would look different.
    pub fn preview(&mut self, ui: &egui::Ui, rect: egui::Rect, desk: &mut Desk, viewer: &Viewer, look: Look) {
        let Some(gpu) = self.gpu.clone() else { return };
        let size = viewer.setup().size;
        if self.target.as_ref().is_none_or(|(target, _)| target.size() != size) {
            let target = Target::new(&gpu, size);
            let picture = gpu.picture(target.view());
            (self.target, self.drawn) = (Some((target, picture)), None);
        }
        let Some((target, picture)) = &self.target else { return };
        let mesh = desk.mesh().cloned();
        let edges = if look.wireframe { desk.edges() } else { None };
        let drawn = Drawn { mesh, camera: *viewer.camera(), look, edges: edges.is_some() };
        if !self.drawn.as_ref().is_some_and(|before| before.same(&drawn)) {
            gpu.draw(target, drawn.mesh.as_deref().map(|mesh| (mesh, edges)), &drawn.camera, &look);
            self.drawn = Some(drawn);
        }
        picture.paint(ui, rect);
    }
}

impl Drawn {
    fn same(&self, other: &Self) -> bool {
        let mesh = match (&self.mesh, &other.mesh) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        mesh && (self.camera, self.look, self.edges) == (other.camera, other.look, other.edges)
    }
}
