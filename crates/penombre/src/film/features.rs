//! Features of first hits: what denoisers and compositors want to know of a pixel besides its colour.

use super::Sum;
use penombre_math::{Spectrum, Vec2, Vec3};

/// What the ray of one sample met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// Share of the light that the surface scatters, plus what it emits, at most 1; linear Rec. 709.
    pub albedo: Spectrum,
    /// Shading normal on the side from which it is seen, world space, unit.
    pub normal: Vec3,
    /// The point, world space, metres.
    pub position: Vec3,
    /// Distance along the viewing direction of the camera, metres.
    pub depth: f32,
    /// Surface coordinates.
    pub uv: Vec2,
    /// Number of the object, from 1.
    pub object: u32,
    /// Number of the material, from 1.
    pub material: u32,
}

/// The sum of the features of some samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeatureSum {
    /// Albedo, normal, position, depth, surface coordinates.
    values: [f64; 12],
    /// Samples that met a surface.
    hits: u32,
    /// All samples.
    count: u32,
    /// Numbers of object and material of the first sample, 0 if it met nothing.
    ids: [u32; 2],
}

impl FeatureSum {
    /// Adds one sample; `None`: it met nothing. Features that are not finite count as nothing too.
    pub fn add(&mut self, feature: Option<&Feature>) {
        let values = feature.map(|f| {
            let ([r, g, b], [nx, ny, nz]) = (f.albedo.to_rgb(), f.normal.to_array());
            let ([x, y, z], [u, v]) = (f.position.to_array(), f.uv.to_array());
            [r, g, b, nx, ny, nz, x, y, z, f.depth, u, v]
        });
        let finite = values.filter(|values| values.iter().all(|v| v.is_finite()));
        if self.count == 0 {
            let known = feature.filter(|_| finite.is_some());
            self.ids = known.map_or([0; 2], |f| [f.object, f.material]);
        }
        self.count += 1;
        if let Some(values) = finite {
            self.hits += 1;
            for (sum, value) in self.values.iter_mut().zip(values) {
                *sum += f64::from(value);
            }
        }
    }

    /// Some of the values divided by the number of all samples, so that nothing counts as 0.
    pub(super) fn mean_of_all<const N: usize>(&self, first: usize) -> [f32; N] {
        self.mean(first, self.count)
    }

    /// Some of the values divided by the number of samples that met a surface; `none` if there are none.
    pub(super) fn mean_of_hits<const N: usize>(&self, first: usize, none: f32) -> [f32; N] {
        if self.hits == 0 { [none; N] } else { self.mean(first, self.hits) }
    }

    fn mean<const N: usize>(&self, first: usize, count: u32) -> [f32; N] {
        let count = f64::from(count.max(1));
        std::array::from_fn(|i| (self.values[first + i] / count) as f32)
    }

    /// Numbers of object and material of the first sample, 0 if it met nothing.
    pub(super) fn ids(&self) -> [u32; 2] {
        self.ids
    }
}

/// Places of the features among the values.
pub(super) const ALBEDO: usize = 0;
pub(super) const NORMAL: usize = 3;
pub(super) const POSITION: usize = 6;
pub(super) const DEPTH: usize = 9;
pub(super) const UV: usize = 10;

impl Sum for FeatureSum {
    fn add_sum(&mut self, other: &Self) {
        if self.count == 0 {
            self.ids = other.ids;
        }
        for (sum, value) in self.values.iter_mut().zip(other.values) {
            *sum += value;
        }
        self.hits += other.hits;
        self.count += other.count;
    }
}
