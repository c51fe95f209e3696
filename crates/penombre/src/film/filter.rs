//! Pixel filters: where around its pixel a sample is drawn.
//!
//! Positions are drawn with the filter as their density \[Ernst2006\], so every sample counts with weight 1 for the one
//! pixel that it was drawn for. All filters are products of the same profile in x and y, even and not negative.

use penombre_math::{Vec2, float};

/// Intervals of a table of half a profile.
const INTERVALS: usize = 64;

/// Terms of the four-term Blackman–Harris window of least sidelobes \[Harris1978\].
const BLACKMAN_HARRIS: [f32; 4] = [0.35875, 0.48829, 0.14128, 0.01168];

/// The shapes of filters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilterKind {
    /// Constant.
    #[default]
    Box,
    /// exp(−x² / 2σ²), lowered so that it ends at 0 at the radius \[PBRT4\].
    Gaussian,
    /// a₀ + a₁ cos(πx/r) + a₂ cos(2πx/r) + a₃ cos(3πx/r) for the radius r \[Harris1978\].
    BlackmanHarris,
}

impl FilterKind {
    /// Names in scene files, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["box", "gaussian", "blackman-harris"];

    /// The kind of that name; the box for any other.
    pub fn from_name(name: &str) -> Self {
        match name {
            "gaussian" => Self::Gaussian,
            "blackman-harris" => Self::BlackmanHarris,
            _ => Self::Box,
        }
    }

    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Its radius unless told otherwise, pixels.
    pub fn default_radius(self) -> f32 {
        if self == Self::Box { 0.5 } else { 1.5 }
    }
}

/// A pixel filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFilter {
    /// Its shape.
    pub kind: FilterKind,
    /// Beyond that distance from the pixel's centre, in x or y, it is 0; pixels, above 0.
    pub radius: f32,
    /// Standard deviation of the Gaussian before it is cut, pixels, above 0.
    pub sigma: f32,
}

impl Default for PixelFilter {
    /// The pixel itself.
    fn default() -> Self {
        Self::of_kind(FilterKind::Box)
    }
}

impl PixelFilter {
    /// Standard deviation of the Gaussian unless told otherwise, pixels.
    pub const SIGMA: f32 = 0.5;

    /// The filter of that shape with the usual size.
    pub fn of_kind(kind: FilterKind) -> Self {
        Self { kind, radius: kind.default_radius(), sigma: Self::SIGMA }
    }

    /// True if it is the pixel itself: uniform points of the pixel are its samples as they are.
    pub fn is_pixel(&self) -> bool {
        self.kind == FilterKind::Box && self.radius == 0.5
    }

    /// The profile at distance `x` ≥ 0 from the centre, pixels; not normalised, 0 from the radius on.
    pub fn profile(&self, x: f32) -> f32 {
        if x >= self.radius {
            return 0.0;
        }
        match self.kind {
            FilterKind::Box => 1.0,
            FilterKind::Gaussian => {
                let at = |x: f32| {
                    let v = x / self.sigma;
                    float::exp(-0.5 * v * v)
                };
                (at(x) - at(self.radius)).max(0.0)
            }
            FilterKind::BlackmanHarris => {
                let c = float::cos(std::f32::consts::PI * (x / self.radius));
                // cos 2φ = 2c² − 1, cos 3φ = 4c³ − 3c.
                let [a0, a1, a2, a3] = BLACKMAN_HARRIS;
                (a0 + a1 * c + a2 * (2.0 * c * c - 1.0) + a3 * (4.0 * c * c - 3.0) * c).max(0.0)
            }
        }
    }
}

/// A filter made ready for drawing: its profile as straight lines between the nodes of a table, inverted exactly.
#[derive(Clone, Debug)]
pub struct FilterTable {
    filter: PixelFilter,
    /// Width of an interval, pixels.
    step: f32,
    /// The profile at the nodes.
    profile: [f32; INTERVALS + 1],
    /// Share of half the profile's integral below each node but the first.
    below: [f32; INTERVALS],
    /// From shares to integrals.
    integral: f32,
}

