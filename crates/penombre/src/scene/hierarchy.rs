//! Figures about the acceleration structure.

use super::Scene;
use penombre_bvh::Bvh;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

/// Figures about the acceleration structure of a scene. Times differ between runs, so they stand here and in no
/// [`Summary`](super::Summary), which may be compared.
#[derive(Clone, Copy, Debug)]
pub struct Hierarchy {
    /// Hierarchies that instances share.
    pub nested: usize,
    /// Inner nodes, those of nested hierarchies included.
    pub nodes: usize,
    /// Leaves, likewise.
    pub leaves: usize,
    /// Nodes on the longest way down, through an instance where there are any.
    pub depth: usize,
    /// Nodes and leaves that a random line through the box of all is expected to meet, nested ones left out (surface area
    /// heuristic).
    pub sah_cost: f64,
    /// Time that all builds took.
    pub build_time: Duration,
}

impl Hierarchy {
    /// Of the upper level and the hierarchies that it holds.
    pub(super) fn of(upper: &Bvh, nested: &HashMap<u32, Arc<Bvh>>) -> Self {
        let stats = upper.stats();
        let mut all = Self {
            nested: nested.len(),
            nodes: stats.nodes,
            leaves: stats.leaves,
            depth: stats.depth,
            sah_cost: stats.sah_cost,
            build_time: upper.build_time(),
        };
        let mut deepest = 0;
        for bvh in nested.values() {
            let stats = bvh.stats();
            all.nodes += stats.nodes;
            all.leaves += stats.leaves;
            all.build_time += bvh.build_time();
            deepest = deepest.max(stats.depth);
        }
        all.depth += deepest;
        all
    }
}

impl Scene {
    /// Figures about the acceleration structure.
    pub fn hierarchy(&self) -> Hierarchy {
        self.shapes.hierarchy
    }
}
