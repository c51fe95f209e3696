//! Vectors of 256 bits.

use crate::Hit;
use crate::lanes::{Eight, Lanes, Machine, Turn};
use crate::node::{ChildRef, Kind};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A processor with AVX2 and FMA. To be named in functions compiled for it only.
#[derive(Clone, Copy)]
pub(crate) struct Avx2;

impl Machine for Avx2 {
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
        // SAFETY: only code that was found to run with AVX2 names this type; all pointers are those of eight words,
        // alignment is not asked for.
        unsafe {
            let (words, numbers, limits) = ordered(order, words, numbers, limits);
            let mask = PackedEight(numbers).not_above(PackedEight(limits));
            let from = takes(mask);
            _mm256_storeu_si256(words_to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(words, from));
            _mm256_storeu_ps(numbers_to.as_mut_ptr().cast(), _mm256_permutevar8x32_ps(numbers, from));
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn compress(mask: u32, words: &[u32; 8], to: &mut [MaybeUninit<u32>; 8]) {
        // SAFETY: as for `arrange`.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(words, takes(mask)));
        }
    }

    #[inline(always)]
    fn kinds(refs: &[u32; 8]) -> [u32; 3] {
        kinds(refs)
    }

    #[inline(always)]
    fn prefetch(address: usize) {
        prefetch(address);
    }

    #[inline(always)]
    fn put(hit: Hit, to: &mut Hit) {
        put(hit, to);
    }
}

/// Words, numbers and limits in the order of `order`, lanes of three bits each. The words change places while the numbers
/// are still being computed.
#[inline(always)]
pub(super) fn ordered(
    order: u32,
    words: &[u32; 8],
    numbers: PackedEight,
    limits: PackedEight,
) -> (__m256i, __m256, __m256) {
    // SAFETY: only code that was found to run with AVX2 gets here; the pointer is that of eight words, alignment is not
    // asked for.
    unsafe {
        let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
        let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
        let words = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(words.as_ptr().cast()), order);
        (words, _mm256_permutevar8x32_ps(numbers.0, order), _mm256_permutevar8x32_ps(limits.0, order))
    }
}

/// Which references lead to nodes, to triangles, and to the end.
#[inline(always)]
pub(super) fn kinds(refs: &[u32; 8]) -> [u32; 3] {
    const { assert!(Kind::Node as u32 == 0) }
    // SAFETY: only code that was found to run with AVX2 gets here; the pointer is that of eight words, alignment is not
    // asked for.
    unsafe {
        let refs = _mm256_loadu_si256(refs.as_ptr().cast());
        let kind = _mm256_srli_epi32::<{ ChildRef::INDEX_BITS as i32 }>(refs);
        let nodes = _mm256_cmpeq_epi32(kind, _mm256_setzero_si256());
        let triangles = _mm256_cmpeq_epi32(kind, _mm256_set1_epi32(Kind::Triangles as i32));
        let ends = _mm256_cmpeq_epi32(refs, _mm256_set1_epi32(ChildRef::RETURN.0 as i32));
        [nodes, triangles, ends].map(|lanes| _mm256_movemask_ps(_mm256_castsi256_ps(lanes)) as u32)
    }
}

/// Asks for four lines.
#[inline(always)]
pub(super) fn prefetch(address: usize) {
    let start = std::ptr::without_provenance::<i8>(address);
    // SAFETY: every processor of this kind has the instruction, which reads nothing, whatever the address.
    unsafe {
        _mm_prefetch::<_MM_HINT_T0>(start);
        _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64));
        _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(128));
        _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(192));
    }
}

