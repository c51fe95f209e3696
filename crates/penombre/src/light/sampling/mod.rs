//! Sampling lights: which light, which direction towards it, and the density of both.
//!
//! A shape of a light, seen from one point, becomes a [`DirectionSampler`]: [`SphericalQuad`],
//! [`SphericalTriangle`], [`SphericalDisk`], [`SphericalCap`] (a sphere). Each is a small value made per shaded
//! point, without allocation. `None` stands for a shape that cannot be seen: it has no extent, or the point
//! lies in its plane. [`Environment`] is the light from infinity, [`LightChoice`] the choice among lights, and
//! [`punctual`] and [`power`] hold what needs no sampling.
//!
//! Points come in and go out as `f32`; between, double precision is used throughout, which makes small, far,
//! large and grazing lights cases like any other. Only shape is known here: the shapes are sampled from both
//! sides, and a light that shines to one side asks [`SphericalQuad::is_in_front`] and its likes first.

mod choice;
mod disk;
mod environment;
mod flat;
pub mod power;
pub mod punctual;
mod quad;
pub mod quick;
mod rectangle;
mod sphere;
mod triangle;

#[cfg(test)]
mod tests;

pub use choice::LightChoice;
pub use disk::SphericalDisk;
pub use environment::{Environment, EnvironmentSample, EnvironmentSampling};
pub use quad::{Parallelogram, SphericalQuad};
pub use sphere::{CapAround, SphericalCap};
pub use triangle::SphericalTriangle;

use penombre_math::{DVec2, DVec3, Vec2, Vec3, float};

/// A direction towards a light's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionSample {
    /// Direction from the reference point, unit.
    pub wi: Vec3,
    /// The point of the shape in that direction, world space, metres. Aim shadow rays at it: `wi` alone may
    /// miss a shape that is smaller than the grain of a direction.
    pub point: Vec3,
    /// Distance of that point, metres.
    pub distance: f32,
    /// Density of `wi` per solid angle, 1/sr; finite, above 0.
    pub pdf: f32,
}

/// Directions from a reference point to a shape.
pub trait DirectionSampler {
    /// The direction of the uniform point `u` ∈ [0, 1)².
    fn sample(&self, u: Vec2) -> DirectionSample;

    /// Density with which [`sample`](Self::sample) gives a direction that is known to meet the shape, for the
    /// first time at `distance` metres; 1/sr. The same number that `sample` reports.
    fn pdf_of_hit(&self, wi: Vec3, distance: f32) -> f32;

    /// Density with which [`sample`](Self::sample) gives the unit direction `wi`, 1/sr; 0 if it misses the
    /// shape. Directions within a rounding of the rim may count as either.
    fn pdf(&self, wi: Vec3) -> f32;
}

/// A shape's points are sampled evenly by area if its radius is below this share of the distance to its
/// middle: the density varies then by less than a tenth, which costs no visible variance, and the sampling a
/// third of the time.
const FAR: f64 = 1.0 / 64.0;

/// Below this solid angle, in sr, a flat shape that is not far away is seen edge-on or is a sliver: the maps of
/// solid angle come to the end of their accuracy, and points are sampled by area.
const THIN: f64 = 1e-9;

/// The uniform numbers as used: NaN and numbers out of range go to an end.
#[inline]
fn inside_unit_square(u: Vec2) -> DVec2 {
    let limit = |v: f32| f64::from(if v >= 0.0 { v.min(1.0f32.next_down()) } else { 0.0 });
    DVec2::new(limit(u.x), limit(u.y))
}

/// 1/`solid_angle` as a density. `None` if the angle is not above 0 or so small that its inverse is no `f32`.
#[inline]
fn uniform_density(solid_angle: f64) -> Option<f32> {
    let density = (1.0 / solid_angle) as f32;
    (density.is_finite() && density > 0.0).then_some(density)
}

/// Sine and cosine, in this order, of an angle whose relative error is that of one `f32`: unlike those of the
/// elementary functions, the results belong to one angle in double precision.
#[inline]
fn unit_circle(angle: f64) -> (f64, f64) {
    let (s, c) = float::sin_cos(angle as f32);
    let (s, c) = (f64::from(s), f64::from(c));
    // The inverse square root of s² + c², which is 1 within 2⁻²³, by its series.
    let excess = s * s + c * c - 1.0;
    let scale = 1.0 - excess * (0.5 - 0.375 * excess);
    (s * scale, c * scale)
}

/// The sample that ends at `to`, a vector from the reference point. Its density is still to be set.
#[inline]
fn sample_at(reference: DVec3, to: DVec3) -> DirectionSample {
    let distance = to.length();
    DirectionSample {
        wi: (to * (1.0 / distance)).as_vec3(),
        point: (reference + to).as_vec3(),
        distance: distance as f32,
        pdf: 0.0,
    }
}
