//! Collapses the binary tree into nodes of eight and lays out the leaves.
//!
//! The tree is cut into pieces that are counted first and then laid out, each by one thread, where they belong. How it is
//! cut depends on the binary tree alone.

use super::binary::Binary;
use super::box4::{Content, PrimRef, Reference as _, Tree as _};
use super::collect::corners;
use super::cover::{Cover, Roots};
use super::parallel;
use crate::Geometry;
use crate::bvh::Tree;
use crate::kernel::pages::Pages;
use crate::node::{ChildRef, Kind, Node, WIDTH};
use crate::primitive::{
    BLOCK, DiskRecord, InstanceRecord, Key, QuadRecord, SphereRecord, TriangleBlock, UserRecord,
};
use penombre_math::Bounds3;

/// Figures about the collapsed tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) leaves: usize,
    pub(crate) depth: usize,
    pub(crate) sah_cost: f64,
}

impl Shape {
    fn add(&mut self, other: &Self) {
        self.leaves += other.leaves;
        self.depth = self.depth.max(other.depth);
        self.sah_cost += other.sah_cost;
    }
}

/// What all pieces share.
struct Plan<'a> {
    cover: Cover<'a>,
    refs: &'a [PrimRef],
    geometries: &'a [Geometry],
    instances: &'a [InstanceRecord],
    /// Numbers of the first primitives of the geometries among all.
    starts: &'a [u32],
    root_area: f64,
    /// Scale of areas that are only compared.
    scale: f32,
}

/// Lengths of the lists of a tree.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    nodes: usize,
    blocks: usize,
    spheres: usize,
    quads: usize,
    disks: usize,
    users: usize,
}

impl Counts {
    fn plus(self, other: &Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            blocks: self.blocks + other.blocks,
            spheres: self.spheres + other.spheres,
            quads: self.quads + other.quads,
            disks: self.disks + other.disks,
            users: self.users + other.users,
        }
    }

    /// A tree with room for so much.
    fn room(&self) -> Tree {
        Tree {
            nodes: Pages::zeroed(self.nodes),
            blocks: Pages::zeroed(self.blocks),
            spheres: Vec::with_capacity(self.spheres),
            quads: Vec::with_capacity(self.quads),
            disks: Vec::with_capacity(self.disks),
            users: Vec::with_capacity(self.users),
            ..Tree::default()
        }
    }
}

/// A subtree of nodes of eight: the root in the binary tree, and its depth.
#[derive(Clone, Copy)]
struct Piece {
    root: usize,
    depth: usize,
}

/// `refs` are those that the planned binary tree numbers, `starts` the numbers of the first primitives of the geometries.
/// The tree is to be finished.
pub(super) fn collapse(
    binary: &Binary,
    refs: &[PrimRef],
    geometries: &[Geometry],
    starts: Vec<u32>,
    instances: Vec<InstanceRecord>,
    threads: usize,
) -> (Tree, Shape) {
    let bounds = binary.nodes.first().map_or(Bounds3::EMPTY, |root| root.extent().bounds());
    let root_area = half_area(&bounds).max(f64::MIN_POSITIVE);
    let cover = Cover { nodes: &binary.nodes };
    let scale = binary.nodes.first().map_or(1.0, |root| root.extent().area_scale());
    let plan = Plan { cover, refs, geometries, instances: &instances, starts: &starts, root_area, scale };
    let (tree, shape) = plan.lay_out(binary.top, threads);
    // Parts of triangles may reach out of the box of all.
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    let reach = if bounds.is_empty() { 0.0 } else { reach };
    (Tree { instances, starts, bounds, extent: reach, depth: shape.depth, ..tree }, shape)
}

/// Numbers of the first primitives of the geometries among all.
pub(super) fn starts(geometries: &[Geometry]) -> Vec<u32> {
    let before = |next: &mut u32, geometry: &Geometry| {
        let start = *next;
        *next += super::collect::len(geometry) as u32;
        Some(start)
    };
    geometries.iter().scan(0, before).collect()
}

/// What a piece becomes.
struct Sheet {
    nodes: Vec<Node>,
    blocks: Vec<TriangleBlock>,
    spheres: Vec<SphereRecord>,
    quads: Vec<QuadRecord>,
    disks: Vec<DiskRecord>,
    users: Vec<UserRecord>,
    /// What comes before in the lists of the tree.
    start: Counts,
    shape: Shape,
}

impl Sheet {
    /// Room for what was counted.
    fn new(counts: &Counts, start: Counts) -> Self {
        Self {
            nodes: Vec::with_capacity(counts.nodes),
            blocks: Vec::with_capacity(counts.blocks),
            spheres: Vec::with_capacity(counts.spheres),
            quads: Vec::with_capacity(counts.quads),
            disks: Vec::with_capacity(counts.disks),
            users: Vec::with_capacity(counts.users),
            start,
            shape: Shape::default(),
        }
    }

