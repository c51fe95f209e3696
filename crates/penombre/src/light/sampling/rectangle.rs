//! Area-preserving map from the unit square to a spherical rectangle.

use super::unit_circle;
use penombre_math::{DVec2, DVec3, float};
use std::f64::consts::TAU;

/// A rectangle seen from a point \[Urena2013\].
///
/// In the frame of its sides the rectangle is [x₀, x₁] × [y₀, y₁] at distance z. The part of it left of x has
/// the solid angle D(x) − D(x₀), where D(x) = F(x, y₁) − F(x, y₀) and F(x, y) = atan(xy/(zr)), the solid angle
/// of [0, x] × [0, y]. F is also asin(s·b) with the sines s = x/√(x² + z²) and b = y/√(y² + z²), so D belongs to
/// a triangle with the sides s·b₀ and s·b₁ in a circle of diameter 1: the law of cosines gives s from D without
/// the cancellation of the arc cosines of the paper. Angles are kept as points of the unit circle, which leaves
/// one arc tangent per rectangle and one sine per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Ends and lengths of the sides, in units of `new`'s own.
    x: [f64; 2],
    y: [f64; 2],
    lengths: [f64; 2],
    z: f64,
    /// The sines of y₀ and y₁ over z.
    b: [f64; 2],
    /// D(x₀)
    start: Angle,
    /// Steradians.
    pub solid_angle: f64,
}

/// The map loses its accuracy where the rectangle is seen from beside it at this ratio of the distances along and
/// above its plane: the measured error of the share of the solid angle is 10⁻¹⁵·ratio², here that of an `f32`.
const GRAZING: f64 = 1e4;

/// An angle by its point of the unit circle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Angle {
    cos: f64,
    sin: f64,
}

impl Angle {
    /// F(x, y), whose point is not on the unit circle but at √((x² + z²)·(y² + z²)).
    fn of_corner(x: f64, y: f64, z: f64) -> Self {
        Self { cos: z * (x * x + y * y + z * z).sqrt(), sin: x * y }
    }

    fn plus(self, o: Self) -> Self {
        Self { cos: self.cos * o.cos - self.sin * o.sin, sin: self.sin * o.cos + self.cos * o.sin }
    }

    fn minus(self, o: Self) -> Self {
        self.plus(Self { cos: o.cos, sin: -o.sin })
    }
}

impl Rectangle {
    /// From the vector to a corner, two sides at a right angle, and the distance of the plane, above 0. `None` at
    /// grazing angles.
    pub fn new(corner: DVec3, sides: [DVec3; 2], height: f64) -> Option<Self> {
        let lengths = sides.map(DVec3::length);
        // Everything is a ratio of lengths: the size is taken out, so that no product overflows.
        let scale = 1.0 / (lengths[0] + lengths[1] + height);
        let range = |side: DVec3, length: f64| {
            let first = corner.dot(side) / length;
            [first * scale, (first + length) * scale]
        };
        let (x, y) = (range(sides[0], lengths[0]), range(sides[1], lengths[1]));
        let z = height * scale;
        let beside = x[0].max(-x[1]).max(y[0]).max(-y[1]);
        if beside > GRAZING * z {
            return None;
        }
        let inverse = y.map(|y| 1.0 / (y * y + z * z).sqrt());
        let difference = |x: f64| {
            let d = Angle::of_corner(x, y[1], z).minus(Angle::of_corner(x, y[0], z));
            let unit = inverse[0] * inverse[1] / (x * x + z * z);
            Angle { cos: d.cos * unit, sin: d.sin * unit }
        };
        let start = difference(x[0]);
        let whole = difference(x[1]).minus(start);
        let angle = f64::from(float::atan2(whole.sin as f32, whole.cos as f32));
        Some(Self {
            x,
            y,
            lengths: lengths.map(|l| l * scale),
            z,
            b: [y[0] * inverse[0], y[1] * inverse[1]],
            start,
            solid_angle: if angle < 0.0 { angle + TAU } else { angle },
        })
    }

    /// Shares of the two sides for `u` ∈ [0, 1)²: `u.x` chooses x, then `u.y` chooses y.
    pub fn shares(&self, u: DVec2) -> DVec2 {
        let x = self.x_at(u.x);
        let y = self.y_at(x, u.y);
        let shares = DVec2::new((x - self.x[0]) / self.lengths[0], (y - self.y[0]) / self.lengths[1]);
        shares.clamp(DVec2::ZERO, DVec2::ONE)
    }

    fn x_at(&self, u: f64) -> f64 {
        let (sin, cos) = unit_circle(u * self.solid_angle);
        let d = self.start.plus(Angle { cos, sin });
        let [b0, b1] = self.b;
        let product = b0 * b1;
        // sin²D/s² = (b₁ − b₀)² + 2·b₀b₁·(1 − cos D), written with terms of one sign.
        let square = if product > 0.0 {
            (b1 - b0) * (b1 - b0) + 2.0 * product * less_cosine(d.cos, d.sin)
        } else {
            (b1 + b0) * (b1 + b0) - 2.0 * product * less_cosine(-d.cos, d.sin)
        };
        // x = z·s/√(1 − s²)
        let x = self.z * d.sin / (square - d.sin * d.sin).max(0.0).sqrt();
        // An s of 1 by rounding is an infinite x, and 0/0 can only be a share of nothing.
        if x.is_nan() { self.x[0] } else { x.clamp(self.x[0], self.x[1]) }
    }

    /// y for that x: uniform in the sine of the angle of y over √(x² + z²).
    fn y_at(&self, x: f64, u: f64) -> f64 {
        let square = x * x + self.z * self.z;
        let [h0, h1] = self.y.map(|y| y / (y * y + square).sqrt());
        let h = h0 + u * (h1 - h0);
        h * (square / ((1.0 - h) * (1.0 + h)).max(f64::MIN_POSITIVE)).sqrt()
    }
}

/// 1 − cos without cancellation.
fn less_cosine(cos: f64, sin: f64) -> f64 {
    if cos > 0.0 { sin * sin / (1.0 + cos) } else { 1.0 - cos }
}
