//! From geometries to trees.

mod binary;
mod bins;
mod box4;
mod collect;
mod cover;
mod pairs;
mod parallel;
mod presplit;
mod refit;
mod reinsert;
mod twins;
mod wide;

pub(crate) use collect::{Collected, collect};
pub(crate) use parallel::all_threads;
pub use refit::RefitError;
pub(crate) use refit::{Dormant, compare, inventory, refit};
pub(crate) use wide::Shape;

use binary::Rules;
use box4::Reference as _;
use reinsert::Effort;

use crate::{Geometry, InstructionSet, bvh::Tree, node::ChildRef, primitive::BLOCK};

/// How much time may go into a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quality {
    /// For previews and what moves: a binary tree by the surface area heuristic, collapsed.
    Fast,
    /// For final pictures: takes several times as long and gives rays less to do.
    #[default]
    High,
}

/// How a tree is built. The hits do not depend on it, only speed and memory do.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BuildOptions {
    /// Time of the build against that of rays. Default [`Quality::High`].
    pub quality: Quality,
    /// Bins per axis between which splits are tried, 4 to 64; fewer for few primitives, up to twice as many for
    /// thousands. Default 32.
    pub bins: usize,
    /// Triangles per leaf at most, 1 to 8. Default 8, which fills the vector units.
    pub max_leaf: usize,
    /// Instructions to follow rays with, at most: what the processor does not have is not used. Default
    /// [`InstructionSet::best`].
    pub instructions: InstructionSet,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { quality: Quality::default(), bins: 32, max_leaf: 8, instructions: InstructionSet::best() }
    }
}

impl BuildOptions {
    /// The defaults with another quality.
    pub fn with_quality(quality: Quality) -> Self {
        Self { quality, ..Self::default() }
    }
}

/// Why no hierarchy could be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle names a vertex that does not exist.
    #[error(
        "geometry {geometry}: triangle {triangle} refers to vertex {index}, but there are {vertices} \
         vertices (counted from 0)"
    )]
    IndexOutOfRange {
        /// Index of the mesh in the list of geometries.
        geometry: usize,
        /// Index of the triangle in its mesh.
        triangle: usize,
        /// The vertex index found.
        index: u32,
        /// Number of vertices of the mesh.
        vertices: usize,
    },
    /// An instance of a hierarchy that holds instances itself.
    #[error(
        "geometry {geometry}: the instanced hierarchy holds instances itself; only two levels are supported: \
         place its contents directly instead"
    )]
    NestedInstances {
        /// Index of the instance in the list of geometries.
        geometry: usize,
    },
    /// More primitives in one hierarchy than ids can number.
    #[error(
        "{found} primitives in one hierarchy; at most {limit} are supported: split them into several instances"
    )]
    TooManyPrimitives {
        /// Primitives or geometries found.
        found: usize,
        /// The limit, 2²⁹.
        limit: usize,
    },
}

/// The most primitives in one tree.
pub(crate) const MAX_PRIMITIVES: usize = ChildRef::LIMIT;

/// With [`Quality::High`]: references for each primitive at most, on average (measured on long thin triangles: 1.3 makes
/// rays 1.75 times as fast, 1.5 twice).
const MOST_PARTS: f64 = 1.3;

/// With [`Quality::High`]: how the binary tree is improved (measured: twice the rounds save rays another hundredth).
const EFFORT: Effort = Effort { rounds: 8, share: 0.1 };

/// Triangles that the binary tree does not part. Leaves of eight are put together from these (measured: with 4 the visits
/// to nodes and leaves are the same as with 1 within a hundredth, and fast builds take a sixth less time; with 2, final
/// ones take a tenth less).
const FAST_LEAF: usize = 4;
const HIGH_LEAF: usize = 2;

/// Builds the tree of the collected primitives. It is the same for any number of threads.
pub(crate) fn build(collected: Collected<'_>, options: &BuildOptions, threads: usize) -> (Tree, Shape) {
    let Collected { mut refs, geometries, instances, .. } = collected;
    let bins = options.bins.clamp(4, bins::MAX_BINS);
    let most = options.max_leaf.clamp(1, BLOCK);
    let high = options.quality == Quality::High;
    let starts = wide::starts(geometries);
    let twins = twins::take_out(&mut refs, geometries, &starts);
    let mut bounds = None;
    if high {
        // Parts may reach out of the box of all.
        bounds = Some(box4::extent_of(&refs, threads).bounds());
        let most = ((refs.len() as f64 * MOST_PARTS) as usize).min(MAX_PRIMITIVES);
        presplit::split(&mut refs, geometries, most, threads);
    }
    let shares: Vec<bool> = geometries.iter().map(|g| matches!(g, Geometry::Triangles(_))).collect();
    let mut spare = Vec::new();
    if !high && most > 1 {
        spare = pairs::join(&mut refs, &shares, threads);
    }
    let leaf = if high { HIGH_LEAF } else { FAST_LEAF }.min(most);
    let rules = Rules { bins, block: 1 << most.ilog2(), leaf, shares: &shares };
    let mut tree = binary::build(&mut refs, spare, rules, threads);
    if high {
        tree.squeeze();
        reinsert::improve(&mut tree, &EFFORT, threads);
        reinsert::arrange(&mut tree, binary::SMALL, threads);
    }
    cover::plan(&mut tree, &refs, most, threads, |r| shares[r.key().geometry as usize]);
    let (mut tree, shape) = wide::collapse(&tree, &refs, geometries, starts, instances, threads);
    tree.twins = twins;
    tree.bounds = bounds.unwrap_or(tree.bounds);
    tree.finish();
    (tree, shape)
}