/// Writes a hit in two parts as copies read it: what is written in small parts cannot be read at once as a whole.
#[inline(always)]
pub(super) fn put(hit: Hit, to: &mut Hit) {
    let to = std::ptr::from_mut(to);
    let last = u64::from(hit.prim) | u64::from(hit.instance) << 32;
    // SAFETY: only code that was found to run with AVX2 gets here. A hit is six words in the order of its fields;
    // alignment is not asked for.
    unsafe {
        let first = _mm_setr_ps(hit.t, hit.u, hit.v, f32::from_bits(hit.geometry));
        _mm_storeu_ps(to.cast(), first);
        to.cast::<u64>().add(2).write_unaligned(last);
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
    fn plus(self, other: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_or_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn if_below(self, other: Self, then: Self, otherwise: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_blendv_ps(otherwise.0, then.0, _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) })
    }

    #[inline(always)]
    fn transposed(rows: [Self; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: as for `splat`. Within halves of four first, then the halves.
        unsafe {
            let (ab, ab2) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
            let (cd, cd2) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
            let (ef, ef2) = (_mm256_unpacklo_ps(e.0, f.0), _mm256_unpackhi_ps(e.0, f.0));
            let (gh, gh2) = (_mm256_unpacklo_ps(g.0, h.0), _mm256_unpackhi_ps(g.0, h.0));
            let (p0, p1) = (_mm256_shuffle_ps::<0x44>(ab, cd), _mm256_shuffle_ps::<0xee>(ab, cd));
            let (p2, p3) = (_mm256_shuffle_ps::<0x44>(ab2, cd2), _mm256_shuffle_ps::<0xee>(ab2, cd2));
            let (q0, q1) = (_mm256_shuffle_ps::<0x44>(ef, gh), _mm256_shuffle_ps::<0xee>(ef, gh));
            let (q2, q3) = (_mm256_shuffle_ps::<0x44>(ef2, gh2), _mm256_shuffle_ps::<0xee>(ef2, gh2));
            [
                Self(_mm256_permute2f128_ps::<0x20>(p0, q0)),
                Self(_mm256_permute2f128_ps::<0x20>(p1, q1)),
                Self(_mm256_permute2f128_ps::<0x20>(p2, q2)),
                Self(_mm256_permute2f128_ps::<0x20>(p3, q3)),
                Self(_mm256_permute2f128_ps::<0x31>(p0, q0)),
                Self(_mm256_permute2f128_ps::<0x31>(p1, q1)),
                Self(_mm256_permute2f128_ps::<0x31>(p2, q2)),
                Self(_mm256_permute2f128_ps::<0x31>(p3, q3)),
            ]
        }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; 8]) {
        // SAFETY: as for `load`.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) };
    }

    #[inline(always)]
    fn about_mul_sub(self, factor: Self, less: Self) -> Self {
        // SAFETY: as for `splat`.
        Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, less.0) })
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
    fn around_zero_or(self, other: Self, sign: Self) -> u32 {
        // SAFETY: as for `splat`.
        unsafe {
            let below = _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, _mm256_setzero_ps());
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(other.0, _mm256_setzero_ps());
            _mm256_movemask_ps(_mm256_or_ps(_mm256_and_ps(below, above), sign.0)) as u32
        }
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        (unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) }) as u32
    }

    #[inline(always)]
    fn beside_zero(self, other: Self) -> u32 {
        // SAFETY: as for `splat`.
        unsafe {
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, _mm256_setzero_ps());
            let below = _mm256_cmp_ps::<_CMP_LT_OQ>(other.0, _mm256_setzero_ps());
            _mm256_movemask_ps(_mm256_or_ps(below, above)) as u32
        }
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        // SAFETY: as for `splat`.
        unsafe {
            let to_front = _mm256_castsi128_si256(_mm_cvtsi32_si128(lane as i32));
            _mm_cvtss_f32(_mm256_castps256_ps128(_mm256_permutevar8x32_ps(self.0, to_front)))
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

impl Turn for Packed {
    #[inline(always)]
    fn turned(self) -> Self {
        // SAFETY: only code that was found to run with AVX2 names this type.
        Self(unsafe { _mm256_permute4x64_pd::<0b11_00_10_01>(self.0) })
    }

    #[inline(always)]
    fn turned_back(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_permute4x64_pd::<0b11_01_00_10>(self.0) })
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
