//! Random numbers for tests.

/// The generator PCG XSH RR 64/32 of \[ONeill2014\]: small, deterministic, good enough for any test here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pcg32 {
    state: u64,
    increment: u64,
}

impl Pcg32 {
    /// The stream numbered 0 of a seed.
    pub fn new(seed: u64) -> Self {
        Self::with_stream(seed, 0)
    }

    /// One of 2⁶³ streams of a seed; the top bit of `stream` is lost.
    pub fn with_stream(seed: u64, stream: u64) -> Self {
        let mut rng = Self { state: 0, increment: stream << 1 | 1 };
        rng.next_u32();
        rng.state = rng.state.wrapping_add(seed);
        rng.next_u32();
        rng
    }

    /// 32 random bits.
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(self.increment);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        u64::from(self.next_u32()) << 32 | u64::from(self.next_u32())
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 / 16_777_216.0
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    pub fn next_f64(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in `0..bound` (0 if `bound` is 0), without bias: \[Lemire2019\]'s rejection.
    pub fn below(&mut self, bound: u32) -> u32 {
        let least = bound.wrapping_neg().checked_rem(bound).unwrap_or(0);
        loop {
            let product = u64::from(self.next_u32()) * u64::from(bound);
            if product as u32 >= least {
                return (product >> 32) as u32;
            }
        }
    }

    /// Standard normal, by the polar method \[Marsaglia1964\].
    pub fn next_normal(&mut self) -> f64 {
        loop {
            let (x, y) = (2.0 * self.next_f64() - 1.0, 2.0 * self.next_f64() - 1.0);
            let r2 = x * x + y * y;
            if r2 > 0.0 && r2 < 1.0 {
                return x * (-2.0 * r2.ln() / r2).sqrt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{chi_square_uniform, kolmogorov_smirnov};

    #[test]
    fn first_numbers_are_those_of_the_reference_demo() {
        // Output of the reference implementation's demo program: seed 42, stream 54.
        let mut rng = Pcg32::with_stream(42, 54);
        let expected = [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293, 0xbfa4_784b, 0xcbed_606e];
        assert_eq!(expected.map(|_| rng.next_u32()), expected);
    }

    #[test]
    fn bounded_numbers_are_uniform() {
        // α = 0.001
        let mut rng = Pcg32::new(7);
        let mut counts = [0.0; 37];
        (0..100_000).for_each(|_| counts[rng.below(37) as usize] += 1.0);
        assert!(chi_square_uniform(&counts).p_value > 0.001);
        assert_eq!(rng.below(0), 0);
        assert_eq!(rng.below(1), 0);
    }

    #[test]
    fn normals_follow_the_normal_distribution() {
        // α = 0.001
        let mut rng = Pcg32::new(8);
        let mut values: Vec<f64> = (0..20_000).map(|_| rng.next_normal()).collect();
        let normal = |x: f64| 0.5 * crate::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
        assert!(kolmogorov_smirnov(&mut values, normal).p_value > 0.001);
        let shifted = |x: f64| normal(x - 0.05);
        assert!(kolmogorov_smirnov(&mut values, shifted).p_value < 0.001);
    }
}
