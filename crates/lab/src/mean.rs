//! Means: running moments, Z-test, t-tests.

use crate::{
    TestResult,
    special::{beta_regularized, erfc},
};

/// Count, mean and variance of numbers seen one at a time \[Welford1962\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared distances from the mean.
    squares: f64,
}

impl Moments {
    /// Adds one number.
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// How many numbers were added.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; 0 if there are none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance of one number; 0 for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.squares / (self.count - 1) as f64 }
    }

    /// Variance of the mean; 0 for fewer than two.
    pub fn variance_of_mean(&self) -> f64 {
        self.variance() / self.count.max(1) as f64
    }
}

impl Extend<f64> for Moments {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, numbers: T) {
        numbers.into_iter().for_each(|v| self.push(v));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<T: IntoIterator<Item = f64>>(numbers: T) -> Self {
        let mut moments = Self::default();
        moments.extend(numbers);
        moments
    }
}

/// Two-sided test that a normal estimate with a known variance has the mean `expected`. Without variance,
/// equality counts.
pub fn z_test(estimate: f64, variance_of_estimate: f64, expected: f64) -> TestResult {
    let statistic = standardized(estimate - expected, variance_of_estimate);
    judged(statistic, |z| erfc(z * std::f64::consts::FRAC_1_SQRT_2))
}

/// Two-sided one-sample t-test that the numbers have the mean `expected`.
pub fn t_test(numbers: &Moments, expected: f64) -> TestResult {
    let freedom = numbers.count.saturating_sub(1) as f64;
    let statistic = standardized(numbers.mean - expected, numbers.variance_of_mean());
    judged(statistic, |t| student_two_sided(t, freedom))
}

/// Two-sided t-test that two sets of numbers have the same mean, whatever their variances (\[Welch1947\]).
pub fn welch_t_test(a: &Moments, b: &Moments) -> TestResult {
    let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
    let weight = |v: f64, m: &Moments| v * v / m.count.saturating_sub(1).max(1) as f64;
    let freedom = (va + vb) * (va + vb) / (weight(va, a) + weight(vb, b));
    judged(standardized(a.mean - b.mean, va + vb), |t| student_two_sided(t, freedom))
}

/// A difference in standard deviations; 0 for equal numbers without variance.
fn standardized(difference: f64, variance: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / variance.sqrt() }
}

fn judged(statistic: f64, two_sided: impl Fn(f64) -> f64) -> TestResult {
    let p_value = match statistic.abs() {
        0.0 => 1.0,
        size if size.is_finite() => two_sided(size),
        _ => 0.0,
    };
    TestResult { statistic, p_value }
}

/// P(|T| ≥ t) of Student's distribution.
fn student_two_sided(t: f64, freedom: f64) -> f64 {
    if freedom > 0.0 { beta_regularized(freedom / 2.0, 0.5, freedom / (freedom + t * t)) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pcg32, kolmogorov_smirnov};

    #[test]
    fn moments_of_known_numbers() {
        // A large offset would ruin the naive sum of squares.
        let m: Moments = [4.0, 7.0, 13.0, 16.0].iter().map(|v| v + 1e9).collect();
        assert_eq!((m.count(), m.mean(), m.variance()), (4, 1e9 + 10.0, 30.0));
        assert_eq!(m.variance_of_mean(), 7.5);
    }

    #[test]
    fn tails_of_tables() {
        assert!((z_test(1.959_964, 1.0, 0.0).p_value - 0.05).abs() < 1e-7);
        assert!((student_two_sided(2.570_582, 5.0) - 0.05).abs() < 1e-7);
        assert!((student_two_sided(63.656_74, 1.0) - 0.01).abs() < 1e-7);
        assert!((student_two_sided(1.96, 1e9) - z_test(1.96, 1.0, 0.0).p_value).abs() < 1e-8);
    }

    #[test]
    fn degenerate_data_is_judged_by_equality() {
        assert_eq!(z_test(1.0, 0.0, 1.0).p_value, 1.0);
        assert_eq!(z_test(1.0, 0.0, 1.1).p_value, 0.0);
        assert_eq!(z_test(f64::NAN, 1.0, 1.0).p_value, 0.0);
        assert_eq!(t_test(&[2.0].into_iter().collect(), 3.0).p_value, 0.0);
    }

    #[test]
    fn t_test_p_values_are_uniform_and_see_a_shift() {
        // α = 0.001; small samples, so that the normal approximation would fail.
        let mut rng = Pcg32::new(3);
        let mut draw =
            |n: usize, shift: f64| -> Moments { (0..n).map(|_| rng.next_normal() * 2.0 + shift).collect() };
        let mut one: Vec<f64> = (0..1000).map(|_| t_test(&draw(4, 5.0), 5.0).p_value).collect();
        assert!(kolmogorov_smirnov(&mut one, |p| p).p_value > 0.001);
        let mut two: Vec<f64> =
            (0..1000).map(|_| welch_t_test(&draw(12, 1.0), &draw(20, 1.0)).p_value).collect();
        assert!(kolmogorov_smirnov(&mut two, |p| p).p_value > 0.001);
        assert!(t_test(&draw(1000, 5.5), 5.0).p_value < 1e-6);
        assert!(welch_t_test(&draw(1000, 5.5), &draw(1000, 5.0)).p_value < 1e-4);
    }
}