impl FilterTable {
    /// The table of a filter.
    pub fn new(filter: PixelFilter) -> Self {
        // Beyond six deviations a bell holds nothing that a single precision sum would see.
        let bell = filter.kind == FilterKind::Gaussian;
        let reach = if bell { filter.radius.min(6.0 * filter.sigma) } else { filter.radius };
        let step = reach / INTERVALS as f32;
        let mut table =
            Self { filter, step, profile: [1.0; INTERVALS + 1], below: [1.0; INTERVALS], integral: 1.0 };
        if filter.kind == FilterKind::Box {
            return table;
        }
        for (i, value) in table.profile.iter_mut().enumerate() {
            *value = filter.profile(i as f32 * step);
        }
        let mut sum = 0.0;
        for (i, below) in table.below.iter_mut().enumerate() {
            sum += 0.5 * (table.profile[i] + table.profile[i + 1]) * step;
            *below = sum;
        }
        // A Gaussian so wide that its lowered bell rounds to nothing is flat within its radius.
        if sum <= 0.0 {
            return Self::new(PixelFilter { kind: FilterKind::Box, ..filter });
        }
        table.below.iter_mut().for_each(|v| *v /= sum);
        table.integral = sum;
        table
    }

    /// The place that the uniform point `u` ∈ [0, 1)² stands for: in pixels from the pixel's upper left corner, its
    /// centre being (0.5, 0.5). Grows with `u` in both axes, so points that are spread well stay so.
    #[inline]
    pub fn place(&self, u: Vec2) -> Vec2 {
        if self.filter.is_pixel() {
            return u;
        }
        Vec2::new(0.5 + self.offset(u.x), 0.5 + self.offset(u.y))
    }

