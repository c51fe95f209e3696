//! Where a shading normal contradicts the surface.

use penombre_math::Vec3;

/// True if the shading normal would let light through an opaque surface or block it at a clear one: `wi` (or `wo`) is on
/// different sides of both normals. Evaluate nothing then (\[Veach1997\], 5.3).
#[inline]
pub fn leaks(w: Vec3, geometric: Vec3, shading: Vec3) -> bool {
    w.dot(geometric) * w.dot(shading) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_leaks_between_the_horizons() {
        let (ng, ns) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
        let toward = |degrees: f32| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        assert!([91.0, 120.0, -60.0, -89.0].iter().all(|d| leaks(toward(*d), ng, ns)));
        assert!(![0.0, 89.0, -50.0, 130.0, -91.0].iter().any(|d| leaks(toward(*d), ng, ns)));
    }
}
