//! Sine, cosine and tangent of radians.

use super::ROUNDER;
use std::f64::consts::FRAC_2_PI;

/// The first 33 bits of π/2: its product with an integer below 2²⁰ is exact.
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
/// π/2 minus [`HALF_PI_HIGH`].
const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;
/// Below this the two-part π/2 is accurate enough for every `f32`.
const NEAR: f32 = 1_048_576.0;

/// The bits of 2/π after the binary point, preceded by one word of zeros.
const TWO_OVER_PI: [u64; 5] =
    [0, 0xa2f9_836e_4e44_1529, 0xfc27_57d1_f534_ddc0, 0xdb62_9599_3c43_9041, 0xfe51_63ab_debb_c561];

/// An angle as `quadrant`·π/2 + `rest`, |rest| ≤ π/4 (a little more by rounding). Only the two low bits of
/// `quadrant` mean anything.
#[derive(Clone, Copy)]
struct Reduced {
    rest: f64,
    quadrant: u32,
}

#[inline]
fn reduce(x: f32) -> Reduced {
    if x.abs() < NEAR {
        let wide = f64::from(x);
        let shifted = wide * FRAC_2_PI + ROUNDER;
        let turns = shifted - ROUNDER;
        let rest = (wide - turns * HALF_PI_HIGH) - turns * HALF_PI_LOW;
        Reduced { rest, quadrant: shifted.to_bits() as u32 }
    } else {
        reduce_far(x)
    }
}

/// Large arguments after \[PayneHanek1983\]: x = m·2ᵉ is multiplied by those 128 bits of 2/π that matter;
/// more significant ones add whole turns. The product, in units of 2⁻¹²⁶ quadrants, is short by less than 2²⁴
/// units.
#[cold]
#[inline(never)]
fn reduce_far(x: f32) -> Reduced {
    if !x.is_finite() {
        return Reduced { rest: f64::NAN, quadrant: 0 };
    }
    let bits = x.to_bits();
    let mantissa = u128::from((bits & 0x007f_ffff) | 0x0080_0000);
    // x = mantissa · 2^e with −3 ≤ e ≤ 104. The window begins at the bit of weight 2^(1−e), bit 62 + e of the
    // table.
    let e = ((bits >> 23) & 0xff) as usize - 147;
    let start = e + 59;
    let (word, offset) = (start / 64, start % 64);
    let pair = (u128::from(TWO_OVER_PI[word]) << 64) | u128::from(TWO_OVER_PI[word + 1]);
    let next = u128::from(TWO_OVER_PI[word + 2]);
    let window = if offset == 0 { pair } else { (pair << offset) | (next >> (64 - offset)) };
    let product = mantissa.wrapping_mul(window);
    let quadrant = (product.wrapping_add(1 << 125) >> 126) as u32;
    let rest = product.wrapping_sub(u128::from(quadrant) << 126) as i128;
    // π/2 · 2⁻¹²⁶
    let rest = rest as f64 * (std::f64::consts::FRAC_PI_2 * f64::from_bits((1023 - 126) << 52));
    if x < 0.0 {
        Reduced { rest: -rest, quadrant: quadrant.wrapping_neg() }
    } else {
        Reduced { rest, quadrant }
    }
}

/// sin r = r·(1 + z·P(z)), z = r², on |r| ≤ π/4: relative error 2^−47.5.
#[inline]
fn sin_polynomial(r: f64) -> f64 {
    let z = r * r;
    let z2 = z * z;
    let low = -0.166_666_666_666_303_34 + z * 0.008_333_333_325_074_743;
    let high = -0.000_198_412_637_269_557_3 + z * 2.755_533_929_463_44e-6;
    r * (1.0 + z * (low + z2 * (high - z2 * 2.476_042_791_165_781_4e-8)))
}

/// cos r = 1 − z/2 + z²·P(z), z = r², on |r| ≤ π/4: relative error 2^−42.9.
#[inline]
fn cos_polynomial(r: f64) -> f64 {
    let z = r * r;
    let z2 = z * z;
    let low = 0.041_666_666_619_471_79 - z * 0.001_388_888_349_842_708_1;
    let high = 2.479_945_972_442_511e-5 - z * 2.720_571_888_538_221_6e-7;
    (1.0 - 0.5 * z) + z2 * (low + z2 * high)
}

/// The number with its sign turned if bit 1 of `quadrant` is set.
#[inline]
fn turn_sign(v: f64, quadrant: u32) -> f64 {
    f64::from_bits(v.to_bits() ^ (u64::from(quadrant & 2) << 62))
}

/// Sine and cosine in double precision.
#[inline]
fn sin_cos_wide(x: f32) -> (f64, f64) {
    let Reduced { rest, quadrant } = reduce(x);
    let (s, c) = (sin_polynomial(rest), cos_polynomial(rest));
    let (s, c) = if quadrant & 1 == 0 { (s, c) } else { (c, s) };
    (turn_sign(s, quadrant), turn_sign(c, quadrant.wrapping_add(1)))
}

/// The sine of `x` radians; right for all sizes of `x`, NaN for infinities.
#[inline]
pub fn sin(x: f32) -> f32 {
    sin_cos_wide(x).0 as f32
}

/// The cosine of `x` radians; right for all sizes of `x`, NaN for infinities.
#[inline]
pub fn cos(x: f32) -> f32 {
    sin_cos_wide(x).1 as f32
}

/// Sine and cosine of `x` radians, in this order, for little more than the price of one.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let (s, c) = sin_cos_wide(x);
    (s as f32, c as f32)
}

/// The tangent of `x` radians; right for all sizes of `x`, NaN for infinities.
#[inline]
pub fn tan(x: f32) -> f32 {
    let (s, c) = sin_cos_wide(x);
    (s / c) as f32
}
