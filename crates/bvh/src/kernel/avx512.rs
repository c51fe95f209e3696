//! The same vectors with the masks and compressions of AVX-512VL.

use super::avx2::{Packed, PackedEight, kinds, ordered, prefetch, put};
use super::sixteen;
use super::wide::Wide;
use crate::bvh::Tree;
use crate::lanes::Machine;
use crate::prepared::TurnedRay;
use crate::primitive::TriangleBlock;
use crate::{Hit, Ray, few};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// A processor with AVX-512VL. To be named in functions compiled for it only.
#[derive(Clone, Copy)]
pub(crate) struct Avx512;

impl Machine for Avx512 {
    type Four = Packed;
    type Eight = PackedEight;

    #[inline(always)]
    fn arrange(
        order: u32,
        words: &[u32; 8],
        numbers: PackedEight,
        limits: PackedEight,
        words_to: &mut [MaybeUninit<u32>; 8],
        numbers_to: &mut [MaybeUninit<f32>; 8],
    ) -> usize {
        // SAFETY: only code that was found to run with AVX-512VL names this type; all pointers are those of eight
        // words, alignment is not asked for.
        unsafe {
            let (words, numbers, limits) = ordered(order, words, numbers, limits);
            let mask = _mm256_cmp_ps_mask::<_CMP_NGT_UQ>(numbers, limits);
            _mm256_storeu_si256(words_to.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(mask, words));
            _mm256_storeu_ps(numbers_to.as_mut_ptr().cast(), _mm256_maskz_compress_ps(mask, numbers));
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn compress(mask: u32, words: &[u32; 8], to: &mut [MaybeUninit<u32>; 8]) {
        // SAFETY: as for `arrange`.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let packed = _mm256_maskz_compress_epi32(mask as u8, words);
            _mm256_storeu_si256(to.as_mut_ptr().cast(), packed);
        }
    }

    #[inline(always)]
    fn kinds(refs: &[u32; 8]) -> [u32; 3] {
        kinds(refs)
    }

    #[inline(always)]
    fn met_by_two(blocks: [&TriangleBlock; 2], rays: [&TurnedRay; 2], limits: [f32; 2]) -> [u32; 2] {
        // SAFETY: as for `arrange`.
        let met = unsafe { sixteen::met(blocks, rays, limits) };
        [met & 0xff, met >> 8]
    }

    #[inline(always)]
    fn prefetch(address: usize) {
        prefetch(address);
    }

    #[inline(always)]
    fn closest_of_few(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) -> usize {
        few::closest::<8, Wide>(tree, rays, hits)
    }

    #[inline(always)]
    fn occluded_by_few(tree: &Tree, rays: &[Ray], blocked: &mut [bool]) -> usize {
        few::occluded::<8, Wide>(tree, rays, blocked)
    }

    #[inline(always)]
    fn put(hit: Hit, to: &mut Hit) {
        put(hit, to);
    }
}
