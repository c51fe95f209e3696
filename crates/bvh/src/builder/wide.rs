//! Collapses the binary tree into nodes of eight and lays out the leaves.

use super::binary::{BinaryNode, half_area};
use super::collect::{PrimRef, corners};
use super::cover::Cover;
use crate::Geometry;
use crate::bvh::Tree;
use crate::node::{ChildRef, Kind, Node, WIDTH};
use crate::primitive::{DiskRecord, InstanceRecord, QuadRecord, SphereRecord, TriangleBlock};
use penombre_math::Bounds3;

/// Figures about the collapsed tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) leaves: usize,
    pub(crate) depth: usize,
    pub(crate) sah_cost: f64,
    pub(crate) triangles: usize,
}

struct Collapse<'a> {
    binary: &'a [BinaryNode],
    cover: Cover<'a>,
    refs: &'a [PrimRef],
    geometries: &'a [Geometry],
    tree: Tree,
    shape: Shape,
    root_area: f64,
}

/// `refs` in the order of the binary tree's leaves; triangles share leaves of at most `most`.
pub(super) fn collapse(
    binary: &[BinaryNode],
    refs: &[PrimRef],
    most: usize,
    geometries: &[Geometry],
    instances: Vec<InstanceRecord>,
) -> (Tree, Shape) {
    let bounds = binary.first().map_or(Bounds3::EMPTY, |root| root.bounds);
    let tree = Tree { instances, bounds, ..Tree::default() };
    let root_area = half_area(&bounds).max(f64::MIN_POSITIVE);
    let shares: Vec<bool> = geometries.iter().map(|g| matches!(g, Geometry::Triangles(_))).collect();
    let cover = Cover::new(binary, refs, most, |r| shares[r.key.geometry as usize]);
    let mut work = Collapse { binary, cover, refs, geometries, tree, shape: Shape::default(), root_area };
    work.run();
    work.tree.depth = work.shape.depth;
    work.tree.finish();
    (work.tree, work.shape)
}

impl Collapse<'_> {
    /// Nodes are laid out depth first.
    fn run(&mut self) {
        self.tree.nodes.push(Node::EMPTY);
        self.shape.depth = 1;
        if self.binary.is_empty() {
            return;
        }
        let mut tasks = vec![(0, 0, 1)];
        while let Some((node, root, depth)) = tasks.pop() {
            self.shape.depth = self.shape.depth.max(depth);
            self.shape.sah_cost += self.share(root);
            let mut filled = Vec::with_capacity(WIDTH);
            for part in self.cover.children(root) {
                let child = if self.cover.is_leaf(part) {
                    self.shape.leaves += 1;
                    self.shape.sah_cost += self.share(part);
                    let (first, count) = self.cover.range(part);
                    self.leaf(first, count)
                } else {
                    let child = self.tree.nodes.len();
                    self.tree.nodes.push(Node::EMPTY);
                    tasks.push((child, part, depth + 1));
                    ChildRef::new(Kind::Node, child)
                };
                filled.push((self.binary[part].bounds, child));
            }
            self.tree.nodes[node] = Node::new(&filled);
        }
    }

    fn area(&self, binary: usize) -> f64 {
        half_area(&self.binary[binary].bounds)
    }

    /// Probability that a random line through the root's box meets this one.
    fn share(&self, binary: usize) -> f64 {
        (self.area(binary) / self.root_area).min(1.0)
    }

    fn leaf(&mut self, first: usize, count: usize) -> ChildRef {
        let key = self.refs[first].key;
        let prim = key.prim as usize;
        match &self.geometries[key.geometry as usize] {
            Geometry::Triangles(_) => self.block(first, count),
            Geometry::Spheres(spheres) => {
                self.tree.spheres.push(SphereRecord::new(&spheres[prim], key));
                ChildRef::new(Kind::Sphere, self.tree.spheres.len() - 1)
            }
            Geometry::Quads(quads) => {
                let record = QuadRecord::new(&quads[prim], key).expect("checked when it was collected");
                self.tree.quads.push(record);
                ChildRef::new(Kind::Quad, self.tree.quads.len() - 1)
            }
            Geometry::Disks(disks) => {
                let record = DiskRecord::new(&disks[prim], key).expect("checked when it was collected");
                self.tree.disks.push(record);
                ChildRef::new(Kind::Disk, self.tree.disks.len() - 1)
            }
            Geometry::Instance(_) => {
                let place = self.tree.instances.binary_search_by_key(&key.geometry, |i| i.index);
                ChildRef::new(Kind::Instance, place.expect("collected in the order of the list"))
            }
        }
    }

    /// Triangles of any meshes, in the order of their ids.
    fn block(&mut self, first: usize, count: usize) -> ChildRef {
        let mut block = TriangleBlock::EMPTY;
        for r in &self.refs[first..first + count] {
            if let Geometry::Triangles(mesh) = &self.geometries[r.key.geometry as usize] {
                block.push(corners(mesh, r.key.prim as usize), r.key);
            }
        }
        self.shape.triangles += count;
        self.tree.blocks.push(block);
        ChildRef::new(Kind::Triangles, self.tree.blocks.len() - 1)
    }
}
