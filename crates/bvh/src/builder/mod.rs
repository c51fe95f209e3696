//! From geometries to trees.

mod binary;
mod collect;
mod cover;
mod wide;

pub(crate) use collect::{Collected, collect};
pub(crate) use wide::Shape;

use crate::{bvh::Tree, node::ChildRef, primitive::BLOCK};

/// How a tree is built. The hits do not depend on it, only speed and memory do.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BuildOptions {
    /// Bins per axis at which splits are tried, 4 to 64. Default 16.
    pub bins: usize,
    /// Triangles per leaf at most, 1 to 8. Default 8, which fills the vector units.
    pub max_leaf: usize,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { bins: 16, max_leaf: 8 }
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

/// Builds the tree of the collected primitives.
pub(crate) fn build(collected: Collected<'_>, options: &BuildOptions) -> (Tree, Shape) {
    let Collected { mut refs, .. } = collected;
    let bins = options.bins.clamp(4, binary::MAX_BINS);
    let most = options.max_leaf.clamp(1, BLOCK);
    let nodes = binary::build(&mut refs, bins);
    wide::collapse(&nodes, &refs, most, collected.geometries, collected.instances)
}
