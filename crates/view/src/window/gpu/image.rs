//! A rendered image in the memory of the graphics card.

use super::{COLOR, Gpu};
use eframe::wgpu;

/// Bytes as they are shown.
#[derive(Debug)]
pub struct GpuImage {
    texture: wgpu::Texture,
}

impl GpuImage {
    /// Room for an image of that size, pixels: at least 1 and at most [`Gpu::longest_edge`] each.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("image"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: COLOR,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Self { texture }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// What is shown.
    pub fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Replaces the image: red, green, blue and anything of all pixels, top row first.
    pub fn write(&self, gpu: &Gpu, rgba: &[u8]) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * self.texture.width()),
            rows_per_image: None,
        };
        gpu.queue.write_texture(self.texture.as_image_copy(), rgba, layout, self.texture.size());
    }
}
