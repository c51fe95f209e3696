//! Lights without extent: nothing to sample, one direction per point.

use penombre_math::{Vec3, float};

/// The way to a light that has one direction from each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualSample {
    /// Direction towards it, unit.
    pub wi: Vec3,
    /// Distance, metres; infinite for directional light.
    pub distance: f32,
    /// What turns its strength into irradiance across `wi`: 1/distance² in m⁻² for an intensity in W/sr, 1 for
    /// directional light.
    pub falloff: f32,
}

/// From `reference` to a point light at `position`. `None` if they are so close together, or so far apart, that
/// the falloff is no `f32`.
pub fn towards_point(reference: Vec3, position: Vec3) -> Option<PunctualSample> {
    let to = position.as_dvec3() - reference.as_dvec3();
    let square = to.length_squared();
    let falloff = (1.0 / square) as f32;
    if !(falloff > 0.0 && falloff.is_finite()) {
        return None;
    }
    let distance = square.sqrt();
    Some(PunctualSample { wi: (to / distance).as_vec3(), distance: distance as f32, falloff })
}

/// Towards parallel light that travels along `direction`, unit.
pub fn against(direction: Vec3) -> PunctualSample {
    PunctualSample { wi: -direction, distance: f32::INFINITY, falloff: 1.0 }
}

/// The cone of a spot light: full strength around its axis, none outside, smoothstep in the cosine between
/// (\[PBRT4\], 12.2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    axis: Vec3,
    /// Full strength from this cosine on.
    cos_start: f32,
    /// No strength up to this one; not above `cos_start`.
    cos_end: f32,
}

impl SpotCone {
    /// From the unit axis, the half angle in degrees within which strength is full, and the half angle of the whole
    /// cone. Angles are limited to 0…180, the first also to the second.
    pub fn new(axis: Vec3, full_degrees: f32, whole_degrees: f32) -> Self {
        let whole = whole_degrees.clamp(0.0, 180.0);
        let full = full_degrees.clamp(0.0, whole);
        let cosine = |degrees: f32| float::sin_cos_degrees(f64::from(degrees)).1 as f32;
        Self { axis, cos_start: cosine(full), cos_end: cosine(whole) }
    }

    /// Share of the strength in the unit direction `from_light`, away from the light, in 0..=1.
    pub fn share(&self, from_light: Vec3) -> f32 {
        let cos = self.axis.dot(from_light);
        if cos >= self.cos_start {
            return 1.0;
        }
        // Above 0, or the cosine would be at least that of the start, or NaN.
        let width = self.cos_start - self.cos_end;
        let t = ((cos - self.cos_end) / width).max(0.0);
        if width > 0.0 { t * t * (3.0 - 2.0 * t) } else { 0.0 }
    }

    /// Integral of the share over the sphere of directions, divided by 2π, in 0..=2.
    pub fn mean_share(&self) -> f32 {
        1.0 - 0.5 * (self.cos_start + self.cos_end)
    }
}
