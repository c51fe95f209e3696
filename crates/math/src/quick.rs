//! Elementary functions for loops over many numbers: polynomials without branches, which a compiler turns into vector code.
//!
//! They are accurate to a few units of the last place; those of [`crate::float`] are better and slower. All are inlined, to
//! be compiled for the caller's instruction set, and round each operation alone: the bits are the same on all of them.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// Sine and cosine of an angle in [−π/4, π/4], within 10⁻⁷.
#[inline(always)]
pub fn sin_cos_quarter(x: f32) -> (f32, f32) {
    let s = x * x;
    let sin = ((s * 2.718_311_4e-6 - 1.983_933_5e-4) * s + 8.333_329e-3) * s - 1.666_666_6e-1;
    let cos = ((s * 2.443_315_7e-5 - 1.388_731_6e-3) * s + 4.166_664_6e-2) * s - 0.5;
    (x + x * s * sin, 1.0 + s * cos)
}

/// Sine and cosine of an angle in [−2π, 2π], within 3·10⁻⁷.
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    // Rounds to a whole number, which stands in the lowest bits: 1.5·2²³.
    const WHOLE: f32 = 12_582_912.0;
    let shifted = x * FRAC_2_PI + WHOLE;
    let quadrant = shifted.to_bits();
    let multiple = shifted - WHOLE;
    // The multiple of π/2 is taken off in two parts.
    let (s, c) = sin_cos_quarter(x - multiple * FRAC_PI_2 + multiple * 4.371_139e-8);
    let even = quadrant & 1 == 0;
    let (sin, cos) = (if even { s } else { c }, if even { c } else { s });
    let flip = |v: f32, bits: u32| f32::from_bits(v.to_bits() ^ ((bits & 2) << 30));
    (flip(sin, quadrant), flip(cos, quadrant.wrapping_add(1)))
}

/// Angle of the point (x, y) in [−π, π], within 4·10⁻⁷; 0 of the origin. The arc tangent on [0, tan π/8] is a
/// polynomial (that of Cephes' `atanf`), elsewhere the addition theorem leads there.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ax < ay;
    let (low, high) = (if steep { ax } else { ay }, if steep { ay } else { ax });
    // Above tan π/8: atan t = π/4 + atan((t − 1)/(t + 1)), t = low/high.
    let far = high * 0.414_213_56 < low;
    let above = if far { low - high } else { low };
    let below = (if far { low + high } else { high }).max(f32::MIN_POSITIVE);
    let t = above / below;
    let s = t * t;
    let tail = ((s * 8.053_744_5e-2 - 1.387_768_6e-1) * s + 1.997_771_1e-1) * s - 3.333_295e-1;
    let angle = t + t * s * tail + if far { FRAC_PI_4 } else { 0.0 };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    f32::from_bits(angle.to_bits() & 0x7fff_ffff | y.to_bits() & 0x8000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error of a function against double precision, over many arguments from `low` to `high`.
    fn largest_error((low, high): (f32, f32), ours: impl Fn(f32) -> f32, exact: impl Fn(f64) -> f64) -> f64 {
        let steps = 1_000_000;
        let argument = |i: i32| (low + (high - low) * (i as f32 / steps as f32)).min(high);
        let error = |x: f32| (f64::from(ours(x)) - exact(f64::from(x))).abs();
        (0..=steps).map(|i| error(argument(i))).fold(0.0, f64::max)
    }

    #[test]
    fn they_are_as_accurate_as_they_say() {
        let quarter = (-FRAC_PI_4, FRAC_PI_4);
        let turns = (-2.0 * PI, 2.0 * PI);
        let errors = [
            largest_error(quarter, |x| sin_cos_quarter(x).0, f64::sin),
            largest_error(quarter, |x| sin_cos_quarter(x).1, f64::cos),
            largest_error(turns, |x| sin_cos(x).0, f64::sin),
            largest_error(turns, |x| sin_cos(x).1, f64::cos),
        ];
        assert!(errors[0] < 1e-7 && errors[1] < 1e-7 && errors[2] < 3e-7 && errors[3] < 3e-7, "{errors:?}");
        for x in [-1e3, -1.0, -0.3, 0.0, 0.4, 1.0, 7.0, 1e-3] {
            let error = largest_error((-9.0, 9.0), |y| atan2(y, x), |y| y.atan2(f64::from(x)));
            assert!(error < 4e-7, "{x}: {error}");
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }
}
