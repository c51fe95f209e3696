//! Functions of degrees in double precision, for transforms and cameras.

use std::f64::consts::FRAC_1_SQRT_2;

/// π/180 and what its rounding left.
const RADIANS_HIGH: f64 = 0.017_453_292_519_943_295;
const RADIANS_LOW: f64 = 2.948_652_270_870_168_7e-19;

/// A product as an unevaluated sum: `high` is the rounded product, `low` the rest.
struct Product {
    high: f64,
    low: f64,
}

/// The exact product of two numbers of moderate size, after \[Dekker1971\].
fn exact_product(a: f64, b: f64) -> Product {
    let split = |v: f64| {
        let big = v * 134_217_729.0; // 2²⁷ + 1
        let head = big - (big - v);
        (head, v - head)
    };
    let ((a_head, a_tail), (b_head, b_tail)) = (split(a), split(b));
    let high = a * b;
    let low = ((a_head * b_head - high) + a_head * b_tail + a_tail * b_head) + a_tail * b_tail;
    Product { high, low }
}

/// Nine terms of the Taylor series Σ (−1)ᵏ z^(k−1) first!/(first + 2k)!, k = 1…; what is left out is below
/// 2⁻⁶⁰ for z ≤ (π/4)². With z = r²: sin r = r·(1 + z·series(z, 1)) and cos r = 1 − z/2·(1 + z·series(z, 2)).
fn series(z: f64, first: u32) -> f64 {
    let mut sum = 0.0;
    for k in (1..=9).rev() {
        let n = f64::from(first + 2 * k);
        sum = -(1.0 + z * sum) / (n * (n - 1.0));
    }
    sum
}

/// Sine and cosine of an angle in degrees, in this order, within 1 ulp: exact at multiples of 30° where the
/// value is 0, ±½ or ±1, equal at 45°. NaN for infinities.
pub fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    // Both steps are exact: the remainder by definition, the difference because it is a small multiple of the
    // last place of `turn`.
    let turn = degrees % 360.0;
    let quadrant = (turn / 90.0).round();
    let rest = turn - quadrant * 90.0;
    let (s, c) = sin_cos_eighth(rest);
    let (s, c) = match quadrant as i32 & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    };
    // Zeros come out positive.
    (s + 0.0, c + 0.0)
}

/// Sine and cosine of |degrees| ≤ 45.
fn sin_cos_eighth(degrees: f64) -> (f64, f64) {
    if degrees.abs() == 45.0 {
        return (FRAC_1_SQRT_2.copysign(degrees), FRAC_1_SQRT_2);
    }
    let Product { high: r, low } = exact_product(degrees, RADIANS_HIGH);
    let r_low = low + degrees * RADIANS_LOW;
    let Product { high: z, low: z_low } = exact_product(r, r);
    // cos = 1 − z/2 + …: the rounding of the first difference and of z is put back.
    let half = 0.5 * z;
    let first = 1.0 - half;
    let c = first + (((1.0 - first) - half) + (z * z * series(z, 2) * -0.5 - r * r_low - 0.5 * z_low));
    let s = r + (r * z * series(z, 1) + r_low * c);
    (s, c)
}

/// The tangent of an angle in degrees, within 2 ulp: exact at multiples of 45°, infinite at 90° (with the
/// sign of the quotient of sine and cosine).
pub fn tan_degrees(degrees: f64) -> f64 {
    let (s, c) = sin_cos_degrees(degrees);
    s / c
}
