//! The texture into which the preview is drawn.

use super::{BACKGROUND, COLOR, DEPTH, Gpu};
use eframe::wgpu;

/// Colour and depth of a picture.
#[derive(Debug)]
pub struct Target {
    size: [u32; 2],
    /// What is shown.
    view: wgpu::TextureView,
    /// Several samples per pixel, resolved into `view`; none where one is enough.
    samples: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl Target {
    /// A picture of that size, pixels; at least one by one, at most what the card can.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let size = size.map(|edge| edge.clamp(1, gpu.longest_edge()));
        let texture = |label, format, samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let shown = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let nothing = wgpu::TextureUsages::empty();
        Self {
            size,
            view: view(&texture("preview", COLOR, 1, shown)),
            samples: (gpu.samples > 1).then(|| view(&texture("samples", COLOR, gpu.samples, nothing))),
            depth: view(&texture("depth", DEPTH, gpu.samples, nothing)),
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What is shown.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Begins a picture: background and no depth.
    pub(super) fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        let (view, resolve_target) = match &self.samples {
            Some(samples) => (samples, Some(&self.view)),
            None => (&self.view, None),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("preview"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                resolve_target,
                depth_slice: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(BACKGROUND), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Reads the picture back: red, green, blue, alpha of all pixels, top row first. Waits for the card.
    pub fn read(&self, gpu: &Gpu) -> Option<Vec<u8>> {
        let ([width, height], texture) = (self.size, self.view.texture());
        let align = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
        let stride = (width * 4).next_multiple_of(align);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(stride) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| drop(send.send(result)));
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        receive.recv().ok()?.ok()?;
        let bytes = buffer.get_mapped_range(..).ok()?;
        Some(
            bytes.chunks_exact(stride as usize).flat_map(|row| &row[..width as usize * 4]).copied().collect(),
        )
    }
}
