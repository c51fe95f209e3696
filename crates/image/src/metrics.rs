//! How far apart two images are.
//!
//! Alpha is left out, grey is taken as colour. Sums run in `f64` in pixel order, so the numbers are the same everywhere.

mod filter;
mod flip;
mod ssim;
#[cfg(test)]
mod tests;

use crate::image::Image;
use penombre_math::float;

/// Pixels per degree of the viewing conditions [`compare`] assumes for FLIP: a screen 3840 pixels and 0.7 m wide, seen
/// from 0.7 m (the default of \[Andersson2020\]).
pub const PIXELS_PER_DEGREE: f32 = 67.020_64;

/// The differences of an image from a reference.
///
/// `mse` to `mean_ratio` are of linear values, over red, green and blue of all pixels that are finite in both images; they
/// are NaN if there is no such pixel. `ssim` and `flip` are of what a screen would show: values cut to 0…1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of (a − b)².
    pub mse: f64,
    /// Root of `mse`.
    pub rmse: f64,
    /// Mean of (a − b)² / (b² + 0.01), b the reference.
    pub rel_mse: f64,
    /// 10 log₁₀(1 / mse), in decibels: the peak is 1. Infinite for equal images.
    pub psnr: f64,
    /// Mean structural similarity \[Wang2004\] of the sRGB-encoded luminance, 11 × 11 Gaussian window with σ = 1.5, over
    /// windows inside the image: 1 for equal images.
    pub ssim: f64,
    /// Mean FLIP error \[Andersson2020\] at [`PIXELS_PER_DEGREE`], 0 (equal) to 1.
    pub flip: f64,
    /// Largest |a − b|.
    pub max_abs: f64,
    /// Mean of a over mean of b; 1 if both are 0.
    pub mean_ratio: f64,
    /// Pixels with NaN or infinity in either image.
    pub non_finite: u64,
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The sizes differ.
    #[error("the images have different sizes: {}×{} and {}×{} pixels", a.0, a.1, b.0, b.1)]
    Size {
        /// Width and height of the first image.
        a: (u32, u32),
        /// Width and height of the second image.
        b: (u32, u32),
    },
    /// There are no pixels.
    #[error("the images have no pixels")]
    Empty,
}

/// All differences of `a` from the reference `b`.
///
/// # Errors
///
/// If the sizes differ, or there are no pixels.
pub fn compare(a: &Image, b: &Image) -> Result<Comparison, CompareError> {
    check(a, b)?;
    let sums = Sums::of(a, b);
    let count = sums.count as f64;
    let mse = sums.square / count;
    let mean_ratio = if sums.a == sums.b { 1.0 } else { sums.a / sums.b };
    Ok(Comparison {
        mse,
        rmse: mse.sqrt(),
        rel_mse: sums.relative / count,
        psnr: psnr(mse),
        ssim: ssim::mean_ssim(a, b),
        flip: mean(&flip::flip(a, b, PIXELS_PER_DEGREE)),
        max_abs: if sums.count == 0 { f64::NAN } else { sums.max_abs },
        mean_ratio: if sums.count == 0 { f64::NAN } else { mean_ratio },
        non_finite: sums.non_finite,
    })
}

/// The FLIP error of each pixel (one channel, 0 to 1) of `a` against the reference `b` at [`PIXELS_PER_DEGREE`].
///
/// # Errors
///
/// If the sizes differ, or there are no pixels.
pub fn flip_map(a: &Image, b: &Image) -> Result<Image, CompareError> {
    check(a, b)?;
    Ok(map(a, flip::flip(a, b, PIXELS_PER_DEGREE)))
}

/// The largest |a − b| over red, green and blue of each pixel (one channel); NaN where either image is not finite.
///
/// # Errors
///
/// If the sizes differ, or there are no pixels.
pub fn error_map(a: &Image, b: &Image) -> Result<Image, CompareError> {
    check(a, b)?;
    let difference = |(a, b): ([f32; 3], [f32; 3])| {
        if !is_finite(a, b) {
            return f32::NAN;
        }
        (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)
    };
    Ok(map(a, a.rgb_pixels().zip(b.rgb_pixels()).map(difference).collect()))
}

fn check(a: &Image, b: &Image) -> Result<(), CompareError> {
    let (size_a, size_b) = ((a.width(), a.height()), (b.width(), b.height()));
    if size_a != size_b {
        return Err(CompareError::Size { a: size_a, b: size_b });
    }
    if a.pixel_count() == 0 { Err(CompareError::Empty) } else { Ok(()) }
}

fn map(like: &Image, data: Vec<f32>) -> Image {
    Image::from_data(like.width(), like.height(), 1, data).expect("one value for each pixel")
}

fn is_finite(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().chain(&b).all(|v| v.is_finite())
}

/// Sums over the finite pixels.
#[derive(Default)]
struct Sums {
    /// Samples (three for each pixel) in the sums.
    count: u64,
    non_finite: u64,
    square: f64,
    relative: f64,
    max_abs: f64,
    a: f64,
    b: f64,
}

impl Sums {
    fn of(a: &Image, b: &Image) -> Self {
        let mut sums = Self::default();
        for (a, b) in a.rgb_pixels().zip(b.rgb_pixels()) {
            if !is_finite(a, b) {
                sums.non_finite += 1;
                continue;
            }
            for (a, b) in a.into_iter().zip(b) {
                let (a, b) = (f64::from(a), f64::from(b));
                let square = (a - b) * (a - b);
                sums.count += 1;
                sums.square += square;
                sums.relative += square / (b * b + 0.01);
                sums.max_abs = sums.max_abs.max((a - b).abs());
                sums.a += a;
                sums.b += b;
            }
        }
        sums
    }
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

fn psnr(mse: f64) -> f64 {
    if mse == 0.0 {
        return f64::INFINITY;
    }
    if !mse.is_finite() {
        return if mse.is_nan() { f64::NAN } else { f64::NEG_INFINITY };
    }
    // log₂ of fraction and exponent apart: a mean square may be far below the range of f32.
    let bits = mse.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32 - 1023;
    let fraction = f64::from_bits(bits & ((1 << 52) - 1) | 1023 << 52);
    let log2 = f64::from(exponent) + f64::from(float::log2(fraction as f32));
    -10.0 * std::f64::consts::LOG10_2 * log2
}
