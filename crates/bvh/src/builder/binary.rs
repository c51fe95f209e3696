//! A binary tree by the surface area heuristic over binned centroids (\[Wald2007\]).

use super::collect::PrimRef;
use penombre_math::{Bounds3, Vec3};

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

struct Task {
    node: usize,
    first: usize,
    count: usize,
    depth: usize,
}

/// Sorts `refs` into leaves of one. Node 0 is the root; there is none if there is nothing to hold.
pub(super) fn build(refs: &mut [PrimRef], bins: usize) -> Vec<BinaryNode> {
    if refs.is_empty() {
        return Vec::new();
    }
    let blank = BinaryNode { bounds: Bounds3::EMPTY, content: Content::Children(0) };
    let mut nodes = vec![blank];
    let mut tasks = vec![Task { node: 0, first: 0, count: refs.len(), depth: 0 }];
    while let Some(Task { node, first, count, depth }) = tasks.pop() {
        let range = &mut refs[first..first + count];
        let extent = Extent::of(range);
        let left = split(range, &extent, depth, bins);
        let content = if left == 0 {
            Content::Leaf { first, count }
        } else {
            let child = nodes.len();
            nodes.extend([blank, blank]);
            tasks.push(Task { node: child + 1, first: first + left, count: count - left, depth: depth + 1 });
            tasks.push(Task { node: child, first, count: left, depth: depth + 1 });
            Content::Children(child)
        };
        nodes[node] = BinaryNode { bounds: extent.bounds, content };
    }
    nodes
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
fn split(range: &mut [PrimRef], extent: &Extent, depth: usize, bins: usize) -> usize {
    let count = range.len();
    if count == 1 {
        return 0;
    }
    let best = if depth < BALANCE_FROM { best_split(range, extent, bins) } else { None };
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
        // The conversion turns NaN and negative numbers into 0.
        (((r.centroid()[self.axis] - self.start) * self.scale) as usize).min(self.last)
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

fn best_split(range: &[PrimRef], extent: &Extent, bins: usize) -> Option<Split> {
    // Few primitives need few bins.
    let bins = bins.min(range.len().next_multiple_of(4));
    let size: Vec3 = extent.centroids.max - extent.centroids.min;
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        let scale = bins as f32 / size[axis];
        if !(size[axis] > 0.0 && scale.is_finite() && scale > 0.0) {
            continue;
        }
        let bins = Bins { axis, start: extent.centroids.min[axis], scale, last: bins - 1 };
        if let Some(split) = best_on_axis(range, bins)
            && best.as_ref().is_none_or(|b| split.cost < b.cost)
        {
            best = Some(split);
        }
    }
    best
}

fn best_on_axis(range: &[PrimRef], bins: Bins) -> Option<Split> {
    let mut filled = [Bin::EMPTY; MAX_BINS];
    for r in range {
        let bin = &mut filled[bins.of(r)];
        *bin = bin.with(Bin { bounds: r.bounds, count: 1 });
    }
    let mut right = [Bin::EMPTY; MAX_BINS + 1];
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
