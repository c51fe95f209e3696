//! Vectors of 512 bits in double precision.

use crate::lanes::Lanes;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight numbers in a vector. To be named in functions compiled for AVX-512 only; everything is inlined there.
#[derive(Clone, Copy)]
pub(crate) struct Wide(__m512d);

macro_rules! operation {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for Wide {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: only code that was found to run with AVX-512 names this type.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}

operation!(Add, add, _mm512_add_pd);
operation!(Sub, sub, _mm512_sub_pd);
operation!(Mul, mul, _mm512_mul_pd);
operation!(Div, div, _mm512_div_pd);

/// The sign bit of each number.
#[inline(always)]
fn sign() -> __m512i {
    // SAFETY: only code that was found to run with AVX-512 gets here.
    unsafe { _mm512_set1_epi64(i64::MIN) }
}

impl Neg for Wide {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: only code that was found to run with AVX-512 names this type.
        Self(unsafe { _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(self.0), sign())) })
    }
}

impl Lanes<8> for Wide {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: only code that was found to run with AVX-512 names this type.
        Self(unsafe { _mm512_set1_pd(x) })
    }

    #[inline(always)]
    fn load(from: &[f64; 8]) -> Self {
        // SAFETY: as for `splat`; the pointer is that of eight numbers, alignment is not asked for.
        Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> [f64; 8] {
        let mut to = [0.0; 8];
        // SAFETY: as for `splat`; the pointer is that of eight numbers, alignment is not asked for.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn widen([a, b, c, d, e, f, g, h]: [f32; 8]) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm512_cvtps_pd(_mm256_setr_ps(a, b, c, d, e, f, g, h)) })
    }

    #[inline(always)]
    fn zero_below(self, limit: Self) -> Self {
        // SAFETY: as for `splat`.
        unsafe {
            let small = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.abs().0, limit.0);
            Self(_mm512_maskz_mov_pd(!small, self.0))
        }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm512_castsi512_pd(_mm512_andnot_si512(sign(), _mm512_castpd_si512(self.0))) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn copysign(self, from: Self) -> Self {
        // SAFETY: as for `splat`.
        unsafe {
            let signs = _mm512_and_si512(sign(), _mm512_castpd_si512(from.0));
            Self(_mm512_castsi512_pd(_mm512_or_si512(_mm512_castpd_si512(self.abs().0), signs)))
        }
    }

    #[inline(always)]
    fn narrow(self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm512_cvtps_pd(_mm512_cvtpd_ps(self.0)) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: as for `splat`. The instruction yields the second one for NaN.
        Self(unsafe { _mm512_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: as for `splat`. The instruction yields the second one for NaN.
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        u32::from(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        u32::from(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
}
