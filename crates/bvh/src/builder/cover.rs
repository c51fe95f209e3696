//! The best way to cover a binary tree with nodes of eight, by dynamic programming over the surface area heuristic.
//!
//! For each subtree and each number of free places in the node above, the cheapest set of roots is known from those of
//! its two halves. A set of triangles that fits into one block may become a leaf. What was decided is kept in the nodes
//! of the binary tree as their plans.

use super::binary::{Binary, Subtree};
use super::box4::{BinaryNode, Content, PrimRef, Reference as _, Tree as _};
use super::parallel::{self, take};
use crate::node::WIDTH;
use crate::primitive::BLOCK;
use penombre_math::Vec4;

/// Cost of a node, in units of itself.
const NODE_COST: f32 = 1.0;
/// Cost of a full leaf, in units of a node. Anything from 0.4 to 1 gives the same visits to nodes and leaves within a
/// two-hundredth (measured).
const LEAF_COST: f32 = 0.6;
/// What each empty place of a leaf adds. It costs rays nothing, but memory: this much fills leaves by a sixth more, and
/// changes the visits by less than a two-hundredth (measured).
const EMPTY_COST: f32 = 0.15;

/// Cost of a leaf of so many primitives.
fn leaf_cost(count: u32) -> f32 {
    LEAF_COST + EMPTY_COST * (BLOCK as u32 - count.min(BLOCK as u32)) as f32
}

/// What is known of a subtree while the one around it is not.
#[derive(Clone, Copy)]
struct Known {
    /// Cost with one to seven places, and once more with seven.
    cost: [f32; WIDTH],
    /// Primitives, if they may share a leaf; otherwise more than fit.
    count: u32,
}

/// More primitives than any leaf holds.
const TOO_MANY: u32 = 1 << 20;

/// Bit of a plan: with one place, the subtree is a leaf.
const LEAF: u32 = 1 << 21;

/// Bits of a plan that tell the places for the left half, given 2 to 8 places; 0: better with one place less.
fn left_of(plan: u32, places: usize) -> usize {
    (plan >> (3 * (places - 2))) as usize % WIDTH
}

/// What costs are computed with.
struct Costs<'a, S> {
    refs: &'a [PrimRef],
    /// Most primitives in a leaf.
    most: u32,
    /// Scale of areas.
    scale: f32,
    shares: S,
}

/// Makes the plans. `shares`: whether a reference may share a leaf, with at most `most` in all.
pub(super) fn plan(
    binary: &mut Binary,
    refs: &[PrimRef],
    most: usize,
    threads: usize,
    shares: impl Fn(&PrimRef) -> bool + Sync,
) {
    let Some(root) = binary.nodes.first() else { return };
    let scale = root.extent().area_scale();
    let costs = Costs { refs, most: most as u32, scale, shares };
    let (top, mut rest) = binary.nodes.split_at_mut(binary.top);
    let jobs = binary.subtrees.iter().map(|subtree| (subtree.clone(), take(&mut rest, subtree.below.len())));
    let pairs = parallel::map(threads, jobs.collect(), |(subtree, nodes)| {
        costs.plan_below(&subtree, &mut nodes[..subtree.used])
    });
    let mut known = vec![costs.nothing(); top.len()];
    let mut pair_below = vec![None; top.len()];
    for (subtree, pair) in binary.subtrees.iter().zip(pairs) {
        pair_below[subtree.root] = pair;
    }
    for i in (0..top.len()).rev() {
        let pair = pair_below[i].or_else(|| top[i].child().map(|child| [known[child], known[child + 1]]));
        known[i] = costs.settle(&mut top[i], pair);
    }
}

