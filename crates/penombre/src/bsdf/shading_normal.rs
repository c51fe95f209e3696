//! What shading normals spoil, and its repair: factors for f·|cos|, from world or local vectors.

use penombre_math::Vec3;

/// True if the shading normal would let light through an opaque surface or block it at a clear one: `wi` (or `wo`) is on
/// different sides of both normals. Evaluate nothing then (\[Veach1997\], 5.3).
#[inline]
pub fn leaks(w: Vec3, geometric: Vec3, shading: Vec3) -> bool {
    w.dot(geometric) * w.dot(shading) <= 0.0
}

/// Factor of f·|cos θi| for `Transport::Importance` (\[Veach1997\], 5.3): |wo·ns|·|wi·ng| / (|wo·ng|·|wi·ns|). In
/// `Radiance` it is 1. At most 100, against specks at grazing angles, which is biased.
#[inline]
pub fn importance_factor(wo: Vec3, wi: Vec3, geometric: Vec3, shading: Vec3) -> f32 {
    let above = (wo.dot(shading) * wi.dot(geometric)).abs();
    let below = (wo.dot(geometric) * wi.dot(shading)).abs();
    if below > 0.0 { (above / below).min(100.0) } else { 0.0 }
}

/// Factor in [0, 1] of light from `wi` that softens the terminator, the hard edge of the shadow that flat triangles cast
/// on their smooth shading (\[Chiang2019\]): −g³ + g² + g of g = (ng·wi)/((ns·wi)·(ng·ns)), 1 where g ≥ 1, 0 behind.
/// A matter of looks: it takes light away.
#[inline]
pub fn terminator_factor(wi: Vec3, geometric: Vec3, shading: Vec3) -> f32 {
    let below = wi.dot(shading) * geometric.dot(shading);
    let above = wi.dot(geometric);
    if above * below <= 0.0 {
        return 0.0;
    }
    let g = (above / below).abs().min(1.0);
    g * (1.0 + g * (1.0 - g))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_normals_change_nothing() {
        let n = Vec3::new(0.48, -0.6, 0.64);
        for (wo, wi) in super::super::check::pairs(1000).filter(|(a, b)| a.dot(n) * b.dot(n) > 1e-3) {
            assert!(!leaks(wi, n, n));
            assert!((importance_factor(wo, wi, n, n) - 1.0).abs() < 1e-5);
            assert!((terminator_factor(wi, n, n) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_terminator_fades_to_the_geometric_horizon() {
        let (ng, ns) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
        let toward = |degrees: f32| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        assert_eq!(terminator_factor(toward(91.0), ng, ns), 0.0);
        assert!(leaks(toward(91.0), ng, ns));
        let factors = [90.0f32, 89.0, 80.0, 60.0, 40.0].map(|d| terminator_factor(toward(d), ng, ns));
        assert!(
            factors.windows(2).all(|w| w[0] <= w[1]) && factors[0] < 1e-5 && factors[4] > 0.9,
            "{factors:?}"
        );
        assert!((importance_factor(ng, ns, ng, ns) - 0.64).abs() < 1e-6);
        assert_eq!(importance_factor(Vec3::X, Vec3::Z, Vec3::Z, ns), 0.0);
    }
}
