//! The same vectors with the masks and compressions of AVX-512VL.

use super::avx2::{Packed, PackedEight, prefetch};
use crate::lanes::Machine;
use std::arch::x86_64::*;

/// A processor with AVX-512VL. To be named in functions compiled for it only.
pub(crate) struct Avx512;

impl Machine for Avx512 {
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
        // SAFETY: only code that was found to run with AVX-512VL names this type; all pointers are those of eight
        // words, alignment is not asked for.
        unsafe {
            let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
            let bits = _mm256_sllv_epi32(_mm256_set1_epi32(1), _mm256_and_si256(order, _mm256_set1_epi32(7)));
            let ordered = _mm256_test_epi32_mask(_mm256_set1_epi32(mask as i32), bits);
            let from = _mm256_maskz_compress_epi32(ordered, order);
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
            let packed = _mm256_maskz_compress_epi32(mask as u8, words);
            _mm256_storeu_si256(to.as_mut_ptr().cast(), packed);
        }
    }

    #[inline(always)]
    fn prefetch<T>(at: &T) {
        prefetch(at);
    }
}
