//! From a hit to the point on the surface.

use super::Scene;
use penombre_bvh::{Hit, Ray};
use penombre_math::rounding::offset_origin;
use penombre_math::{Spectrum, Vec2, Vec3};

/// What lies where a ray met a surface, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, metres.
    pub p: Vec3,
    /// Bound per axis on how far it lies off the surface, metres.
    pub p_error: Vec3,
    /// Geometric normal, unit, on the outside of the surface.
    pub ng: Vec3,
    /// Shading normal, unit.
    pub ns: Vec3,
    /// Toward where the ray came from, unit.
    pub wo: Vec3,
    /// Surface coordinates.
    pub uv: Vec2,
    /// Interpolated vertex colour; white where there is none.
    pub color: Spectrum,
    /// Index of the material.
    pub material: u32,
    /// Index of the shape.
    pub shape: u32,
    /// The ray's parameter at the hit.
    pub t: f32,
}

impl SurfacePoint {
    /// True if the ray came from the outside.
    pub fn outside(&self) -> bool {
        self.ng.dot(self.wo) >= 0.0
    }

    /// The shading normal turned to the side from which the ray came.
    pub fn facing_normal(&self) -> Vec3 {
        let ng = self.facing_geometric_normal();
        if self.ns.dot(ng) < 0.0 { -self.ns } else { self.ns }
    }

    /// The geometric normal turned to the side from which the ray came.
    pub fn facing_geometric_normal(&self) -> Vec3 {
        if self.outside() { self.ng } else { -self.ng }
    }

    /// The origins of rays that leave this point.
    pub fn departure(&self) -> Departure {
        let sides = [self.origin_toward(-self.ng), self.origin_toward(self.ng)];
        Departure { p: self.p, normal: self.ng, sides }
    }

    /// Origin for a ray that leaves in direction `dir` (any length) without meeting this spot again.
    pub fn origin_toward(&self, dir: Vec3) -> Vec3 {
        offset_origin(self.p, self.p_error, self.ng, dir)
    }
}

/// Where rays leave a surface point: one origin on each side, for many rays from one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    p: Vec3,
    normal: Vec3,
    /// Origins behind and before the surface.
    sides: [Vec3; 2],
}

impl Departure {
    /// Origin for a ray toward `target`.
    pub fn origin(&self, target: Vec3) -> Vec3 {
        self.sides[usize::from((target - self.p).dot(self.normal) >= 0.0)]
    }
}

impl Scene {
    /// The surface at a hit of `ray`; `None` for a miss.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfacePoint> {
        if !hit.is_hit() {
            return None;
        }
        let index = if hit.instance == Hit::NO_INSTANCE { hit.geometry } else { hit.instance };
        let placed = &self.shapes.placed[index as usize];
        let shape = &self.shapes.list[placed.shape as usize].value;
        let local_ray = match &placed.to_world {
            None => *ray,
            Some(map) => {
                let inverse = map.inverse();
                Ray::new(inverse.point(ray.origin), inverse.vector(ray.dir), ray.t_min, ray.t_max)
            }
        };
        let mut at = shape.point(&local_ray, hit);
        if let Some(map) = &placed.to_world {
            (at.p, at.p_error) = map.point_with_error(at.p, at.p_error);
            at.ng = map.normal(at.ng).normalize_or(Vec3::Z);
            at.ns = map.normal(at.ns).normalize_or(at.ng);
        }
        let slots = &self.slots[placed.shape as usize];
        let slot = (at.slot as usize).min(slots.len() - 1);
        Some(SurfacePoint {
            p: at.p,
            p_error: at.p_error,
            ng: at.ng,
            ns: at.ns,
            wo: -ray.dir.normalize(),
            uv: at.uv,
            color: at.color,
            material: slots[slot],
            shape: placed.shape,
            t: hit.t,
        })
    }
}
