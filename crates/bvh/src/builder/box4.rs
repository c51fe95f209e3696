//! Boxes as the builder handles them: corners as vectors of four, which the processor compares at once.

use super::parallel;
use crate::primitive::Key;
use penombre_math::{Bounds3, Vec3, Vec4};

/// A box whose corners have a fourth lane, with a word of its owner or nothing of meaning. Unions leave there what they
/// like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    pub(super) low: Vec4,
    pub(super) high: Vec4,
}

impl Box4 {
    /// The neutral element of union.
    pub(super) const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    #[cfg(test)]
    pub(super) fn new(bounds: &Bounds3) -> Self {
        Self { low: bounds.min.extend(0.0), high: bounds.max.extend(0.0) }
    }

    pub(super) fn bounds(self) -> Bounds3 {
        Bounds3 { min: self.low.truncate(), max: self.high.truncate() }
    }

    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline(always)]
    pub(super) fn with_point(self, point: Vec4) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }

    /// Whether both are the same box, whatever stands beside the corners.
    #[inline(always)]
    pub(super) fn equals(self, other: Self) -> bool {
        let same = self.low.cmpeq(other.low).bitmask() & self.high.cmpeq(other.high).bitmask();
        same & 7 == 7
    }

    /// Twice the middle, infinite for boxes near the limit of `f32`.
    #[inline(always)]
    pub(super) fn double_center(self) -> Vec4 {
        self.low + self.high
    }

    /// An eighth of the surface area with all lengths multiplied by `scale`, see [`Box4::area_scale`]. Negative or NaN
    /// for an empty box.
    #[inline(always)]
    pub(super) fn area(self, scale: f32) -> f32 {
        let d = (self.high * 0.5 - self.low * 0.5) * scale;
        d.x * (d.y + d.z) + d.y * d.z
    }

    /// The scale at which no part of this box has an area that overflows.
    pub(super) fn area_scale(self) -> f32 {
        let half = self.high.truncate() * 0.5 - self.low.truncate() * 0.5;
        let longest = half.max_element().max(f32::MIN_POSITIVE);
        1.0 / longest
    }
}

/// Set in every word beside a corner, so that it is a common number as `f32`: neither NaN, which spreads, nor
/// subnormal, which some processors compute slowly.
const PLAIN: u32 = 0x4000_0000;

/// Words beside corners are below this.
const WORDS: u32 = 1 << 30;

/// Set in the second word of references to two primitives. The sign of a number does no harm.
const PAIR: u32 = 0x8000_0000;

/// The box of one primitive, of a part of it, or of one and the next one: two corners, with the geometry and the (first)
/// primitive beside them.
///
/// Plain arrays, and this is why: a list of them that begins as zeros is memory that nobody has touched yet, so that
/// the threads that fill it share the work of the system.
pub(crate) type PrimRef = [[f32; 4]; 2];

/// A reference of zeros, which stands for none.
pub(super) const NO_REF: PrimRef = [[0.0; 4]; 2];

/// What [`PrimRef`]s know.
pub(super) trait Reference: Copy {
    /// Geometry and primitive number must be below 2³⁰.
    fn new(bounds: &Bounds3, key: Key) -> Self;
    /// True for [`NO_REF`].
    fn is_none(&self) -> bool;
    /// The primitive, the first one of a pair.
    fn key(&self) -> Key;
    /// How many primitives: one or two with consecutive numbers.
    fn count(&self) -> u32;
    /// This one and another, which is that of the next primitive of the same geometry.
    fn with_next(&self, next: &Self) -> Self;
    fn extent(&self) -> Box4;
    /// The same primitive, another box.
    fn with_bounds(&self, bounds: &Bounds3) -> Self;

    fn bounds(&self) -> Bounds3 {
        self.extent().bounds()
    }
}

impl Reference for PrimRef {
    fn new(bounds: &Bounds3, key: Key) -> Self {
        debug_assert!(key.geometry < WORDS && key.prim < WORDS);
        let word = |value: u32| f32::from_bits(value | PLAIN);
        let corner = |corner: Vec3, beside: u32| corner.extend(word(beside)).to_array();
        [corner(bounds.min, key.geometry), corner(bounds.max, key.prim)]
    }

    fn is_none(&self) -> bool {
        self[0][3] == 0.0
    }

