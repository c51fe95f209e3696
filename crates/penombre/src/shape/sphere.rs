//! `sphere`: all points at one distance from a centre.
//!
//! Surface coordinates as the course has them, poles on the z axis: u = atan2(y, x)/2π (in 0..1),
//! v = asin(z/r)/π + 1/2.
//!
//! ```toml
//! [shape.ball]
//! type = "sphere"
//! center = [0, 0, 0]
//! radius = 1
//! material = "red"
//! ```

use super::common::{CENTER, MATERIAL, RADIUS, TRANSFORM, place, rounded, scaled_radius, uniform_scale};
use super::{Detail, Shape, ShapePoint, Tessellation};
use crate::registry::Context;
use penombre_bvh::{Geometry, Hit, Ray};
use penombre_math::{Bounds3, DAffine3, DVec3, Spectrum, Vec2, Vec3, float};
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Edges of the equator in previews: a sphere of 1000 pixels is off by less than a third of a pixel.
const SEGMENTS: u32 = 128;

/// A sphere in world space, or in the space before [`Shape::remainder`].
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    center: Vec3,
    radius: f32,
    /// World to object directions, for the coordinates only (a turned sphere turns its texture).
    to_object: Option<DAffine3>,
    remainder: Option<DAffine3>,
}

impl Sphere {
    /// Centre and radius in the space of its geometry, metres.
    pub fn center_and_radius(&self) -> (Vec3, f32) {
        (self.center, self.radius)
    }

    /// In world space. `None` if it has no area or leaves the range of single precision.
    pub fn new(center: Vec3, radius: f32) -> Option<Self> {
        let sound = center.is_finite() && radius > 0.0 && radius.is_finite();
        sound.then_some(Self { center, radius, to_object: None, remainder: None })
    }
}

impl Shape for Sphere {
    const TYPE_NAME: &'static str = "sphere";
    const SCHEMA: &'static [ParamSpec] = &[CENTER, RADIUS, MATERIAL, TRANSFORM];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let (center, radius) = (p.vec3("center"), p.f32("radius"));
        let map = p.transform("transform");
        let mirrored = map.matrix3.determinant() < 0.0;
        let Some(scale) = uniform_scale(&map).filter(|_| !mirrored) else {
            return Some(Self { center, radius, to_object: None, remainder: Some(map) });
        };
        let center = place(&map, center, p, context)?;
        let radius = scaled_radius(radius, scale, p, context)?;
        let turned = map.matrix3 * (1.0 / scale) != DAffine3::IDENTITY.matrix3;
        Some(Self { center, radius, to_object: turned.then(|| map.inverse()), remainder: None })
    }

    fn geometry(&self) -> Geometry {
        Geometry::Spheres(vec![penombre_bvh::Sphere { center: self.center, radius: self.radius }])
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint {
        let center = self.center.as_dvec3();
        let along = ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(hit.t);
        // The rounded parameter puts the point off the sphere by up to t·2⁻²⁴: pull it back.
        let n = (along - center).normalize_or(DVec3::Z);
        let radius = f64::from(self.radius);
        let (p, p_error) = rounded(center + n * radius, center.abs().max_element() + radius);
        let normal = n.as_vec3();
        let object = self.to_object.map_or(n, |map| map.transform_vector3(n).normalize_or(DVec3::Z));
        ShapePoint {
            p,
            p_error,
            ng: normal,
            ns: normal,
            rise: 0.0,
            bulge: [0.0; 2],
            uv: coordinates(object.as_vec3()),
            color: Spectrum::WHITE,
            slot: 0,
        }
    }

    fn tessellate(&self, detail: &Detail) -> Tessellation {
        // n segments around make n/2 rows of 2n triangles.
        let segments = (detail.curved.isqrt() as u32).clamp(4, SEGMENTS);
        Tessellation::grid(segments, segments / 2, |uv| {
            let (s, c) = float::sin_cos(uv.x * TAU);
            let (z, across) = float::sin_cos((uv.y - 0.5) * PI);
            let object = Vec3::new(c * across, s * across, z);
            let turn =
                |map: &DAffine3| map.inverse().transform_vector3(object.as_dvec3()).normalize().as_vec3();
            let n = self.to_object.as_ref().map_or(object, turn);
            (self.center + n * self.radius, n)
        })
    }

    fn remainder(&self) -> Option<DAffine3> {
        self.remainder
    }

    fn bounds(&self) -> Bounds3 {
        let r = Vec3::splat(self.radius);
        Bounds3 { min: self.center - r, max: self.center + r }
    }
}

/// (u, v) of a unit direction from the centre.
fn coordinates(n: Vec3) -> Vec2 {
    let u = float::atan2(n.y, n.x) / TAU;
    let u = if u < 0.0 { u + 1.0 } else { u };
    let v = float::asin(n.z.clamp(-1.0, 1.0)) * FRAC_1_PI + 0.5;
    Vec2::new(u.min(1.0), v.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_follow_the_course() {
        assert_eq!(coordinates(Vec3::X), Vec2::new(0.0, 0.5));
        assert_eq!(coordinates(Vec3::Z).y, 1.0);
        assert_eq!(coordinates(-Vec3::Z).y, 0.0);
        assert!((coordinates(Vec3::Y).x - 0.25).abs() < 1e-6);
        assert!((coordinates(-Vec3::Y).x - 0.75).abs() < 1e-6);
    }

    #[test]
    fn hit_points_lie_on_the_sphere_from_ten_thousand_radii_away() {
        let sphere =
            Sphere { center: Vec3::new(1.0, -2.0, 0.5), radius: 0.75, to_object: None, remainder: None };
        let bvh = penombre_bvh::Bvh::build(vec![sphere.geometry()], &Default::default()).unwrap();
        let origin = Vec3::new(7500.0, 300.0, -200.0);
        let ray = Ray::new(origin, (sphere.center - origin).normalize(), 0.0, f32::INFINITY);
        let hit = bvh.closest(&ray);
        assert!(hit.is_hit());
        let at = sphere.point(&ray, &hit);
        let distance = (at.p.as_dvec3() - sphere.center.as_dvec3()).length();
        assert!((distance - 0.75).abs() <= f64::from(at.p_error.length()), "{distance}");
        assert!(at.p_error.max_element() < 1e-6);
    }
}
