//! A scene's triangles and materials in the memory of the graphics card.

use super::Gpu;
use super::frame::Block;
use crate::preview::{Group, Limits, PreviewLight, PreviewMaterial, PreviewMesh, PreviewTexture};
use eframe::wgpu;
use penombre::Scene;
use penombre_math::color::{srgb_decode_u8, srgb_encode_u8};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Uniform blocks start at multiples of this many bytes on every card.
const BLOCK_STRIDE: u64 = 256;
/// Bytes of the shader's `Material`.
const BLOCK_BYTES: u64 = 48;

/// A scene ready to be drawn. It may be made on any thread.
#[derive(Debug)]
pub struct GpuMesh {
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) groups: Vec<Group>,
    /// For each material: whether its colour is the same everywhere.
    pub(super) plain: Vec<bool>,
    pub(super) materials: Vec<wgpu::BindGroup>,
    pub(super) lights: Vec<PreviewLight>,
}

/// The edges of a scene, for wireframes.
#[derive(Debug)]
pub struct GpuEdges {
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) groups: Vec<Group>,
}

impl GpuMesh {
    /// Copies a preview to the card.
    pub fn new(gpu: &Gpu, mesh: &PreviewMesh) -> Self {
        let blocks = material_blocks(gpu, &mesh.materials);
        let white = PreviewTexture { edge: 1, rgba: vec![255; 4] };
        let white = texture(gpu, &white);
        let bind = |(i, material): (usize, &PreviewMaterial)| {
            let own = material.texture.as_ref().map(|t| texture(gpu, t));
            material_group(gpu, &blocks, i as u64 * BLOCK_STRIDE, own.as_ref().unwrap_or(&white))
        };
        let colored = mesh.vertices.iter().any(|v| v.color != [1.0; 4]);
        Self {
            plain: mesh.materials.iter().map(|m| !colored && m.texture.is_none()).collect(),
            vertices: gpu.buffer("vertices", &mesh.vertex_bytes(), wgpu::BufferUsages::VERTEX),
            indices: gpu.buffer("indices", &mesh.index_bytes(), wgpu::BufferUsages::INDEX),
            groups: mesh.groups.clone(),
            materials: mesh.materials.iter().enumerate().map(bind).collect(),
            lights: mesh.lights.clone(),
        }
    }
}

impl GpuEdges {
    /// Finds the edges and copies them to the card; takes a while for large scenes.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Self {
        let mesh = PreviewMesh::new(scene, &Limits::wireframe());
        let edges = mesh.edges();
        let bytes: Vec<u8> = edges.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        Self {
            vertices: gpu.buffer("ends", &mesh.vertex_bytes(), wgpu::BufferUsages::VERTEX),
            indices: gpu.buffer("edges", &bytes, wgpu::BufferUsages::INDEX),
            groups: edges.groups,
        }
    }
}

/// One uniform block for each material.
fn material_blocks(gpu: &Gpu, materials: &[PreviewMaterial]) -> wgpu::Buffer {
    let mut bytes = Vec::with_capacity(materials.len() * BLOCK_STRIDE as usize);
    for material in materials {
        let mut block = Block::default();
        let with = |[r, g, b]: [f32; 3], last: f32| [r, g, b, last];
        block.real(with(material.ambient, 0.0));
        block.real(with(material.diffuse, 1.0));
        block.real(with(material.specular, material.shininess));
        block.bytes.resize(BLOCK_STRIDE as usize, 0);
        bytes.extend(block.bytes);
    }
    gpu.buffer("materials", &bytes, wgpu::BufferUsages::UNIFORM)
}

fn material_group(
    gpu: &Gpu,
    blocks: &wgpu::Buffer,
    offset: u64,
    texture: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let block = wgpu::BufferBinding { buffer: blocks, offset, size: wgpu::BufferSize::new(BLOCK_BYTES) };
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("material"),
        layout: &gpu.material_layout,
        entries: &[
            entry(0, wgpu::BindingResource::Buffer(block)),
            entry(1, wgpu::BindingResource::TextureView(texture)),
            entry(2, wgpu::BindingResource::Sampler(&gpu.sampler)),
        ],
    })
}

/// A texture with all its smaller versions.
fn texture(gpu: &Gpu, source: &PreviewTexture) -> wgpu::TextureView {
    let levels = source.edge.ilog2() + 1;
    let size = wgpu::Extent3d { width: source.edge, height: source.edge, depth_or_array_layers: 1 };
    let descriptor = wgpu::TextureDescriptor {
        label: Some("diffuse"),
        size,
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let (mut edge, mut level) = (source.edge, source.rgba.clone());
    let mut bytes = Vec::new();
    for _ in 0..levels {
        bytes.extend_from_slice(&level);
        level = halved(&level, edge);
        edge /= 2;
    }
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, &bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Half the size: means of 2 × 2 texels, taken in linear light.
fn halved(rgba: &[u8], edge: u32) -> Vec<u8> {
    let (edge, half) = (edge as usize, edge as usize / 2);
    let mut result = Vec::with_capacity(half * half * 4);
    for (y, x) in (0..half).flat_map(|y| (0..half).map(move |x| (y, x))) {
        for channel in 0..4 {
            let at = |dy: usize, dx: usize| rgba[4 * ((2 * y + dy) * edge + 2 * x + dx) + channel];
            let four = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
            let sum: f32 = four.into_iter().map(srgb_decode_u8).sum();
            result.push(srgb_encode_u8(sum * 0.25));
        }
    }
    result
}

impl Gpu {
    /// A buffer with these bytes; never empty, for cards refuse that.
    pub(super) fn buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let contents = if bytes.is_empty() { &[0; 16] } else { bytes };
        self.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_textures_keep_the_light() {
        // Half black, half white: the mean of the light is a half, which is 188 in sRGB.
        let rgba = [0u8, 255, 255, 0].into_iter().flat_map(|c| [c, c, c, 255]).collect::<Vec<_>>();
        assert_eq!(halved(&rgba, 2), [188, 188, 188, 255]);
        assert!(halved(&[1, 2, 3, 4], 1).is_empty());
    }
}
