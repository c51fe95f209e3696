//! Pipelines and layouts of the preview.

use super::{COLOR, DEPTH, frame};
use crate::preview::Vertex;
use eframe::wgpu;

/// What draws a preview.
#[derive(Debug)]
pub struct Pipelines {
    pub surfaces: Kinds,
    pub lines: Kinds,
    /// The uniform block of the picture that is drawn.
    pub frame: wgpu::Buffer,
    pub frame_group: wgpu::BindGroup,
}

/// How a kind of primitive is drawn.
#[derive(Debug)]
pub struct Kinds {
    /// In the material's colour.
    pub plain: wgpu::RenderPipeline,
    /// With textures and colours of vertices.
    pub full: wgpu::RenderPipeline,
}

impl Pipelines {
    /// Compiles the shader. `samples`: per pixel.
    pub fn new(device: &wgpu::Device, material_layout: &wgpu::BindGroupLayout, samples: u32) -> Self {
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[uniform(0, frame::BYTES as u64, wgpu::ShaderStages::VERTEX_FRAGMENT)],
        });
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: frame::BYTES as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("preview"),
            bind_group_layouts: &[Some(&frame_layout), Some(material_layout)],
            immediate_size: 0,
        });
        let shader = device.create_shader_module(wgpu::include_wgsl!("preview.wgsl"));
        let with = |topology| Kinds {
            plain: pipeline(device, &layout, &shader, "plain", topology, samples),
            full: pipeline(device, &layout, &shader, "full", topology, samples),
        };
        Self {
            surfaces: with(wgpu::PrimitiveTopology::TriangleList),
            lines: with(wgpu::PrimitiveTopology::LineList),
            frame,
            frame_group,
        }
    }
}

/// Layout of a material: its numbers, its texture, how that is looked up.
pub fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let fragment = wgpu::ShaderStages::FRAGMENT;
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: fragment, ty, count: None };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("material"),
        entries: &[
            uniform(0, 48, fragment),
            entry(
                1,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ],
    })
}

fn uniform(binding: u32, bytes: u64, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: wgpu::BufferSize::new(bytes),
        },
        count: None,
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    kind: &str,
    topology: wgpu::PrimitiveTopology,
    samples: u32,
) -> wgpu::RenderPipeline {
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x4];
    let vertices = wgpu::VertexBufferLayout {
        array_stride: Vertex::STRIDE as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("preview"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(&format!("vertex_{kind}")),
            compilation_options: Default::default(),
            buffers: &[Some(vertices)],
        },
        // Surfaces are seen from both sides: nothing is culled.
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(&format!("fragment_{kind}")),
            compilation_options: Default::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
