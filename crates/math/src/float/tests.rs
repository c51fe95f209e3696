//! Accuracy against double precision, special values, symmetries.
//!
//! The normal run samples the inputs; with `PENOMBRE_SLOW=1` it takes all 2³² of them.

use super::*;
use crate::hash::{mix64, unit_f64};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

fn slow() -> bool {
    std::env::var_os("PENOMBRE_SLOW").is_some_and(|v| v == "1")
}

/// Distance of `found` from the true value in units of the last place of the true value.
fn ulps(found: f32, exact: f64) -> f64 {
    let rounded = exact as f32;
    if exact.is_nan() || found.is_nan() {
        return if exact.is_nan() && found.is_nan() { 0.0 } else { f64::INFINITY };
    }
    if rounded.is_infinite() && found == rounded {
        return 0.0;
    }
    let exponent = ((exact.to_bits() >> 52 & 0x7ff) as i64 - 1023).max(-126);
    let ulp = f64::from_bits(((exponent - 23 + 1023) as u64) << 52);
    (f64::from(found) - exact).abs() / ulp
}

/// The worst input found and its error.
#[derive(Clone, Copy)]
struct Worst {
    input: [f32; 2],
    error: f64,
}

/// The largest error over the indices 0, `stride`, 2·`stride`… below 2³², on two threads.
fn largest(stride: u64, error_at: impl Fn(u32) -> ([f32; 2], f64) + Sync) -> Worst {
    let scan = |start: u64| {
        let mut worst = Worst { input: [0.0; 2], error: 0.0 };
        for i in (start..1 << 32).step_by(2 * stride as usize) {
            let (input, error) = error_at(i as u32);
            if error > worst.error {
                worst = Worst { input, error };
            }
        }
        worst
    };
    std::thread::scope(|s| {
        let other = s.spawn(|| scan(stride));
        let (a, b) = (scan(0), other.join().expect("the scan does not panic"));
        if a.error >= b.error { a } else { b }
    })
}

fn judge(name: &str, worst: Worst, bound: f64) {
    eprintln!("{name}: at most {:.6} ulp, at {:?}", worst.error, worst.input);
    assert!(worst.error <= bound, "{name}{:?}: {} ulp, more than {bound}", worst.input, worst.error);
}

fn check(name: &str, f: impl Fn(f32) -> f32 + Sync, oracle: impl Fn(f64) -> f64 + Sync, bound: f64) {
    let stride = if slow() { 1 } else { 997 };
    let worst = largest(stride, |bits| {
        let x = f32::from_bits(bits);
        ([x, x], ulps(f(x), oracle(f64::from(x))))
    });
    judge(name, worst, bound);
}

fn check_pairs(
    name: &str,
    pair: impl Fn(u64) -> [f32; 2] + Sync,
    f: impl Fn(f32, f32) -> f32 + Sync,
    oracle: impl Fn(f64, f64) -> f64 + Sync,
    bound: f64,
) {
    let stride = if slow() { 1 } else { 997 };
    let worst = largest(stride, |i| {
        let [a, b] = pair(mix64(u64::from(i) + 1));
        ([a, b], ulps(f(a, b), oracle(f64::from(a), f64::from(b))))
    });
    judge(name, worst, bound);
}

#[test]
fn accuracy_of_sin() {
    check("sin", sin, f64::sin, 0.5001);
}

#[test]
fn accuracy_of_cos() {
    check("cos", cos, f64::cos, 0.5001);
}

#[test]
fn accuracy_of_tan() {
    check("tan", tan, f64::tan, 0.5001);
}

#[test]
fn accuracy_of_asin() {
    check("asin", asin, f64::asin, 0.5001);
}

#[test]
fn accuracy_of_acos() {
    check("acos", acos, f64::acos, 0.5001);
}

#[test]
fn accuracy_of_atan() {
    check("atan", atan, f64::atan, 0.5001);
}

#[test]
fn accuracy_of_exp() {
    check("exp", exp, f64::exp, 0.5001);
}

#[test]
fn accuracy_of_exp2() {
    check("exp2", exp2, f64::exp2, 0.5001);
}

#[test]
fn accuracy_of_ln() {
    check("ln", ln, f64::ln, 0.5001);
}

