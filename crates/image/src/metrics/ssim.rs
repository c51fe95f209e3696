//! Structural similarity \[Wang2004\].

use super::filter::{Plane, gaussian};
use crate::image::Image;
use crate::tone::srgb;
use penombre_math::color::luminance;

/// Half the window: 11 × 11 pixels.
const RADIUS: usize = 5;
const SIGMA: f32 = 1.5;
/// Constants of the paper for values from 0 to 1: (0.01)² and (0.03)².
const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// Mean over the windows that lie inside the image; where an image is smaller than a window, over all pixels, with the edge
/// repeated.
pub fn mean_ssim(a: &Image, b: &Image) -> f64 {
    let (a, b) = (plane(a), plane(b));
    let weights: Vec<f64> = gaussian(SIGMA, RADIUS).into_iter().map(f64::from).collect();
    let total: f64 = weights.iter().sum();
    let weights: Vec<f64> = weights.into_iter().map(|g| g / total).collect();
    let blur = |p: &Plane<f64>| p.filtered(&weights, &weights).data;
    let product = |p: &Plane<f64>, q: &Plane<f64>| {
        let data = p.data.iter().zip(&q.data).map(|(p, q)| p * q).collect();
        blur(&Plane { data, ..*p })
    };
    let (mean_a, mean_b) = (blur(&a), blur(&b));
    let (aa, bb, ab) = (product(&a, &a), product(&b, &b), product(&a, &b));
    let margin = |n: usize| if n > 2 * RADIUS { RADIUS..n - RADIUS } else { 0..n };
    let (mut sum, mut count) = (0.0, 0u64);
    for y in margin(a.height) {
        for x in margin(a.width) {
            let i = y * a.width + x;
            let [ma, mb, aa, bb, ab] = [mean_a[i], mean_b[i], aa[i], bb[i], ab[i]];
            let (va, vb, cov) = (aa - ma * ma, bb - mb * mb, ab - ma * mb);
            sum += (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2));
            count += 1;
        }
    }
    sum / count as f64
}

/// sRGB-encoded luminance. In `f64`: a variance is a small difference of large numbers.
fn plane(image: &Image) -> Plane<f64> {
    let data = image.rgb_pixels().map(|rgb| f64::from(srgb(luminance(rgb)))).collect();
    Plane { width: image.width() as usize, height: image.height() as usize, data }
}
