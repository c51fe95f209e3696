//! The best way to cover a binary tree with nodes of eight, by dynamic programming over the surface area heuristic.
//!
//! For each subtree and each number of free places in the node above, the cheapest set of roots is known from those of
//! its two halves. A set of triangles that fits into one block may become a leaf.

use super::binary::{BinaryNode, Content, half_area};
use super::collect::PrimRef;
use crate::node::WIDTH;

/// Cost of a node, in units of itself.
const NODE_COST: f32 = 1.0;
/// Cost of a leaf, in units of a node.
const LEAF_COST: f32 = 0.6;

/// What is known of a subtree.
#[derive(Clone, Copy)]
struct Best {
    /// Cost with one to seven places.
    cost: [f32; WIDTH - 1],
    /// Places for the left half, of two to eight; 0: better with one place less.
    left: [u8; WIDTH + 1],
    /// Its references.
    first: u32,
    count: u32,
    /// True: with one place, it is a leaf.
    leaf: bool,
}

/// How subtrees are covered.
pub(super) struct Cover<'a> {
    binary: &'a [BinaryNode],
    best: Vec<Best>,
}

impl<'a> Cover<'a> {
    /// `shares`: whether a reference may share a leaf, with at most `most` in all. Children come behind their parents.
    pub(super) fn new(
        binary: &'a [BinaryNode],
        refs: &[PrimRef],
        most: usize,
        shares: impl Fn(&PrimRef) -> bool,
    ) -> Self {
        let nothing = Best { cost: [0.0; WIDTH - 1], left: [0; WIDTH + 1], first: 0, count: 0, leaf: true };
        let mut best = vec![nothing; binary.len()];
        for (i, node) in binary.iter().enumerate().rev() {
            let area = half_area(&node.bounds) as f32;
            best[i] = match node.content {
                Content::Leaf { first, count } => {
                    let cost = [area * LEAF_COST; WIDTH - 1];
                    Best { cost, first: first as u32, count: count as u32, ..nothing }
                }
                Content::Children(child) => {
                    let (l, r) = (best[child], best[child + 1]);
                    let range = l.first as usize..(l.first + l.count + r.count) as usize;
                    let fits = range.len() <= most && refs[range].iter().all(&shares);
                    join(&l, &r, area, fits)
                }
            };
        }
        Self { binary, best }
    }

    /// First reference and number of those in a subtree.
    pub(super) fn range(&self, root: usize) -> (usize, usize) {
        (self.best[root].first as usize, self.best[root].count as usize)
    }

    /// Whether a subtree that has a place of its own is a leaf.
    pub(super) fn is_leaf(&self, root: usize) -> bool {
        self.best[root].leaf
    }

    /// The subtrees in the places of the node that covers `root`.
    pub(super) fn children(&self, root: usize) -> Vec<usize> {
        let mut found = Vec::with_capacity(WIDTH);
        match self.binary[root].content {
            _ if self.best[root].leaf => found.push(root),
            Content::Leaf { .. } => found.push(root),
            Content::Children(child) => {
                let left = usize::from(self.best[root].left[WIDTH]);
                self.gather(child, left, &mut found);
                self.gather(child + 1, WIDTH - left, &mut found);
            }
        }
        found
    }

    fn gather(&self, root: usize, places: usize, found: &mut Vec<usize>) {
        let best = &self.best[root];
        let mut places = places.min(WIDTH - 1);
        while places > 1 && best.left[places] == 0 {
            places -= 1;
        }
        match self.binary[root].content {
            Content::Children(child) if places > 1 => {
                let left = usize::from(best.left[places]);
                self.gather(child, left, found);
                self.gather(child + 1, places - left, found);
            }
            _ => found.push(root),
        }
    }
}

/// A subtree from its halves; `fits`: it may be a leaf.
fn join(l: &Best, r: &Best, area: f32, fits: bool) -> Best {
    let mut left = [0u8; WIDTH + 1];
    let mut apart = [f32::INFINITY; WIDTH + 1];
    for places in 2..=WIDTH {
        for k in 1..places {
            let cost = l.cost[k.min(WIDTH - 1) - 1] + r.cost[(places - k).min(WIDTH - 1) - 1];
            if cost < apart[places] || left[places] == 0 {
                (apart[places], left[places]) = (cost, k as u8);
            }
        }
    }
    let node = area * NODE_COST + apart[WIDTH];
    let leaf = if fits { area * LEAF_COST } else { f32::INFINITY };
    let mut cost = [node.min(leaf); WIDTH - 1];
    for places in 2..WIDTH {
        cost[places - 1] = cost[places - 2];
        if apart[places] < cost[places - 2] {
            cost[places - 1] = apart[places];
        } else {
            left[places] = 0;
        }
    }
    Best { cost, left, first: l.first, count: l.count + r.count, leaf: fits && leaf <= node }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::Key;
    use penombre_math::{Bounds3, Vec3};

    /// A row of unit boxes, halved again and again.
    fn row(count: usize) -> (Vec<BinaryNode>, Vec<PrimRef>) {
        let bounds = |a: usize, b: usize| Bounds3 {
            min: Vec3::new(a as f32 * 3.0, 0.0, 0.0),
            max: Vec3::new(b as f32 * 3.0 - 2.0, 1.0, 1.0),
        };
        let refs = (0..count)
            .map(|i| PrimRef { bounds: bounds(i, i + 1), key: Key { geometry: 0, prim: i as u32 } })
            .collect();
        let mut nodes = vec![BinaryNode { bounds: bounds(0, count), content: Content::Children(0) }];
        let mut tasks = vec![(0, 0, count)];
        while let Some((node, a, b)) = tasks.pop() {
            if b - a == 1 {
                nodes[node].content = Content::Leaf { first: a, count: 1 };
                continue;
            }
            let (child, middle) = (nodes.len(), a.midpoint(b));
            nodes[node].content = Content::Children(child);
            for (x, y) in [(a, middle), (middle, b)] {
                nodes.push(BinaryNode { bounds: bounds(x, y), content: Content::Children(0) });
            }
            tasks.extend([(child, a, middle), (child + 1, middle, b)]);
        }
        (nodes, refs)
    }

    /// Every reference is covered once, by leaves of at most `most`.
    fn check(cover: &Cover<'_>, root: usize, most: usize, seen: &mut Vec<usize>) {
        for child in cover.children(root) {
            if cover.is_leaf(child) {
                let (first, count) = cover.range(child);
                assert!(count <= most);
                seen.extend(first..first + count);
            } else {
                assert_ne!(child, root);
                check(cover, child, most, seen);
            }
        }
        assert!(cover.children(root).len() <= WIDTH);
    }

    #[test]
    fn everything_is_covered_once() {
        for count in [1, 2, 7, 8, 9, 63, 64, 65, 1000] {
            for (most, sharing) in [(8, true), (1, true), (8, false)] {
                let (binary, refs) = row(count);
                let cover = Cover::new(&binary, &refs, most, |_| sharing);
                let mut seen = Vec::new();
                check(&cover, 0, if sharing { most } else { 1 }, &mut seen);
                seen.sort_unstable();
                assert_eq!(seen, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_node_is_filled_before_another_is_opened() {
        let (binary, refs) = row(64);
        let cover = Cover::new(&binary, &refs, 1, |_| true);
        let children = cover.children(0);
        assert_eq!(children.len(), 8);
        assert!(children.iter().all(|c| cover.range(*c).1 == 8));
    }
}
