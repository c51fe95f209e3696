//! Goodness of fit: χ², Kolmogorov–Smirnov, many tests at once.

use crate::special::gamma_q;

/// Bins with fewer expected counts than this are pooled, as is the custom (and pbrt's): the statistic of
/// smaller ones does not follow the χ² distribution well.
const LEAST_EXPECTED: f64 = 5.0;
/// Share of all counts that may lie in bins where none is expected: rounding at the border of a support.
const STRAY_SHARE: f64 = 1e-5;

/// A test statistic and the probability of one at least as extreme if the hypothesis is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestResult {
    /// The statistic: z, t or the Kolmogorov distance.
    pub statistic: f64,
    /// In [0, 1]; 0 if the statistic is not finite.
    pub p_value: f64,
}

/// The outcome of a χ² test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Σ (observed − expected)² / expected over the bins left after pooling.
    pub statistic: f64,
    /// Bins left after pooling, less one.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least as large; 0 if counts lie where none may.
    pub p_value: f64,
    /// Number of bins that were pooled.
    pub pooled: usize,
}

/// Pearson's χ² test of observed counts against expected ones with the same sum.
///
/// Bins are pooled, smallest first, until each expects 5 counts or more. Counts where zero is expected make
/// the p-value 0 if they are more than 10⁻⁵ of all.
///
/// # Panics
/// If the slices differ in length, or an expected count is negative or not finite.
pub fn chi_square(observed: &[f64], expected: &[f64]) -> ChiSquare {
    assert_eq!(observed.len(), expected.len(), "as many observed as expected counts");
    assert!(
        expected.iter().all(|e| e.is_finite() && *e >= 0.0),
        "expected counts are finite and not negative"
    );
    let total: f64 = observed.iter().sum();
    let mut bins: Vec<(f64, f64)> = expected.iter().copied().zip(observed.iter().copied()).collect();
    bins.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut statistic, mut kept, mut pooled, mut stray) = (0.0, 0, 0, 0.0);
    let mut pool = (0.0, 0.0);
    for (expected, observed) in bins {
        if expected == 0.0 {
            stray += observed;
        } else if expected < LEAST_EXPECTED || (pool.0 > 0.0 && pool.0 < LEAST_EXPECTED) {
            pool = (pool.0 + expected, pool.1 + observed);
            pooled += 1;
        } else {
            statistic += (observed - expected) * (observed - expected) / expected;
            kept += 1;
        }
    }
    if pool.0 > 0.0 {
        statistic += (pool.1 - pool.0) * (pool.1 - pool.0) / pool.0;
        kept += 1;
    }
    let degrees_of_freedom = usize::saturating_sub(kept, 1);
    let p_value = if stray > total * STRAY_SHARE || !statistic.is_finite() {
        0.0
    } else if degrees_of_freedom == 0 {
        1.0
    } else {
        gamma_q(degrees_of_freedom as f64 / 2.0, statistic / 2.0)
    };
    ChiSquare { statistic, degrees_of_freedom, p_value, pooled }
}

/// [`chi_square`] against equal counts.
pub fn chi_square_uniform(observed: &[f64]) -> ChiSquare {
    let mean = observed.iter().sum::<f64>() / observed.len().max(1) as f64;
    chi_square(observed, &vec![mean; observed.len()])
}

