//! Piecewise constant distributions, sampled by inversion.
//!
//! Probabilities are whole multiples of 2⁻²⁴, the grain of the uniform numbers: what `pdf` says is exactly
//! what `sample` does, not a rounding of it. A bin of zero weight is never sampled, a bin of positive weight
//! always can be, however small it is beside the others (for up to 2²² bins): the estimates stay unbiased.

use crate::Vec2;

/// The number of grains of probability.
const GRAINS: u32 = 1 << 24;

/// A point drawn from a [`Distribution1D`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample1D {
    /// The point, in [0, 1).
    pub x: f32,
    /// Density at `x` with respect to length on [0, 1].
    pub pdf: f32,
    /// The bin of `x`.
    pub index: usize,
}

/// A bin drawn from a [`Distribution1D`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteSample {
    /// The bin.
    pub index: usize,
    /// Its probability, above 0.
    pub probability: f32,
    /// Where the uniform number lay within the bin's share, in [0, 1): fit for use again, with as many bits
    /// fewer as the choice took.
    pub remapped: f32,
}

/// A density on [0, 1] that is constant on equal bins, or a choice among the bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution1D {
    /// Shares of the bins before each bin, and 1.
    cdf: Vec<f32>,
    guide: Vec<u32>,
    integral: f32,
}

impl Distribution1D {
    /// From bin weights in any unit. Negative and NaN weights count as 0, infinite ones as the largest float.
    /// If all are 0 the distribution is uniform and its [`integral`](Self::integral) 0. `None` if there are
    /// no weights.
    pub fn new(weights: &[f32]) -> Option<Self> {
        if weights.is_empty() {
            return None;
        }
        let mut cdf = Vec::with_capacity(weights.len() + 1);
        let total = push_cdf(weights.iter().map(|&w| usable(w)), &mut cdf);
        Some(Self { guide: guide(&cdf), cdf, integral: (total / weights.len() as f64) as f32 })
    }

    /// The number of bins, at least 1.
    pub fn bins(&self) -> usize {
        self.cdf.len() - 1
    }

    /// The mean weight, which is the integral of the weights as a function on [0, 1]. 0 if nothing has
    /// weight.
    pub fn integral(&self) -> f32 {
        self.integral
    }

    /// The point with the share `u` ∈ [0, 1) of probability below it.
    pub fn sample(&self, u: f32) -> Sample1D {
        sample_cdf(&self.cdf, &self.guide, u)
    }

    /// Density at `x`; 0 outside [0, 1) and for NaN.
    pub fn pdf(&self, x: f32) -> f32 {
        bin_of(x, self.bins()).map_or(0.0, |i| share(&self.cdf, i) * self.bins() as f32)
    }

    /// A bin, drawn with its probability by `u` ∈ [0, 1).
    pub fn sample_discrete(&self, u: f32) -> DiscreteSample {
        let found = find(&self.cdf, &self.guide, u);
        DiscreteSample {
            index: found.index,
            probability: share(&self.cdf, found.index),
            remapped: found.inside,
        }
    }

    /// Probability of the bin `index`; 0 if there is no such bin.
    pub fn probability(&self, index: usize) -> f32 {
        if index < self.bins() { share(&self.cdf, index) } else { 0.0 }
    }
}

/// A point drawn from a [`Distribution2D`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample2D {
    /// The point, in [0, 1)²: x along the rows, y across them, y = 0 at the first row.
    pub point: Vec2,
    /// Density at the point with respect to area on [0, 1]².
    pub pdf: f32,
    /// Cell of the point along the row.
    pub column: usize,
    /// Row of the point.
    pub row: usize,
}

/// A density on [0, 1]² that is constant on the cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution2D {
    rows: Distribution1D,
    /// Per row what `Distribution1D` keeps, `width + 1` numbers.
    columns: Vec<f32>,
    guides: Vec<u32>,
    width: usize,
}

impl Distribution2D {
    /// From `width`·`height` weights, row by row. Odd weights are treated as by [`Distribution1D::new`].
    /// `None` if there are none or their number is another.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Option<Self> {
        if weights.is_empty() || width.checked_mul(height) != Some(weights.len()) {
            return None;
        }
        let mut columns = Vec::with_capacity(weights.len() + height);
        let totals: Vec<f64> = weights
            .chunks_exact(width)
            .map(|row| push_cdf(row.iter().map(|&w| usable(w)), &mut columns))
            .collect();
        let mut cdf = Vec::with_capacity(height + 1);
        let total = push_cdf(totals.into_iter(), &mut cdf);
        let integral = (total / weights.len() as f64) as f32;
        let rows = Distribution1D { guide: guide(&cdf), cdf, integral };
        let guides = columns.chunks_exact(width + 1).flat_map(guide).collect();
        Some(Self { rows, columns, guides, width })
    }

    /// Cells along a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.rows.bins()
    }

    /// The mean weight, which is the integral of the weights as a function on [0, 1]². 0 if nothing has
    /// weight.
    pub fn integral(&self) -> f32 {
        self.rows.integral
    }

    /// The point of the uniform point `u` ∈ [0, 1)²: `u.y` chooses the row, then `u.x` the place in it.
    pub fn sample(&self, u: Vec2) -> Sample2D {
        let y = self.rows.sample(u.y);
        let buckets = buckets(self.width);
        let guide = &self.guides[y.index * buckets..(y.index + 1) * buckets];
        let x = sample_cdf(self.row(y.index), guide, u.x);
        Sample2D { point: Vec2::new(x.x, y.x), pdf: x.pdf * y.pdf, column: x.index, row: y.index }
    }

    /// Density at a point; 0 outside [0, 1)² and for NaN.
    pub fn pdf(&self, point: Vec2) -> f32 {
        match (bin_of(point.x, self.width), bin_of(point.y, self.height())) {
            (Some(column), Some(row)) => {
                let along = share(self.row(row), column) * self.width as f32;
                along * (self.rows.probability(row) * self.height() as f32)
            }
            _ => 0.0,
        }
    }

    fn row(&self, row: usize) -> &[f32] {
        let stride = self.width + 1;
        &self.columns[row * stride..(row + 1) * stride]
    }
}

