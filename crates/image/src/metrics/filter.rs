//! Separable filters on planes of pixels.

use penombre_math::float;
use std::ops::{AddAssign, Mul};

/// One number for each pixel, top row first.
#[derive(Clone)]
pub struct Plane<T> {
    pub width: usize,
    pub height: usize,
    pub data: Vec<T>,
}

impl<T: Copy + Default + Mul<Output = T> + AddAssign> Plane<T> {
    /// The plane with `row` applied along rows, then `column` along columns. Both have an odd number of weights, the middle
    /// one for the pixel itself; beyond the edge stands the value of the edge.
    pub fn filtered(&self, row: &[T], column: &[T]) -> Self {
        let (w, h) = (self.width, self.height);
        let mut rows = Vec::with_capacity(self.data.len());
        for line in self.data.chunks_exact(w) {
            let radius = row.len() / 2;
            for x in 0..w {
                let mut sum = T::default();
                for (k, g) in row.iter().enumerate() {
                    sum += *g * line[(x + k).saturating_sub(radius).min(w - 1)];
                }
                rows.push(sum);
            }
        }
        let mut data = Vec::with_capacity(rows.len());
        for y in 0..h {
            let radius = column.len() / 2;
            let start = data.len();
            data.resize(start + w, T::default());
            for (k, g) in column.iter().enumerate() {
                let from = (y + k).saturating_sub(radius).min(h - 1) * w;
                for (out, v) in data[start..].iter_mut().zip(&rows[from..from + w]) {
                    *out += *g * *v;
                }
            }
        }
        Self { width: w, height: h, data }
    }
}

/// e^(−x²/(2σ²)) for x from −radius to radius.
pub fn gaussian(sigma: f32, radius: usize) -> Vec<f32> {
    let x = |i: usize| i as f32 - radius as f32;
    (0..=2 * radius).map(|i| float::exp(-x(i) * x(i) / (2.0 * sigma * sigma))).collect()
}

/// The weights divided by their sum.
pub fn normalised(weights: &[f32]) -> Vec<f32> {
    let sum: f32 = weights.iter().sum();
    weights.iter().map(|g| g / sum).collect()
}
