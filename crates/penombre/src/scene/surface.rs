//! From a hit to the point on the surface.

use super::Scene;
use super::shapes::Placed;
use crate::bsdf::shading_normal::leaks;
use penombre_bvh::{Hit, Ray};
use penombre_math::rounding::offset_origin;
use penombre_math::{Frame, Spectrum, Vec2, Vec3};

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
    /// How far `p` lies before the geometry, along `wo`, if it was moved to the smooth surface that flat triangles stand for,
    /// metres.
    pub rise: f32,
    /// How far the smooth surface that the shading normals tell of may lie beyond `p`, along `ns` and against it, metres.
    pub bulge: [f32; 2],
    /// Toward where the ray came from, unit.
    pub wo: Vec3,
    /// True if that is the outside.
    pub is_outside: bool,
    /// Surface coordinates.
    pub uv: Vec2,
    /// Interpolated vertex colour; white where there is none.
    pub color: Spectrum,
    /// Index of the material.
    pub material: u32,
    /// Index of the shape.
    pub shape: u32,
    /// Index of the emitter that it belongs to, or [`NO_EMITTER`](super::NO_EMITTER).
    pub emitter: u32,
    /// Index of the primitive in its shape.
    pub prim: u32,
    /// The ray's parameter at the hit.
    pub t: f32,
}

impl SurfacePoint {
    /// True if the ray came from the outside.
    #[inline]
    pub fn outside(&self) -> bool {
        self.is_outside
    }

    /// The shading normal turned to the side from which the ray came.
    #[inline]
    pub fn facing_normal(&self) -> Vec3 {
        let ng = self.facing_geometric_normal();
        if self.ns.dot(ng) < 0.0 { -self.ns } else { self.ns }
    }

    /// The geometric normal turned to the side from which the ray came.
    #[inline]
    pub fn facing_geometric_normal(&self) -> Vec3 {
        if self.outside() { self.ng } else { -self.ng }
    }

    /// The origins of rays that leave this point.
    #[inline]
    pub fn departure(&self) -> Departure {
        let sides = [self.origin_toward(-self.ng), self.origin_toward(self.ng)];
        Departure { p: self.p, normal: self.ng, sides }
    }

    /// Origin for a ray that leaves in direction `dir` (any length) without meeting this spot again.
    #[inline]
    pub fn origin_toward(&self, dir: Vec3) -> Vec3 {
        if self.rise > 0.0 && dir.dot(self.ng) * self.wo.dot(self.ng) < 0.0 {
            return offset_origin(self.p - self.wo * self.rise, self.p_error, self.ng, dir);
        }
        offset_origin(self.p, self.p_error, self.ng, dir)
    }

    /// Origin for a ray that leaves in direction `dir` (any length) to the side of both normals. `None` if they disagree:
    /// the ray would lead through the surface or be blocked by it. But where the surface bulges to the side of `dir`
    /// by its shading normals, a ray may sink below the flat triangle, and begins above its neighbours \[Hanika2021\]:
    /// else such triangles show at the terminator.
    #[inline]
    pub fn leave(&self, dir: Vec3) -> Option<Vec3> {
        if !leaks(dir, self.ng, self.ns) {
            return Some(self.origin_toward(dir));
        }
        let side = if dir.dot(self.ns) > 0.0 { self.ns } else { -self.ns };
        let bulge = self.bulge[usize::from(dir.dot(self.ns) <= 0.0)];
        (bulge > 0.0).then(|| offset_origin(self.p + side * bulge, self.p_error, self.ng, side))
    }

    /// [`wo`](Self::wo) in the frame of the shading normal, on the true side of the surface: what interpolated normals turn
    /// below the horizon is mirrored at it.
    #[inline]
    pub fn local_wo(&self, frame: &Frame) -> Vec3 {
        let wo = frame.to_local(self.wo);
        if (wo.z >= 0.0) == self.outside() { wo } else { Vec3::new(wo.x, wo.y, -wo.z) }
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

impl Placed {
    /// A ray in the geometry's space.
    #[inline]
    pub fn local(&self, ray: &Ray) -> Ray {
        let Some(map) = &self.to_world else { return *ray };
        let inverse = map.inverse();
        Ray::new(inverse.point(ray.origin), inverse.vector(ray.dir), ray.t_min, ray.t_max)
    }
}

impl Scene {
    /// Index of the material of a shape's slot: those beyond the last have the last one's.
    #[inline]
    pub(super) fn material_of_slot(&self, shape: u32, slot: u32) -> u32 {
        let slots = &self.slots[shape as usize];
        slots[(slot as usize).min(slots.len() - 1)]
    }

    /// The surface at a hit of `ray`; `None` for a miss.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfacePoint> {
        self.surface_of(ray, hit, false)
    }

    /// As [`surface`](Self::surface), with flat triangles taken for the smooth surface that their normals tell of.
    pub fn smooth_surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfacePoint> {
        self.surface_of(ray, hit, true)
    }

    #[inline(always)]
    fn surface_of(&self, ray: &Ray, hit: &Hit, smooth: bool) -> Option<SurfacePoint> {
        if !hit.is_hit() {
            return None;
        }
        let index = if hit.instance == Hit::NO_INSTANCE { hit.geometry } else { hit.instance };
        let placed = &self.shapes.placed[index as usize];
        let shape = &self.shapes.list[placed.shape as usize].value;
        let local = placed.local(ray);
        let mut at = shape.point(&local, hit);
        let material = self.material_of_slot(placed.shape, at.slot);
        if smooth {
            shape.smooth(&local, hit, &mut at);
        }
        if let Some(map) = &placed.to_world {
            (at.p, at.p_error) = map.point_with_error(at.p, at.p_error);
            at.ng = map.normal(at.ng).normalize_or(Vec3::Z);
            let raised = map.vector(at.ns);
            at.ns = map.normal(at.ns).normalize_or(at.ng);
            let scale = raised.dot(at.ns).abs();
            at.bulge = at.bulge.map(|b| b * scale);
            at.rise *= map.vector(local.dir).length() / local.dir.length();
        }
        let wo = -ray.dir.normalize();
        Some(SurfacePoint {
            p: at.p,
            p_error: at.p_error,
            ng: at.ng,
            ns: at.ns,
            rise: at.rise,
            bulge: at.bulge,
            wo,
            is_outside: at.ng.dot(wo) >= 0.0,
            uv: at.uv,
            color: at.color,
            material,
            shape: placed.shape,
            emitter: self.emitter_at(index, material),
            prim: hit.prim,
            t: hit.t,
        })
    }
}
