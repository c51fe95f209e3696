//! Where to part a range of references: the surface area heuristic over binned centroids (\[Wald2007\]), over all places
//! where there are few.

use super::binary::Rules;
use super::box4::{Box4, NO_REF, PrimRef, Reference as _};
use penombre_math::Vec4;

pub(super) const MAX_BINS: usize = 64;

/// Up to so many references, all places to part them are tried.
const FEW: usize = 8;

/// With so many references in each bin, a second set of bins pays.
const WORTH_TWO: usize = 8;

/// More references than this are worth twice the bins.
const MANY: usize = 4096;

/// 2²³: in numbers from here to its double the low bits are a whole number.
const WHOLE: f32 = 8_388_608.0;

/// Maps centroids to bins on all axes at once.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    start: Vec4,
    scale: Vec4,
    last: Vec4,
    /// Bins per axis.
    pub(super) bins: usize,
    /// Bits of the axes that can be parted.
    useful: u32,
    /// Primitives that fill a leaf, less one.
    mask: u32,
}

impl Grid {
    /// `centroids`: the box of the double centroids. Few references (`count`) need few bins, many are worth more, for
    /// all that is below depends on where they are parted.
    pub(super) fn new(centroids: &Box4, rules: &Rules<'_>, count: usize) -> Self {
        let few = rules.bins.min(4 + count / 8);
        let bins = if count > MANY { (2 * rules.bins).min(MAX_BINS) } else { few };
        let size = centroids.high - centroids.low;
        let (mut scale, mut useful) = (Vec4::ZERO, 0);
        for axis in 0..3 {
            // Slightly less, so that the last centroid falls into the last bin without a comparison.
            let s = bins as f32 * (1.0 - 1e-6) / size[axis];
            if size[axis] > 0.0 && s.is_finite() && s > 0.0 {
                scale[axis] = s;
                useful |= 1 << axis;
            }
        }
        let start = centroids.low.truncate().extend(0.0);
        Self {
            start,
            scale,
            last: Vec4::splat(WHOLE + bins as f32 - 1.0),
            bins,
            useful,
            mask: rules.block - 1,
        }
    }

    /// Cost of so many primitives: half of it is that of leaves, full or not, the other half what is in them (measured:
    /// with each alone rays visit up to a tenth more; without the first half, a tenth to a fifth more leaves take memory).
    #[inline(always)]
    fn cost(&self, count: u32) -> f32 {
        (count + ((count + self.mask) & !self.mask)) as f32
    }

    /// On each axis 2²³ plus the number of the bin; NaN counts as the first.
    #[inline(always)]
    fn places(&self, r: &PrimRef) -> Vec4 {
        let place = (r.extent().double_center() - self.start) * self.scale;
        // Half a bin less, for the sum is rounded to the nearest whole number.
        (place + (WHOLE - 0.5)).max(Vec4::splat(WHOLE)).min(self.last)
    }

    /// Whether a reference lies behind a split.
    #[inline(always)]
    pub(super) fn is_right(&self, split: &Split, r: &PrimRef) -> bool {
        let right = self.places(r).cmpge(Vec4::splat(WHOLE + split.bin as f32)).bitmask();
        right >> split.axis & 1 == 1
    }
}

/// A split before bin `bin` along an axis.
#[derive(Clone, Copy)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) bin: usize,
    /// Boxes of both sides, and how many are on the left one.
    pub(super) sides: [Box4; 2],
    pub(super) left: usize,
}

/// The bins of all axes.
#[derive(Clone)]
pub(super) struct Bins {
    extents: [[Box4; MAX_BINS]; 3],
    /// References, and in the upper half primitives.
    counts: [[u64; MAX_BINS]; 3],
}

