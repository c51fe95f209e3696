//! The hierarchy itself.

use crate::builder::{self, Shape};
use crate::few;
use crate::kernel::Kernel;
use crate::node::Node;
use crate::primitive::{DiskRecord, InstanceRecord, QuadRecord, SphereRecord, TriangleBlock};
use crate::{BuildError, BuildOptions, Geometry, Hit, PrimitiveCounts, Ray, Stats};
use penombre_math::Bounds3;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

/// A bounding volume hierarchy: an immutable set of primitives that answers rays. Share it between threads
/// freely.
pub struct Bvh {
    pub(crate) tree: Tree,
    kernel: Kernel,
    stats: Stats,
}

/// Nodes and leaves of one level.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// The root is the first; there always is one.
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<TriangleBlock>,
    pub(crate) spheres: Vec<SphereRecord>,
    pub(crate) quads: Vec<QuadRecord>,
    pub(crate) disks: Vec<DiskRecord>,
    pub(crate) instances: Vec<InstanceRecord>,
    pub(crate) bounds: Bounds3,
    /// The largest coordinate of `bounds`; 0 if there is nothing.
    pub(crate) extent: f32,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    /// Entries that a ray's stack may need: seven wait for each level, eight are written at once.
    pub(crate) stack: usize,
    /// By how much hits may lie beside their boxes, as a share of the distance to the farthest corner.
    pub(crate) aside: f32,
    /// So few primitives that rays test all of them and leave the nodes alone.
    pub(crate) few: bool,
}

/// What spheres and disks need as `aside`; less than 16 roundings of 2⁻⁵³.
const ROUND_ASIDE: f64 = 1.0 / (1u64 << 44) as f64;

impl Tree {
    /// To be called once all leaves are there.
    pub(crate) fn finish(&mut self) {
        let round = if self.spheres.is_empty() && self.disks.is_empty() { 0.0 } else { ROUND_ASIDE };
        let quads = self.quads.iter().map(QuadRecord::aside).fold(round, f64::max);
        let all = self.instances.iter().map(|i| i.aside).fold(quads, f64::max);
        self.aside = all as f32;
        let nested = self.instances.iter().map(|i| i.bvh.tree.depth).max().unwrap_or(0);
        self.stack = 7 * (self.depth + nested) + 16;
        let corner = self.bounds.min.abs().max(self.bounds.max.abs());
        self.extent = if self.bounds.is_empty() { 0.0 } else { corner.max_element() };
        self.few = few::suits(self);
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.blocks)
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.quads)
            + size_of_val(&*self.disks)
            + size_of_val(&*self.instances)
    }
}

impl fmt::Debug for Bvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bvh")
            .field("bounds", &self.bounds())
            .field("stats", &self.stats)
            .finish_non_exhaustive()
    }
}

impl Bvh {
    /// Builds the hierarchy of all `geometries`. Their order is that of [`Hit::geometry`]. Primitives that
    /// cannot be hit are skipped and counted. The result depends on the arguments only; hits do not even
    /// depend on `options`.
    ///
    /// # Errors
    /// A triangle with a vertex index out of range, an instance of a hierarchy with instances, or more than
    /// 2²⁹ primitives.
    pub fn build(geometries: Vec<Geometry>, options: &BuildOptions) -> Result<Self, BuildError> {
        let collected = builder::collect(&geometries)?;
        let skipped = collected.skipped;
        let (tree, shape) = builder::build(collected, options);
        let stats = summary(&tree, &shape, skipped);
        Ok(Self { tree, kernel: Kernel::best(), stats })
    }

    /// The closest hit of one ray, [`Hit::MISS`] if there is none. Of several at the same distance, the one
    /// with the smallest place in the list of geometries (an instance counts by its own), then in the nested
    /// list, then primitive index.
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut hit = [Hit::MISS];
        self.kernel.closest(self, std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// Whether the ray hits anything; the same as `closest(ray).is_hit()`, sooner.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut blocked = [false];
        self.kernel.occluded(self, std::slice::from_ref(ray), &mut blocked);
        blocked[0]
    }

    /// [`Bvh::closest`] of every ray into the same place of `hits`: the same bits, faster.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one place for each ray");
        self.kernel.closest(self, rays, hits);
    }

    /// [`Bvh::occluded`] of every ray into the same place of `blocked`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len(), "one place for each ray");
        self.kernel.occluded(self, rays, blocked);
    }

    /// A box around everything that can be hit; empty if nothing can.
    pub fn bounds(&self) -> Bounds3 {
        self.tree.bounds
    }

    /// Figures about size and quality.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    pub(crate) fn holds_instances(&self) -> bool {
        !self.tree.instances.is_empty()
    }

    pub(crate) fn aside(&self) -> f32 {
        self.tree.aside
    }

    /// The same hierarchy on each kind of processor that this one can stand for.
    #[cfg(test)]
    pub(crate) fn on_all_kernels(&self) -> impl Iterator<Item = Self> {
        Kernel::all().into_iter().map(|kernel| Self { kernel, tree: self.tree.clone(), stats: self.stats })
    }

    /// The same hierarchy, using its nodes however few primitives there are.
    #[cfg(test)]
    pub(crate) fn through_nodes(&self) -> Self {
        Self { kernel: self.kernel, tree: Tree { few: false, ..self.tree.clone() }, stats: self.stats }
    }
}

fn summary(tree: &Tree, shape: &Shape, skipped: usize) -> Stats {
    let mut seen = BTreeSet::new();
    let nested = tree.instances.iter().filter(|i| seen.insert(Arc::as_ptr(&i.bvh)));
    Stats {
        nodes: tree.nodes.len(),
        leaves: shape.leaves,
        depth: shape.depth,
        sah_cost: shape.sah_cost,
        bytes: tree.bytes() + nested.map(|i| i.bvh.stats.bytes).sum::<usize>(),
        primitives: PrimitiveCounts {
            triangles: shape.triangles,
            spheres: tree.spheres.len(),
            quads: tree.quads.len(),
            disks: tree.disks.len(),
            instances: tree.instances.len(),
        },
        skipped,
    }
}
