//! Several numbers in double precision at once.

use std::array;
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

/// A processor's ways to compute several numbers at once.
pub(crate) trait Machine {
    /// Four in double precision.
    type Four: Lanes<4>;

    /// The top bits of eight words.
    fn top_bits(words: &[u32; 8]) -> u32;
}

/// Any processor.
pub(crate) struct Baseline;

impl Machine for Baseline {
    type Four = Plain;

    #[inline(always)]
    fn top_bits(words: &[u32; 8]) -> u32 {
        (0..8).fold(0, |bits, i| bits | (words[i] >> 31) << i)
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
