//! Several numbers in double precision at once.

use crate::bvh::Tree;
use crate::node::ChildRef;
use crate::prepared::TurnedRay;
use crate::primitive::TriangleBlock;
use crate::{Hit, Ray, few};
use std::array;
use std::mem::MaybeUninit;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `N` numbers, each computed for itself: the bits are those of one number after the other. Comparisons give a
/// bit per lane.
pub(crate) trait Lanes<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    fn splat(x: f64) -> Self;
    fn load(from: &[f64; N]) -> Self;
    fn store(self) -> [f64; N];
    fn widen(from: [f32; N]) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn copysign(self, sign: Self) -> Self;
    /// 0 where the size is below `limit`.
    fn zero_below(self, limit: Self) -> Self;
    /// Rounded to `f32`.
    fn narrow(self) -> Self;
    /// The smaller one; `other` if either is NaN.
    fn smaller(self, other: Self) -> Self;
    /// The larger one; `other` if either is NaN.
    fn larger(self, other: Self) -> Self;
    /// `<`
    fn below(self, other: Self) -> u32;
    /// `<=`
    fn at_most(self, other: Self) -> u32;
}

/// Eight numbers in single precision. What has no other word to it is IEEE: the same bits on every processor.
pub(crate) trait Eight: Copy {
    fn splat(x: f32) -> Self;
    fn load(from: &[f32; 8]) -> Self;
    /// Numbers by their bits.
    fn load_bits(from: &[u32; 8]) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn plus(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The bits of either.
    fn or(self, other: Self) -> Self;
    /// `then` in the lanes where `self < other`, else `otherwise`.
    fn if_below(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// The rows of a square turned into its columns.
    fn transposed(rows: [Self; 8]) -> [Self; 8];
    fn store(self, to: &mut [f32; 8]);
    /// `self · factor − less`, rounded once or twice as the processor likes: for bounds only.
    fn about_mul_sub(self, factor: Self, less: Self) -> Self;
    /// The smaller one; `other` if either is NaN.
    fn smaller(self, other: Self) -> Self;
    /// The larger one; `other` if either is NaN.
    fn larger(self, other: Self) -> Self;
    /// A bit for each lane: not greater, also where either is NaN.
    fn not_above(self, other: Self) -> u32;
    /// A bit for each lane: `self < other`.
    fn below(self, other: Self) -> u32;
    /// A bit for each lane: `self < 0 < other`, or the sign bit of `sign`.
    fn around_zero_or(self, other: Self, sign: Self) -> u32;
    /// A bit for each lane: `self > 0` or `other < 0`.
    fn beside_zero(self, other: Self) -> u32;
    /// One of the numbers.
    fn lane(self, lane: usize) -> f32;
}

/// Four numbers of which the first three may change places.
pub(crate) trait Turn {
    /// Lanes 1, 2, 0, 3.
    fn turned(self) -> Self;
    /// Lanes 2, 0, 1, 3.
    fn turned_back(self) -> Self;
}

/// A processor's ways to compute several numbers at once.
pub(crate) trait Machine: Copy {
    /// Four in double precision.
    type Four: Lanes<4> + Turn;
    /// Eight in single precision.
    type Eight: Eight;

    /// Of the lanes where `numbers` are not above `limits`, writes words and numbers one after the other, in the order of
    /// `order` (lanes of three bits each, the first lowest), and returns how many there are. What lies behind them is
    /// overwritten with anything.
    fn arrange(
        order: u32,
        words: &[u32; 8],
        numbers: Self::Eight,
        limits: Self::Eight,
        words_to: &mut [MaybeUninit<u32>; 8],
        numbers_to: &mut [MaybeUninit<f32>; 8],
    ) -> usize;

    /// Writes the words of the lanes in `mask` one after the other. What lies behind them is overwritten with anything.
    fn compress(mask: u32, words: &[u32; 8], to: &mut [MaybeUninit<u32>; 8]);

    /// Which of eight references, as words, lead to nodes, to triangles, and to the end, as bits.
    #[inline(always)]
    fn kinds(refs: &[u32; 8]) -> [u32; 3] {
        let mut kinds = [0; 3];
        let mut lane = 0;
        while lane < 8 {
            let next = ChildRef(refs[lane]);
            kinds[0] |= u32::from(next.is_node()) << lane;
            kinds[1] |= u32::from(next.is_triangles()) << lane;
            kinds[2] |= u32::from(next == ChildRef::RETURN) << lane;
            lane += 1;
        }
        kinds
    }

    /// [`TriangleBlock::met_before`] of two blocks, a ray each.
    #[inline(always)]
    fn met_by_two(blocks: [&TriangleBlock; 2], rays: [&TurnedRay; 2], limits: [f32; 2]) -> [u32; 2] {
        [blocks[0].met_before::<Self>(rays[0], limits[0]), blocks[1].met_before::<Self>(rays[1], limits[1])]
    }

    /// Says that the four lines from this address on will be read soon, whatever lies there.
    fn prefetch(address: usize);

    /// [`few::closest`] in the widest vectors; returns how many rays were left over.
    #[inline(always)]
    fn closest_of_few(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) -> usize {
        few::closest::<4, Self::Four>(tree, rays, hits)
    }

    /// [`few::occluded`] in the widest vectors; returns how many rays were left over.
    #[inline(always)]
    fn occluded_by_few(tree: &Tree, rays: &[Ray], blocked: &mut [bool]) -> usize {
        few::occluded::<4, Self::Four>(tree, rays, blocked)
    }

    /// Writes a hit in such a way that it can be copied at once.
    fn put(hit: Hit, to: &mut Hit);
}

/// Any processor.
#[derive(Clone, Copy)]
pub(crate) struct Baseline;

impl Machine for Baseline {
    type Four = Plain;
    type Eight = PlainEight;

    #[inline(always)]
    fn arrange(
        order: u32,
        words: &[u32; 8],
        numbers: PlainEight,
        limits: PlainEight,
        words_to: &mut [MaybeUninit<u32>; 8],
        numbers_to: &mut [MaybeUninit<f32>; 8],
    ) -> usize {
        let (mask, mut count) = (numbers.not_above(limits), 0);
        for place in 0..8 {
            let lane = (order >> (3 * place) & 7) as usize;
            if mask >> lane & 1 == 1 {
                words_to[count % 8].write(words[lane]);
                numbers_to[count % 8].write(numbers.0[lane]);
                count += 1;
            }
        }
        count
    }

    #[inline(always)]
    fn compress(mask: u32, words: &[u32; 8], to: &mut [MaybeUninit<u32>; 8]) {
        let (mut rest, mut count) = (mask, 0);
        while rest != 0 {
            to[count % 8].write(words[rest.trailing_zeros() as usize % 8]);
            rest &= rest - 1;
            count += 1;
        }
    }

    #[inline(always)]
    fn prefetch(_: usize) {}

    #[inline(always)]
    fn put(hit: Hit, to: &mut Hit) {
        *to = hit;
    }
}

/// Eight numbers on any processor.
#[derive(Clone, Copy)]
pub(crate) struct PlainEight(pub(crate) [f32; 8]);

impl PlainEight {
    #[inline(always)]
    fn each(self, other: Self, operation: impl Fn(f32, f32) -> f32) -> Self {
        Self(array::from_fn(|i| operation(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn bits(self, other: Self, comparison: impl Fn(f32, f32) -> bool) -> u32 {
        (0..8).fold(0, |bits, i| bits | u32::from(comparison(self.0[i], other.0[i])) << i)
    }
}

impl Eight for PlainEight {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn load_bits(from: &[u32; 8]) -> Self {
        Self(from.map(f32::from_bits))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.each(other, |a, b| f32::from_bits(a.to_bits() | b.to_bits()))
    }

    #[inline(always)]
    fn if_below(self, other: Self, then: Self, otherwise: Self) -> Self {
        Self(array::from_fn(|i| if self.0[i] < other.0[i] { then.0[i] } else { otherwise.0[i] }))
    }

    #[inline(always)]
    fn transposed(rows: [Self; 8]) -> [Self; 8] {
        array::from_fn(|i| Self(array::from_fn(|j| rows[j].0[i])))
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        *to = self.0;
    }

    #[inline(always)]
    fn about_mul_sub(self, factor: Self, less: Self) -> Self {
        self.times(factor).minus(less)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.each(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.each(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn not_above(self, other: Self) -> u32 {
        !self.bits(other, |a, b| a > b) & 0xff
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }

    #[inline(always)]
    fn around_zero_or(self, other: Self, sign: Self) -> u32 {
        self.bits(other, |a, b| a < 0.0 && b > 0.0) | sign.bits(sign, |s, _| s.is_sign_negative())
    }

    #[inline(always)]
    fn beside_zero(self, other: Self) -> u32 {
        self.bits(other, |a, b| a > 0.0 || b < 0.0)
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.0[lane % 8]
    }
}

impl Lanes<1> for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn load(&[x]: &[f64; 1]) -> Self {
        x
    }

    #[inline(always)]
    fn store(self) -> [f64; 1] {
        [self]
    }

    #[inline(always)]
    fn widen([x]: [f32; 1]) -> Self {
        f64::from(x)
    }

    #[inline(always)]
    fn zero_below(self, limit: Self) -> Self {
        if self.abs() < limit { 0.0 } else { self }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }

    #[inline(always)]
    fn narrow(self) -> Self {
        f64::from(self as f32)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        u32::from(self < other)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        u32::from(self <= other)
    }
}

/// Four numbers on any processor.
#[derive(Clone, Copy)]
pub(crate) struct Plain([f64; 4]);

impl Plain {
    #[inline(always)]
    fn each(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        Self(array::from_fn(|i| operation(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn bits(self, other: Self, comparison: impl Fn(f64, f64) -> u32) -> u32 {
        (0..4).fold(0, |bits, i| bits | comparison(self.0[i], other.0[i]) << i)
    }
}

impl Add for Plain {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each(other, f64::add)
    }
}

impl Sub for Plain {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each(other, f64::sub)
    }
}

impl Mul for Plain {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.each(other, f64::mul)
    }
}

impl Div for Plain {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.each(other, f64::div)
    }
}

impl Neg for Plain {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(f64::neg))
    }
}

impl Turn for Plain {
    #[inline(always)]
    fn turned(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([b, c, a, d])
    }

    #[inline(always)]
    fn turned_back(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([c, a, b, d])
    }
}

impl Lanes<4> for Plain {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn load(from: &[f64; 4]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn widen(from: [f32; 4]) -> Self {
        Self(from.map(f64::from))
    }

    #[inline(always)]
    fn zero_below(self, limit: Self) -> Self {
        self.each(limit, Lanes::zero_below)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.each(sign, f64::copysign)
    }

    #[inline(always)]
    fn narrow(self) -> Self {
        Self(self.0.map(Lanes::narrow))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.each(other, Lanes::smaller)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.each(other, Lanes::larger)
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        self.bits(other, Lanes::below)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        self.bits(other, Lanes::at_most)
    }
}