impl<S: Fn(&PrimRef) -> bool> Costs<'_, S> {
    fn nothing(&self) -> Known {
        Known { cost: [0.0; WIDTH], count: TOO_MANY }
    }

    /// Plans all nodes of a subtree but its root. Returns what is known of the root's children.
    fn plan_below(&self, subtree: &Subtree, nodes: &mut [BinaryNode]) -> Option<[Known; 2]> {
        let start = subtree.below.start;
        let mut known = vec![self.nothing(); nodes.len()];
        for i in (0..nodes.len()).rev() {
            let pair = nodes[i].child().map(|child| [known[child - start], known[child + 1 - start]]);
            known[i] = self.settle(&mut nodes[i], pair);
        }
        known.first_chunk().copied()
    }

    /// Plans a node by what is known of its children.
    #[inline(always)]
    fn settle(&self, node: &mut BinaryNode, children: Option<[Known; 2]>) -> Known {
        let area = node.extent().area(self.scale);
        match (node.content(), children) {
            (Content::Children(_), Some([l, r])) => {
                let count = (l.count + r.count).min(TOO_MANY);
                let (known, plan) = join(&l, &r, area, count, count <= self.most);
                node.set_plan(plan);
                known
            }
            (Content::Leaf { first, count }, _) => {
                node.set_plan(LEAF);
                let refs = &self.refs[first..first + count];
                let shares = (self.shares)(&refs[0]);
                let count = refs.iter().map(|r| r.count()).sum();
                let cost = [area * leaf_cost(count); WIDTH];
                Known { cost, count: if shares { count } else { TOO_MANY } }
            }
            (Content::Children(_), None) => self.nothing(),
        }
    }
}

/// A subtree from its halves, and its plan; `fits`: it may be a leaf.
#[inline(always)]
fn join(l: &Known, r: &Known, area: f32, count: u32, fits: bool) -> (Known, u32) {
    // Lane j: the least cost of both halves apart with j + 1 places, and how many of these the left one has.
    let mut padded = [f32::INFINITY; 2 * WIDTH];
    padded[WIDTH..].copy_from_slice(&r.cost);
    let (mut costs, mut lefts) = ([Vec4::INFINITY; 2], [Vec4::ONE; 2]);
    for k in 1..WIDTH {
        let (left, number) = (Vec4::splat(l.cost[k - 1]), Vec4::splat(k as f32));
        for half in 0..2 {
            let cost = left + Vec4::from_slice(&padded[WIDTH - k + 4 * half..]);
            let better = cost.cmplt(costs[half]);
            costs[half] = cost.min(costs[half]);
            lefts[half] = Vec4::select(better, number, lefts[half]);
        }
    }
    let mut apart = [0f32; WIDTH];
    let mut left = [0f32; WIDTH];
    for half in 0..2 {
        costs[half].write_to_slice(&mut apart[4 * half..]);
        // 2²³ more: then the low bits are the number.
        (lefts[half] + 8_388_608.0).write_to_slice(&mut left[4 * half..]);
    }
    let number = |places: usize| (left[places - 1].to_bits() % WIDTH as u32) << (3 * (places - 2));
    let node = area * NODE_COST + apart[WIDTH - 1];
    let leaf = if fits { area * leaf_cost(count) } else { f32::INFINITY };
    let mut plan = number(WIDTH) | if leaf <= node && fits { LEAF } else { 0 };
    let mut cost = [node.min(leaf); WIDTH];
    for places in 2..WIDTH {
        let (less, more) = (cost[places - 2], apart[places - 1]);
        cost[places - 1] = if more < less { more } else { less };
        plan |= if more < less { number(places) } else { 0 };
    }
    cost[WIDTH - 1] = cost[WIDTH - 2];
    (Known { cost, count }, plan)
}

/// A few nodes of the binary tree.
#[derive(Clone, Copy)]
pub(super) struct Roots {
    list: [u32; WIDTH],
    len: usize,
}

impl Roots {
    fn push(&mut self, root: usize) {
        self.list[self.len] = root as u32;
        self.len += 1;
    }

    /// In ascending order of a number; equals stay in order.
    pub(super) fn sort_by(&mut self, number: impl Fn(usize) -> f32) {
        let mut numbers = [0f32; WIDTH];
        for i in 0..self.len {
            let (root, key) = (self.list[i], number(self.list[i] as usize));
            let mut at = i;
            while at > 0 && numbers[at - 1] > key {
                (numbers[at], self.list[at]) = (numbers[at - 1], self.list[at - 1]);
                at -= 1;
            }
            (numbers[at], self.list[at]) = (key, root);
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        self.list.into_iter().take(self.len).map(|root| root as usize)
    }
}

/// How subtrees are covered, as planned.
#[derive(Clone, Copy)]
pub(super) struct Cover<'a> {
    pub(super) nodes: &'a [BinaryNode],
}

