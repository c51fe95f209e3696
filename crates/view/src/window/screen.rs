//! What stands in the picture's room: the preview's texture or a rendered image. Each is made anew only when
//! something that it depends on has changed.

use super::desk::Desk;
use super::gpu::{Gpu, GpuMesh, Look, Target};
use crate::camera::CourseCamera;
use crate::progressive::Snapshot;
use crate::state::Viewer;
use eframe::egui::{self, Color32, TextureId};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use penombre_image::{Image, ToneCurve, quantise};
use std::sync::Arc;

/// Textures of the picture.
pub struct Screen {
    gpu: Option<Gpu>,
    state: Option<RenderState>,
    target: Option<(Target, TextureId)>,
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
    image: Arc<Image>,
    tone: ToneCurve,
    exposure: f32,
    texture: egui::TextureHandle,
}

impl Screen {
    /// An empty screen. Without a card, no preview is shown.
    pub fn new(gpu: Option<Gpu>, state: Option<RenderState>) -> Self {
        Self { gpu, state, target: None, drawn: None, image: None }
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
            self.upload(ui.ctx(), snapshot, tone, exposure);
        }
        if let Some(shown) = &self.image {
            paint(ui, rect, shown.texture.id());
        }
    }

    fn upload(&mut self, ctx: &egui::Context, snapshot: &Snapshot, tone: ToneCurve, exposure: f32) {
        let image = snapshot.image.clone();
        let limit = self.gpu.as_ref().map_or(u32::MAX, Gpu::longest_edge);
        let size = [image.width(), image.height()];
        if size.into_iter().any(|edge| edge == 0 || edge > limit) {
            self.image = None;
            return;
        }
        let pixels = egui::ColorImage::from_rgb(size.map(|v| v as usize), &quantise(&image, tone, exposure));
        let texture = match self.image.take() {
            Some(mut shown) => {
                shown.texture.set(pixels, egui::TextureOptions::NEAREST);
                shown.texture
            }
            None => ctx.load_texture("image", pixels, egui::TextureOptions::NEAREST),
        };
        self.image = Some(Shown { image, tone, exposure, texture });
    }

    /// Shows the preview, drawing it if it would look different.
    pub fn preview(&mut self, ui: &egui::Ui, rect: egui::Rect, desk: &mut Desk, viewer: &Viewer, look: Look) {
        let Some(gpu) = self.gpu.clone() else { return };
        let size = viewer.setup().size;
        self.fit(&gpu, size);
        let Some((target, texture)) = &self.target else { return };
        let mesh = desk.mesh().cloned();
        let edges = if look.wireframe { desk.edges() } else { None };
        let drawn = Drawn { mesh, camera: *viewer.camera(), look, edges: edges.is_some() };
        if !self.drawn.as_ref().is_some_and(|before| before.same(&drawn)) {
            gpu.draw(target, drawn.mesh.as_deref().map(|mesh| (mesh, edges)), &drawn.camera, &look);
            self.drawn = Some(drawn);
        }
        paint(ui, rect, *texture);
    }

    /// Makes the target as large as the picture.
    fn fit(&mut self, gpu: &Gpu, size: [u32; 2]) {
        let Some(state) = &self.state else { return };
        if self.target.as_ref().is_some_and(|(target, _)| target.size() == size) {
            return;
        }
        let target = Target::new(gpu, size);
        let (device, filter) = (&state.device, wgpu::FilterMode::Nearest);
        let mut renderer = state.renderer.write();
        let id = match self.target.take() {
            Some((_, id)) => {
                renderer.update_egui_texture_from_wgpu_texture(device, target.view(), filter, id);
                id
            }
            None => renderer.register_native_texture(device, target.view(), filter),
        };
        (self.target, self.drawn) = (Some((target, id)), None);
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

fn paint(ui: &egui::Ui, rect: egui::Rect, texture: TextureId) {
    let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
    ui.painter().image(texture, rect, whole, Color32::WHITE);
}
