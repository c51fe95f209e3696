//! Inverse trigonometric functions.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// tan(π/8) = √2 − 1.
const TAN_EIGHTH_PI: f64 = std::f64::consts::SQRT_2 - 1.0;

/// The angle in [0, π] of the point (x, y), y ≥ 0 (the sign of a zero `x` counts), relative error below 2⁻⁴⁴.
/// Not for infinite arguments; NaN gives NaN.
#[inline]
fn angle(y: f64, x: f64) -> f64 {
    let across = x.abs();
    let steep = y > across;
    let (short, long) = if steep { (across, y) } else { (y, across) };
    // Above π/8 the angle is measured from the diagonal, so that one division serves both cases.
    let diagonal = short > long * TAN_EIGHTH_PI;
    let numerator = if diagonal { short - long } else { short };
    let denominator = if diagonal { short + long } else { long };
    // The origin has the angle of its signs.
    let t = numerator / if denominator == 0.0 { 1.0 } else { denominator };
    let a = atan_polynomial(t) + if diagonal { FRAC_PI_4 } else { 0.0 };
    let a = if steep { FRAC_PI_2 - a } else { a };
    if x.is_sign_negative() { PI - a } else { a }
}

/// atan t = t·(1 + z·P(z)), z = t², on |t| ≤ tan(π/8): relative error 2^−45.
#[inline]
fn atan_polynomial(t: f64) -> f64 {
    let z = t * t;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (-0.333_333_333_316_624_35 + z * 0.199_999_996_804_413_24)
        + z2 * (-0.142_856_933_347_181_89 + z * 0.111_104_437_352_489_05);
    let high = (-0.090_790_577_251_499_96 + z * 0.075_679_788_202_321_17)
        + z2 * (-0.058_890_152_758_995_264 + z * 0.030_864_577_594_757_553);
    t * (1.0 + z * (low + z4 * high))
}

/// Infinity becomes a number so large that no finite `f32` counts beside it. NaN stays.
#[inline]
fn limit(v: f32) -> f64 {
    let wide = f64::from(v.abs());
    if wide > 1e200 { 1e200 } else { wide }
}

/// The angle of the point (x, y) in [−π, π]: `atan(y / x)` in the right quadrant. Special cases as in C99:
/// the sign is that of `y`, `atan2(±0, −0)` is ±π, infinities give multiples of π/4.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let a = angle(limit(y), limit(x).copysign(f64::from(x))) as f32;
    if y.is_nan() || x.is_nan() { f32::NAN } else { a.copysign(y) }
}

/// The arc tangent, in [−π/2, π/2].
#[inline]
pub fn atan(x: f32) -> f32 {
    (angle(limit(x), 1.0) as f32).copysign(x)
}

/// The arc sine, in [−π/2, π/2]; NaN outside [−1, 1].
#[inline]
pub fn asin(x: f32) -> f32 {
    let sine = f64::from(x);
    (angle(sine.abs(), (1.0 - sine * sine).sqrt()) as f32).copysign(x)
}

/// The arc cosine, in [0, π]; NaN outside [−1, 1].
#[inline]
pub fn acos(x: f32) -> f32 {
    let cosine = f64::from(x);
    angle((1.0 - cosine * cosine).sqrt(), cosine) as f32
}
