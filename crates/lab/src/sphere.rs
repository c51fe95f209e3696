//! Does a sampler of directions follow the density it claims?

use crate::{ChiSquare, Pcg32, chi_square};
use std::{f64::consts::PI, fmt};

/// Absolute error allowed in the expected share of one bin, and relative error.
const ABSOLUTE: f64 = 1e-8;
const RELATIVE: f64 = 1e-4;
/// A bin is halved in both angles at most this often.
const DEEPEST: u32 = 9;
/// A bin whose count is off by more than 3 deviations at first, or that has counts but no density, is integrated
/// again, halved at least this often: a narrow lobe or the edge of a support may have slipped between the nodes.
/// A right density only gains from that.
const DEEP: u32 = 4;
/// The same for a bin with directions in which no density was seen: the corner of a shape with sharp borders may
/// have slipped between the nodes.
const DEEPER: u32 = 7;
/// Error granted to the integral of the density.
const MASS_TOLERANCE: f64 = 2e-3;

/// Settings of a check; the default is pbrt's: 10⁶ samples in 80 × 160 bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DensityCheck {
    /// Number of samples drawn.
    pub samples: u32,
    /// Bins in θ, equal in angle. Even, so that the horizon z = 0 is a border.
    pub theta_bins: usize,
    /// Bins in φ.
    pub phi_bins: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for DensityCheck {
    fn default() -> Self {
        Self { samples: 1_000_000, theta_bins: 80, phi_bins: 160, seed: 1 }
    }
}

/// The outcome of a [`DensityCheck`].
#[derive(Clone, Debug, PartialEq)]
pub struct DensityReport {
    /// The test of shape: counts of the bins against the density, scaled to the number of directions that
    /// came.
    pub shape: ChiSquare,
    /// Integral of the density over the sphere.
    pub integral: f64,
    /// Share of the samples that gave a direction; should be the integral.
    pub hit_share: f64,
    /// Standard deviation of `hit_share`.
    pub hit_deviation: f64,
    /// Directions that are not finite or not of length 1 within 10⁻⁴ (not counted in the bins).
    pub bad_directions: u32,
    /// Density values that were negative or not finite (taken as 0).
    pub bad_densities: u32,
    /// The bins that are off most.
    pub worst: Vec<BinDifference>,
}

/// One bin of the histogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinDifference {
    /// θ of its middle, in radians from +z.
    pub theta: f64,
    /// φ of its middle, in radians from +x towards +y, in [0, 2π).
    pub phi: f64,
    /// Directions counted.
    pub observed: f64,
    /// Directions the density promises.
    pub expected: f64,
}

impl DensityReport {
    /// True if nothing is wrong at significance `alpha` (for several checks use [`crate::sidak`]): all values
    /// are sound, the shape fits, and directions come as often as the integral of the density says.
    pub fn passes(&self, alpha: f64) -> bool {
        let mass_error = (self.hit_share - self.integral).abs();
        self.bad_directions == 0
            && self.bad_densities == 0
            && mass_error <= MASS_TOLERANCE + 5.0 * self.hit_deviation
            && self.shape.p_value >= alpha
    }
}

impl fmt::Display for DensityReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ChiSquare { statistic, degrees_of_freedom, p_value, pooled } = self.shape;
        writeln!(
            f,
            "chi² {statistic:.1}, {degrees_of_freedom} degrees of freedom, {pooled} bins pooled: p = {p_value:.3e}"
        )?;
        writeln!(
            f,
            "integral of the density {:.5}, share of samples with a direction {:.5} ± {:.5}",
            self.integral, self.hit_share, self.hit_deviation
        )?;
        writeln!(f, "bad directions {}, bad densities {}", self.bad_directions, self.bad_densities)?;
        for b in &self.worst {
            let (theta, phi) = (b.theta.to_degrees(), b.phi.to_degrees());
            writeln!(f, "  θ {theta:.2}° φ {phi:.2}°: {} counted, {:.1} expected", b.observed, b.expected)?;
        }
        Ok(())
    }
}

/// [`DensityCheck::run`] with pbrt's settings and a seed.
pub fn check_density(
    seed: u64,
    sample: impl FnMut(&mut Pcg32) -> Option<[f32; 3]>,
    pdf: impl FnMut([f32; 3]) -> f32,
) -> DensityReport {
    DensityCheck { seed, ..DensityCheck::default() }.run(sample, pdf)
}

