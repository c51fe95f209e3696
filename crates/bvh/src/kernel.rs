//! Picks the instruction set. The only unsafe code of the crate.
//!
//! The same source is compiled twice, for the baseline and for AVX2 (without fused multiply-add). All
//! arithmetic is plain IEEE, so both give the same bits; a test compares them.
#![allow(unsafe_code)]

use crate::lanes::Plain;
use crate::{Bvh, Hit, Ray, traverse};

/// A compiled version of the traversal. Private fields, so that only [`Kernel::best`] makes the fast one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kernel {
    avx2: bool,
}

impl Kernel {
    /// For any processor.
    pub(crate) const PORTABLE: Self = Self { avx2: false };

    /// The fastest that this processor runs.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            return Self { avx2: true };
        }
        Self::PORTABLE
    }

    #[inline]
    pub(crate) fn closest(self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        #[cfg(target_arch = "x86_64")]
        if self.avx2 {
            // SAFETY: `avx2` is set by `best` alone, which found the processor to have AVX2.
            return unsafe { closest_avx2(bvh, rays, hits) };
        }
        closest_portable(bvh, rays, hits);
    }

    #[inline]
    pub(crate) fn occluded(self, bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
        #[cfg(target_arch = "x86_64")]
        if self.avx2 {
            // SAFETY: `avx2` is set by `best` alone, which found the processor to have AVX2.
            return unsafe { occluded_avx2(bvh, rays, blocked) };
        }
        occluded_portable(bvh, rays, blocked);
    }
}

#[inline(never)]
fn closest_portable(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<Plain>(bvh, rays, hits);
}

#[inline(never)]
fn occluded_portable(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<Plain>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn closest_avx2(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<avx::Packed>(bvh, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn occluded_avx2(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<avx::Packed>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
mod avx {
    use crate::lanes::Lanes;
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Neg, Sub};

    /// Four numbers in a vector. To be named in functions compiled for AVX2 only; everything is inlined there.
    #[derive(Clone, Copy)]
    pub(super) struct Packed(__m256d);

    macro_rules! operation {
        ($trait:ident, $method:ident, $instruction:ident) => {
            impl $trait for Packed {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: only code that was found to run with AVX2 names this type.
                    Self(unsafe { $instruction(self.0, other.0) })
                }
            }
        };
    }

    operation!(Add, add, _mm256_add_pd);
    operation!(Sub, sub, _mm256_sub_pd);
    operation!(Mul, mul, _mm256_mul_pd);
    operation!(Div, div, _mm256_div_pd);

    impl Neg for Packed {
        type Output = Self;

        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: only code that was found to run with AVX2 names this type.
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    impl Lanes<4> for Packed {
        #[inline(always)]
        fn splat(x: f64) -> Self {
            // SAFETY: only code that was found to run with AVX2 names this type.
            Self(unsafe { _mm256_set1_pd(x) })
        }

        #[inline(always)]
        fn load(from: &[f64; 4]) -> Self {
            // SAFETY: as for `splat`; the pointer is that of four numbers, alignment is not asked for.
            Self(unsafe { _mm256_loadu_pd(from.as_ptr()) })
        }

        #[inline(always)]
        fn store(self) -> [f64; 4] {
            let mut to = [0.0; 4];
            // SAFETY: as for `splat`; the pointer is that of four numbers, alignment is not asked for.
            unsafe { _mm256_storeu_pd(to.as_mut_ptr(), self.0) };
            to
        }

        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_sqrt_pd(self.0) })
        }

        #[inline(always)]
        fn copysign(self, sign: Self) -> Self {
            // SAFETY: as for `splat`.
            let sign = unsafe { _mm256_and_pd(_mm256_set1_pd(-0.0), sign.0) };
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_or_pd(self.abs().0, sign) })
        }

        #[inline(always)]
        fn narrow(self) -> Self {
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_cvtps_pd(_mm256_cvtpd_ps(self.0)) })
        }

        #[inline(always)]
        fn smaller(self, other: Self) -> Self {
            // SAFETY: as for `splat`. The instruction yields the second one for NaN.
            Self(unsafe { _mm256_min_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn larger(self, other: Self) -> Self {
            // SAFETY: as for `splat`. The instruction yields the second one for NaN.
            Self(unsafe { _mm256_max_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            // SAFETY: as for `splat`.
            (unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)) }) as u32
        }

        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            // SAFETY: as for `splat`.
            (unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)) }) as u32
        }
    }
}
