//! Rays and hits.

use penombre_math::Vec3;

/// A half-open question: what lies on `origin + t·dir` with `t_min < t < t_max`?
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: Vec3,
    /// Hits count beyond this `t` only (exclusive). May be negative.
    pub t_min: f32,
    /// Direction, of any length but zero.
    pub dir: Vec3,
    /// Hits count before this `t` only (exclusive). May be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray from its parts.
    pub fn new(origin: Vec3, dir: Vec3, t_min: f32, t_max: f32) -> Self {
        Self { origin, t_min, dir, t_max }
    }

    /// The point at `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.dir * t
    }
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in lengths of the ray's direction; infinite for a miss.
    pub t: f32,
    /// Triangle: barycentric weight of vertex 1. Quad: coordinate along side 0, in \[0, 1\]. A caller's
    /// primitive: what it says. Otherwise 0.
    pub u: f32,
    /// Triangle: barycentric weight of vertex 2. Quad: coordinate along side 1, in \[0, 1\]. A caller's
    /// primitive: what it says. Otherwise 0.
    pub v: f32,
    /// Index of the geometry in the list the hierarchy was built from; for a hit inside an instance, in the
    /// list of the nested hierarchy.
    pub geometry: u32,
    /// Index of the primitive in its geometry.
    pub prim: u32,
    /// Index of the instance in the top-level list of geometries, or [`Hit::NO_INSTANCE`].
    pub instance: u32,
}

impl Hit {
    /// The value of `instance` for a hit outside all instances.
    pub const NO_INSTANCE: u32 = u32::MAX;

    /// Nothing was met.
    pub const MISS: Self = Self {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        geometry: u32::MAX,
        prim: u32::MAX,
        instance: Self::NO_INSTANCE,
    };

    /// True unless this is a miss.
    pub fn is_hit(&self) -> bool {
        self.prim != u32::MAX
    }

    /// Index of what was met in the top-level list of geometries: the instance if there is one, else the geometry.
    pub fn top_geometry(&self) -> u32 {
        if self.instance == Self::NO_INSTANCE { self.geometry } else { self.instance }
    }
}

impl Default for Hit {
    fn default() -> Self {
        Self::MISS
    }
}