    /// From a uniform number to the distance from the centre along one axis.
    #[inline]
    fn offset(&self, u: f32) -> f32 {
        let side = 2.0 * u - 1.0;
        if self.filter.kind == FilterKind::Box {
            return side * self.filter.radius;
        }
        let share = side.abs();
        let i = self.below.partition_point(|below| *below <= share).min(INTERVALS - 1);
        let before = if i == 0 { 0.0 } else { self.below[i - 1] };
        // Within an interval the integral is f₀x + (f₁ − f₀)x²/2h; its smaller root in the form without cancellation.
        let rest = ((share - before) * self.integral).max(0.0);
        let (f0, f1) = (self.profile[i], self.profile[i + 1]);
        let under_root = (f0 * f0 + 2.0 * (f1 - f0) * rest / self.step).max(0.0);
        let x = 2.0 * rest / (f0 + under_root.sqrt()).max(f32::MIN_POSITIVE);
        (i as f32 * self.step + x.min(self.step)).copysign(side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::{chi_square, kolmogorov_smirnov, sidak};
    use penombre_math::sobol::independent_2d;

    const BINS: usize = 60;

    fn filters() -> Vec<PixelFilter> {
        let [pixel, gaussian, harris] =
            [FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris].map(PixelFilter::of_kind);
        vec![
            pixel,
            PixelFilter { radius: 1.25, ..pixel },
            gaussian,
            PixelFilter { radius: 2.0, sigma: 0.8, ..gaussian },
            PixelFilter { radius: 0.7, sigma: 3.0, ..gaussian },
            PixelFilter { radius: 1.0, sigma: 0.1, ..gaussian },
            harris,
            PixelFilter { radius: 2.5, ..harris },
        ]
    }

    /// The profile's integral from 0 to x, by the midpoint rule on the exact profile.
    fn integral(filter: &PixelFilter, x: f64) -> f64 {
        let n = 2000;
        let at = |i: usize| (i as f64 + 0.5) * x / f64::from(n);
        (0..n as usize).map(|i| f64::from(filter.profile(at(i) as f32))).sum::<f64>() * x / f64::from(n)
    }

    /// Chi² of both axes over bins of equal width, a million points each.
    #[test]
    fn places_follow_the_filter() {
        let alpha = sidak(0.01, 2 * filters().len());
        for (key, filter) in filters().iter().enumerate() {
            let (table, r) = (FilterTable::new(*filter), f64::from(filter.radius));
            let mut counts = [vec![0.0; BINS], vec![0.0; BINS]];
            let n = 1_000_000;
            for i in 0..n {
                let place = table.place(Vec2::from(independent_2d(i, key as u32)));
                for (counts, v) in counts.iter_mut().zip(place.to_array()) {
                    let at = (f64::from(v) - 0.5 + r) / (2.0 * r) * BINS as f64;
                    assert!((0.0..=BINS as f64).contains(&at), "{filter:?} {v}");
                    counts[(at as usize).min(BINS - 1)] += 1.0;
                }
            }
            let whole = 2.0 * integral(filter, r);
            let edge = |i: usize| (i as f64 / BINS as f64 * 2.0 - 1.0) * r;
            let share = |i: usize| {
                let signed = |x: f64| integral(filter, x.abs()).copysign(x);
                ((signed(edge(i + 1)) - signed(edge(i))) / whole).max(0.0)
            };
            let expected: Vec<f64> = (0..BINS).map(|i| share(i) * f64::from(n)).collect();
            for counts in &counts {
                let found = chi_square(counts, &expected);
                assert!(found.p_value >= alpha, "{filter:?}: {found:?}");
            }
        }
    }

    #[test]
    fn places_follow_the_distribution_function() {
        let alpha = sidak(0.01, filters().len());
        for (key, filter) in filters().iter().enumerate() {
            let table = FilterTable::new(*filter);
            let draw = |i| f64::from(table.place(Vec2::from(independent_2d(i, 77 + key as u32))).x);
            let mut places: Vec<f64> = (0..4000).map(draw).collect();
            let half = integral(filter, f64::from(filter.radius));
            let cdf = |x: f64| 0.5 + 0.5 * integral(filter, (x - 0.5).abs()).copysign(x - 0.5) / half;
            let found = kolmogorov_smirnov(&mut places, cdf);
            assert!(found.p_value >= alpha, "{filter:?}: {found:?}");
        }
    }

    #[test]
    fn places_grow_with_the_numbers_and_stay_within_the_radius() {
        for filter in filters() {
            let table = FilterTable::new(filter);
            let last = 1.0 - f32::EPSILON / 2.0;
            let numbers = (0..=1000).map(|i| (i as f32 / 1000.0).min(last));
            let places: Vec<f32> = numbers.map(|u| table.place(Vec2::splat(u)).x).collect();
            assert!(places.is_sorted(), "{filter:?}");
            assert!(places[0] >= 0.5 - filter.radius && places[0] < 0.5, "{filter:?} {}", places[0]);
            assert!(places[1000] <= 0.5 + filter.radius && places[1000] > 0.5, "{filter:?}");
            assert_eq!(places[500], 0.5);
        }
    }

    #[test]
    fn the_pixel_itself_takes_numbers_as_they_are() {
        let table = FilterTable::new(PixelFilter::default());
        let u = Vec2::new(0.1, 0.7);
        assert_eq!(table.place(u), u);
    }

    #[test]
    fn extreme_sizes_stay_finite() {
        for (radius, sigma) in [(0.01, 100.0), (16.0, 0.01), (16.0, 1e-3), (0.5, 1e6)] {
            for kind in [FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris] {
                let table = FilterTable::new(PixelFilter { kind, radius, sigma });
                for i in 0..1000 {
                    let place = table.place(Vec2::from(independent_2d(i, 5))) - Vec2::splat(0.5);
                    assert!(place.abs().max_element() <= radius * 1.0001, "{kind:?} {radius} {sigma}");
                }
            }
        }
    }
}
