//! Fresnel's equations for unpolarised light.

use super::bounded;
use penombre_math::Spectrum;

/// Reflectance of a smooth boundary between dielectrics and the cosine of the refracted direction, from
/// cos θ ∈ [0, 1] and the index behind the boundary relative to that in front. Total reflection is (1, 0).
#[inline]
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let sin2 = (1.0 - cos) * (1.0 + cos) / (eta * eta);
    if sin2 >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2).sqrt();
    (dielectric_of_pair(cos, cos_t, eta), cos_t)
}

/// The same reflectance from the cosines on both sides, which Snell's law couples; symmetric in them.
#[inline]
pub fn dielectric_of_pair(cos: f32, cos_t: f32, eta: f32) -> f32 {
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let across = (cos - eta * cos_t) / (cos + eta * cos_t);
    (0.5 * (parallel * parallel + across * across)).min(1.0)
}

/// Mean of the reflectance over cosine-weighted directions on the rarer side, for a relative index of 1 or more:
/// the fit of \[Kulla2017\], good to 0.02. On the denser side it is 1 − (1 − mean)/η².
#[inline]
pub fn dielectric_mean(eta: f32) -> f32 {
    ((eta - 1.0) / (4.08567 + 1.00071 * eta)).min(1.0)
}

/// Reflectance of a metal with the complex index n + ik by colour lane, from cos θ ∈ [0, 1] (\[PBRT4\], 9.3.6, in
/// real numbers). n = 0 reflects everything.
#[inline]
pub fn conductor(cos: f32, n: [f32; 3], k: [f32; 3]) -> Spectrum {
    let cos2 = cos * cos;
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let lane = |i: usize| {
        let (n2, k2) = (n[i] * n[i], k[i] * k[i]);
        let t = n2 - k2 - sin2;
        let length = (t * t + 4.0 * n2 * k2).sqrt(); // a² + b², of the index along the normal a + ib
        let larger = 0.5 * (length + t.abs());
        let a2 = if t > 0.0 { larger } else { n2 * k2 / larger.max(f32::MIN_POSITIVE) }; // without cancellation
        let twice = 2.0 * cos * a2.sqrt();
        let across = (length + cos2 - twice) / (length + cos2 + twice).max(f32::MIN_POSITIVE);
        let (even, odd) = (cos2 * length + sin2 * sin2, twice * sin2);
        let ratio = (even - odd) / (even + odd).max(f32::MIN_POSITIVE);
        bounded(0.5 * across * (1.0 + ratio), 0.0, 1.0)
    };
    Spectrum::rgb(lane(0), lane(1), lane(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // Normal incidence: ((η − 1)/(η + 1))² and ((n − 1)² + k²)/((n + 1)² + k²); Brewster's angle by its tangent.
        assert!((dielectric(1.0, 1.5).0 - 0.04).abs() < 1e-7);
        assert!((dielectric(1.0, 1.0 / 1.5).0 - 0.04).abs() < 1e-7);
        let brewster = 1.0 / (1.0 + 1.5f32 * 1.5).sqrt();
        let across = (1.0 - 1.5f32 * 1.5) / (1.0 + 1.5 * 1.5);
        assert!((dielectric(brewster, 1.5).0 - 0.5 * across * across).abs() < 1e-6);
        assert_eq!(dielectric(0.5, 1.0 / 1.5), (1.0, 0.0));
        let gold = conductor(1.0, [0.2, 1.0, 3.0], [3.0, 2.0, 0.0]).to_rgb();
        let normal = |n: f32, k: f32| ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
        for (f, nk) in gold.into_iter().zip([(0.2, 3.0), (1.0, 2.0), (3.0, 0.0)]) {
            assert!((f - normal(nk.0, nk.1)).abs() < 1e-6);
        }
        assert_eq!(conductor(0.3, [0.0; 3], [1.0; 3]), Spectrum::WHITE);
    }

    #[test]
    fn a_metal_without_absorption_is_a_dielectric() {
        for i in 0..=100 {
            let cos = i as f32 / 100.0;
            let expected = dielectric(cos, 1.7).0;
            assert!((conductor(cos, [1.7; 3], [0.0; 3])[1] - expected).abs() < 2e-6, "{cos}");
        }
    }

    #[test]
    fn the_fit_of_the_mean_is_good_to_two_hundredths() {
        for eta in [1.0, 1.1, 1.33, 1.5, 2.0, 3.0, 10.0] {
            let at = |i: i32| (i as f32 + 0.5) / 1000.0;
            let mean: f32 = (0..1000).map(|i| 2.0 * at(i) * dielectric(at(i), eta).0 / 1000.0).sum();
            assert!((mean - dielectric_mean(eta)).abs() < 0.02, "{eta}: {mean} {}", dielectric_mean(eta));
        }
    }
}
