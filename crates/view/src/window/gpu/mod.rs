//! The raster preview on the graphics card, drawn into a texture that is shown until something changes.

mod blit;
mod frame;
mod image;
mod mesh;
mod pipeline;
mod target;

use crate::camera::CourseCamera;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use std::sync::Arc;

pub use blit::Picture;
pub use frame::Look;
pub use image::GpuImage;
pub use mesh::{GpuEdges, GpuMesh};
pub use target::Target;

/// Samples per pixel on real cards; software takes one.
const SAMPLES: u32 = 4;
/// Background of the course's preview; what `glClearColor` takes.
const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.2, g: 0.2, b: 0.3, a: 1.0 };
/// Depth buffer of the preview.
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Colour of the preview: what egui's renderer takes, values as they are shown.
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A graphics card with what all previews share. Cloning is cheap, and any thread may use it.
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    material_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    pipelines: Arc<pipeline::Pipelines>,
    blit: Arc<blit::Blit>,
    samples: u32,
    software: bool,
}

impl Gpu {
    /// Prepares the card that draws the window.
    pub fn new(state: &RenderState) -> Self {
        Self::with_samples(state, if is_software(state) { 1 } else { SAMPLES })
    }

    /// The same with 1 or 4 samples per pixel.
    pub fn with_samples(state: &RenderState, samples: u32) -> Self {
        let software = is_software(state);
        let device = state.device.clone();
        let material_layout = pipeline::material_layout(&device);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("diffuse"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let pipelines = Arc::new(pipeline::Pipelines::new(&device, &material_layout, samples));
        let blit = Arc::new(blit::Blit::new(&device, state.target_format));
        Self {
            device,
            blit,
            queue: state.queue.clone(),
            material_layout,
            sampler,
            pipelines,
            samples,
            software,
        }
    }

    /// True if the processor does the card's work.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// The longest edge of a picture, pixels.
    pub fn longest_edge(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// Draws a scene, or only the background, into the target. With `look.wireframe`, and once there are edges, these
    /// are drawn in place of surfaces.
    pub fn draw(
        &self,
        target: &Target,
        scene: Option<(&GpuMesh, Option<&GpuEdges>)>,
        camera: &CourseCamera,
        look: &Look,
    ) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = target.begin(&mut encoder);
            if let Some((mesh, edges)) = scene {
                let uniforms = frame::uniforms(camera, target.size(), &mesh.lights, look);
                self.queue.write_buffer(&self.pipelines.frame, 0, &uniforms);
                let lines = edges.filter(|_| look.wireframe);
                let (pipelines, vertices, indices, groups) = match lines {
                    Some(edges) => (&self.pipelines.lines, &edges.vertices, &edges.indices, &edges.groups),
                    None => (&self.pipelines.surfaces, &mesh.vertices, &mesh.indices, &mesh.groups),
                };
                pass.set_bind_group(0, &self.pipelines.frame_group, &[]);
                pass.set_vertex_buffer(0, vertices.slice(..));
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                for group in groups {
                    let plain = mesh.plain[group.material as usize];
                    pass.set_pipeline(if plain { &pipelines.plain } else { &pipelines.full });
                    pass.set_bind_group(1, &mesh.materials[group.material as usize], &[]);
                    pass.draw_indexed(group.indices.clone(), 0, 0..1);
                }
            }
        }
        self.queue.submit([encoder.finish()]);
    }
}

fn is_software(state: &RenderState) -> bool {
    state.adapter.get_info().device_type == wgpu::DeviceType::Cpu
}
