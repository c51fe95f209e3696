//! Powers of lights, for the choice among them.
//!
//! All take and give one number per light, the luminance of its spectrum, and give watts of it. Products that
//! leave the range of `f32` go to its ends, so that a light with power never counts as having none.

use super::punctual::SpotCone;
use std::f64::consts::PI;

/// Of a point that shines with `intensity` W/sr in all directions: 4π·I.
pub fn of_point(intensity: f32) -> f32 {
    watts(4.0 * PI, &[intensity])
}

/// Of a point that shines with `intensity` W/sr in a cone, less at its rim: the falloff over the ring of the
/// rim has the mean ½.
pub fn of_spot(intensity: f32, cone: &SpotCone) -> f32 {
    watts(2.0 * PI * f64::from(cone.mean_share()), &[intensity])
}

/// Of parallel light with the irradiance `irradiance` W/m² across its direction, on a scene within a sphere of
/// that radius in metres: πR²·E.
pub fn of_directional(irradiance: f32, scene_radius: f32) -> f32 {
    watts(PI, &[irradiance, scene_radius, scene_radius])
}

/// Of a surface of `area` m² that emits the radiance `radiance` W/(sr·m²) evenly: π·A·L per side.
pub fn of_surface(radiance: f32, area: f32, two_sided: bool) -> f32 {
    watts(if two_sided { 2.0 * PI } else { PI }, &[radiance, area])
}

/// Of a sphere of `radius` metres that emits that radiance to the outside: 4π²r²·L.
pub fn of_sphere(radiance: f32, radius: f32) -> f32 {
    watts(4.0 * PI * PI, &[radiance, radius, radius])
}

/// Of an environment with that mean radiance, on a scene within a sphere of that radius: 4π²R²·L, the
/// irradiance of each direction on the disk across it, over all directions.
pub fn of_environment(mean_radiance: f32, scene_radius: f32) -> f32 {
    of_sphere(mean_radiance, scene_radius)
}

/// The product, in the range of positive `f32`; 0 only if a factor is not above 0.
fn watts(constant: f64, factors: &[f32]) -> f32 {
    if factors.iter().any(|f| *f <= 0.0) || constant <= 0.0 {
        return 0.0;
    }
    let product = factors.iter().fold(constant, |p, f| p * f64::from(*f));
    (product as f32).clamp(f32::MIN_POSITIVE, f32::MAX)
}
