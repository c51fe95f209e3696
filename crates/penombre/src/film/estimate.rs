//! How far a film is from the image that it converges to, as its own two halves tell.

use super::{Film, PixelSum, Sum};

/// Keeps dark pixels from ruling relative errors: that of relMSE.
const DARK: f64 = 0.01;

/// Standard errors by which [`Estimate::bound`] lies above the square of [`Estimate::error`].
const CAUTION: f64 = 2.0;

/// The error of an image, estimated from two independently scrambled halves of each pixel's samples.
///
/// For the means A and B of n_A and n_B samples, (A − B)²·n_A·n_B/(n_A + n_B)² is an unbiased estimate of the variance of
/// the pixel's mean: ((A − B)/2)² for equal halves. It is worth little for one pixel, but the mean over all is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Relative standard error: the root of the mean over pixels and channels of variance / (mean² + 0.01). Its square
    /// is the relMSE to be expected against the converged image.
    pub error: f64,
    /// The same with two standard errors of that mean added below the root, as its scatter over the pixels tells them.
    /// The error lies below with a chance of about 98 %.
    pub bound: f64,
}

/// Variance of the mean of a pixel by channel; `None` unless both halves have samples.
pub(super) fn variance([even, odd]: &[PixelSum; 2]) -> Option<[f64; 3]> {
    if even.count == 0 || odd.count == 0 {
        return None;
    }
    let (a, b) = (f64::from(even.count), f64::from(odd.count));
    let share = a * b / ((a + b) * (a + b));
    Some(std::array::from_fn(|c| {
        let difference = even.rgb[c] / a - odd.rgb[c] / b;
        difference * difference * share
    }))
}

/// Mean over the channels of variance / (mean² + 0.01).
fn relative(halves: &[PixelSum; 2]) -> Option<f64> {
    let variance = variance(halves)?;
    let mut total = halves[0];
    total.add_sum(&halves[1]);
    let count = f64::from(total.count);
    let channel = |(v, sum): (f64, f64)| {
        let mean = sum / count;
        v / (mean * mean + DARK)
    };
    Some(variance.into_iter().zip(total.rgb).map(channel).sum::<f64>() / 3.0)
}

impl Film {
    /// The error of the image so far; `None` if no pixel has samples in two halves. Pixels that have not are left out.
    pub fn estimate(&self) -> Option<Estimate> {
        if self.odd.whole.is_empty() {
            return None;
        }
        let (mut count, mut sum, mut squares) = (0u64, 0.0, 0.0);
        for value in self.halves().filter_map(|halves| relative(&halves)) {
            count += 1;
            sum += value;
            squares += value * value;
        }
        let pixels = count as f64;
        let mean = sum / pixels;
        let scatter = (squares / pixels - mean * mean).max(0.0);
        let bound = (mean + CAUTION * (scatter / pixels).sqrt()).sqrt();
        (count > 0).then(|| Estimate { error: mean.sqrt(), bound })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Tile, TileSums};
    use super::*;
    use penombre_lab::{Pcg32, t_test};

    /// Samples of mean 1, 2 and 0 with deviations 0.5, 1 and 0.1, in halves of those sizes.
    fn noisy(edge: u32, halves: [u32; 2], seed: u64) -> Film {
        let mut random = Pcg32::new(seed);
        let tile = Tile { x0: 0, y0: 0, x1: edge, y1: edge };
        let mut sums = TileSums::new(tile.pixels(), true, false);
        for (plane, count) in [(&mut sums.color, halves[0]), (&mut sums.odd, halves[1])] {
            for pixel in plane {
                for _ in 0..count {
                    let mut channel = |mean: f64, deviation: f64| mean + deviation * random.next_normal();
                    for (sum, v) in
                        pixel.rgb.iter_mut().zip([channel(1.0, 0.5), channel(2.0, 1.0), channel(0.0, 0.1)])
                    {
                        *sum += v;
                    }
                    pixel.count += 1;
                }
            }
        }
        let mut film = Film::new(edge, edge, 1);
        film.merge(0, tile, 0, halves[0] + halves[1], sums);
        film
    }

    /// The mean estimate of a pixel's variance is the variance, for halves of equal and other sizes.
    #[test]
    fn the_variance_is_unbiased() {
        for (halves, seed) in [([8, 8], 1), ([3, 2], 2), ([1, 1], 3)] {
            let film = noisy(100, halves, seed);
            let n = f64::from(halves[0] + halves[1]);
            for (channel, deviation) in [0.5, 1.0, 0.1].into_iter().enumerate() {
                let mut found = penombre_lab::Moments::default();
                film.halves().filter_map(|h| variance(&h)).for_each(|v| found.push(v[channel]));
                let test = t_test(&found, deviation * deviation / n);
                assert!(test.p_value > penombre_lab::sidak(0.01, 9), "{halves:?} {channel}: {test:?}");
            }
        }
    }

    /// With many samples the error is the root of the mean of σ²/n/(μ² + 0.01), and the bound covers it.
    #[test]
    fn the_error_is_the_root_of_the_expected_relative_square() {
        let n = 64.0;
        let exact = f64::sqrt((0.25 / 1.01 + 1.0 / 4.01 + 0.01 / 0.01) / 3.0 / n);
        let found = noisy(60, [32, 32], 9).estimate().unwrap();
        // σ²/n is 1/64 of the 0.01 beside the square of the mean of the third channel: that bias is 1.5 %.
        assert!((found.error / exact - 1.0).abs() < 0.03, "{found:?} {exact}");
        assert!(found.bound > found.error && found.bound < found.error * 1.1, "{found:?}");
        // The bound lies above the error almost always: of 100 films of 400 pixels, 2 are expected below.
        let exact = exact * std::f64::consts::SQRT_2;
        let below = (0..100).filter(|seed| noisy(20, [16, 16], *seed).estimate().unwrap().bound < exact);
        assert!(below.count() <= 7);
    }

    #[test]
    fn no_halves_no_estimate() {
        assert_eq!(Film::new(3, 3, 1).estimate(), None);
        assert_eq!(noisy(4, [5, 0], 1).estimate(), None);
        let flat = noisy(4, [1, 1], 1);
        assert!(flat.estimate().is_some());
    }
}
