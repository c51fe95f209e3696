//! Spheres.

use super::{Key, Meeting, difference, dot, rounded_out, scaled, sum, wide};
use crate::{Sphere, prepared::PreparedRay};
use penombre_math::{Bounds3, Vec3};

/// A sphere that can be hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereRecord {
    center: Vec3,
    radius: f32,
    pub(crate) key: Key,
}

impl SphereRecord {
    pub(crate) fn new(sphere: &Sphere, key: Key) -> Self {
        Self { center: sphere.center, radius: sphere.radius, key }
    }

    /// The box, `None` for a sphere that cannot be hit.
    pub(crate) fn bounds(sphere: &Sphere) -> Option<Bounds3> {
        let (c, r) = (wide(sphere.center), f64::from(sphere.radius));
        if r > 0.0 { rounded_out(c.map(|x| x - r), c.map(|x| x + r)) } else { None }
    }

    /// The nearest intersection in range. All in `f64`; the discriminant comes from the distance of the line
    /// to the centre, which stays accurate far away, and the smaller root from the product of both
    /// (\[Haines2019\]).
    #[inline(always)]
    pub(crate) fn meet(&self, ray: &PreparedRay) -> Option<Meeting> {
        let radius = f64::from(self.radius);
        let from_center = difference(wide(ray.origin), wide(self.center));
        let a = dot(ray.dir, ray.dir);
        let b = -dot(from_center, ray.dir);
        let nearest = sum(from_center, scaled(ray.dir, b / a));
        let quarter_chord = radius * radius - dot(nearest, nearest);
        if quarter_chord < 0.0 {
            return None;
        }
        let c = dot(from_center, from_center) - radius * radius;
        let q = b + (a * quarter_chord).sqrt().copysign(b);
        let (t0, t1) = (c / q, q / a);
        let (first, second) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let t = ray.in_range(first).or_else(|| ray.in_range(second))?;
        Some(Meeting { t, u: 0.0, v: 0.0 })
    }
}
