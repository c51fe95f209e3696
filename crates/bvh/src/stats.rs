//! Figures about a built hierarchy.

/// How many primitives of each kind can be hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PrimitiveCounts {
    /// Triangles.
    pub triangles: usize,
    /// Spheres.
    pub spheres: usize,
    /// Parallelograms.
    pub quads: usize,
    /// Disks.
    pub disks: usize,
    /// Instances, whatever they hold.
    pub instances: usize,
    /// Primitives of the caller's making.
    pub users: usize,
}

/// Figures about one hierarchy. Everything but `bytes` leaves nested hierarchies out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Inner nodes, each with up to 8 children.
    pub nodes: usize,
    /// Leaves: blocks of up to 8 triangles, or single primitives of the other kinds.
    pub leaves: usize,
    /// Nodes on the longest way down, 1 for a single node.
    pub depth: usize,
    /// Surface area heuristic: expected nodes plus leaves that a random line through the box meets.
    pub sah_cost: f64,
    /// Memory in bytes, each nested hierarchy counted once.
    pub bytes: usize,
    /// Primitives that can be hit.
    pub primitives: PrimitiveCounts,
    /// Primitives left out: no area, a radius not above 0, not finite, beyond the range of `f32`,
    /// an instance of nothing, or without a box.
    pub skipped: usize,
}
