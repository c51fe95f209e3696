//! Points in the unit disk and cosine-weighted directions.

use penombre_math::{Vec2, Vec3, float};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Maps the unit square to the unit disk, area to area, neighbours to neighbours \[Shirley1997\].
#[inline]
pub fn disk(u: [f32; 2]) -> Vec2 {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    let (sin, cos) = float::sin_cos(angle);
    Vec2::new(radius * cos, radius * sin)
}

/// A direction of the upper hemisphere with density cos θ / π (Malley's method, \[PBRT4\]). Its z is at least
/// 10⁻⁴, so that the density is never 0.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let p = disk(u);
    Vec3::new(p.x, p.y, (1.0 - p.length_squared()).max(1e-8).sqrt())
}
