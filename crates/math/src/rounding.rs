//! Rounding-error bounds, after Higham and chapter 6.8 of \[PBRT4\].

use glam::Vec3;

/// Half the distance from 1 to the next `f32`: the largest relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// The bound γₙ = nε/(1−nε) on the relative error of `n` rounded operations in a row.
pub const fn gamma(n: u32) -> f32 {
    let ne = n as f32 * UNIT_ROUNDOFF;
    ne / (1.0 - ne)
}

/// Origin of a ray that leaves a surface without meeting it again because of rounding.
///
/// `p` is the computed hit point and `p_error` a bound on its absolute error per axis (same unit),
/// `normal` the geometric normal (unit), `dir` the direction of the new ray (any length). The point moves
/// along the normal, to the side of `dir`, until the box of the error lies behind it; each coordinate is then
/// rounded away from `p` (\[PBRT4\], 6.8.6).
#[inline]
pub fn offset_origin(p: Vec3, p_error: Vec3, normal: Vec3, dir: Vec3) -> Vec3 {
    let distance = normal.abs().dot(p_error);
    let mut offset = normal * distance;
    if dir.dot(normal) < 0.0 {
        offset = -offset;
    }
    let moved = p + offset;
    Vec3::new(away(moved.x, offset.x), away(moved.y, offset.y), away(moved.z, offset.z))
}

/// The next number in the direction of `offset`; `value` itself where that is 0. Like `next_up` and `next_down`, but
/// without branches that cannot be foretold.
#[inline(always)]
fn away(value: f32, offset: f32) -> f32 {
    let (bits, up) = (value.to_bits(), offset > 0.0);
    let grows = up == value.is_sign_positive();
    let next = if grows { bits.wrapping_add(1) } else { bits.wrapping_sub(1) };
    let from_zero = if up { 1 } else { 1 | 1 << 31 };
    let next = if value == 0.0 { from_zero } else { next };
    let stays = offset == 0.0 || offset.is_nan() || !value.is_finite();
    f32::from_bits(if stays { bits } else { next })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f32};

    #[test]
    fn gamma_bounds_products() {
        assert_eq!(UNIT_ROUNDOFF, 2f32.powi(-24));
        assert_eq!(gamma(0), 0.0);
        assert!(gamma(1) > UNIT_ROUNDOFF && gamma(1) < 1.000_001 * UNIT_ROUNDOFF);
        // Ten products in a row, each rounded, against double precision.
        for trial in 0..10_000 {
            let factor = |i| 0.5 + unit_f32(combine(trial, i));
            let rounded = (0..11).map(factor).fold(1.0f32, |a, b| a * b);
            let exact = (0..11).map(factor).fold(1.0f64, |a, b| a * f64::from(b));
            let error = (f64::from(rounded) - exact).abs() / exact;
            assert!(error <= f64::from(gamma(10)), "trial {trial}");
        }
    }

    #[test]
    fn the_new_origin_lies_on_the_side_of_the_direction_and_beyond_the_error() {
        for trial in 0..10_000 {
            let number = |i: u32| unit_f32(combine(trial, i)) - 0.5;
            let vector = |i: u32| Vec3::new(number(i), number(i + 1), number(i + 2));
            let normal = vector(0).normalize();
            let (p, dir) = (vector(3) * 1000.0, vector(6));
            let error = (vector(9).abs() + 0.1) * 1e-3;
            let moved = offset_origin(p, error, normal, dir);
            let side = dir.dot(normal).signum();
            // The corner of the error box that reaches farthest.
            let reach = (p.as_dvec3() + (error * normal.signum() * side).as_dvec3() - p.as_dvec3())
                .dot(normal.as_dvec3());
            let climbed = (moved.as_dvec3() - p.as_dvec3()).dot(normal.as_dvec3());
            assert!(climbed * f64::from(side) >= reach * f64::from(side) - 1e-12, "trial {trial}");
        }
    }

    #[test]
    fn away_is_the_next_number() {
        for value in [0.0, -0.0, 1.0, -1.0, f32::MIN_POSITIVE, -1e-45, 1e-45, f32::MAX, 0.3, -1e20] {
            assert_eq!(away(value, 1e-9).to_bits(), value.next_up().to_bits());
            assert_eq!(away(value, -1e-9).to_bits(), value.next_down().to_bits());
            assert_eq!(away(value, 0.0).to_bits(), value.to_bits());
            assert_eq!(away(value, f32::NAN).to_bits(), value.to_bits());
        }
        assert_eq!(away(f32::INFINITY, -1.0), f32::INFINITY);
    }

    #[test]
    fn axes_without_offset_stay() {
        let moved = offset_origin(Vec3::ONE, Vec3::splat(1e-6), Vec3::Z, Vec3::new(1.0, 0.0, -1.0));
        assert_eq!((moved.x, moved.y), (1.0, 1.0));
        assert!(moved.z < 1.0 - 1e-6);
        assert_eq!(offset_origin(Vec3::ONE, Vec3::ZERO, Vec3::Z, Vec3::Z), Vec3::ONE);
    }
}
