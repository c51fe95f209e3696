//! A binary tree by the surface area heuristic over binned centroids (\[Wald2007\]).

use super::collect::PrimRef;
use penombre_math::{Bounds3, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Bounds3,
    pub(super) content: Content,
}

/// What a binary node holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// Two nodes, side by side from this index on.
    Children(usize),
    /// References from `first` on.
    Leaf { first: usize, count: usize },
}

/// From this depth on, ranges are halved by count, so that no depth exceeds this plus 32.
const BALANCE_FROM: usize = 64;

/// Ranges of up to so many primitives are built each by one thread. The tree does not depend on who builds what.
const ONE_THREAD: usize = 1 << 15;

/// A range that is to become a subtree.
#[derive(Clone, Copy)]
struct Task {
    node: usize,
    first: usize,
    count: usize,
    depth: usize,
}

const BLANK: BinaryNode = BinaryNode { bounds: Bounds3::EMPTY, content: Content::Children(0) };

/// Sorts `refs` into leaves of one. Node 0 is the root; there is none if there is nothing to hold. Children come behind
/// their parents.
pub(super) fn build(refs: &mut [PrimRef], bins: usize) -> Vec<BinaryNode> {
    if refs.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![BLANK];
    let root = Task { node: 0, first: 0, count: refs.len(), depth: 0 };
    let mut rest = grow(refs, 0, &mut nodes, root, bins, ONE_THREAD);
    rest.sort_unstable_by_key(|task| task.first);
    let subtrees = build_all(refs, &rest, bins);
    for (task, subtree) in rest.iter().zip(subtrees) {
        graft(&mut nodes, task.node, &subtree);
    }
    nodes
}

/// Splits a task's range again and again, down to leaves or to ranges of at most `small`, which are returned. `refs`
/// begins with reference number `start`.
fn grow(
    refs: &mut [PrimRef],
    start: usize,
    nodes: &mut Vec<BinaryNode>,
    root: Task,
    bins: usize,
    small: usize,
) -> Vec<Task> {
    let (mut rest, mut scratch) = (Vec::new(), Scratch::EMPTY);
    let mut tasks = vec![root];
    while let Some(task) = tasks.pop() {
        let Task { node, first, count, depth } = task;
        if count <= small {
            rest.push(task);
            continue;
        }
        let range = &mut refs[first - start..first - start + count];
        let extent = Extent::of(range);
        let left = split(range, &extent, depth, bins, &mut scratch);
        let content = if left == 0 {
            Content::Leaf { first, count }
        } else {
            let child = nodes.len();
            nodes.extend([BLANK, BLANK]);
            tasks.push(Task { node: child + 1, first: first + left, count: count - left, depth: depth + 1 });
            tasks.push(Task { node: child, first, count: left, depth: depth + 1 });
            Content::Children(child)
        };
        nodes[node] = BinaryNode { bounds: extent.bounds, content };
    }
    rest
}