impl Cover<'_> {
    /// Whether a subtree that has a place of its own is a leaf.
    #[inline(always)]
    pub(super) fn is_leaf(&self, root: usize) -> bool {
        self.nodes[root].plan() & LEAF != 0
    }

    /// The subtrees in the places of the node that covers `root`.
    pub(super) fn children(&self, root: usize) -> Roots {
        let mut found = Roots { list: [0; WIDTH], len: 0 };
        match self.nodes[root].child() {
            Some(child) if !self.is_leaf(root) => {
                let left = left_of(self.nodes[root].plan(), WIDTH);
                self.gather(child, left, &mut found);
                self.gather(child + 1, WIDTH - left, &mut found);
            }
            _ => found.push(root),
        }
        found
    }

    fn gather(&self, root: usize, places: usize, found: &mut Roots) {
        let node = &self.nodes[root];
        let mut places = places.min(WIDTH - 1);
        while places > 1 && left_of(node.plan(), places) == 0 {
            places -= 1;
        }
        match node.child() {
            Some(child) if places > 1 => {
                let left = left_of(node.plan(), places);
                self.gather(child, left, found);
                self.gather(child + 1, places - left, found);
            }
            _ => found.push(root),
        }
    }

    /// Calls `take` with the number of every reference below `root`.
    pub(super) fn references(&self, root: usize, take: &mut impl FnMut(usize)) {
        match self.nodes[root].content() {
            Content::Leaf { first, count } => (first..first + count).for_each(take),
            Content::Children(child) => {
                self.references(child, take);
                self.references(child + 1, take);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::box4::{BLANK, Box4};
    use super::*;
    use crate::primitive::Key;
    use penombre_math::{Bounds3, Vec3};

    /// A row of unit boxes, halved again and again.
    fn row(count: usize) -> (Binary, Vec<PrimRef>) {
        let bounds = |a: usize, b: usize| Bounds3 {
            min: Vec3::new(a as f32 * 3.0, 0.0, 0.0),
            max: Vec3::new(b as f32 * 3.0 - 2.0, 1.0, 1.0),
        };
        let refs = (0..count)
            .map(|i| PrimRef::new(&bounds(i, i + 1), Key { geometry: 0, prim: i as u32 }))
            .collect();
        let mut nodes = vec![BLANK];
        let mut tasks = vec![(0, 0usize, count)];
        while let Some((node, a, b)) = tasks.pop() {
            let (child, middle) = (nodes.len(), a.midpoint(b));
            let content =
                if b - a == 1 { Content::Leaf { first: a, count: 1 } } else { Content::Children(child) };
            nodes[node] = BinaryNode::new(Box4::new(&bounds(a, b)), content);
            if b - a > 1 {
                nodes.extend([BLANK; 2]);
                tasks.extend([(child, a, middle), (child + 1, middle, b)]);
            }
        }
        let top = nodes.len();
        (Binary { nodes, top, subtrees: Vec::new() }, refs)
    }

    fn references(cover: &Cover<'_>, root: usize) -> Vec<usize> {
        let mut found = Vec::new();
        cover.references(root, &mut |reference| found.push(reference));
        found
    }

    /// Every reference is covered once, by leaves of at most `most`.
    fn check(cover: &Cover<'_>, root: usize, most: usize, seen: &mut Vec<usize>) {
        for child in cover.children(root).iter() {
            if cover.is_leaf(child) {
                let found = references(cover, child);
                assert!(found.len() <= most);
                seen.extend(found);
            } else {
                assert_ne!(child, root);
                check(cover, child, most, seen);
            }
        }
    }

    #[test]
    fn everything_is_covered_once() {
        for count in [1, 2, 7, 8, 9, 63, 64, 65, 1000] {
            for (most, sharing) in [(8, true), (1, true), (8, false)] {
                let (mut binary, refs) = row(count);
                plan(&mut binary, &refs, most, 1, |_| sharing);
                let mut seen = Vec::new();
                let cover = Cover { nodes: &binary.nodes };
                check(&cover, 0, if sharing { most } else { 1 }, &mut seen);
                seen.sort_unstable();
                assert_eq!(seen, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_node_is_filled_before_another_is_opened() {
        let (mut binary, refs) = row(64);
        plan(&mut binary, &refs, 1, 1, |_| true);
        let cover = Cover { nodes: &binary.nodes };
        let children: Vec<usize> = cover.children(0).iter().collect();
        assert_eq!(children.len(), 8);
        assert!(children.iter().all(|&c| references(&cover, c).len() == 8));
    }
}