    /// A place for a node.
    fn node(&mut self) -> usize {
        self.nodes.push(Node::EMPTY);
        self.nodes.len() - 1
    }

    fn append_to(&self, tree: &mut Tree, shape: &mut Shape) {
        tree.nodes[self.start.nodes..][..self.nodes.len()].copy_from_slice(&self.nodes);
        tree.blocks[self.start.blocks..][..self.blocks.len()].copy_from_slice(&self.blocks);
        tree.spheres.extend_from_slice(&self.spheres);
        tree.quads.extend_from_slice(&self.quads);
        tree.disks.extend_from_slice(&self.disks);
        tree.users.extend_from_slice(&self.users);
        shape.add(&self.shape);
    }
}

impl Plan<'_> {
    /// The nodes of eight that begin in the top of the binary tree, which has `top` nodes, become the beginning of the
    /// list; what is below them are the pieces.
    fn lay_out(&self, top: usize, threads: usize) -> (Tree, Shape) {
        let pieces = self.pieces(top);
        let jobs = pieces.clone();
        let counts = parallel::map(threads, jobs, |piece| self.count(piece.root, &|_| false));
        let mut all = self.count(0, &|root| self.is_piece(root, top));
        let mut starts = Vec::with_capacity(pieces.len());
        for count in &counts {
            starts.push(all);
            all = all.plus(count);
        }
        let (mut tree, mut shape) = (all.room(), Shape { depth: 1, ..Shape::default() });
        let mut following = starts.iter().map(|start| start.nodes);
        let first = starts.first().copied().unwrap_or(all);
        let sheet =
            self.fill(Piece { root: 0, depth: 1 }, Sheet::new(&first, Counts::default()), &mut |root| {
                self.is_piece(root, top).then(|| following.next()).flatten()
            });
        sheet.append_to(&mut tree, &mut shape);
        let jobs = pieces.iter().zip(counts.iter().zip(starts)).collect();
        let work = |(piece, (count, start)): (&Piece, (&Counts, Counts))| {
            self.fill(*piece, Sheet::new(count, start), &mut |_| None)
        };
        // So memory is first touched by one thread while others fill the next sheets.
        parallel::feed(threads, jobs, work, |sheet| sheet.append_to(&mut tree, &mut shape));
        (tree, shape)
    }

    /// Whether the node of eight that covers `root` begins a piece: all below it lies below the top.
    fn is_piece(&self, root: usize, top: usize) -> bool {
        self.cover.nodes[root].child().is_some_and(|child| child >= top)
    }

    /// All pieces, in the order in which [`Plan::fill`] meets them.
    fn pieces(&self, top: usize) -> Vec<Piece> {
        let mut pieces = Vec::new();
        if !self.cover.nodes.is_empty() {
            self.walk(Piece { root: 0, depth: 1 }, &mut |part, depth| {
                let found = self.is_piece(part, top);
                if found {
                    pieces.push(Piece { root: part, depth });
                }
                !found
            });
        }
        pieces
    }

    /// Visits all nodes of eight from one on, depth first. `enter` is asked before each other one,
    /// with its depth.
    fn walk(&self, from: Piece, enter: &mut impl FnMut(usize, usize) -> bool) {
        let mut tasks = vec![from];
        while let Some(Piece { root, depth }) = tasks.pop() {
            for part in self.largest_first(root).iter().filter(|&part| !self.cover.is_leaf(part)) {
                if enter(part, depth + 1) {
                    tasks.push(Piece { root: part, depth: depth + 1 });
                }
            }
        }
    }

    /// How much a subtree of nodes of eight fills, without what `leave` leaves out.
    fn count(&self, root: usize, leave: &dyn Fn(usize) -> bool) -> Counts {
        let mut counts = Counts { nodes: 1, ..Counts::default() };
        if self.cover.nodes.is_empty() {
            return counts;
        }
        let mut tasks = vec![root];
        while let Some(root) = tasks.pop() {
            for part in self.cover.children(root).iter() {
                if self.cover.is_leaf(part) {
                    self.count_leaf(part, &mut counts);
                } else if !leave(part) {
                    counts.nodes += 1;
                    tasks.push(part);
                }
            }
        }
        counts
    }

    fn count_leaf(&self, part: usize, counts: &mut Counts) {
        match &self.geometries[self.key_of(part).geometry as usize] {
            Geometry::Triangles(_) => counts.blocks += 1,
            Geometry::Spheres(_) => counts.spheres += 1,
            Geometry::Quads(_) => counts.quads += 1,
            Geometry::Disks(_) => counts.disks += 1,
            Geometry::Instance(_) => {}
            Geometry::User(_) => counts.users += 1,
        }
    }

    /// The first primitive in a subtree.
    fn key_of(&self, mut root: usize) -> Key {
        loop {
            match self.cover.nodes[root].content() {
                Content::Leaf { first, .. } => return self.refs[first].key(),
                Content::Children(child) => root = child,
            }
        }
    }

    /// Lays out a subtree, depth first. `elsewhere` tells the number of a node that is laid out elsewhere.
    fn fill(
        &self,
        piece: Piece,
        mut sheet: Sheet,
        elsewhere: &mut dyn FnMut(usize) -> Option<usize>,
    ) -> Sheet {
        let first = sheet.node();
        sheet.shape.depth = piece.depth;
        if self.cover.nodes.is_empty() {
            return sheet;
        }
        let mut tasks = vec![(first, piece)];
        while let Some((place, Piece { root, depth })) = tasks.pop() {
            sheet.shape.depth = sheet.shape.depth.max(depth);
            sheet.shape.sah_cost += self.share(root);
            let mut filled = [(Bounds3::EMPTY, ChildRef::ROOT); WIDTH];
            let mut count = 0;
            for part in self.largest_first(root).iter() {
                let child = if self.cover.is_leaf(part) {
                    self.leaf(part, &mut sheet)
                } else if let Some(number) = elsewhere(part) {
                    ChildRef::new(Kind::Node, number)
                } else {
                    let child = sheet.node();
                    tasks.push((child, Piece { root: part, depth: depth + 1 }));
                    ChildRef::new(Kind::Node, sheet.start.nodes + child)
                };
                filled[count] = (self.cover.nodes[part].extent().bounds(), child);
                count += 1;
            }
            sheet.nodes[place] = Node::new(&filled[..count]);
        }
        sheet
    }

    /// The parts of a node, those with large boxes first. Where any hit will do, the last ones are visited first: what is
    /// small is more likely to be hit if its box is (measured: a sixth fewer leaves for shadow rays).
    fn largest_first(&self, root: usize) -> Roots {
        let mut parts = self.cover.children(root);
        parts.sort_by(|part| -self.cover.nodes[part].extent().area(self.scale));
        parts
    }

    /// Probability that a random line through the root's box meets this one.
    fn share(&self, root: usize) -> f64 {
        (half_area(&self.cover.nodes[root].extent().bounds()) / self.root_area).min(1.0)
    }

    fn leaf(&self, part: usize, sheet: &mut Sheet) -> ChildRef {
        sheet.shape.leaves += 1;
        sheet.shape.sah_cost += self.share(part);
        let key = self.key_of(part);
        let prim = key.prim as usize;
        match &self.geometries[key.geometry as usize] {
            Geometry::Triangles(_) => self.block(part, sheet),
            Geometry::Spheres(spheres) => {
                sheet.spheres.push(SphereRecord::new(&spheres[prim], key));
                ChildRef::new(Kind::Sphere, sheet.start.spheres + sheet.spheres.len() - 1)
            }
            Geometry::Quads(quads) => {
                let record = QuadRecord::new(&quads[prim], key).expect("checked when it was collected");
                sheet.quads.push(record);
                ChildRef::new(Kind::Quad, sheet.start.quads + sheet.quads.len() - 1)
            }
            Geometry::Disks(disks) => {
                let record = DiskRecord::new(&disks[prim], key).expect("checked when it was collected");
                sheet.disks.push(record);
                ChildRef::new(Kind::Disk, sheet.start.disks + sheet.disks.len() - 1)
            }
            Geometry::User(list) => {
                sheet.users.push(UserRecord::new(list, key));
                ChildRef::new(Kind::User, sheet.start.users + sheet.users.len() - 1)
            }
            Geometry::Instance(_) => {
                let place = self.instances.binary_search_by_key(&key.geometry, |i| i.index);
                ChildRef::new(Kind::Instance, place.expect("collected in the order of the list"))
            }
        }
    }

    /// Triangles of any meshes; of each that was split, one part.
    fn block(&self, part: usize, sheet: &mut Sheet) -> ChildRef {
        let mut keys = [Key { geometry: u32::MAX, prim: u32::MAX }; BLOCK];
        let mut len = 0;
        self.cover.references(part, &mut |reference| {
            let Key { geometry, prim } = self.refs[reference].key();
            for prim in prim..prim + self.refs[reference].count() {
                let key = Key { geometry, prim };
                if !keys[..len].contains(&key) {
                    keys[len] = key;
                    len += 1;
                }
            }
        });
        let mut block = TriangleBlock::EMPTY;
        for key in &keys[..len] {
            if let Geometry::Triangles(mesh) = &self.geometries[key.geometry as usize] {
                block.push(corners(mesh, key.prim as usize), self.starts[key.geometry as usize] + key.prim);
            }
        }
        sheet.blocks.push(block);
        ChildRef::new(Kind::Triangles, sheet.start.blocks + sheet.blocks.len() - 1)
    }
}

/// Half the surface area. `f64`, for the square of a large `f32` overflows.
pub(super) fn half_area(bounds: &Bounds3) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let d = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    d.x * d.y + d.y * d.z + d.z * d.x
}