/// The subtrees of disjoint ranges in the order of the references, on all cores.
fn build_all(refs: &mut [PrimRef], tasks: &[Task], bins: usize) -> Vec<Vec<BinaryNode>> {
    let mut jobs = Vec::with_capacity(tasks.len());
    let (mut left, mut at) = (refs, 0);
    for task in tasks {
        let (_, behind) = std::mem::take(&mut left).split_at_mut(task.first - at);
        let (range, behind) = behind.split_at_mut(task.count);
        jobs.push(Mutex::new((range, Vec::new())));
        (left, at) = (behind, task.first + task.count);
    }
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some((job, task)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            jobs.get(i).zip(tasks.get(i))
        } {
            let (range, nodes) = &mut *job.lock().unwrap_or_else(PoisonError::into_inner);
            nodes.push(BLANK);
            grow(range, task.first, nodes, Task { node: 0, ..*task }, bins, 0);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    jobs.into_iter().map(|job| job.into_inner().unwrap_or_else(PoisonError::into_inner).1).collect()
}

/// Puts a subtree in the place of a node.
fn graft(nodes: &mut Vec<BinaryNode>, place: usize, subtree: &[BinaryNode]) {
    // The subtree's own root goes to `place`; the others keep their order.
    let shift = nodes.len() - 1;
    let moved = subtree.iter().map(|node| match node.content {
        Content::Children(child) => BinaryNode { content: Content::Children(child + shift), ..*node },
        Content::Leaf { .. } => *node,
    });
    for (i, node) in moved.enumerate() {
        if i == 0 { nodes[place] = node } else { nodes.push(node) }
    }
}

/// Boxes around a range of primitives and around their centroids.
struct Extent {
    bounds: Bounds3,
    centroids: Bounds3,
}

impl Extent {
    fn of(range: &[PrimRef]) -> Self {
        let mut all = Self { bounds: Bounds3::EMPTY, centroids: Bounds3::EMPTY };
        for r in range {
            all.bounds = all.bounds.union(r.bounds);
            all.centroids = all.centroids.with_point(r.centroid());
        }
        all
    }
}

/// Parts the range in two and returns the length of the first part; 0 for a leaf.
fn split(range: &mut [PrimRef], extent: &Extent, depth: usize, bins: usize, scratch: &mut Scratch) -> usize {
    let count = range.len();
    if count == 1 {
        return 0;
    }
    let best = if depth < BALANCE_FROM { best_split(range, extent, bins, scratch) } else { None };
    let left = best.map_or(0, |s| partition(range, |r| s.bins.of(r) < s.bin));
    if left == 0 || left == count { halve(range, &extent.centroids) } else { left }
}

/// Halves by centroid along the longest axis, by id among equals.
fn halve(range: &mut [PrimRef], centroids: &Bounds3) -> usize {
    let size = centroids.max * 0.5 - centroids.min * 0.5;
    let axis = size.max_position();
    let middle = range.len() / 2;
    range.select_nth_unstable_by(middle, |a, b| {
        let ids = || (a.key.geometry, a.key.prim).cmp(&(b.key.geometry, b.key.prim));
        a.centroid()[axis].total_cmp(&b.centroid()[axis]).then_with(ids)
    });
    middle
}

/// Moves what belongs left to the front and returns its number.
fn partition(range: &mut [PrimRef], left: impl Fn(&PrimRef) -> bool) -> usize {
    let mut end = 0;
    for i in 0..range.len() {
        if left(&range[i]) {
            range.swap(end, i);
            end += 1;
        }
    }
    end
}

/// A split before bin `bin` along the axis of `bins`.
struct Split {
    bins: Bins,
    bin: usize,
    /// Areas times primitives.
    cost: f64,
}

/// Maps centroids to bins.
#[derive(Clone, Copy)]
struct Bins {
    axis: usize,
    start: f32,
    scale: f32,
    last: usize,
}

impl Bins {
    fn of(&self, r: &PrimRef) -> usize {
        self.at(r.centroid())
    }

    fn at(&self, centroid: Vec3) -> usize {
        // The conversion turns NaN and negative numbers into 0.
        (((centroid[self.axis] - self.start) * self.scale) as usize).min(self.last)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds3,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds3::EMPTY, count: 0 };

    fn with(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    fn cost(&self) -> f64 {
        half_area(&self.bounds) * self.count as f64
    }
}

pub(super) const MAX_BINS: usize = 64;

/// Room for bins, used again and again.
struct Scratch {
    /// By axis.
    filled: [[Bin; MAX_BINS]; 3],
    /// The sum of each bin and all behind it.
    right: [Bin; MAX_BINS + 1],
}

impl Scratch {
    const EMPTY: Self = Self { filled: [[Bin::EMPTY; MAX_BINS]; 3], right: [Bin::EMPTY; MAX_BINS + 1] };
}

fn best_split(range: &[PrimRef], extent: &Extent, bins: usize, scratch: &mut Scratch) -> Option<Split> {
    // Few primitives need few bins.
    let bins = bins.min(range.len().next_multiple_of(4));
    let size: Vec3 = extent.centroids.max - extent.centroids.min;
    let on_axis = |axis: usize| {
        let scale = bins as f32 / size[axis];
        let useful = size[axis] > 0.0 && scale.is_finite() && scale > 0.0;
        // On an axis of no use all fall into one bin, which no split parts.
        let scale = if useful { scale } else { 0.0 };
        Bins { axis, start: extent.centroids.min[axis], scale, last: bins - 1 }
    };
    let axes = [0, 1, 2].map(on_axis);
    scratch.filled.iter_mut().for_each(|filled| filled[..bins].fill(Bin::EMPTY));
    for r in range {
        let centroid = r.centroid();
        for (bins, filled) in axes.iter().zip(&mut scratch.filled) {
            let bin = &mut filled[bins.at(centroid)];
            (bin.bounds, bin.count) = (bin.bounds.union(r.bounds), bin.count + 1);
        }
    }
    let mut best: Option<Split> = None;
    for (bins, filled) in axes.into_iter().zip(&scratch.filled) {
        if let Some(split) = best_of(filled, &mut scratch.right, bins)
            && best.as_ref().is_none_or(|b| split.cost < b.cost)
        {
            best = Some(split);
        }
    }
    best
}

/// The best place to part an axis.
fn best_of(filled: &[Bin; MAX_BINS], right: &mut [Bin; MAX_BINS + 1], bins: Bins) -> Option<Split> {
    right[bins.last + 1] = Bin::EMPTY;
    for i in (1..=bins.last).rev() {
        right[i] = right[i + 1].with(filled[i]);
    }
    let mut left = Bin::EMPTY;
    let mut best: Option<Split> = None;
    for i in 1..=bins.last {
        left = left.with(filled[i - 1]);
        let cost = left.cost() + right[i].cost();
        let useful = left.count > 0 && right[i].count > 0;
        if useful && best.as_ref().is_none_or(|b| cost < b.cost) {
            best = Some(Split { bins, bin: i, cost });
        }
    }
    best
}

/// Half the surface area. `f64`, for the square of a large `f32` overflows.
pub(super) fn half_area(bounds: &Bounds3) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let d = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    d.x * d.y + d.y * d.z + d.z * d.x
}
