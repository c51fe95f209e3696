//! `disk`: a flat round plate.
//!
//! Surface coordinates: u the angle around the centre over 2π (in 0..1), v the distance from the centre over the
//! radius.
//!
//! ```toml
//! [shape.table]
//! type = "disk"
//! center = [0, -1, 0]
//! normal = [0, 1, 0]
//! radius = 3
//! material = "floor"
//! ```

use super::common::{CENTER, MATERIAL, RADIUS, TRANSFORM, place, rounded, scaled_radius, uniform_scale};
use super::{Detail, Shape, ShapePoint, Tessellation};
use crate::registry::Context;
use penombre_bvh::{Geometry, Hit, Ray};
use penombre_math::{Bounds3, DAffine3, Frame, Spectrum, Vec2, Vec3, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec};
use std::f32::consts::TAU;

/// Edges of the polygon that stands for the circle in previews.
const SEGMENTS: u32 = 128;

/// A disk in world space, or in the space before [`Shape::remainder`].
#[derive(Clone, Debug, PartialEq)]
pub struct Disk {
    center: Vec3,
    frame: Frame,
    radius: f32,
    remainder: Option<DAffine3>,
}

impl Disk {
    /// In world space; `normal` of any length but 0. `None` if it has no area or leaves the range of single precision.
    pub fn new(center: Vec3, normal: Vec3, radius: f32) -> Option<Self> {
        let normal = normal.as_dvec3().try_normalize()?.as_vec3();
        let sound = center.is_finite() && radius > 0.0 && radius.is_finite();
        sound.then(|| Self { center, frame: Frame::from_z(normal), radius, remainder: None })
    }
}

impl Shape for Disk {
    const TYPE_NAME: &'static str = "disk";
    const SCHEMA: &'static [ParamSpec] = &[
        CENTER,
        ParamSpec::with_default(
            "normal",
            Kind::Direction,
            ParamDefault::Vec3([0.0, 0.0, 1.0]),
            "The direction that it faces, of any length.",
        ),
        RADIUS,
        MATERIAL,
        TRANSFORM,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let normal = p.vec3("normal").as_dvec3().normalize_or_zero();
        let (center, radius) = (p.vec3("center"), p.f32("radius"));
        let map = p.transform("transform");
        let Some(scale) = uniform_scale(&map) else {
            let frame = Frame::from_z(normal.as_vec3());
            return Some(Self { center, frame, radius, remainder: Some(map) });
        };
        let center = place(&map, center, p, context)?;
        let radius = scaled_radius(radius, scale, p, context)?;
        let normal = (map.transform_vector3(normal) * map.matrix3.determinant().signum()).normalize();
        Some(Self { center, frame: Frame::from_z(normal.as_vec3()), radius, remainder: None })
    }

    fn geometry(&self) -> Geometry {
        let disk = penombre_bvh::Disk { center: self.center, normal: self.frame.z, radius: self.radius };
        Geometry::Disks(vec![disk])
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint {
        let (center, n) = (self.center.as_dvec3(), self.frame.z.as_dvec3());
        let along = ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(hit.t) - center;
        let on_plane = along - n * along.dot(n);
        let (p, p_error) = rounded(center + on_plane, center.abs().max_element() + f64::from(self.radius));
        let local = self.frame.to_local(on_plane.as_vec3());
        let angle = float::atan2(local.y, local.x) / TAU;
        let u = if angle < 0.0 { angle + 1.0 } else { angle };
        let v = (local.truncate().length() / self.radius).min(1.0);
        ShapePoint {
            p,
            p_error,
            ng: self.frame.z,
            ns: self.frame.z,
            rise: 0.0,
            bulge: [0.0; 2],
            uv: Vec2::new(u, v),
            color: Spectrum::WHITE,
            slot: 0,
        }
    }

    fn tessellate(&self, detail: &Detail) -> Tessellation {
        let segments = (detail.curved / 2).clamp(6, SEGMENTS as usize) as u32;
        Tessellation::grid(segments, 1, |uv| {
            let (s, c) = float::sin_cos(uv.x * TAU);
            let local = Vec3::new(c, s, 0.0) * (self.radius * uv.y);
            (self.center + self.frame.to_world(local), self.frame.z)
        })
    }

    fn remainder(&self) -> Option<DAffine3> {
        self.remainder
    }

    fn bounds(&self) -> Bounds3 {
        // The disk's extent along an axis is r·√(1 − n²).
        let n = self.frame.z;
        let r = (Vec3::ONE - n * n).max(Vec3::ZERO).map(f32::sqrt) * self.radius;
        Bounds3 { min: self.center - r, max: self.center + r }
    }
}
