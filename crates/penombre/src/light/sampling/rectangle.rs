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
///
/// Divisions and roots take most of the time: quotients share their division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Ends of the sides, metres.
    x: [f64; 2],
    y: [f64; 2],
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
    #[inline(always)]
    fn of_corner(x: f64, y: f64, z: f64, distance: f64) -> Self {
        Self { cos: z * distance, sin: x * y }
    }

    #[inline(always)]
    fn plus(self, o: Self) -> Self {
        Self { cos: self.cos * o.cos - self.sin * o.sin, sin: self.sin * o.cos + self.cos * o.sin }
    }

    #[inline(always)]
    fn minus(self, o: Self) -> Self {
        self.plus(Self { cos: o.cos, sin: -o.sin })
    }

    #[inline(always)]
    fn times(self, scale: f64) -> Self {
        Self { cos: self.cos * scale, sin: self.sin * scale }
    }
}

impl Rectangle {
    /// From the vector to a corner in the frame of the sides, whose z is the distance of the plane, above 0, and the
    /// lengths of the sides. No product below has more than six lengths as factors: all are in the range of double
    /// precision if the lengths are in that of single precision. `None` at grazing angles.
    #[inline(always)]
    pub fn new(corner: DVec3, lengths: [f64; 2]) -> Option<Self> {
        let DVec3 { x: x0, y: y0, z } = corner;
        let (x, y) = ([x0, x0 + lengths[0]], [y0, y0 + lengths[1]]);
        let beside = x[0].max(-x[1]).max(y[0]).max(-y[1]);
        if beside > GRAZING * z {
            return None;
        }
        let z_square = z * z;
        let y_squares = y.map(|y| y * y);
        let x_squares = x.map(|x| x * x + z_square);
        let across = y_squares.map(|y| (y + z_square).sqrt());
        let difference = |i: usize| {
            let corner = |j: usize| Angle::of_corner(x[i], y[j], z, (x_squares[i] + y_squares[j]).sqrt());
            corner(1).minus(corner(0))
        };
        let x_product = x_squares[0] * x_squares[1];
        let inverse = 1.0 / (across[0] * across[1] * x_product);
        let start = difference(0).times(inverse * x_squares[1]);
        let whole = difference(1).times(inverse * x_squares[0]).minus(start);
        let angle = f64::from(float::atan2(whole.sin as f32, whole.cos as f32));
        let inverse = inverse * x_product;
        Some(Self {
            x,
            y,
            z,
            b: [y[0] * across[1] * inverse, y[1] * across[0] * inverse],
            start,
            solid_angle: if angle < 0.0 { angle + TAU } else { angle },
        })
    }

    /// The point (x, y) for `u` ∈ [0, 1)²: `u.x` chooses x, then `u.y` chooses y.
    #[inline(always)]
    pub fn point(&self, u: DVec2) -> DVec2 {
        let x = self.x_at(u.x);
        DVec2::new(x, self.y_at(x, u.y).max(self.y[0]).min(self.y[1]))
    }

    #[inline(always)]
    fn x_at(&self, u: f64) -> f64 {
        let (sin, cos) = unit_circle(u * self.solid_angle);
        let d = self.start.plus(Angle { cos, sin });
        let [b0, b1] = self.b;
        let product = b0 * b1;
        // sin²D/s² = (b₁ − b₀)² + 2·b₀b₁·(1 − cos D), written with terms of one sign.
        // Signs are moved rather than asked for: which way a branch goes is anyone's guess.
        let sign = 1f64.copysign(product);
        let difference = b1 - sign * b0;
        let square = difference * difference + 2.0 * product.abs() * less_cosine(sign * d.cos, d.sin);
        // x = z·s/√(1 − s²)
        let x = self.z * d.sin / (square - d.sin * d.sin).max(0.0).sqrt();
        // An s of 1 by rounding is an infinite x, and 0/0 can only be a share of nothing.
        if x.is_nan() { self.x[0] } else { x.max(self.x[0]).min(self.x[1]) }
    }

    /// y for that x: uniform in the sine of the angle of y over √(x² + z²).
    #[inline(always)]
    fn y_at(&self, x: f64, u: f64) -> f64 {
        let square = x * x + self.z * self.z;
        let [y0, y1] = self.y;
        let [r0, r1] = self.y.map(|y| (y * y + square).sqrt());
        let inverse = 1.0 / (r0 * r1);
        let (h0, h1) = (y0 * r1 * inverse, y1 * r0 * inverse);
        let h = h0 + u * (h1 - h0);
        h * (square / ((1.0 - h) * (1.0 + h)).max(f64::MIN_POSITIVE)).sqrt()
    }
}

/// 1 − cos without cancellation.
#[inline]
fn less_cosine(cos: f64, sin: f64) -> f64 {
    let square = sin * sin;
    // The sine belongs to the cosine within a rounding: where that is negative the quotient loses what the difference keeps.
    let (numerator, denominator) = if cos > 0.0 { (square, 1.0 + cos) } else { (1.0 - cos, 1.0) };
    numerator / denominator
}