    #[inline(always)]
    fn key(&self) -> Key {
        let value = |word: f32| word.to_bits() & (WORDS - 1);
        Key { geometry: value(self[0][3]), prim: value(self[1][3]) }
    }

    #[inline(always)]
    fn count(&self) -> u32 {
        1 + u32::from(self[1][3].to_bits() & PAIR != 0)
    }

    #[inline(always)]
    fn with_next(&self, next: &Self) -> Self {
        let Box4 { low, high } = self.extent().union(next.extent());
        let mut pair = [low.to_array(), high.to_array()];
        pair[0][3] = self[0][3];
        pair[1][3] = f32::from_bits(self[1][3].to_bits() | PAIR);
        pair
    }

    #[inline(always)]
    fn extent(&self) -> Box4 {
        Box4 { low: Vec4::from_array(self[0]), high: Vec4::from_array(self[1]) }
    }

    fn with_bounds(&self, bounds: &Bounds3) -> Self {
        let corner = |corner: Vec3, word: f32| corner.extend(word).to_array();
        [corner(bounds.min, self[0][3]), corner(bounds.max, self[1][3])]
    }
}

/// References whose boxes one thread unites at a time.
const CHUNK: usize = 1 << 15;

/// The box around all; empty for none.
pub(super) fn extent_of(refs: &[PrimRef], threads: usize) -> Box4 {
    let unite = |refs: &[PrimRef]| refs.iter().fold(Box4::EMPTY, |all, r| all.union(r.extent()));
    let parts = parallel::map(threads, refs.chunks(CHUNK).collect(), unite);
    parts.into_iter().fold(Box4::EMPTY, Box4::union)
}

/// Node of a binary tree: its box, and beside the corners where to go on and how the node is to be covered by nodes of
/// eight ([`super::cover`]). A plain array for the same reason as [`PrimRef`].
pub(super) type BinaryNode = [f32; 8];

/// A node of zeros, to be filled.
pub(super) const BLANK: BinaryNode = [0.0; 8];

/// What a binary node holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Two nodes, side by side from this index on.
    Children(usize),
    /// References from `first` on, at most eight.
    Leaf { first: usize, count: usize },
}

/// Bits of a node's second word with the number of a leaf's references, 0 for others; below them is room for a plan.
const COUNT_FROM: u32 = 26;

/// What [`BinaryNode`]s know.
pub(super) trait Tree {
    fn new(extent: Box4, content: Content) -> Self;
    fn content(&self) -> Content;
    /// The first child, if there are children.
    fn child(&self) -> Option<usize>;
    fn extent(&self) -> Box4;
    /// A number below 2²⁶ that the node carries.
    fn plan(&self) -> u32;
    fn set_plan(&mut self, plan: u32);
}

impl Tree for BinaryNode {
    #[inline(always)]
    fn new(extent: Box4, content: Content) -> Self {
        let (link, plan) = match content {
            Content::Children(child) => (child as u32, 0),
            Content::Leaf { first, count } => (first as u32, (count as u32) << COUNT_FROM),
        };
        debug_assert!(link < WORDS);
        let mut node = BLANK;
        extent.low.write_to_slice(&mut node[..4]);
        extent.high.write_to_slice(&mut node[4..]);
        node[3] = f32::from_bits(link | PLAIN);
        node[7] = f32::from_bits(plan | PLAIN);
        node
    }

    #[inline(always)]
    fn content(&self) -> Content {
        let link = (self[3].to_bits() & !PLAIN) as usize;
        match (self[7].to_bits() & !PLAIN) >> COUNT_FROM {
            0 => Content::Children(link),
            count => Content::Leaf { first: link, count: count as usize },
        }
    }

    #[inline(always)]
    fn child(&self) -> Option<usize> {
        match self.content() {
            Content::Children(child) => Some(child),
            Content::Leaf { .. } => None,
        }
    }

    #[inline(always)]
    fn extent(&self) -> Box4 {
        Box4 { low: Vec4::from_slice(&self[..4]), high: Vec4::from_slice(&self[4..]) }
    }

    #[inline(always)]
    fn plan(&self) -> u32 {
        self[7].to_bits() & ((1 << COUNT_FROM) - 1)
    }

    #[inline(always)]
    fn set_plan(&mut self, plan: u32) {
        debug_assert!(plan < 1 << COUNT_FROM);
        self[7] = f32::from_bits(self[7].to_bits() >> COUNT_FROM << COUNT_FROM | plan);
    }
}
