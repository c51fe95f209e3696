//! What one picture of the preview depends on besides the scene, as the shader's uniform block.

use crate::camera::{CourseCamera, Lens};
use crate::preview::{MOST_LIGHTS as LIGHTS, PreviewLight};
use penombre_math::{DVec3, float};

/// Part of the head light where the scene has lights of its own.
const HEAD_LIGHT: f32 = 0.3;

/// Flags of the shader.
const FLAT: u32 = 1;
const SRGB: u32 = 2;
const ORTHOGRAPHIC: u32 = 4;

/// How the preview looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// True: the colour of the nearest surface alone, as phase 1 of the course.
    pub flat: bool,
    /// True: sRGB-encoded, as the image will be shown; false: linear values, as the course shows them.
    pub srgb: bool,
    /// Brightness in powers of two.
    pub exposure: f32,
    /// Edges in place of surfaces.
    pub wireframe: bool,
}

/// The bytes of the shader's `Frame`, little endian. `size`: of the picture, pixels.
pub fn uniforms(camera: &CourseCamera, size: [u32; 2], lights: &[PreviewLight], look: &Look) -> Vec<u8> {
    let lights = &lights[..lights.len().min(LIGHTS)];
    let flag = |on: bool, bit: u32| if on { bit } else { 0 };
    let parallel = matches!(camera.lens(), Lens::Orthographic { .. });
    let flags = flag(look.flat, FLAT) | flag(look.srgb, SRGB) | flag(parallel, ORTHOGRAPHIC);
    let strengths = match lights {
        [] => [1.0, 0.0],
        _ => [HEAD_LIGHT, 1.0 - HEAD_LIGHT],
    };
    let mut block = Block::default();
    block.matrix(&camera.view_matrix());
    block.matrix(&camera.projection_matrix(f64::from(size[0]) / f64::from(size[1])));
    block.whole([lights.len() as u32, flags, size[0], size[1]]);
    block.real([strengths[0], strengths[1], float::exp2(look.exposure), 0.0]);
    block.real([0.0; 4]);
    let rotation = camera.rotation();
    let eye = camera.look_at().position;
    for light in lights {
        let p = rotation * (DVec3::from_array(light.center.map(f64::from)) - eye);
        block.real(p.as_vec3().extend(0.0).to_array());
        let [r, g, b] = light.color;
        block.real([r, g, b, 0.0]);
    }
    block.bytes.resize(BYTES, 0);
    block.bytes
}

/// Bytes of the block.
pub const BYTES: usize = 2 * 64 + 3 * 16 + LIGHTS * 32;

/// Sixteen bytes at a time, as uniform blocks are laid out.
#[derive(Default)]
pub struct Block {
    /// What was added.
    pub bytes: Vec<u8>,
}

impl Block {
    fn matrix(&mut self, columns: &[[f32; 4]; 4]) {
        columns.iter().for_each(|column| self.real(*column));
    }

    fn whole(&mut self, values: [u32; 4]) {
        self.bytes.extend(values.into_iter().flat_map(u32::to_le_bytes));
    }

    /// Adds four numbers.
    pub fn real(&mut self, values: [f32; 4]) {
        self.bytes.extend(values.into_iter().flat_map(f32::to_le_bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::LookAt;
    use penombre_math::Bounds3;

    fn number(bytes: &[u8], index: usize) -> f32 {
        f32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap())
    }

    #[test]
    fn lights_stand_in_eye_space_and_those_beyond_the_limit_are_left_out() {
        let look = LookAt {
            position: DVec3::new(0.0, 0.0, 6.1),
            target: DVec3::ZERO,
            up: DVec3::Y,
            lens: Lens::Perspective { fov: 45.0 },
            near: 4.1,
            far: 1e4,
        };
        let camera = CourseCamera::of_look_at(&look, &Bounds3::EMPTY);
        let light = PreviewLight { center: [0.0, 1.5, 0.0], color: [1.0, 0.5, 0.25] };
        let look = Look { flat: false, srgb: true, exposure: 1.0, wireframe: false };
        let bytes = uniforms(&camera, [7, 5], &[light; 100], &look);
        assert_eq!(bytes.len(), BYTES);
        assert_eq!(bytes[128..144], [64, 0, 0, 0, SRGB as u8, 0, 0, 0, 7, 0, 0, 0, 5, 0, 0, 0]);
        assert!((number(&bytes, 38) - 2.0).abs() < 1e-6);
        let first = (128 + 48) / 4;
        let found: Vec<f32> = (first..first + 7).map(|i| number(&bytes, i)).collect();
        for (found, expected) in found.iter().zip([0.0, 1.5, -6.1, 0.0, 1.0, 0.5, 0.25]) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        let alone = uniforms(&camera, [7, 5], &[], &look);
        assert!((number(&alone, 36) - 1.0).abs() < 1e-6);
    }
}