#[test]
fn accuracy_of_log2() {
    check("log2", log2, f64::log2, 0.5001);
}

#[test]
fn accuracy_of_atan2() {
    // Half of the pairs are any bits, half of similar size.
    let pair = |h: u64| {
        let (y, x) = (h as u32, (h >> 32) as u32);
        let near = (y & 0x807f_ffff) | ((x & 0x7f80_0000).wrapping_add((y >> 3) & 0x0380_0000) & 0x7f80_0000);
        [f32::from_bits(if h & 4 == 0 { y } else { near }), f32::from_bits(x)]
    };
    check_pairs("atan2", pair, atan2, f64::atan2, 0.5001);
}

#[test]
fn accuracy_of_pow() {
    // Half of the pairs are any bits; the others have results between 2^−151 and 2^129.
    let pair = |h: u64| {
        let (x, y) = (f32::from_bits(h as u32), f32::from_bits((h >> 32) as u32));
        if h & 1 == 0 {
            return [x, y];
        }
        let x = x.abs();
        let target = unit_f64(mix64(h)) * 280.0 - 151.0;
        [x, (target / f64::from(x).log2()) as f32]
    };
    check_pairs("pow", pair, pow, f64::powf, 0.5005);
}

/// Equal, with equal signs of zeros and NaN equal to NaN.
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

const INF: f32 = f32::INFINITY;
const NAN: f32 = f32::NAN;

#[test]
fn odd_functions_are_odd_and_even_ones_even() {
    for i in (0..1u32 << 31).step_by(9973) {
        let x = f32::from_bits(i);
        for (name, f) in [("sin", sin as fn(f32) -> f32), ("tan", tan), ("asin", asin), ("atan", atan)] {
            assert!(same(f(-x), -f(x)), "{name}({x})");
        }
        assert!(same(cos(-x), cos(x)), "cos({x})");
        assert!(same(sin_cos(x).0, sin(x)) && same(sin_cos(x).1, cos(x)), "sin_cos({x})");
    }
    assert!(
        same(sin(-0.0), -0.0) && same(tan(-0.0), -0.0) && same(asin(-0.0), -0.0) && same(atan(-0.0), -0.0)
    );
}

#[test]
fn special_values_of_unary_functions() {
    for (name, found, expected) in [
        ("sin ∞", sin(INF), NAN),
        ("cos −∞", cos(-INF), NAN),
        ("tan ∞", tan(INF), NAN),
        ("cos 0", cos(0.0), 1.0),
        ("asin 1", asin(1.0), FRAC_PI_2 as f32),
        ("asin 1+", asin(1.0f32.next_up()), NAN),
        ("acos 1", acos(1.0), 0.0),
        ("acos −1", acos(-1.0), PI as f32),
        ("acos −0", acos(-0.0), FRAC_PI_2 as f32),
        ("acos −1−", acos((-1.0f32).next_down()), NAN),
        ("acos ∞", acos(INF), NAN),
        ("atan ∞", atan(INF), FRAC_PI_2 as f32),
        ("atan −∞", atan(-INF), -FRAC_PI_2 as f32),
        ("exp 0", exp(-0.0), 1.0),
        ("exp ∞", exp(INF), INF),
        ("exp −∞", exp(-INF), 0.0),
        ("exp 89", exp(89.0), INF),
        ("exp −104", exp(-104.0), 0.0),
        ("exp2 128", exp2(128.0), INF),
        ("ln 1", ln(1.0), 0.0),
        ("ln 0", ln(0.0), -INF),
        ("ln −0", ln(-0.0), -INF),
        ("ln −1", ln(-1.0), NAN),
        ("ln ∞", ln(INF), INF),
        ("log2 −∞", log2(-INF), NAN),
        ("log2 0", log2(0.0), -INF),
    ] {
        assert!(same(found, expected), "{name}: {found}");
    }
    for f in [sin, cos, tan, asin, acos, atan, exp, exp2, ln, log2] {
        assert!(f(NAN).is_nan() && f(-NAN).is_nan());
    }
}

#[test]
fn powers_of_two_are_exact_both_ways() {
    for k in -149..128 {
        let power = 2f64.powi(k) as f32;
        assert!(same(exp2(k as f32), power) && same(log2(power), k as f32), "2^{k}");
    }
}

