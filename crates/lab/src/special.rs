//! Special functions in double precision, from the formulas of \[DLMF\].

use std::f64::consts::PI;

/// Iterations after which a series or fraction is taken as converged; about √a of them are needed.
const MOST_TERMS: usize = 100_000;

/// ln Γ(x) for x > 0, relative error about 10⁻¹⁴ (absolute near the zeros at 1 and 2). Stirling's series
/// \[DLMF 5.11.1\] after shifting the argument above 12.
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0);
    while x < 12.0 {
        product *= x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let tail = [-691.0 / 360_360.0, 1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0]
        .iter()
        .fold(0.0, |sum, c| sum * y + c);
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + tail / x - product.ln()
}

/// The regularised upper incomplete gamma function Q(a, x), a > 0, x ≥ 0: relative error about 10⁻¹². Series
/// \[DLMF 8.7.1\] below a + 1, continued fraction \[DLMF 8.9.2\] above.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..MOST_TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * 1e-17 {
                break;
            }
        }
        1.0 - scale * sum
    } else {
        // 1/(x+1−a − 1(1−a)/(x+3−a − 2(2−a)/(x+5−a − …
        let fraction = continued_fraction(x + 1.0 - a, |n| {
            let n = n as f64;
            (n * (a - n), x + 2.0 * n + 1.0 - a)
        });
        scale / fraction
    }
}

/// The complementary error function.
pub fn erfc(x: f64) -> f64 {
    let tail = gamma_q(0.5, x * x);
    if x < 0.0 { 2.0 - tail } else { tail }
}

/// The regularised incomplete beta function I_x(a, b), a, b > 0, 0 ≤ x ≤ 1, by \[DLMF 8.17.22\].
pub fn beta_regularized(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // The fraction converges fast below the mean; above it the mirrored one does.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_regularized(b, a, 1.0 - x);
    }
    let scale = (a * x.ln() + b * (1.0 - x).ln() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b)).exp() / a;
    let fraction = continued_fraction(1.0, |n| {
        let m = (n / 2) as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        (if n % 2 == 0 { even } else { odd }, 1.0)
    });
    scale / fraction
}

/// b₀ + a₁/(b₁ + a₂/(b₂ + …, the terms (aₙ, bₙ) given for n ≥ 1, by Lentz' method \[DLMF 3.10(iii)\].
fn continued_fraction(b0: f64, terms: impl Fn(usize) -> (f64, f64)) -> f64 {
    let nonzero = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let mut value = nonzero(b0);
    let (mut c, mut d) = (value, 0.0);
    for n in 1..MOST_TERMS {
        let (a, b) = terms(n);
        d = 1.0 / nonzero(b + a * d);
        c = nonzero(b + a / c);
        let factor = c * d;
        value *= factor;
        if (factor - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-11 * expected.abs().max(1e-3), "{found} for {expected}");
    }

    #[test]
    fn ln_gamma_of_integers_and_halves() {
        let mut factorial = 1.0f64;
        for n in 1..=30 {
            close(ln_gamma(f64::from(n)), factorial.ln());
            factorial *= f64::from(n);
        }
        close(ln_gamma(0.5), PI.sqrt().ln());
        close(ln_gamma(3.5), (15.0 / 8.0 * PI.sqrt()).ln());
    }

    #[test]
    fn gamma_q_in_closed_forms() {
        for x in [0.01, 0.3, 1.0, 2.5, 7.0, 20.0, 60.0] {
            close(gamma_q(1.0, x), (-x).exp());
            close(gamma_q(3.0, x), (-x).exp() * (1.0 + x + x * x / 2.0));
        }
        // Q(n, x) is a Poisson distribution function, here with many terms: both branches for large a.
        for x in [6000.0f64, 6399.0, 6402.0, 6600.0] {
            let poisson = |k: u32| (f64::from(k) * x.ln() - x - ln_gamma(f64::from(k) + 1.0)).exp();
            let sum: f64 = (0..6400).map(poisson).sum();
            assert!((gamma_q(6400.0, x) - sum).abs() < 1e-9, "{x}");
        }
        assert_eq!(gamma_q(2.0, 0.0), 1.0);
    }

    #[test]
    fn erfc_known_values() {
        close(erfc(0.0), 1.0);
        close(erfc(1.0), 0.157_299_207_050_285_13);
        close(erfc(-1.0), 1.842_700_792_949_715);
        close(erfc(3.0), 2.209_049_699_858_544e-5);
    }

    #[test]
    fn beta_in_closed_forms() {
        for x in [0.0, 0.1, 0.35, 0.5, 0.8, 0.99, 1.0] {
            close(beta_regularized(1.0, 1.0, x), x);
            close(beta_regularized(2.0, 3.0, x), x * x * (6.0 - 8.0 * x + 3.0 * x * x));
            close(beta_regularized(0.5, 0.5, x), 2.0 / PI * x.sqrt().asin());
        }
    }
}