/// The significance for each of `tests` independent tests such that all together have the significance
/// `alpha`: 1 − (1 − α)^(1/n).
pub fn sidak(alpha: f64, tests: usize) -> f64 {
    -((-alpha).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// The one-sample Kolmogorov–Smirnov test of independent samples against a continuous distribution function.
/// Sorts the samples. The p-value uses the limit distribution with Stephens' correction for finite n
/// (\[Stephens1970\]), good from about 10 samples on.
pub fn kolmogorov_smirnov(samples: &mut [f64], cdf: impl Fn(f64) -> f64) -> TestResult {
    samples.sort_by(f64::total_cmp);
    let n = samples.len() as f64;
    let mut distance = 0.0f64;
    for (i, &x) in samples.iter().enumerate() {
        let value = cdf(x);
        let (below, above) = (value - i as f64 / n, (i + 1) as f64 / n - value);
        if value.is_nan() {
            return TestResult { statistic: f64::NAN, p_value: 0.0 };
        }
        distance = distance.max(below).max(above);
    }
    let root = n.sqrt();
    TestResult {
        statistic: distance,
        p_value: kolmogorov_tail(distance * (root + 0.12 + 0.11 / root.max(1.0))),
    }
}

/// Probability that the limit of √n·D exceeds `t`: 2 Σ (−1)^(k−1) exp(−2k²t²).
fn kolmogorov_tail(t: f64) -> f64 {
    if t < 0.2 {
        return 1.0; // 1 − 10⁻¹²
    }
    let term = |k: i32| (-2.0 * f64::from(k * k) * t * t).exp() * if k % 2 == 0 { -2.0 } else { 2.0 };
    (1..=20).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pcg32;

    #[test]
    fn p_values_of_a_table() {
        // Critical values of the χ² table: 3.841459 (1 degree, 5 %), 23.20925 (10, 1 %).
        let one = chi_square(
            &[100.0 + 3.841_459f64.sqrt() * 50f64.sqrt(), 100.0 - 3.841_459f64.sqrt() * 50f64.sqrt()],
            &[100.0; 2],
        );
        assert!((one.p_value - 0.05).abs() < 1e-6, "{one:?}");
        assert_eq!(one.degrees_of_freedom, 1);
        let mut eleven = [1000.0; 11];
        let step = (23.209_25f64 * 1000.0 / 2.0).sqrt();
        eleven[3] += step;
        eleven[7] -= step;
        let result = chi_square_uniform(&eleven);
        assert!((result.p_value - 0.01).abs() < 1e-6, "{result:?}");
    }

    #[test]
    fn small_bins_are_pooled_and_strays_rejected() {
        let expected = [0.0, 1.0, 1.0, 1.0, 3.0, 20.0, 74.0];
        let observed = [0.0, 0.0, 2.0, 1.0, 3.0, 19.0, 75.0];
        let result = chi_square(&observed, &expected);
        assert_eq!((result.pooled, result.degrees_of_freedom), (4, 2));
        assert!(result.p_value > 0.5);
        let mut stray = observed;
        stray[0] = 1.0;
        assert_eq!(chi_square(&stray, &expected).p_value, 0.0);
        // A pool that stays below 5 takes the next bin in.
        let result = chi_square(&[2.0, 50.0, 48.0], &[2.0, 49.0, 49.0]);
        assert_eq!((result.pooled, result.degrees_of_freedom), (2, 1));
    }

    #[test]
    fn p_values_are_uniform_under_the_hypothesis() {
        // 400 χ² tests of fair dice; their p-values must look uniform (Kolmogorov–Smirnov, α = 0.001).
        let mut rng = Pcg32::new(1);
        let mut p_values: Vec<f64> = (0..400)
            .map(|_| {
                let mut counts = [0.0; 20];
                (0..4000).for_each(|_| counts[rng.below(20) as usize] += 1.0);
                chi_square_uniform(&counts).p_value
            })
            .collect();
        assert!(kolmogorov_smirnov(&mut p_values, |p| p).p_value > 0.001);
    }

    #[test]
    fn a_loaded_die_is_rejected() {
        let mut rng = Pcg32::new(2);
        let mut counts = [0.0; 6];
        for _ in 0..60_000 {
            let face = rng.below(6);
            let face = if face == 0 && rng.below(10) == 0 { 5 } else { face };
            counts[face as usize] += 1.0;
        }
        assert!(chi_square_uniform(&counts).p_value < 1e-6);
    }

    #[test]
    fn kolmogorov_known_tail() {
        // Critical values of the limit distribution: 1.3581 (5 %), 1.6276 (1 %).
        assert!((kolmogorov_tail(1.3581) - 0.05).abs() < 1e-5);
        assert!((kolmogorov_tail(1.6276) - 0.01).abs() < 1e-5);
        assert!(kolmogorov_tail(0.21) > 0.999_999_99);
        let mut wrong: Vec<f64> = (0..1000).map(|i| (f64::from(i) / 1000.0).powf(1.2)).collect();
        assert!(kolmogorov_smirnov(&mut wrong, |x| x).p_value < 0.001);
        assert_eq!(kolmogorov_smirnov(&mut [0.5], |_| f64::NAN).p_value, 0.0);
    }

    #[test]
    fn sidak_keeps_the_joint_significance() {
        for n in [1, 3, 12_800, 10_000_000] {
            let each = sidak(0.01, n);
            assert!(((n as f64 * (-each).ln_1p()).exp() - 0.99).abs() < 1e-12, "{n}");
        }
        assert_eq!(sidak(0.01, 1), 0.01);
    }
}
