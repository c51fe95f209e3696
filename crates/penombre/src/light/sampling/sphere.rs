//! Directions to spheres.

use super::flat::ROUNDINGS;
use super::{DirectionSample, DirectionSampler, inside_unit_square, sample_at, uniform_density, unit_circle};
use penombre_math::{DVec2, DVec3, Vec2, Vec3};
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
        let slack = (reference.abs().max_element() + radius) * ROUNDINGS;
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

/// Share of the samples of a [`CapAround`] that go to all that any point of the ball sees.
const RIM_SHARE: f64 = 0.1;

/// The part of a sphere that the points of a ball see, sampled for all of them at once: most samples as seen from the ball's
/// middle, the others even over that part, so that none of it is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CapAround {
    middle: SphericalCap,
    center: DVec3,
    /// Least cosine at the sphere's centre between a point of that part and the ball.
    least: f64,
    /// Of the even share, 1/m².
    even: f64,
}

impl CapAround {
    /// Of the sphere `center`, `radius`, for a ball around `reference`; `None` from within the sphere, and where
    /// [`SphericalCap::new`] gives none.
    pub fn new(reference: Vec3, ball_radius: f64, center: Vec3, radius: f32) -> Option<Self> {
        let middle = SphericalCap::new(reference, center, radius).filter(|cap| !cap.is_inside())?;
        // The tangent plane of a point of normal n has the ball behind it if n·(ball − centre) + ball radius < radius.
        let least = ((middle.radius - ball_radius) / middle.distance).max(-1.0);
        let even = RIM_SHARE / (TAU * middle.radius * middle.radius * (1.0 - least));
        even.is_finite().then_some(Self { middle, center: center.as_dvec3(), least, even })
    }

    /// A point for `u` ∈ \[0, 1)², as seen from the ball's middle; its density is per area, 1/m².
    pub fn sample(&self, u: Vec2) -> DirectionSample {
        let DVec2 { x, y } = inside_unit_square(u);
        let middle = &self.middle;
        let to = if x < RIM_SHARE {
            let less = x / RIM_SHARE * (1.0 - self.least);
            let across = (less * (2.0 - less)).max(0.0).sqrt();
            let (s, c) = unit_circle(TAU * y);
            let (a, b) = middle.axis.any_orthonormal_pair();
            let normal = a * (across * c) + b * (across * s) - middle.axis * (1.0 - less);
            middle.to_center + normal * middle.radius
        } else {
            let rest = (x - RIM_SHARE) / (1.0 - RIM_SHARE);
            middle.sample(Vec2::new(rest as f32, y as f32)).point.as_dvec3() - middle.reference
        };
        let sample = sample_at(middle.reference, to);
        DirectionSample { pdf: self.pdf(sample.point), ..sample }
    }

    /// Density with which [`sample`](Self::sample) gives a point of the sphere, 1/m².
    pub fn pdf(&self, point: Vec3) -> f32 {
        let middle = &self.middle;
        let normal = (point.as_dvec3() - self.center) / middle.radius;
        let to = point.as_dvec3() - middle.reference;
        let square = to.length_squared();
        let cos = -to.dot(normal) / square.sqrt();
        let seen = (1.0 - RIM_SHARE) * f64::from(middle.density) * cos.max(0.0) / square;
        // Rounded points of the rim count.
        let even = if -normal.dot(middle.axis) >= self.least - 1e-4 { self.even } else { 0.0 };
        (seen + even) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::{Moments, Pcg32};
    use std::f64::consts::PI;

    /// The whole sphere's light to a far point beside the ball's middle, π·r² across, and the area of the part itself.
    #[test]
    fn caps_around_a_ball_leave_nothing_out() {
        let (from, center) = (Vec3::new(0.3, -0.2, 1.0), Vec3::new(-0.8, 2.0, 0.4));
        let distance = f64::from(from.distance(center));
        for (ball, radius) in [(0.5f64, 0.004f32), (0.5, 0.3), (2.0, 0.1), (0.1, 1.5), (4.0, 2.0)] {
            let cap = CapAround::new(from, ball, center, radius).unwrap();
            let r = f64::from(radius);
            let axis = (from - center).as_dvec3().normalize();
            let lean = (0.9 * (ball - r) / distance).clamp(0.0, 0.9);
            let to = axis * (1.0 - lean * lean).sqrt() + axis.any_orthonormal_vector() * lean;
            let mut rng = Pcg32::new(3);
            let (mut across, mut area) = (Moments::default(), Moments::default());
            for _ in 0..40_000 {
                let s = cap.sample(Vec2::new(rng.next_f32(), rng.next_f32()));
                let n = (s.point - center).as_dvec3() / r;
                let pdf = f64::from(cap.pdf(s.point));
                assert!(pdf == f64::from(s.pdf) && (n.length() - 1.0).abs() < 1e-3);
                across.push(n.dot(to).max(0.0) / pdf);
                area.push(1.0 / pdf);
            }
            let whole = 2.0 * PI * r * r * (1.0 - ((r - ball) / distance).max(-1.0));
            let agree = |found: &Moments, expected: f64| {
                let error = 4.0 * found.variance_of_mean().sqrt() + 1e-4 * expected;
                assert!((found.mean() - expected).abs() < error, "{ball} {radius}: {found:?} {expected}");
            };
            agree(&area, whole);
            if ball > r {
                agree(&across, PI * r * r);
            }
        }
    }
}
