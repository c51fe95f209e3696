//! What a hierarchy is built from.

use crate::{Bvh, UserPrimitives};
use penombre_math::{Transform, Vec3};
use std::sync::Arc;

/// One entry of the list given to [`Bvh::build`]; its place in the list is the `geometry` of a
/// [`crate::Hit`].
#[derive(Clone, Debug)]
pub enum Geometry {
    /// A triangle mesh, hit from both sides.
    Triangles(Triangles),
    /// Spheres, hit from in- and outside.
    Spheres(Vec<Sphere>),
    /// Parallelograms, hit from both sides.
    Quads(Vec<Quad>),
    /// Circular disks, hit from both sides.
    Disks(Vec<Disk>),
    /// A hierarchy placed in the world; its hits carry `instance`.
    Instance(Instance),
    /// Primitives of the caller's making.
    User(Arc<dyn UserPrimitives>),
}

/// An indexed triangle mesh. Shared edges are watertight if they share vertex positions, bit for bit.
#[derive(Clone, Debug)]
pub struct Triangles {
    /// Vertex positions, any finite value.
    pub positions: Arc<[Vec3]>,
    /// Three indices into `positions` for each triangle.
    pub indices: Arc<[[u32; 3]]>,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, above 0.
    pub radius: f32,
}

/// A parallelogram: the points `origin + u·sides[0] + v·sides[1]` with `u`, `v` in \[0, 1\].
///
/// Its edges reach out by two ulps of its largest corner coordinate (`u` and `v` are clamped), so that walls
/// given by rounded corners and sides leave no gap between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// The corner at `u = v = 0`.
    pub origin: Vec3,
    /// The two sides that leave it, not parallel.
    pub sides: [Vec3; 2],
}

/// A circular disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// Centre.
    pub center: Vec3,
    /// Normal of any length but zero.
    pub normal: Vec3,
    /// Radius, above 0.
    pub radius: f32,
}

/// A hierarchy, shared by any number of instances, and its place. Two levels only: it may not hold instances.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The nested hierarchy.
    pub bvh: Arc<Bvh>,
    /// From its space to that of the instance.
    pub to_world: Transform,
}