impl DensityCheck {
    /// Draws directions, counts them in bins, and compares the counts with the integral of the density over
    /// each bin.
    ///
    /// `sample` returns a unit direction (`None`: absorbed), `pdf` its density per solid angle, which may
    /// integrate to less than 1 if `sample` returns `None` accordingly. Leave perfectly specular parts out of
    /// both. The sampler should use independent numbers from the generator: stratified ones make counts too
    /// even.
    pub fn run(
        &self,
        mut sample: impl FnMut(&mut Pcg32) -> Option<[f32; 3]>,
        mut pdf: impl FnMut([f32; 3]) -> f32,
    ) -> DensityReport {
        let counted = self.count(&mut sample);
        let mut bad_densities = 0;
        let mut integrand = |theta: f64, phi: f64| {
            let (sin, cos) = theta.sin_cos();
            let density = f64::from(pdf([(sin * phi.cos()) as f32, (sin * phi.sin()) as f32, cos as f32]));
            let sound = density >= 0.0 && density.is_finite();
            bad_densities += u32::from(!sound);
            if sound { density * sin } else { 0.0 }
        };
        let shares: Vec<f64> =
            (0..counted.bins.len()).map(|i| self.share(i, counted.bins[i], &mut integrand)).collect();
        let integral: f64 = shares.iter().sum();
        let hits: f64 = counted.bins.iter().sum();
        let scale = if integral > 0.0 { hits / integral } else { 0.0 };
        let expected: Vec<f64> = shares.iter().map(|s| s * scale).collect();
        let n = f64::from(self.samples.max(1));
        let hit_share = hits / n;
        DensityReport {
            shape: chi_square(&counted.bins, &expected),
            integral,
            hit_share,
            hit_deviation: (hit_share * (1.0 - hit_share) / n).max(0.0).sqrt(),
            bad_directions: counted.bad,
            bad_densities,
            worst: self.worst(&counted.bins, &expected),
        }
    }

    fn count(&self, sample: &mut impl FnMut(&mut Pcg32) -> Option<[f32; 3]>) -> Counted {
        let mut rng = Pcg32::new(self.seed);
        let mut counted = Counted { bins: vec![0.0; self.theta_bins * self.phi_bins], bad: 0 };
        for _ in 0..self.samples {
            let Some(direction) = sample(&mut rng) else { continue };
            let [x, y, z] = direction.map(f64::from);
            let length = (x * x + y * y + z * z).sqrt();
            let unit = (length - 1.0).abs() < 1e-4; // false for NaN
            if !unit {
                counted.bad += 1;
                continue;
            }
            let theta = (x * x + y * y).sqrt().atan2(z);
            let phi = y.atan2(x).rem_euclid(2.0 * PI);
            let row = ((theta / PI * self.theta_bins as f64) as usize).min(self.theta_bins - 1);
            let column = ((phi / (2.0 * PI) * self.phi_bins as f64) as usize).min(self.phi_bins - 1);
            counted.bins[row * self.phi_bins + column] += 1.0;
        }
        counted
    }

    /// The share of all samples that the density puts into a bin.
    fn share(&self, index: usize, observed: f64, f: &mut impl FnMut(f64, f64) -> f64) -> f64 {
        let n = f64::from(self.samples);
        let patch = self.patch(index);
        let whole = patch.gauss(f);
        let share = patch.adaptive(f, whole, 0, 0);
        if share == 0.0 && observed > 0.0 {
            return patch.adaptive(f, share, 0, DEEPER);
        }
        let off = (share * n - observed).abs();
        let missed = share == 0.0 && observed > 0.0;
        let doubtful = missed || off > 3.0 * (share * n).max(observed).sqrt();
        if doubtful { patch.adaptive(f, share, 0, DEEP) } else { share }
    }

    fn patch(&self, index: usize) -> Patch {
        let (height, width) = (PI / self.theta_bins as f64, 2.0 * PI / self.phi_bins as f64);
        let (row, column) = (index / self.phi_bins, index % self.phi_bins);
        let (theta, phi) = ((row as f64 + 0.5) * height, (column as f64 + 0.5) * width);
        Patch { theta, phi, half_height: height / 2.0, half_width: width / 2.0 }
    }

