//! Two blocks of triangles, a ray each, in vectors of 512 bits.

use crate::kernel::row_at;
use crate::prepared::TurnedRay;
use crate::primitive::{TriangleBlock, range_end};
use std::arch::x86_64::*;

/// Eight numbers of either.
#[inline(always)]
unsafe fn both(a: &[f32; 8], b: &[f32; 8]) -> __m512 {
    // SAFETY: only code that was found to run with AVX-512 gets here; pointers are those of eight numbers.
    unsafe {
        let (a, b) = (_mm256_loadu_ps(a.as_ptr()), _mm256_loadu_ps(b.as_ptr()));
        let low = _mm512_castps_pd(_mm512_castps256_ps512(a));
        _mm512_castpd_ps(_mm512_insertf64x4::<1>(low, _mm256_castps_pd(b)))
    }
}

/// One number of either, eight times each.
#[inline(always)]
unsafe fn splat(a: f32, b: f32) -> __m512 {
    // SAFETY: as above.
    unsafe { _mm512_mask_broadcastss_ps(_mm512_set1_ps(a), 0xff00, _mm_set_ss(b)) }
}

/// A corner of all triangles relative to the rays.
#[inline(always)]
unsafe fn corner(
    [p, q]: [&TriangleBlock; 2],
    [r, s]: [&TurnedRay; 2],
    corner: usize,
    origin: [__m512; 3],
    shear: [__m512; 2],
) -> [__m512; 3] {
    let (p, q) = (p.corner(corner), q.corner(corner));
    // SAFETY: as above.
    unsafe {
        let z = _mm512_sub_ps(both(row_at(p, r.rows[2]), row_at(q, s.rows[2])), origin[2]);
        let x = _mm512_sub_ps(both(row_at(p, r.rows[0]), row_at(q, s.rows[0])), origin[0]);
        let y = _mm512_sub_ps(both(row_at(p, r.rows[1]), row_at(q, s.rows[1])), origin[1]);
        [_mm512_sub_ps(x, _mm512_mul_ps(shear[0], z)), _mm512_sub_ps(y, _mm512_mul_ps(shear[1], z)), z]
    }
}

/// [`TriangleBlock::met_before`] of both, as bits: the first eight for the first.
#[inline(always)]
pub(super) unsafe fn met(blocks: [&TriangleBlock; 2], rays: [&TurnedRay; 2], limits: [f32; 2]) -> u32 {
    let ([p, q], [r, s]) = (blocks, rays);
    // SAFETY: as above.
    unsafe {
        let origin = [
            splat(r.origin[0], s.origin[0]),
            splat(r.origin[1], s.origin[1]),
            splat(r.origin[2], s.origin[2]),
        ];
        let shear = [splat(r.shear[0], s.shear[0]), splat(r.shear[1], s.shear[1])];
        let [ax, ay, az] = corner(blocks, rays, 0, origin, shear);
        let [bx, by, bz] = corner(blocks, rays, 1, origin, shear);
        let [cx, cy, cz] = corner(blocks, rays, 2, origin, shear);
        let u = _mm512_sub_ps(_mm512_mul_ps(cx, by), _mm512_mul_ps(cy, bx));
        let v = _mm512_sub_ps(_mm512_mul_ps(ax, cy), _mm512_mul_ps(ay, cx));
        let w = _mm512_sub_ps(_mm512_mul_ps(bx, ay), _mm512_mul_ps(by, ax));
        let (least, most) = (_mm512_min_ps(w, _mm512_min_ps(u, v)), _mm512_max_ps(w, _mm512_max_ps(u, v)));
        let none = _mm512_setzero_ps();
        let below = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(least, none);
        let apart = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(below, most, none);
        let (p, q) = (p.numbers().as_ptr().cast(), q.numbers().as_ptr().cast());
        let low = _mm512_castsi256_si512(_mm256_loadu_si256(p));
        let numbers = _mm512_inserti64x4::<1>(low, _mm256_loadu_si256(q));
        let unused = _mm512_cmplt_epi32_mask(numbers, _mm512_setzero_si512());
        let pace = splat(r.inverse_pace, s.inverse_pace);
        let (a, b, c) = (_mm512_mul_ps(az, pace), _mm512_mul_ps(bz, pace), _mm512_mul_ps(cz, pace));
        let near = _mm512_min_ps(c, _mm512_min_ps(a, b));
        let far = _mm512_max_ps(c, _mm512_max_ps(a, b));
        let ends = splat(range_end(limits[0]), range_end(limits[1]));
        let beyond = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(ends, near);
        let behind = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(far, splat(r.behind, s.behind));
        u32::from(!(apart | unused | beyond | behind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::avx512::Avx512;
    use crate::lanes::{Baseline, Machine};
    use crate::prepared::PreparedRay;
    use crate::{InstructionSet, Ray};
    use penombre_lab::Pcg32;
    use penombre_math::Vec3;

    #[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
    fn by_two(blocks: [&TriangleBlock; 2], rays: [&TurnedRay; 2], limits: [f32; 2]) -> [u32; 2] {
        Avx512::met_by_two(blocks, rays, limits)
    }

    #[test]
    fn two_at_once_meet_what_one_after_the_other_does() {
        if !InstructionSet::available().contains(&InstructionSet::Avx512) {
            eprintln!("NOT RUN: this processor has no AVX-512");
            return;
        }
        let mut rng = Pcg32::new(31);
        let mut number = || rng.next_f32() * 2.0 - 1.0;
        let (mut met, mut open) = (0, 0);
        for round in 0..20_000 {
            let mut any = |scale: f32| Vec3::new(number(), number(), number()) * scale;
            let mut block = || {
                let mut block = TriangleBlock::EMPTY;
                (0..1 + round % 8).for_each(|i| block.push([any(1.0), any(1.0), any(1.0)], i));
                block
            };
            let blocks = [block(), block()];
            // Directions of no ordinary length and rays that look before their origin too.
            let scale = if round % 5 == 0 { 1e-9 } else { 1.0 };
            let t_min = if round % 7 == 0 { -1.0 } else { 0.0 };
            let rays = [(); 2].map(|()| Ray::new(any(1.5), any(scale), t_min, f32::INFINITY));
            let [r, s] = rays.each_ref().map(|ray| PreparedRay::new(ray, 1.0));
            let (Some(r), Some(s)) = (r, s) else { continue };
            let limits = [number() * 4.0, f32::INFINITY];
            let (two, rays) = ([&blocks[0], &blocks[1]], [&r.turned, &s.turned]);
            let plain = Baseline::met_by_two(two, rays, limits);
            // SAFETY: the processor was found to have AVX-512.
            assert_eq!(unsafe { by_two(two, rays, limits) }, plain, "round {round}");
            met += plain[0].count_ones() + plain[1].count_ones();
            open += 16;
        }
        assert!(met * 100 > open, "{met} of {open} met");
    }
}
