//! Comparison of two noisy images.

use crate::{sidak, z_test};
use std::fmt;

/// Share of tests that must pass, as Mitsuba 3 and our golden images ask.
const PASSING_SHARE: f64 = 0.9975;
/// Standard deviation granted to every mean for the rounding of `f32` sums, relative to the mean.
const ROUNDING: f64 = 1e-6;

/// An estimated image: interleaved channels, rows from the top.
#[derive(Clone, Copy, Debug)]
pub struct MeanImage<'a> {
    /// Estimate per pixel and channel.
    pub mean: &'a [f32],
    /// Variance of that estimate (of the *mean*, not of one sample).
    pub variance: &'a [f32],
}

/// Extent of both images and of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values per pixel.
    pub channels: usize,
    /// Edge length of the square blocks in pixels, at least 1; blocks at the right and lower border may be
    /// smaller. 1 compares pixel by pixel, 8 sees fainter differences.
    pub block: usize,
}

/// One block whose means differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockDifference {
    /// Leftmost pixel of the block.
    pub x: usize,
    /// Uppermost pixel of the block.
    pub y: usize,
    /// Channel.
    pub channel: usize,
    /// Mean of the block in the first image.
    pub a: f64,
    /// Mean of the block in the second image.
    pub b: f64,
    /// Difference in standard deviations.
    pub z: f64,
}

/// The outcome of [`compare_blocks`].
#[derive(Clone, Debug, PartialEq)]
pub struct BlockReport {
    /// Number of Z-tests: blocks times channels.
    pub tests: usize,
    /// The tests that failed at the Šidák-corrected significance, in image order.
    pub failures: Vec<BlockDifference>,
}

impl BlockReport {
    /// Share of the tests passed.
    pub fn pass_share(&self) -> f64 {
        1.0 - self.failures.len() as f64 / self.tests.max(1) as f64
    }

    /// True if at least 99.75 % of the tests passed: a few may fail because variances are estimates
    /// themselves.
    pub fn passes(&self) -> bool {
        self.pass_share() >= PASSING_SHARE
    }
}

impl fmt::Display for BlockReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} blocks differ", self.failures.len(), self.tests)?;
        let mut worst: Vec<_> = self.failures.iter().collect();
        worst.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        for w in worst.iter().take(5) {
            write!(
                f,
                "\n  at ({}, {}) channel {}: {} and {}, z = {:.1}",
                w.x, w.y, w.channel, w.a, w.b, w.z
            )?;
        }
        Ok(())
    }
}

/// Compares the means of blocks of two independently estimated images by Z-tests, all together at
/// significance `alpha`. Values that are not finite fail their block.
///
/// # Panics
/// If a slice has not `width · height · channels` values or the block is empty.
pub fn compare_blocks(a: MeanImage<'_>, b: MeanImage<'_>, layout: Layout, alpha: f64) -> BlockReport {
    let Layout { width, height, channels, block } = layout;
    let size = width * height * channels;
    assert!(
        [a.mean, a.variance, b.mean, b.variance].iter().all(|s| s.len() == size),
        "every slice has {width} x {height} x {channels} values"
    );
    assert!(block > 0, "a block has pixels");
    let tests = width.div_ceil(block) * height.div_ceil(block) * channels;
    let each = sidak(alpha, tests);
    let mut failures = Vec::new();
    for y in (0..height).step_by(block) {
        for x in (0..width).step_by(block) {
            for channel in 0..channels {
                let (ma, va) = block_estimate(a, layout, x, y, channel);
                let (mb, vb) = block_estimate(b, layout, x, y, channel);
                let test = z_test(ma, va + vb, mb);
                if test.p_value < each {
                    failures.push(BlockDifference { x, y, channel, a: ma, b: mb, z: test.statistic });
                }
            }
        }
    }
    BlockReport { tests, failures }
}

/// Mean of a block and variance of that mean, of independent pixels.
fn block_estimate(image: MeanImage<'_>, layout: Layout, x: usize, y: usize, channel: usize) -> (f64, f64) {
    let (mut mean, mut variance, mut pixels) = (0.0, 0.0, 0.0);
    for row in y..(y + layout.block).min(layout.height) {
        for column in x..(x + layout.block).min(layout.width) {
            let i = (row * layout.width + column) * layout.channels + channel;
            mean += f64::from(image.mean[i]);
            variance += f64::from(image.variance[i]);
            pixels += 1.0;
        }
    }
    let mean = mean / pixels;
    (mean, variance / (pixels * pixels) + (ROUNDING * mean) * (ROUNDING * mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pcg32;

    const LAYOUT: Layout = Layout { width: 50, height: 37, channels: 3, block: 8 };

    /// Means of normal samples around a gradient, scaled at (x, y) by `gain`.
    fn noisy(seed: u64, gain: impl Fn(usize, usize) -> f64) -> (Vec<f32>, Vec<f32>) {
        let mut rng = Pcg32::new(seed);
        let (mut mean, mut variance) = (Vec::new(), Vec::new());
        for y in 0..LAYOUT.height {
            for x in 0..LAYOUT.width {
                for c in 0..LAYOUT.channels {
                    let deviation = 0.05 * (1 + c) as f64;
                    let truth = (0.5 + 0.01 * x as f64) * gain(x, y);
                    mean.push((truth + deviation * rng.next_normal()) as f32);
                    variance.push((deviation * deviation) as f32);
                }
            }
        }
        (mean, variance)
    }

    fn compare(a: &(Vec<f32>, Vec<f32>), b: &(Vec<f32>, Vec<f32>), block: usize) -> BlockReport {
        let image = |i| {
            let (mean, variance): &(Vec<f32>, Vec<f32>) = i;
            MeanImage { mean, variance }
        };
        compare_blocks(image(a), image(b), Layout { block, ..LAYOUT }, 0.01)
    }

    #[test]
    fn noise_alone_passes() {
        let (a, b) = (noisy(1, |_, _| 1.0), noisy(2, |_, _| 1.0));
        for block in [1, 8, 64] {
            let report = compare(&a, &b, block);
            assert!(report.failures.is_empty(), "block {block}: {report}");
        }
        assert_eq!(compare(&a, &b, 8).tests, 7 * 5 * 3);
    }

    #[test]
    fn a_faint_local_error_is_found_by_blocks() {
        // 8 % brighter in one corner: less than two deviations per pixel, many per block.
        let (a, b) = (noisy(1, |_, _| 1.0), noisy(2, |x, y| if x < 16 && y < 16 { 1.08 } else { 1.0 }));
        let report = compare(&a, &b, 8);
        assert!(!report.passes() && report.failures.len() >= 4, "{report}");
        assert!(report.failures.iter().all(|f| f.x < 16 && f.y < 16));
        assert!(compare(&a, &b, 1).passes(), "single pixels cannot see it");
    }

    #[test]
    fn exact_images_need_equality_up_to_rounding() {
        let exact = |v: f32| (vec![v; 50 * 37 * 3], vec![0.0; 50 * 37 * 3]);
        assert!(compare(&exact(0.25), &exact(0.25f32.next_up()), 8).passes());
        assert_eq!(compare(&exact(0.25), &exact(0.2501), 8).pass_share(), 0.0);
        assert_eq!(compare(&exact(0.0), &exact(f32::NAN), 8).pass_share(), 0.0);
    }
}
