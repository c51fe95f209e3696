//! Reflection, refraction and Fresnel's equations at a smooth boundary.

use penombre_math::Vec3;

/// What happens to light at a boundary between two clear media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refraction {
    /// Total internal reflection.
    Total,
    /// A part is reflected, the rest goes on.
    Partial {
        /// Share of unpolarised light that is reflected.
        reflectance: f32,
        /// Unit direction of the refracted ray.
        dir: Vec3,
    },
}

/// The mirrored direction: `wo` and the result point away from the surface; `normal` is a unit vector.
pub fn reflect(wo: Vec3, normal: Vec3) -> Vec3 {
    (normal * (2.0 * wo.dot(normal)) - wo).normalize()
}

/// Snell's law and Fresnel's equations for unpolarised light (\[PBRT4\], 9.3).
///
/// `wo` is the unit direction toward the incoming ray's origin, `normal` the unit normal on that side, `eta` the
/// index of refraction beyond the boundary divided by that before it.
pub fn refract(wo: Vec3, normal: Vec3, eta: f32) -> Refraction {
    // Double precision: near the critical angle 1 − sin²θₜ loses most of its digits.
    let (wo, n, eta) = (wo.as_dvec3(), normal.as_dvec3(), f64::from(eta));
    let cos_i = wo.dot(n).clamp(0.0, 1.0);
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return Refraction::Total;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    let dir = n * (cos_i / eta - cos_t) - wo / eta;
    Refraction::Partial { reflectance: reflectance as f32, dir: dir.normalize().as_vec3() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_math::float;

    fn at_angle(degrees: f32) -> Vec3 {
        let (s, c) = float::sin_cos(degrees.to_radians());
        Vec3::new(s, 0.0, c)
    }

    #[test]
    fn reflection_mirrors_at_the_normal() {
        for degrees in [0.0, 10.0, 45.0, 80.0, 89.9] {
            let wo = at_angle(degrees);
            assert!(reflect(wo, Vec3::Z).distance(Vec3::new(-wo.x, 0.0, wo.z)) < 1e-6);
        }
    }

    #[test]
    fn refraction_obeys_snell() {
        for eta in [1.4f32, 1.0 / 1.4, 2.42, 1.0] {
            for degrees in [0.0f32, 5.0, 20.0, 40.0, 45.0] {
                let Refraction::Partial { dir, .. } = refract(at_angle(degrees), Vec3::Z, eta) else {
                    assert!(float::sin(degrees.to_radians()) >= eta);
                    continue;
                };
                let sine = float::sin(degrees.to_radians()) / eta;
                assert!((-dir.x - sine).abs() < 1e-6 && dir.z < 0.0, "{eta} {degrees} {dir}");
                assert!((dir.length() - 1.0).abs() < 1e-6);
            }
        }
    }

    fn reflectance(degrees: f32, eta: f32) -> f32 {
        match refract(at_angle(degrees), Vec3::Z, eta) {
            Refraction::Total => 1.0,
            Refraction::Partial { reflectance, .. } => reflectance,
        }
    }

    #[test]
    fn fresnel_weights_are_the_closed_forms() {
        // Normal incidence: ((n − 1) / (n + 1))².
        for n in [1.33f32, 1.4, 1.5, 2.42] {
            let expected = ((n - 1.0) / (n + 1.0)) * ((n - 1.0) / (n + 1.0));
            assert!((reflectance(0.0, n) - expected).abs() < 1e-6);
            assert!((reflectance(0.0, 1.0 / n) - expected).abs() < 1e-6);
        }
        // Brewster's angle: the parallel part vanishes, the perpendicular one is ((n² − 1) / (n² + 1))².
        let n = 1.5f32;
        let ratio = (n * n - 1.0) / (n * n + 1.0);
        assert!((reflectance(float::atan(n).to_degrees(), n) - 0.5 * ratio * ratio).abs() < 1e-5);
        // Beyond the critical angle all is reflected, just below it almost all.
        let critical = float::asin(1.0 / 1.4).to_degrees();
        assert_eq!(refract(at_angle(critical + 0.01), Vec3::Z, 1.0 / 1.4), Refraction::Total);
        assert!(reflectance(critical - 0.0001, 1.0 / 1.4) > 0.98);
        assert!(reflectance(90.0, 1.4) > 0.999_9);
        assert_eq!(reflectance(30.0, 1.0), 0.0);
    }

    /// Light that goes the other way through the same boundary has the same weight.
    #[test]
    fn fresnel_is_reciprocal() {
        for degrees in [1.0f32, 30.0, 60.0, 85.0] {
            let inside = float::asin(float::sin(degrees.to_radians()) / 1.4).to_degrees();
            assert!((reflectance(degrees, 1.4) - reflectance(inside, 1.0 / 1.4)).abs() < 1e-5);
        }
    }
}