#[test]
fn special_values_of_atan2() {
    let (pi, half, quarter) = (PI as f32, FRAC_PI_2 as f32, FRAC_PI_4 as f32);
    for (y, x, expected) in [
        (0.0, 0.0, 0.0),
        (0.0, -0.0, pi),
        (0.0, 1.0, 0.0),
        (0.0, -1.0, pi),
        (1.0, 0.0, half),
        (1.0, -0.0, half),
        (1.0, INF, 0.0),
        (1.0, -INF, pi),
        (INF, 1.0, half),
        (INF, -1.0, half),
        (INF, INF, quarter),
        (INF, -INF, (3.0 * FRAC_PI_4) as f32),
        (2.0, 2.0, quarter),
        (NAN, 1.0, NAN),
        (1.0, NAN, NAN),
        (NAN, INF, NAN),
    ] {
        assert!(same(atan2(y, x), expected), "atan2({y}, {x}): {}", atan2(y, x));
        assert!(same(atan2(-y, x), -expected), "atan2({}, {x}): {}", -y, atan2(-y, x));
    }
}

#[test]
fn special_values_of_pow() {
    // Every case of C99, F.9.4.4.
    for y in [0.0, -0.0] {
        for x in [0.0, 1.0, -2.0, INF, NAN] {
            assert!(same(pow(x, y), 1.0));
        }
    }
    for (x, y, expected) in [
        (0.0, -3.0, INF),
        (-0.0, -3.0, -INF),
        (0.0, -2.0, INF),
        (-0.0, -2.0, INF),
        (-0.0, -2.5, INF),
        (0.0, -INF, INF),
        (-0.0, -INF, INF),
        (0.0, 3.0, 0.0),
        (-0.0, 3.0, -0.0),
        (-0.0, 2.0, 0.0),
        (-0.0, 2.5, 0.0),
        (-1.0, INF, 1.0),
        (-1.0, -INF, 1.0),
        (1.0, NAN, 1.0),
        (1.0, INF, 1.0),
        (-8.0, 1.0 / 3.0, NAN),
        (-2.0, 3.0, -8.0),
        (-2.0, 4.0, 16.0),
        (-2.0, -1.0, -0.5),
        (-1.0, 16_777_215.0, -1.0),
        (-1.0, 16_777_216.0, 1.0),
        (-1.0, f32::MAX, 1.0),
        (0.5, -INF, INF),
        (-0.5, -INF, INF),
        (2.0, -INF, 0.0),
        (-2.0, -INF, 0.0),
        (0.5, INF, 0.0),
        (2.0, INF, INF),
        (-INF, -3.0, -0.0),
        (-INF, -2.0, 0.0),
        (-INF, 3.0, -INF),
        (-INF, 2.0, INF),
        (-INF, 2.5, INF),
        (INF, -0.5, 0.0),
        (INF, 0.5, INF),
        (NAN, 2.0, NAN),
        (2.0, NAN, NAN),
        (-2.0, 129.0, -INF),
        (-2.0, -151.0, -0.0),
        (3.0, 1.0, 3.0),
        (3.0, 5.0, 243.0),
        (0.25, 0.5, 0.5),
    ] {
        assert!(same(pow(x, y), expected), "pow({x}, {y}): {}", pow(x, y));
    }
}

#[test]
fn compile_time_and_run_time_agree() {
    const AT_COMPILE_TIME: [f32; 4] = [exp(1.5), ln(0.3), pow(2.7, -3.3), log2(1e-40)];
    let x = std::hint::black_box([1.5, 0.3, 2.7, 1e-40]);
    assert_eq!(AT_COMPILE_TIME, [exp(x[0]), ln(x[1]), pow(x[2], -3.3), log2(x[3])]);
}

