//! The hierarchy itself.

use crate::builder::{self, Dormant, Shape};
use crate::few;
use crate::kernel::Kernel;
use crate::kernel::pages::Pages;
use crate::node::Node;
use crate::primitive::{DiskRecord, InstanceRecord, QuadRecord, SphereRecord, TriangleBlock, UserRecord};
use crate::query::Filtered;
use crate::{
    BuildError, BuildOptions, Filter, Geometry, Hit, InstructionSet, PrimitiveCounts, Ray, RefitError, Stats,
};
use penombre_math::Bounds3;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A bounding volume hierarchy: a set of primitives that answers rays. Share it between threads freely.
pub struct Bvh {
    pub(crate) tree: Tree,
    kernel: Kernel,
    stats: Stats,
    /// Kind and number of primitives of each geometry that it was built from.
    inventory: Vec<(u8, usize)>,
    build_time: Duration,
}

/// Nodes and leaves of one level.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// The root is the first; there always is one.
    pub(crate) nodes: Pages<Node>,
    pub(crate) blocks: Pages<TriangleBlock>,
    /// Numbers of the first primitives of the geometries among all.
    pub(crate) starts: Vec<u32>,
    pub(crate) spheres: Vec<SphereRecord>,
    pub(crate) quads: Vec<QuadRecord>,
    pub(crate) disks: Vec<DiskRecord>,
    pub(crate) instances: Vec<InstanceRecord>,
    pub(crate) users: Vec<UserRecord>,
    pub(crate) bounds: Bounds3,
    /// The largest coordinate of all boxes; 0 if there is nothing.
    pub(crate) extent: f32,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    /// Entries that a ray's stack may need: seven wait for each level, eight are written at once.
    pub(crate) stack: usize,
    /// By how much hits may lie beside their boxes, as a share of the distance to the farthest corner.
    pub(crate) aside: f32,
    /// Larger than the caches next to a core.
    pub(crate) large: bool,
    /// Triangles that cannot be hit at present but have a place in a block, in the order of the blocks.
    pub(crate) dormant: Vec<Dormant>,
    /// Triangles that have no place in a block because an earlier one lies there, in order.
    pub(crate) twins: Vec<Twin>,
    /// So few primitives that rays test all of them and leave the nodes alone.
    pub(crate) few: bool,
}

/// Numbers among all primitives of two triangles with the same corners in the same order, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Twin {
    /// That of the first of its kind, which is in the tree.
    pub(crate) first: u32,
    pub(crate) number: u32,
}

/// What spheres and disks need as `aside`, and what others who compute in double precision are granted; less than 16
/// roundings of 2⁻⁵³.
const ROUND_ASIDE: f64 = 1.0 / (1u64 << 44) as f64;

/// Bytes of a tree from which on it pays to say ahead what will be read. (Measured: 5 to 17 % of a batch in trees of 47 MiB and
/// more; from 2 MiB on instead of 8, nothing is gained.)
const LARGE: usize = 8 << 20;