    /// The five bins that add most to the statistic.
    fn worst(&self, observed: &[f64], expected: &[f64]) -> Vec<BinDifference> {
        let weight = |&i: &usize| (observed[i] - expected[i]).powi(2) / expected[i].max(1.0);
        let mut order: Vec<usize> = (0..observed.len()).collect();
        order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let difference = |i: usize| {
            let Patch { theta, phi, .. } = self.patch(i);
            BinDifference { theta, phi, observed: observed[i], expected: expected[i] }
        };
        order.into_iter().take(5).map(difference).collect()
    }
}

/// A histogram of directions.
struct Counted {
    bins: Vec<f64>,
    bad: u32,
}

/// A rectangle of angles by its middle.
#[derive(Clone, Copy)]
struct Patch {
    theta: f64,
    phi: f64,
    half_height: f64,
    half_width: f64,
}

impl Patch {
    /// Gauss–Legendre quadrature with 3 × 3 nodes.
    fn gauss(&self, f: &mut impl FnMut(f64, f64) -> f64) -> f64 {
        let node = 0.6f64.sqrt();
        let rule = [(-node, 5.0 / 9.0), (0.0, 8.0 / 9.0), (node, 5.0 / 9.0)];
        let mut sum = 0.0;
        for (t, wt) in rule {
            for (p, wp) in rule {
                sum += wt * wp * f(self.theta + t * self.half_height, self.phi + p * self.half_width);
            }
        }
        sum * self.half_height * self.half_width
    }

    /// Halves both angles until the sum of the quarters agrees with the whole.
    fn adaptive(&self, f: &mut impl FnMut(f64, f64) -> f64, whole: f64, depth: u32, least_depth: u32) -> f64 {
        let (half_height, half_width) = (self.half_height / 2.0, self.half_width / 2.0);
        let quarters = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].map(|(t, p)| Patch {
            theta: self.theta + t * half_height,
            phi: self.phi + p * half_width,
            half_height,
            half_width,
        });
        let parts = quarters.map(|q| q.gauss(f));
        let sum: f64 = parts.iter().sum();
        let settled = (sum - whole).abs() <= ABSOLUTE + RELATIVE * sum.abs();
        if (settled && depth >= least_depth) || depth >= DEEPEST {
            return sum;
        }
        (0..4).map(|i| quarters[i].adaptive(f, parts[i], depth + 1, least_depth)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const ALPHA: f64 = 0.01;

    fn polar(cos: f64, phi: f64) -> [f32; 3] {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        [(sin * phi.cos()) as f32, (sin * phi.sin()) as f32, cos as f32]
    }

    /// A lobe cosⁿ around +z.
    fn lobe(exponent: f64) -> impl FnMut(&mut Pcg32) -> Option<[f32; 3]> {
        move |rng| Some(polar(rng.next_f64().powf(1.0 / (exponent + 1.0)), 2.0 * PI * rng.next_f64()))
    }

    fn lobe_pdf(exponent: f64) -> impl FnMut([f32; 3]) -> f32 {
        move |w| ((exponent + 1.0) / (2.0 * PI) * f64::from(w[2].max(0.0)).powf(exponent)) as f32
    }

    fn tilted(v: [f32; 3], angle: f32) -> [f32; 3] {
        let (s, c) = angle.sin_cos();
        [c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]]
    }

    #[test]
    fn right_densities_pass() {
        let uniform = |rng: &mut Pcg32| Some(polar(1.0 - 2.0 * rng.next_f64(), 2.0 * PI * rng.next_f64()));
        let report = check_density(1, uniform, |_| (0.25 / PI) as f32);
        assert!(report.passes(ALPHA) && report.shape.degrees_of_freedom > 12_000, "{report}");
        for exponent in [1.0, 50.0] {
            let report = check_density(2, lobe(exponent), lobe_pdf(exponent));
            assert!(report.passes(ALPHA), "exponent {exponent}: {report}");
        }
    }

    #[test]
    fn a_lobe_narrower_than_a_bin_passes() {
        // Tilted away from the pole; its width is 0.006 rad, that of a bin 0.04.
        let (angle, exponent) = (0.7, 30_000.0);
        let mut straight = (lobe(exponent), lobe_pdf(exponent));
        let report = check_density(
            3,
            |rng| straight.0(rng).map(|w| tilted(w, angle)),
            |w| straight.1(tilted(w, -angle)),
        );
        assert!(report.passes(ALPHA), "{report}");
        assert!((report.integral - 1.0).abs() < 1e-3, "{report}");
    }

