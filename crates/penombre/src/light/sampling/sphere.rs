//! Directions to spheres.

use super::{DirectionSample, DirectionSampler, inside_unit_square, uniform_density, unit_circle};
use penombre_math::{DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// A sphere seen from a point: uniform in the cone of directions that meet it (\[PBRT4\], 6.2.4). From inside that
/// are all directions, and from points on it, too: rounding would tell by chance on which side they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalCap {
    reference: DVec3,
    /// Unit direction to the centre. In double precision: a far sphere is smaller than the grain of `f32`.
    axis: DVec3,
    /// From the reference point to the centre.
    to_center: DVec3,
    distance: f64,
    radius: f64,
    /// 1 − cos of the cone's half angle: in (0, 1) from outside, 2 from inside.
    less_cosine: f64,
    is_inside: bool,
    density: f32,
}

impl SphericalCap {
    /// The sphere seen from `reference`; `None` if its radius is not above 0, or it is so far away that its solid
    /// angle is below 10⁻³⁸ sr.
    pub fn new(reference: Vec3, center: Vec3, radius: f32) -> Option<Self> {
        let reference = reference.as_dvec3();
        let to_center = center.as_dvec3() - reference;
        let (distance, radius) = (to_center.length(), f64::from(radius));
        if !(radius > 0.0 && ((distance + radius) as f32).is_finite()) {
            return None;
        }
        // What a point on the sphere may be off, by a few roundings to `f32`.
        let slack = (reference.abs().max_element() + radius) * 2f64.powi(-22);
        let is_inside = distance <= radius + slack;
        let less_cosine = if !is_inside {
            let sine = radius / distance;
            let square = sine * sine;
            // 1 − cos = sin²/(1 + cos), without cancellation however small the cone is.
            square / (1.0 + ((1.0 - sine) * (1.0 + sine)).sqrt())
        } else {
            2.0
        };
        let axis = to_center.try_normalize().unwrap_or(DVec3::Z);
        let density = uniform_density(TAU * less_cosine)?;
        Some(Self { reference, axis, to_center, distance, radius, less_cosine, is_inside, density })
    }

    /// True if the reference point is within the sphere or on it.
    pub fn is_inside(&self) -> bool {
        self.is_inside
    }

    /// True of a hit at that distance which lies on the far side of the sphere, where no sample does: a ray from outside went
    /// through a hole of the near side. Beside the outline the answer is no.
    #[inline]
    pub fn is_beyond(&self, distance: f32) -> bool {
        let outline = (self.distance + self.radius) * (self.distance - self.radius);
        !self.is_inside() && f64::from(distance) * f64::from(distance) > outline * 1.001
    }

    /// The solid angle, in (0, 2π) sr from outside, 4π from inside.
    pub fn solid_angle(&self) -> f32 {
        (TAU * self.less_cosine) as f32
    }

    /// From the reference point to where a unit direction first meets the sphere (leaves it, from inside), moved
    /// onto it. Directions that miss it give the nearest point of its rim.
    fn meet(&self, wi: DVec3, less_cosine: f64) -> DVec3 {
        let cosine = 1.0 - less_cosine;
        let sine_square = less_cosine * (2.0 - less_cosine);
        let (d, r) = (self.distance, self.radius);
        let half_chord = (r * r - d * d * sine_square).max(0.0).sqrt();
        let t = if self.is_inside() { d * cosine + half_chord } else { d * cosine - half_chord };
        let normal = wi * t - self.to_center;
        self.to_center + normal.normalize_or(wi) * r
    }
}

impl DirectionSampler for SphericalCap {
    fn sample(&self, u: Vec2) -> DirectionSample {
        let u = inside_unit_square(u);
        let less_cosine = u.x * self.less_cosine;
        let sine = (less_cosine * (2.0 - less_cosine)).max(0.0).sqrt();
        let (s, c) = unit_circle(TAU * u.y);
        let (x, y) = self.axis.any_orthonormal_pair();
        let wi = x * (sine * c) + y * (sine * s) + self.axis * (1.0 - less_cosine);
        let to = self.meet(wi, less_cosine);
        DirectionSample {
            wi: wi.as_vec3(),
            point: (self.reference + to).as_vec3(),
            distance: to.length() as f32,
            pdf: self.density,
        }
    }

    fn pdf_of_hit(&self, _: Vec3, _: f32) -> f32 {
        self.density
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let wi = wi.as_dvec3();
        let across = wi.cross(self.to_center).length_squared();
        let limit = self.radius * self.radius * wi.length_squared();
        let hit = self.is_inside() && limit > 0.0 || across <= limit && wi.dot(self.to_center) > 0.0;
        if hit { self.density } else { 0.0 }
    }
}