/// A number as an unevaluated sum of two doubles, for an oracle of about 100 bits.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn add(self, o: Self) -> Self {
        let sum = self.0 + o.0;
        let part = sum - self.0;
        let rest = (self.0 - (sum - part)) + (o.0 - part) + (self.1 + o.1);
        Self(sum + rest, rest - ((sum + rest) - sum))
    }

    fn mul(self, o: Self) -> Self {
        let product = self.0 * o.0;
        let rest = self.0.mul_add(o.0, -product) + (self.0 * o.1 + self.1 * o.0);
        Self(product + rest, rest - ((product + rest) - product))
    }

    /// Sine (`first` = 1) or cosine (`first` = 0) by the Taylor series.
    fn series(self, first: u32) -> Self {
        let mut term = if first == 1 { self } else { Self(1.0, 0.0) };
        let square = self.mul(self);
        let mut sum = term;
        for k in 1..20 {
            let n = f64::from(2 * k + first);
            let factor = n * (n - 1.0);
            let inverse = 1.0 / factor;
            let inverse = Self(inverse, (-inverse).mul_add(factor, 1.0) / factor);
            let next = term.mul(square).mul(inverse);
            term = Self(-next.0, -next.1);
            sum = sum.add(term);
        }
        sum
    }
}

/// Distance in units of the last place of the exact value.
fn ulps_wide(found: f64, exact: Double) -> f64 {
    let ulp = exact.0.abs().next_up() - exact.0.abs();
    ((found - exact.0) - exact.1).abs() / ulp
}

#[test]
fn degrees_are_accurate() {
    // π/180 to 106 bits.
    let unit = Double(0.017_453_292_519_943_295, 2.948_652_270_870_168_7e-19);
    let (mut largest, mut largest_tan) = (0.0f64, 0.0f64);
    for i in 0..200_000u64 {
        let small = i % 7 == 0;
        let degrees = unit_f64(mix64(i)) * if small { 1e-3 } else { 90.0 } - if small { 5e-4 } else { 45.0 };
        let angle = Double(degrees, 0.0).mul(unit);
        let (exact_sin, exact_cos) = (angle.series(1), angle.series(0));
        let (s, c) = sin_cos_degrees(degrees);
        largest = largest.max(ulps_wide(s, exact_sin)).max(ulps_wide(c, exact_cos));
        let quotient = exact_sin.0 / exact_cos.0;
        let rest = exact_sin.add(exact_cos.mul(Double(-quotient, 0.0)));
        largest_tan =
            largest_tan.max(ulps_wide(tan_degrees(degrees), Double(quotient, rest.0 / exact_cos.0)));
    }
    eprintln!("degrees: sine and cosine at most {largest:.3} ulp, tangent {largest_tan:.3}");
    assert!(largest < 0.8 && largest_tan < 2.0, "{largest} {largest_tan}");
}

#[test]
fn degrees_are_exact_where_they_can_be() {
    let root = std::f64::consts::FRAC_1_SQRT_2;
    for turn in [-360.0 * 2_777_778.0, -360.0, 0.0, 360.0, 7200.0, 360.0 * 2f64.powi(40)] {
        for (degrees, sin, cos) in [
            (0.0, 0.0, 1.0),
            (30.0, 0.5, 0.866_025_403_784_438_6),
            (45.0, root, root),
            (60.0, 0.866_025_403_784_438_6, 0.5),
            (90.0, 1.0, 0.0),
            (120.0, 0.866_025_403_784_438_6, -0.5),
            (135.0, root, -root),
            (180.0, 0.0, -1.0),
            (225.0, -root, -root),
            (270.0, -1.0, 0.0),
            (330.0, -0.5, 0.866_025_403_784_438_6),
        ] {
            assert_eq!(sin_cos_degrees(turn + degrees), (sin, cos), "{degrees} + {turn}");
        }
    }
    assert_eq!(
        (tan_degrees(45.0), tan_degrees(-45.0), tan_degrees(135.0), tan_degrees(180.0)),
        (1.0, -1.0, -1.0, 0.0)
    );
    assert_eq!((tan_degrees(90.0), tan_degrees(0.0)), (f64::INFINITY, 0.0));
    assert!(sin_cos_degrees(f64::INFINITY).0.is_nan() && tan_degrees(f64::NAN).is_nan());
    // No zero of the wrong sign.
    for degrees in [-0.0, 0.0, 90.0, 180.0, 270.0, -90.0] {
        let (s, c) = sin_cos_degrees(degrees);
        assert!([s, c].iter().all(|v| *v != 0.0 || v.is_sign_positive()), "{degrees}");
    }
}