impl Tree {
    /// To be called once all leaves are there, and `extent` and `depth` known.
    pub(crate) fn finish(&mut self) {
        let flat = self.spheres.is_empty() && self.disks.is_empty() && self.users.is_empty();
        let round = if flat { 0.0 } else { ROUND_ASIDE };
        let quads = self.quads.iter().map(QuadRecord::aside).fold(round, f64::max);
        let all = self.instances.iter().map(|i| i.aside).fold(quads, f64::max);
        self.aside = all as f32;
        let nested = self.instances.iter().map(|i| i.bvh.tree.depth).max().unwrap_or(0);
        self.stack = 7 * (self.depth + nested) + 16;
        self.few = few::suits(self);
        self.large = self.bytes() > LARGE;
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.blocks)
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.quads)
            + size_of_val(&*self.disks)
            + size_of_val(&*self.instances)
            + size_of_val(&*self.users)
            + size_of_val(&*self.dormant)
            + size_of_val(&*self.twins)
    }

    /// The twins of a triangle in the tree, in order.
    pub(crate) fn twins_of(&self, number: u32) -> &[Twin] {
        let from = self.twins.partition_point(|twin| twin.first < number);
        let twins = &self.twins[from..];
        &twins[..twins.partition_point(|twin| twin.first == number)]
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
        Self::build_on(geometries, options, builder::all_threads())
    }

    /// [`Bvh::build`] with so many threads.
    pub(crate) fn build_on(
        geometries: Vec<Geometry>,
        options: &BuildOptions,
        threads: usize,
    ) -> Result<Self, BuildError> {
        let start = Instant::now();
        let inventory = builder::inventory(&geometries);
        let collected = builder::collect(&geometries, threads)?;
        let (skipped, triangles) = (collected.skipped, collected.triangles());
        let (tree, shape) = builder::build(collected, options, threads);
        let stats = summary(&tree, &shape, triangles, skipped);
        let kernel = Kernel::new(options.instructions);
        Ok(Self { tree, kernel, stats, inventory, build_time: start.elapsed() })
    }

    /// Moves the hierarchy along with its primitives, several times as fast as building it anew: the same lists of
    /// geometries as it was built from, with other positions (and indices, radii, places of instances). Hits are exactly
    /// those of a new build. Triangles that cannot be hit any more are skipped, and come back when they can.
    ///
    /// Nodes and leaves stay what they are, so rays take longer the more the arrangement changes: compare
    /// [`Stats::sah_cost`] with what it was after the build; from about half more on, build anew. Parts of long triangles
    /// ([`Quality::High`](crate::Quality::High)) become whole ones, so that the cost rises at first, by several
    /// times where most triangles are long: build what is to move with [`Quality::Fast`](crate::Quality::Fast).
    ///
    /// # Errors
    /// Other kinds or numbers of primitives, primitives that could not be hit when the hierarchy was built and now can,
    /// others than triangles that no longer can, triangles that lay upon an equal one and no longer do, and whatever
    /// [`Bvh::build`] refuses. The hierarchy is unchanged then.
    pub fn refit(&mut self, geometries: Vec<Geometry>) -> Result<(), RefitError> {
        let threads = builder::all_threads();
        builder::compare(&self.inventory, &builder::inventory(&geometries))?;
        let collected = builder::collect(&geometries, threads)?;
        let skipped = collected.skipped;
        let old = Shape { leaves: self.stats.leaves, depth: self.stats.depth, sah_cost: self.stats.sah_cost };
        let (shape, triangles) = builder::refit(&mut self.tree, &old, collected, threads)?;
        self.stats = summary(&self.tree, &shape, triangles, skipped);
        Ok(())
    }

    /// The instructions that rays are followed with.
    pub fn instructions(&self) -> InstructionSet {
        self.kernel.instructions()
    }

    /// How long the build took.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// The closest hit of one ray, [`Hit::MISS`] if there is none. Of several at the same distance, the one
    /// with the smallest place in the list of geometries (an instance counts by its own), then in the nested
    /// list, then primitive index.
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut hit = Hit::MISS;
        self.kernel.closest_one(self, ray, &mut hit);
        hit
    }

    /// Whether the ray hits anything; the same as `closest(ray).is_hit()`, sooner.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.kernel.occluded_one(self, ray)
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

    /// The closest hit of one ray that `filter` accepts; [`Bvh::closest`] if it accepts all. Takes longer: every
    /// candidate is computed to the last digit, and the filter asked (measured in batches on 80 000 triangles, a filter
    /// that accepts all: 7 % longer, for [`Bvh::occluded_batch_where`] 27 %).
    pub fn closest_where(&self, ray: &Ray, filter: &dyn Filter) -> Hit {
        let mut hit = Hit::MISS;
        self.kernel.closest_one_where(self, ray, filter, &mut hit);
        hit
    }

    /// Whether the ray hits anything that `filter` accepts.
    pub fn occluded_where(&self, ray: &Ray, filter: &dyn Filter) -> bool {
        self.kernel.occluded_one_where(self, ray, filter)
    }

    /// [`Bvh::closest_where`] of every ray into the same place of `hits`. The filter learns the ray's place.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_batch_where(&self, rays: &[Ray], filter: &dyn Filter, hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one place for each ray");
        self.kernel.closest_where(self, Filtered { rays, filter }, hits);
    }

    /// [`Bvh::occluded_where`] of every ray into the same place of `blocked`. The filter learns the ray's place.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_batch_where(&self, rays: &[Ray], filter: &dyn Filter, blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len(), "one place for each ray");
        self.kernel.occluded_where(self, Filtered { rays, filter }, blocked);
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
        let all = InstructionSet::available().into_iter().map(Kernel::new);
        all.map(|kernel| self.with(kernel, self.tree.clone()))
    }

    /// The same hierarchy, using its nodes however few primitives there are.
    #[cfg(test)]
    pub(crate) fn through_nodes(&self) -> Self {
        self.with(self.kernel, Tree { few: false, ..self.tree.clone() })
    }

    #[cfg(test)]
    fn with(&self, kernel: Kernel, tree: Tree) -> Self {
        let inventory = self.inventory.clone();
        Self { tree, kernel, stats: self.stats, inventory, build_time: self.build_time }
    }
}

fn summary(tree: &Tree, shape: &Shape, triangles: usize, skipped: usize) -> Stats {
    let mut seen = BTreeSet::new();
    let nested = tree.instances.iter().filter(|i| seen.insert(Arc::as_ptr(&i.bvh)));
    Stats {
        nodes: tree.nodes.len(),
        leaves: shape.leaves,
        depth: shape.depth,
        sah_cost: shape.sah_cost,
        bytes: tree.bytes() + nested.map(|i| i.bvh.stats.bytes).sum::<usize>(),
        primitives: PrimitiveCounts {
            triangles,
            spheres: tree.spheres.len(),
            quads: tree.quads.len(),
            disks: tree.disks.len(),
            instances: tree.instances.len(),
            users: tree.users.len(),
        },
        skipped,
    }
}
