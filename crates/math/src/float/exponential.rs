//! Exponentials, logarithms and powers.

use super::ROUNDER;
use std::f64::consts::{LN_2, LOG2_E};

/// Bits of √½ in double precision: mantissas are taken from [√½, √2).
const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;

/// 2ᵗ in double precision with a relative error below 2⁻³⁹. Beyond ±200, where every `f32` over- or
/// underflows, the argument is limited. NaN stays NaN.
#[inline]
const fn exp2_wide(t: f64) -> f64 {
    let t = if t > 200.0 { 200.0 } else { t };
    let t = if t < -200.0 { -200.0 } else { t };
    let shifted = t + ROUNDER;
    let r = t - (shifted - ROUNDER);
    // 2^r = 1 + r·P(r) on [−½, ½], relative error 2^−39.8.
    let r2 = r * r;
    let low = (0.693_147_180_541_229_8 + r * 0.240_226_506_947_421_95)
        + r2 * (0.055_504_109_592_409_825 + r * 0.009_618_129_559_009_368);
    let high = (0.001_333_343_414_579_590_6 + r * 0.000_154_030_981_429_013_84)
        + r2 * (1.531_421_224_304_431_3e-5 + r * 1.334_421_474_235_654_8e-6);
    let power = 1.0 + r * (low + (r2 * r2) * high);
    // The integer part stands in the low bits of `shifted`; it becomes the exponent.
    power * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0f64.to_bits()))
}

/// log₂ x in double precision with a relative error below 2⁻⁵⁰, for positive finite `x` that is not subnormal
/// as a double.
#[inline]
const fn log2_wide(x: f64) -> f64 {
    let bits = x.to_bits();
    let exponent = bits.wrapping_sub(SQRT_HALF_BITS) as i64 >> 52;
    let m = f64::from_bits(bits.wrapping_sub((exponent as u64) << 52));
    let s = (m - 1.0) / (m + 1.0);
    // log₂((1+s)/(1−s)) = s·P(s²) on |s| ≤ 3 − 2√2, relative error 2^−52.4.
    let z = s * s;
    let z2 = z * z;
    let low = 2.885_390_081_777_927 + z * 0.961_796_693_924_323_7;
    let middle = 0.577_078_017_250_763_8 + z * 0.412_198_401_393_773_23;
    let high = (0.320_616_431_688_572_57 + z * 0.261_442_915_080_689_9) + z2 * 0.242_931_400_498_037_05;
    exponent as f64 + s * (low + z2 * (middle + z2 * high))
}

/// eˣ.
#[inline]
pub const fn exp(x: f32) -> f32 {
    exp2_wide(x as f64 * LOG2_E) as f32
}

/// 2ˣ; exact for integers.
#[inline]
pub const fn exp2(x: f32) -> f32 {
    exp2_wide(x as f64) as f32
}

/// The natural logarithm: −∞ at ±0, NaN below.
#[inline]
pub const fn ln(x: f32) -> f32 {
    if x > 0.0 && x < f32::INFINITY { (log2_wide(x as f64) * LN_2) as f32 } else { log_special(x) }
}

/// The logarithm to base 2: exact for powers of two, −∞ at ±0, NaN below.
#[inline]
pub const fn log2(x: f32) -> f32 {
    if x > 0.0 && x < f32::INFINITY { log2_wide(x as f64) as f32 } else { log_special(x) }
}

/// Logarithms of what is not a positive finite number.
#[cold]
const fn log_special(x: f32) -> f32 {
    if x == 0.0 {
        f32::NEG_INFINITY
    } else if x == f32::INFINITY {
        x
    } else {
        f32::NAN
    }
}

/// xʸ, with the special cases of C99 annex F and IEEE 754 `pow`: `pow(x, 0)` and `pow(1, y)` are 1 even for
/// NaN; a negative `x` with a `y` that is no integer gives NaN.
#[inline]
pub const fn pow(x: f32, y: f32) -> f32 {
    if x > 0.0 && x < f32::INFINITY && y.is_finite() { pow_positive(x, y) } else { pow_special(x, y) }
}

/// xʸ of a positive finite base.
#[inline]
const fn pow_positive(x: f32, y: f32) -> f32 {
    pow_wide(x as f64, y as f64) as f32
}

/// xʸ in double precision of a positive finite base, relative error below 2⁻³⁸ where the result fits an
/// `f32`.
#[inline]
pub(crate) const fn pow_wide(x: f64, y: f64) -> f64 {
    exp2_wide(y * log2_wide(x))
}

/// Powers of zero, infinite, negative or NaN bases and infinite or NaN exponents.
#[cold]
const fn pow_special(x: f32, y: f32) -> f32 {
    let magnitude = x.abs();
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    if x.is_nan() || y.is_nan() {
        return f32::NAN;
    }
    if y.is_infinite() {
        if magnitude == 1.0 {
            return 1.0;
        }
        return if (magnitude > 1.0) == (y > 0.0) { f32::INFINITY } else { 0.0 };
    }
    let parity = parity(y);
    let size = if magnitude == 0.0 || magnitude.is_infinite() {
        if (magnitude == 0.0) == (y < 0.0) { f32::INFINITY } else { 0.0 }
    } else if matches!(parity, Parity::Fraction) {
        return f32::NAN;
    } else {
        pow_positive(magnitude, y)
    };
    if x.is_sign_negative() && matches!(parity, Parity::Odd) { -size } else { size }
}

/// What a finite exponent is.
enum Parity {
    Even,
    Odd,
    Fraction,
}

const fn parity(y: f32) -> Parity {
    // From 2²⁴ on every `f32` is an even integer.
    if y.abs() >= 16_777_216.0 {
        return Parity::Even;
    }
    let integer = y as i32;
    if integer as f32 != y {
        Parity::Fraction
    } else if integer & 1 == 0 {
        Parity::Even
    } else {
        Parity::Odd
    }
}