impl Bins {
    pub(super) const EMPTY: Self = Self { extents: [[Box4::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    /// Sorts references into emptied bins. `spare` is room for more bins.
    pub(super) fn fill(&mut self, grid: &Grid, refs: &[PrimRef], spare: &mut Self) {
        self.clear(grid);
        if refs.len() < WORTH_TWO * grid.bins {
            refs.iter().for_each(|r| self.put(grid, r));
            return;
        }
        // Neighbours fall into the same bins: two sets, so that they need not wait for each other.
        spare.clear(grid);
        let (pairs, rest) = refs.as_chunks::<2>();
        for [a, b] in pairs {
            self.put(grid, a);
            spare.put(grid, b);
        }
        rest.iter().for_each(|r| self.put(grid, r));
        self.add(grid, spare);
    }

    fn clear(&mut self, grid: &Grid) {
        for axis in 0..3 {
            self.extents[axis][..grid.bins].fill(Box4::EMPTY);
            self.counts[axis][..grid.bins].fill(0);
        }
    }

    #[inline(always)]
    fn put(&mut self, grid: &Grid, r: &PrimRef) {
        let places = grid.places(r).to_array();
        let count = 1 | u64::from(r.count()) << 32;
        for (axis, place) in places.iter().enumerate().take(3) {
            let bin = place.to_bits() as usize % MAX_BINS;
            self.extents[axis][bin] = self.extents[axis][bin].union(r.extent());
            self.counts[axis][bin] += count;
        }
    }

    /// Adds the bins of other references.
    pub(super) fn add(&mut self, grid: &Grid, other: &Self) {
        for axis in 0..3 {
            for bin in 0..grid.bins {
                self.extents[axis][bin] = self.extents[axis][bin].union(other.extents[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// How many references lie before a split.
    pub(super) fn left_of(&self, split: &Split) -> usize {
        self.counts[split.axis][..split.bin].iter().map(|&count| count as u32 as usize).sum()
    }

    /// The best place to part `extent`, which holds all references. None if nothing parts their centroids.
    pub(super) fn best(&self, grid: &Grid, extent: Box4) -> Option<Split> {
        let scale = extent.area_scale();
        let mut best = None;
        for axis in (0..3).filter(|axis| grid.useful >> axis & 1 == 1) {
            self.best_on(axis, grid, scale, &mut best);
        }
        let (axis, bin, _) = best?;
        let mut split = Split { axis, bin, sides: [Box4::EMPTY; 2], left: 0 };
        for (i, extent) in self.extents[axis][..grid.bins].iter().enumerate() {
            let side = &mut split.sides[usize::from(i >= bin)];
            *side = side.union(*extent);
        }
        split.left = self.left_of(&split);
        Some(split)
    }

    fn best_on(&self, axis: usize, grid: &Grid, scale: f32, best: &mut Option<(usize, usize, f32)>) {
        let (extents, counts) = (&self.extents[axis], &self.counts[axis]);
        let mut right_costs = [0f32; MAX_BINS];
        let (mut right, mut count) = (Box4::EMPTY, 0);
        for i in (1..grid.bins).rev() {
            (right, count) = (right.union(extents[i]), count + counts[i]);
            right_costs[i] = right.area(scale) * grid.cost((count >> 32) as u32);
        }
        let (mut left, mut count) = (Box4::EMPTY, 0);
        for i in 1..grid.bins {
            (left, count) = (left.union(extents[i - 1]), count + counts[i - 1]);
            // NaN if a side is empty, which is never less.
            let cost = left.area(scale) * grid.cost((count >> 32) as u32) + right_costs[i];
            if cost < best.map_or(f32::INFINITY, |b| b.2) {
                *best = Some((axis, i, cost));
            }
        }
    }
}

/// Parts few references where the heuristic wants it, across their longest side: they will share a leaf or two, so that
/// it hardly matters how (measured: no difference to trying all axes). Returns the boxes of both sides and how many are
/// on the left one.
pub(super) fn part_few(refs: &mut [PrimRef], extent: Box4) -> ([Box4; 2], usize) {
    if let [a, b] = refs {
        return ([a.extent(), b.extent()], 1);
    }
    let n = refs.len().min(FEW);
    let axis = (extent.high * 0.5 - extent.low * 0.5).truncate().max_position();
    let mut centers = [0f32; FEW];
    for (center, r) in centers.iter_mut().zip(&*refs) {
        *center = r[0][axis] + r[1][axis];
    }
    let mut ordered = [NO_REF; FEW];
    for (place, from) in ordered.iter_mut().zip(&order_of(&centers, n)[..n]) {
        *place = refs[*from as usize];
    }
    refs[..n].copy_from_slice(&ordered[..n]);
    let mut rights = [Box4::EMPTY; FEW + 1];
    for i in (1..n).rev() {
        rights[i] = rights[i + 1].union(ordered[i].extent());
    }
    let scale = extent.area_scale();
    let (mut left, mut best) = (Box4::EMPTY, (f32::INFINITY, 1, [Box4::EMPTY; 2]));
    for i in 1..n {
        left = left.union(ordered[i - 1].extent());
        let cost = left.area(scale) * i as f32 + rights[i].area(scale) * (n - i) as f32;
        if cost < best.0 || i == 1 {
            best = (cost, i, [left, rights[i]]);
        }
    }
    (best.2, best.1)
}

/// Whether [`part_few`] can part so many.
pub(super) fn is_few(count: usize) -> bool {
    count <= FEW
}

/// The first `n` numbers in ascending order; equal ones stay in order. None may be NaN.
#[inline(always)]
fn order_of(numbers: &[f32; FEW], n: usize) -> [u8; FEW] {
    // Each pair gives a point to one of both, without branches, for they could not be foretold.
    let mut ranks = [0u8; FEW];
    for i in 1..n {
        for j in 0..i {
            let after = u8::from(numbers[j] > numbers[i]);
            ranks[j] += after;
            ranks[i] += 1 - after;
        }
    }
    let mut order = [0; FEW];
    for (i, rank) in ranks.iter().enumerate().take(n) {
        order[*rank as usize % FEW] = i as u8;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::super::box4::extent_of;
    use super::*;
    use crate::primitive::Key;
    use penombre_math::{Bounds3, Vec3};

    /// How many of some cubes in a row go left, each standing for `count` primitives.
    fn left_of_row(cubes: u32, count: u32, block: u32) -> usize {
        let cube = |i: u32| {
            let min = Vec3::X * i as f32;
            let bounds = Bounds3 { min, max: min + 1.0 };
            let one = PrimRef::new(&bounds, Key { geometry: 0, prim: 2 * i });
            if count == 2 { one.with_next(&one) } else { one }
        };
        let refs: Vec<PrimRef> = (0..cubes).map(cube).collect();
        let centroids = refs.iter().fold(Box4::EMPTY, |all, r| all.with_point(r.extent().double_center()));
        let grid = Grid::new(&centroids, &Rules { bins: 64, block, leaf: 1, shares: &[true] }, 512);
        let mut bins = [Bins::EMPTY, Bins::EMPTY];
        let [filled, spare] = &mut bins;
        filled.fill(&grid, &refs, spare);
        filled.best(&grid, extent_of(&refs, 1)).map_or(0, |split| split.left)
    }

    #[test]
    fn leaves_are_filled() {
        assert_eq!(left_of_row(20, 1, 1), 10);
        assert!([8, 12].contains(&left_of_row(20, 1, 8)));
        assert!([4, 6].contains(&left_of_row(10, 2, 8)));
    }
}
