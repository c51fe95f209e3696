//! Makes a binary tree better: subtrees are taken out and put in where they enlarge boxes the least
//! (\[Meister2018\]).
//!
//! In each round the best places of many subtrees are searched on all cores while the tree stays as it is. Then the moves
//! are made one after the other, the most rewarding first; those that meet what an earlier one changed are dropped. So
//! the result does not depend on the number of threads.

use super::binary::Binary;
use super::box4::{BLANK, BinaryNode, Box4, Content, Tree as _};
use super::parallel;

/// Moves must not make the binary tree higher than this, the most that the first build makes.
const HIGHEST: u8 = 100;

/// Searches that one thread does at a time.
const CHUNK: usize = 256;

/// A search gives up after so many nodes.
const PATIENCE: usize = 400;

/// Gains below this share of the box around the subtree's old place are not worth a move (measured: with a five-hundredth
/// of this, small gains far from where rays go make their ways longer by up to a fifteenth).
const LEAST_GAIN: f32 = 0.05;

/// Rounds, and the share of nodes that are candidates in each: those with the largest boxes.
pub(super) struct Effort {
    pub(super) rounds: usize,
    pub(super) share: f64,
}

/// A subtree and its better place.
#[derive(Clone, Copy, Debug)]
struct Move {
    node: u32,
    /// What it shall be the sibling of.
    beside: u32,
    /// Area saved.
    gain: f32,
}

/// The tree while it is changed. Siblings stand side by side, the left one at an odd index; nodes may come before
/// their parents.
struct Work {
    nodes: Vec<BinaryNode>,
    /// By pair of siblings.
    parents: Vec<u32>,
    /// Longest way down to a leaf, in steps.
    heights: Vec<u8>,
    /// The last round that changed what is there.
    touched: Vec<u8>,
    scale: f32,
}

/// Improves a tree without gaps. Its leaves hold the same references, but children may come before their parents afterwards, and
/// subtrees are not known.
pub(super) fn improve(binary: &mut Binary, effort: &Effort, threads: usize) {
    if binary.nodes.len() < 7 {
        return;
    }
    let mut work = Work::new(std::mem::take(&mut binary.nodes));
    for round in 0..effort.rounds.min(usize::from(u8::MAX)) {
        let candidates = work.candidates(effort.share);
        let jobs: Vec<&[u32]> = candidates.chunks(CHUNK).collect();
        let found = parallel::map(threads, jobs, |nodes| work.search_all(nodes));
        let mut moves: Vec<Move> = found.into_iter().flatten().collect();
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        for action in moves {
            work.apply(&action, round as u8 + 1);
        }
    }
    binary.nodes = work.nodes;
}

fn sibling(node: usize) -> usize {
    ((node - 1) ^ 1) + 1
}

impl Work {
    /// Children come behind their parents.
    fn new(nodes: Vec<BinaryNode>) -> Self {
        let mut parents = vec![0; nodes.len() / 2];
        let mut heights = vec![0u8; nodes.len()];
        for (i, node) in nodes.iter().enumerate().rev() {
            if let Some(child) = node.child() {
                parents[child / 2] = i as u32;
                heights[i] = heights[child].max(heights[child + 1]).saturating_add(1);
            }
        }
        let scale = nodes.first().map_or(1.0, |root| root.extent().area_scale());
        let touched = vec![0; nodes.len()];
        Self { nodes, parents, heights, touched, scale }
    }

    #[inline(always)]
    fn parent(&self, node: usize) -> usize {
        self.parents[(node - 1) / 2] as usize
    }

    #[inline(always)]
    fn area(&self, extent: Box4) -> f32 {
        extent.area(self.scale)
    }