    #[test]
    fn a_shape_that_reaches_into_a_bin_by_a_corner_passes() {
        // Uniform over θ in 0.5..1.0 and φ in a little less than 1 bin to a little more than 9.
        let bin = 2.0 * PI / 160.0;
        let (from, to) = (0.98 * bin, 9.02 * bin);
        let (high, low) = (0.5f64.cos(), 1.0f64.cos());
        let within = move |rng: &mut Pcg32| {
            Some(polar(low + (high - low) * rng.next_f64(), from + (to - from) * rng.next_f64()))
        };
        let density = move |w: [f32; 3]| {
            let (z, phi) = (f64::from(w[2]), f64::from(w[1]).atan2(f64::from(w[0])));
            let inside = z <= high && z >= low && phi >= from && phi <= to;
            if inside { (1.0 / ((high - low) * (to - from))) as f32 } else { 0.0 }
        };
        let report = check_density(7, within, density);
        assert!(report.passes(ALPHA), "{report}");
    }

    #[test]
    fn wrong_shapes_are_rejected() {
        let quick = DensityCheck { samples: 200_000, seed: 4, ..DensityCheck::default() };
        assert!(!quick.run(lobe(1.0), lobe_pdf(1.1)).passes(ALPHA), "another exponent");
        assert!(!quick.run(lobe(1.0), |w| 1.05 * lobe_pdf(1.0)(w)).passes(ALPHA), "does not integrate to 1");
        let mut straight = lobe_pdf(20.0);
        let report = quick.run(lobe(20.0), |w| straight(tilted(w, 0.02)));
        assert!(report.shape.p_value < 1e-6, "tilted by 1.1°: {report}");
        let below = |w: [f32; 3]| if w[2] > 0.0 { lobe_pdf(1.0)(w) } else { 0.0 };
        let mut every = 0;
        let mut stray = lobe(1.0);
        let leaking = |rng: &mut Pcg32| {
            every += 1;
            stray(rng).map(|w| if every % 1000 == 0 { [w[0], w[1], -w[2]] } else { w })
        };
        let report = quick.run(leaking, below);
        assert_eq!(report.shape.p_value, 0.0, "directions where the density is zero: {report}");
    }

    #[test]
    fn absorption_must_match_the_mass() {
        let quick = DensityCheck { samples: 200_000, seed: 5, ..DensityCheck::default() };
        let absorbing = |rng: &mut Pcg32| (rng.next_f64() < 0.7).then(|| lobe(1.0)(rng)).flatten();
        assert!(quick.run(absorbing, |w| 0.7 * lobe_pdf(1.0)(w)).passes(ALPHA));
        assert!(!quick.run(absorbing, |w| 0.72 * lobe_pdf(1.0)(w)).passes(ALPHA));
    }

    #[test]
    fn unsound_values_fail() {
        let quick = DensityCheck { samples: 1000, theta_bins: 8, phi_bins: 16, seed: 6 };
        let long = quick.run(|_| Some([0.0, 0.0, 1.1]), |_| 0.1);
        assert_eq!((long.bad_directions, long.passes(0.0)), (1000, false));
        let report = quick.run(lobe(1.0), |w| if w[0] > 0.9 { f32::NAN } else { lobe_pdf(1.0)(w) });
        assert!(report.bad_densities > 0 && !report.passes(0.0));
    }

    #[test]
    fn bins_are_where_the_report_says() {
        let check = DensityCheck { samples: 10, ..DensityCheck::default() };
        for (direction, theta, phi) in [
            ([0.0, 0.0, 1.0], 0.0, 0.0),
            ([0.0, 1.0, 0.0], FRAC_PI_2, FRAC_PI_2),
            ([0.0, -1.0, 0.0], FRAC_PI_2, 1.5 * PI),
        ] {
            let worst = check.run(|_| Some(direction), |_| 0.0).worst[0];
            assert_eq!(worst.observed, 10.0);
            assert!((worst.theta - theta).abs() < 0.021 && (worst.phi - phi).abs() < 0.021, "{worst:?}");
        }
    }
}
