//! Picks the instruction set. The only unsafe code of the crate.
//!
//! The same source is compiled twice, for the baseline and for AVX2 (without fused multiply-add). Where the
//! compiler does not find vector instructions by itself, the source asks a [`crate::lanes::Machine`] for them.
//! All arithmetic is plain IEEE, so both give the same bits; tests compare them.
//!
//! Whatever the AVX2 version calls must be inlined into it, or it is compiled for the baseline: functions are
//! `#[inline(always)]`, and closures stay out of hot places.
#![allow(unsafe_code)]

use crate::lanes::Baseline;
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
    traverse::closest::<Baseline>(bvh, rays, hits);
}

#[inline(never)]
fn occluded_portable(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<Baseline>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn closest_avx2(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<avx::Avx2>(bvh, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn occluded_avx2(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<avx::Avx2>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
mod avx {
    use crate::lanes::{Lanes, Machine};
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Neg, Sub};

    /// A processor with AVX2. To be named in functions compiled for it only.
    pub(super) struct Avx2;

    impl Machine for Avx2 {
        type Four = Packed;

        #[inline(always)]
        fn top_bits(words: &[u32; 8]) -> u32 {
            // SAFETY: only code that was found to run with AVX2 names this type; the pointer is that of eight
            // words, alignment is not asked for.
            (unsafe { _mm256_movemask_ps(_mm256_loadu_ps(words.as_ptr().cast())) }) as u32
        }
    }

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
        fn widen([a, b, c, d]: [f32; 4]) -> Self {
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d)) })
        }

        #[inline(always)]
        fn zero_below(self, limit: Self) -> Self {
            // SAFETY: as for `splat`.
            Self(unsafe { _mm256_andnot_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.abs().0, limit.0), self.0) })
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

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::{Kernel, avx::Avx2, avx::Packed};
    use crate::lanes::{Baseline, Lanes, Machine, Plain};

    const NUMBERS: [f64; 12] = [
        0.0,
        -0.0,
        1.5,
        -1.5,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e-310,
        -1e300,
        16_777_217.5,
        1e-46,
        0.1,
    ];

    /// Everything that two vectors yield, as bits; NaN counts as one number.
    #[inline(always)]
    fn all<V: Lanes<4>>(a: [f64; 4], b: [f64; 4]) -> Vec<u64> {
        let (x, y) = (V::load(&a), V::load(&b));
        let results = [
            x + y,
            x - y,
            x * y,
            x / y,
            -x,
            x.abs(),
            x.sqrt(),
            x.copysign(y),
            x.narrow(),
            x.smaller(y),
            x.larger(y),
            x.zero_below(y),
            V::splat(a[1]),
            V::widen(a.map(|a| a as f32)),
        ];
        let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
        let mut all: Vec<u64> = results.iter().flat_map(|r| r.store()).map(bits).collect();
        all.extend([u64::from(x.below(y)), u64::from(x.at_most(y))]);
        all
    }

    #[target_feature(enable = "avx2")]
    fn top_bits(words: &[u32; 8]) -> u32 {
        Avx2::top_bits(words)
    }

    #[target_feature(enable = "avx2")]
    fn packed(a: [f64; 4], b: [f64; 4]) -> Vec<u64> {
        all::<Packed>(a, b)
    }

    #[test]
    fn vectors_compute_what_plain_code_does() {
        if !Kernel::best().avx2 {
            eprintln!("NOT RUN: this processor has no AVX2");
            return;
        }
        let n = NUMBERS.len();
        for i in 0..n * n {
            let a = std::array::from_fn(|lane| NUMBERS[(i + lane) % n]);
            let b = std::array::from_fn(|lane| NUMBERS[(i / n + 5 * lane) % n]);
            // SAFETY: the processor was found to have AVX2.
            assert_eq!(unsafe { packed(a, b) }, all::<Plain>(a, b), "{a:?} {b:?}");
        }
        for bits in 0..256 {
            let words = std::array::from_fn(|lane| if bits >> lane & 1 == 1 { u32::MAX } else { 0 });
            // SAFETY: the processor was found to have AVX2.
            assert_eq!([unsafe { top_bits(&words) }, Baseline::top_bits(&words)], [bits; 2]);
        }
    }
}