    /// The nodes with the largest boxes, in order.
    fn candidates(&self, share: f64) -> Vec<u32> {
        let areas: Vec<f32> = self.nodes.iter().map(|node| self.area(node.extent())).collect();
        let mut order: Vec<u32> = (1..self.nodes.len() as u32).collect();
        let count = ((order.len() as f64 * share) as usize).clamp(1, order.len());
        if count < order.len() {
            let area = |i: &u32| areas[*i as usize];
            order.select_nth_unstable_by(count, |a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
            order.truncate(count);
        }
        order.sort_unstable();
        order
    }

    fn search_all(&self, nodes: &[u32]) -> Vec<Move> {
        let mut stack = Vec::new();
        nodes.iter().filter_map(|&node| self.search(node as usize, &mut stack)).collect()
    }

    /// The best new place of a subtree. `stack` is room for the search.
    fn search(&self, node: usize, stack: &mut Vec<(f32, u32)>) -> Option<Move> {
        let extent = self.nodes[node].extent();
        let (own, home) = (self.area(extent), self.parent(node));
        let home_area = self.area(self.nodes[home].extent());
        let mut best = Move { node: node as u32, beside: 0, gain: home_area * LEAST_GAIN };
        // What is saved on the way up: the box around the old place vanishes, those above shrink.
        let mut saved = home_area;
        let mut left = self.nodes[sibling(node)].extent();
        let (mut below, mut beside) = (home, sibling(node));
        let mut patience = PATIENCE;
        loop {
            self.search_below(extent, own, saved, beside, &mut best, stack, &mut patience);
            if below == 0 || patience == 0 {
                break;
            }
            if below != home {
                left = left.union(self.nodes[beside].extent());
                saved += self.area(self.nodes[below].extent()) - self.area(left);
            }
            beside = sibling(below);
            below = self.parent(below);
        }
        let stays = best.beside as usize == home || best.beside as usize == sibling(node);
        (best.beside != 0 && !stays).then_some(best)
    }

    /// Tries all places in a subtree that may be better than the best one. `saved` is the area saved before anything is
    /// enlarged.
    #[allow(clippy::too_many_arguments, reason = "the state of a search")]
    #[inline(always)]
    fn search_below(
        &self,
        extent: Box4,
        own: f32,
        saved: f32,
        root: usize,
        best: &mut Move,
        stack: &mut Vec<(f32, u32)>,
        patience: &mut usize,
    ) {
        stack.clear();
        stack.push((saved, root as u32));
        while let Some((saved, at)) = stack.pop() {
            if saved - own <= best.gain || *patience == 0 {
                continue;
            }
            *patience -= 1;
            let there = &self.nodes[at as usize];
            let gain = saved - self.area(there.extent().union(extent));
            if gain > best.gain {
                (best.gain, best.beside) = (gain, at);
            }
            if let Some(child) = there.child() {
                let saved = gain + self.area(there.extent());
                if saved - own > best.gain {
                    stack.extend([(saved, child as u32), (saved, child as u32 + 1)]);
                }
            }
        }
    }

    /// Moves a subtree unless something has changed there.
    fn apply(&mut self, action: &Move, round: u8) {
        let (node, beside) = (action.node as usize, action.beside as usize);
        let (home, other) = (self.parent(node), sibling(node));
        let there = if beside == 0 { 0 } else { self.parent(beside) };
        let around = [node, beside, home, other, there];
        if around.iter().any(|&i| self.touched[i] == round) || !self.allows(node, beside) {
            return;
        }
        around.iter().for_each(|&i| self.touched[i] = round);
        // The sibling takes the place of the old parent; both places are free for the new pair.
        self.copy(other, home);
        self.copy(beside, other);
        let extent = self.nodes[node].extent().union(self.nodes[other].extent());
        let pair = node.min(other);
        self.nodes[beside] = BinaryNode::new(extent, Content::Children(pair));
        self.parents[pair / 2] = beside as u32;
        self.heights[beside] = self.heights[node].max(self.heights[other]) + 1;
        self.update_above(home);
        self.update_above(beside);
    }

    /// Whether the new place is not below the node, and neither it nor what is there now comes too deep.
    fn allows(&self, node: usize, beside: usize) -> bool {
        let (mut at, mut depth) = (beside, 1);
        while at != 0 {
            if at == node {
                return false;
            }
            (at, depth) = (self.parent(at), depth + 1);
        }
        depth + usize::from(self.heights[node].max(self.heights[beside])) <= usize::from(HIGHEST)
    }

    /// Puts what is at `from` to `to`.
    fn copy(&mut self, from: usize, to: usize) {
        self.nodes[to] = self.nodes[from];
        self.heights[to] = self.heights[from];
        if let Some(child) = self.nodes[to].child() {
            self.parents[child / 2] = to as u32;
        }
    }

    /// Corrects boxes and heights above a node, as far as they change.
    fn update_above(&mut self, mut at: usize) {
        while at != 0 {
            at = self.parent(at);
            let Some(child) = self.nodes[at].child() else { return };
            let extent = self.nodes[child].extent().union(self.nodes[child + 1].extent());
            let height = self.heights[child].max(self.heights[child + 1]) + 1;
            if self.nodes[at].extent().equals(extent) && self.heights[at] == height {
                return;
            }
            self.nodes[at] = BinaryNode::new(extent, Content::Children(child));
            self.heights[at] = height;
        }
    }
}

/// Brings a changed tree into order again: parents before their children, subtrees together, and no subtree with more
/// than `small` leaves.
pub(super) fn arrange(binary: &mut Binary, small: usize, threads: usize) {
    let old = std::mem::take(&mut binary.nodes);
    if old.is_empty() {
        return;
    }
    let counts = leaf_counts(&old);
    let mut top = vec![old[0]];
    let mut roots = Vec::new();
    // Depth first, as a subtree is.
    let mut tasks = vec![(0, 0)];
    while let Some((from, to)) = tasks.pop() {
        let Some(child) = old[from].child() else {
            top[to] = old[from];
            continue;
        };
        if counts[from] as usize <= small {
            roots.push((from, to));
            continue;
        }
        let place = top.len();
        top[to] = BinaryNode::new(old[from].extent(), Content::Children(place));
        top.extend([BLANK; 2]);
        tasks.extend([(child + 1, place + 1), (child, place)]);
    }
    let mut nodes = vec![BLANK; old.len()];
    let (tops, mut rest) = nodes.split_at_mut(top.len());
    let (mut at, mut jobs) = (top.len(), Vec::with_capacity(roots.len()));
    binary.subtrees.clear();
    for (from, to) in roots {
        let below = 2 * counts[from] as usize - 2;
        binary.subtrees.push(super::binary::Subtree { root: to, below: at..at + below, used: below });
        jobs.push((from, at, parallel::take(&mut rest, below)));
        at += below;
    }
    let roots = parallel::map(threads, jobs, |(from, start, nodes)| arrange_below(&old, from, start, nodes));
    binary.top = top.len();
    tops.copy_from_slice(&top);
    for (subtree, root) in binary.subtrees.iter().zip(roots) {
        tops[subtree.root] = root;
    }
    binary.nodes = nodes;
}

/// Copies what is below a node to places from `start` on, depth first. Returns the node as it refers to them.
fn arrange_below(old: &[BinaryNode], from: usize, start: usize, nodes: &mut [BinaryNode]) -> BinaryNode {
    let mut root = old[from];
    let (mut next, mut tasks) = (0, vec![(from, None)]);
    while let Some((from, to)) = tasks.pop() {
        let mut node = old[from];
        if let Some(child) = node.child() {
            node = BinaryNode::new(node.extent(), Content::Children(start + next));
            tasks.extend([(child + 1, Some(next + 1)), (child, Some(next))]);
            next += 2;
        }
        match to {
            Some(place) => nodes[place] = node,
            None => root = node,
        }
    }
    root
}

/// Leaves below each node.
fn leaf_counts(nodes: &[BinaryNode]) -> Vec<u32> {
    let mut order = Vec::with_capacity(nodes.len());
    let mut tasks = vec![0];
    while let Some(at) = tasks.pop() {
        order.push(at as u32);
        if let Some(child) = nodes[at].child() {
            tasks.extend([child, child + 1]);
        }
    }
    let mut counts = vec![1; nodes.len()];
    for &at in order.iter().rev() {
        if let Some(child) = nodes[at as usize].child() {
            counts[at as usize] = counts[child] + counts[child + 1];
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::super::binary::{self, Rules};
    use super::super::box4::{PrimRef, Reference as _};
    use super::*;
    use crate::primitive::Key;
    use penombre_lab::Pcg32;
    use penombre_math::{Bounds3, Vec3};

    fn boxes(count: u32) -> Vec<PrimRef> {
        let mut rng = Pcg32::new(70);
        let mut vector = || Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let mut one = |prim| {
            let (at, size) = (vector() * 10.0, vector() * 0.3);
            let size = if prim % 10 == 0 { size * 20.0 } else { size };
            PrimRef::new(&Bounds3 { min: at, max: at + size }, Key { geometry: 0, prim })
        };
        (0..count).map(&mut one).collect()
    }

    /// Sum of all areas. Each reference is in one leaf, boxes hold their children, and children come behind their
    /// parents if `ordered`.
    fn check(binary: &Binary, refs: &[PrimRef], ordered: bool) -> f64 {
        let (mut seen, mut area, mut visited) = (vec![false; refs.len()], 0.0, 0);
        let mut tasks = vec![0];
        while let Some(at) = tasks.pop() {
            let node = &binary.nodes[at];
            visited += 1;
            area += f64::from(node.extent().area(1.0));
            match node.content() {
                Content::Children(child) => {
                    assert!(!ordered || child > at);
                    let pair = [child, child + 1].map(|i| binary.nodes[i].extent());
                    assert!(node.extent().equals(pair[0].union(pair[1])));
                    tasks.extend([child, child + 1]);
                }
                Content::Leaf { first, count } => {
                    for i in first..first + count {
                        assert!(!std::mem::replace(&mut seen[i], true));
                        assert!(refs[i].extent().union(node.extent()).equals(node.extent()));
                    }
                }
            }
        }
        assert!(seen.iter().all(|&seen| seen));
        assert_eq!(visited, binary.nodes.len(), "no gaps, no loops");
        area
    }

    #[test]
    fn moves_keep_the_tree_whole_and_make_it_smaller() {
        for (count, leaf) in [(1, 1), (2, 1), (5, 2), (3000, 1), (40_000, 2)] {
            let mut refs = boxes(count);
            let mut tree =
                binary::build(&mut refs, Vec::new(), Rules { bins: 16, block: 8, leaf, shares: &[true] }, 2);
            tree.squeeze();
            let before = check(&tree, &refs, true);
            improve(&mut tree, &Effort { rounds: 4, share: 0.3 }, 2);
            let after = check(&tree, &refs, false);
            assert!(after <= before && (count < 100 || after < 0.97 * before), "{before} {after}");
            arrange(&mut tree, 1000, 2);
            let arranged = check(&tree, &refs, true);
            assert!((arranged / after - 1.0).abs() < 1e-9);
            let below: usize = tree.subtrees.iter().map(|s| s.used).sum();
            assert_eq!(tree.top + below, tree.nodes.len());
        }
    }
}
