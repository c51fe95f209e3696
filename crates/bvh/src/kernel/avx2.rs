//! Vectors of 256 bits.

use crate::lanes::{Eight, Lanes, Machine};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A processor with AVX2 and FMA. To be named in functions compiled for it only.
pub(crate) struct Avx2;

impl Machine for Avx2 {
    type Four = Packed;
    type Eight = PackedEight;

    #[inline(always)]
    fn arrange(
        mask: u32,
        order: u32,
        words: &[u32; 8],
        numbers: PackedEight,
        words_to: &mut [u32; 8],
        numbers_to: &mut [f32; 8],
    ) {
        // SAFETY: only code that was found to run with AVX2 names this type; all pointers are those of eight words,
        // alignment is not asked for.
        unsafe {
            let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
            // The lanes in the mask, in the new order: bits, then the places to take them from.
            let bits = _mm256_sllv_epi32(_mm256_set1_epi32(1), _mm256_and_si256(order, _mm256_set1_epi32(7)));
            let inside = _mm256_and_si256(_mm256_set1_epi32(mask as i32), bits);
            let outside = _mm256_cmpeq_epi32(inside, _mm256_setzero_si256());
            let ordered = !_mm256_movemask_ps(_mm256_castsi256_ps(outside)) as u32 & 0xff;
            let from = _mm256_permutevar8x32_epi32(order, takes(ordered));
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            _mm256_storeu_si256(words_to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(words, from));
            _mm256_storeu_ps(numbers_to.as_mut_ptr(), _mm256_permutevar8x32_ps(numbers.0, from));
        }
    }

    #[inline(always)]
    fn compress(mask: u32, words: &[u32; 8], to: &mut [u32; 8]) {
        // SAFETY: as for `arrange`.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(words, takes(mask)));
        }
    }

    #[inline(always)]
    fn prefetch<T>(at: &T) {
        prefetch(at);
    }
}

/// Asks for up to six lines of something.
#[inline(always)]
pub(super) fn prefetch<T>(at: &T) {
    let start = std::ptr::from_ref(at).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64).min(6) {
        // SAFETY: every processor of this kind has the instruction, which reads nothing, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line)) };
    }
}

/// Places of the bits set in a mask, one after the other.
#[target_feature(enable = "avx2")]
#[inline]
fn takes(mask: u32) -> __m256i {
    let word = TAKES[mask as usize % 256];
    _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(word as i64))
}

/// For each mask the places of its bits, a byte each.
static TAKES: [u64; 256] = {
    let mut table = [0u64; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask] |= (lane as u64) << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// Eight numbers in a vector. To be named in functions compiled for AVX2 and FMA only; everything is inlined there.
#[derive(Clone, Copy)]
pub(crate) struct PackedEight(pub(super) __m256);

impl Eight for PackedEight {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: only code that was found to run with AVX2 and FMA names this type.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        // SAFETY: as for `splat`; the pointer is that of eight numbers, alignment is not asked for.
        Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn load_bits(from: &[u32; 8]) -> Self {
        // SAFETY: as for `load`.
        Self(unsafe { _mm256_loadu_ps(from.as_ptr().cast()) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn about_mul_sub(self, factor: Self, less: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, less.0) })
    }

    #[inline(always)]
    fn opposite(self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: as for `splat`. The instruction yields the second one for NaN.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: as for `splat`. The instruction yields the second one for NaN.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn not_above(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        (unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NGT_UQ>(self.0, other.0)) }) as u32
    }

    #[inline(always)]
    fn around_zero(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        unsafe {
            let below = _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, _mm256_setzero_ps());
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(other.0, _mm256_setzero_ps());
            _mm256_movemask_ps(_mm256_and_ps(below, above)) as u32
        }
    }
}

/// Four numbers in a vector. To be named in functions compiled for AVX2 only; everything is inlined there.
#[derive(Clone, Copy)]
pub(crate) struct Packed(__m256d);

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
