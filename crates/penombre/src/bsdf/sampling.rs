//! Points in the unit disk and cosine-weighted directions.

use penombre_math::{Vec2, Vec3, quick};
use std::f32::consts::FRAC_PI_4;

/// Maps the unit square to the unit disk, area to area, neighbours to neighbours \[Shirley1997\].
#[inline]
pub fn disk(u: [f32; 2]) -> Vec2 {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let wide = x.abs() > y.abs();
    let (radius, other) = if wide { (x, y) } else { (y, x) };
    // The sector's angle from its own axis; 0/0 only in the centre.
    let share = if radius == 0.0 { 0.0 } else { other / radius };
    let (sin, cos) = quick::sin_cos_quarter(FRAC_PI_4 * share);
    if wide { Vec2::new(radius * cos, radius * sin) } else { Vec2::new(radius * sin, radius * cos) }
}

/// A direction of the upper hemisphere with density cos θ / π (Malley's method, \[PBRT4\]). Its z is at least
/// 10⁻⁴, so that the density is never 0.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let p = disk(u);
    Vec3::new(p.x, p.y, (1.0 - p.length_squared()).max(1e-8).sqrt())
}