/// The weight as used: not negative, finite.
fn usable(weight: f32) -> f64 {
    if weight > 0.0 { f64::from(weight.min(f32::MAX)) } else { 0.0 }
}

/// Appends the shares before each bin, and 1, and returns the sum of the weights.
///
/// Each bin of positive weight gets one grain of its own; the other grains are dealt by weight.
fn push_cdf(weights: impl ExactSizeIterator<Item = f64> + Clone, cdf: &mut Vec<f32>) -> f64 {
    let count = weights.len();
    let total: f64 = weights.clone().sum();
    cdf.push(0.0);
    if total == 0.0 {
        cdf.extend((1..=count).map(|i| (i as f64 / count as f64) as f32));
        return total;
    }
    let positive = weights.clone().filter(|&w| w > 0.0).count();
    let own = if positive as u64 <= u64::from(GRAINS / 4) { 1.0 } else { 0.0 };
    let grains = f64::from(GRAINS);
    let shared = grains - own * positive as f64;
    let (mut sum, mut before) = (0.0, 0.0);
    for weight in weights {
        if weight > 0.0 {
            sum += weight;
            before += own;
        }
        cdf.push(((before + (shared * (sum / total) + 0.5).floor()) / grains) as f32);
    }
    total
}

/// Probability of a bin.
fn share(cdf: &[f32], index: usize) -> f32 {
    cdf[index + 1] - cdf[index]
}

/// Where a share of probability lies.
struct Place {
    index: usize,
    /// Place inside the bin, in [0, 1).
    inside: f32,
}

/// Buckets in which the guide of so many bins divides the uniform numbers.
fn buckets(bins: usize) -> usize {
    bins.div_ceil(2)
}

/// For each bucket of uniform numbers the bin in which it begins: searches end after a step or two.
fn guide(cdf: &[f32]) -> Vec<u32> {
    let buckets = buckets(cdf.len() - 1);
    let begin = |k: usize| (k as f64 / buckets as f64) as f32;
    (0..buckets).map(|k| (cdf.partition_point(|&c| c <= begin(k)) - 1) as u32).collect()
}

/// The last bin that begins at or below u.
#[inline]
fn last_below(cdf: &[f32], guide: &[u32], u: f32) -> usize {
    let bucket = (f64::from(u) * guide.len() as f64) as usize;
    let low = guide.get(bucket).map_or(0, |i| *i as usize);
    let high = guide.get(bucket + 1).map_or(cdf.len() - 1, |i| *i as usize + 1);
    match cdf.get(low..=high) {
        // Rounding may have chosen the neighbouring bucket.
        Some(part) if part[0] <= u && part[part.len() - 1] > u => low + part.partition_point(|&c| c <= u) - 1,
        _ => cdf.partition_point(|&c| c <= u) - 1,
    }
}

#[inline]
fn find(cdf: &[f32], guide: &[u32], u: f32) -> Place {
    // NaN and numbers out of range go to an end.
    let u = if u >= 0.0 { u.min(1.0f32.next_down()) } else { 0.0 };
    // The last bin that begins at or below u: later bins of zero width begin there too only if the share is
    // theirs.
    let index = last_below(cdf, guide, u);
    let inside = ((u - cdf[index]) / share(cdf, index)).min(1.0f32.next_down());
    Place { index, inside }
}

#[inline]
fn sample_cdf(cdf: &[f32], guide: &[u32], u: f32) -> Sample1D {
    let count = cdf.len() - 1;
    let Place { index, inside } = find(cdf, guide, u);
    let x = ((index as f64 + f64::from(inside)) / count as f64) as f32;
    Sample1D { x: keep_inside(x, index, count), pdf: share(cdf, index) * count as f32, index }
}

/// Moves a coordinate that rounding pushed into a neighbouring bin back by the last place.
fn keep_inside(mut x: f32, index: usize, count: usize) -> f32 {
    for _ in 0..4 {
        match bin_of(x, count) {
            Some(bin) if bin == index => break,
            Some(bin) if bin < index => x = x.next_up(),
            _ => x = x.next_down(),
        }
    }
    x
}

/// The bin of a coordinate in [0, 1).
fn bin_of(x: f32, count: usize) -> Option<usize> {
    (0.0..1.0).contains(&x).then(|| ((f64::from(x) * count as f64) as usize).min(count - 1))
}

#[cfg(test)]
mod tests;
