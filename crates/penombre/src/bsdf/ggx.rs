//! The GGX distribution of microfacets with Smith's masking.
//!
//! D(m) = 1/(π αx αy (x²/αx² + y²/αy² + z²)²), \[Walter2007\]; Smith's functions for it, the height-correlated
//! masking and shadowing, \[Heitz2014\]; normals that `wo` sees are drawn by spherical caps, \[Dupuy2023\].
//!
//! Below, σ(w) = √(z² + αx²x² + αy²y²), the projected area of the microsurface, in which Smith's functions are
//! free of cancellation: G1(w) = 2z/(z + σ), 1 + Λ(w) = (1 + σ/z)/2.

use super::bounded;
use penombre_math::{Vec3, float};
use std::f32::consts::PI;

/// How the shadowing of `wi` goes with the masking of `wo`, and what becomes of light that both keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Masking {
    /// Height-correlated, G2 = 1/(1 + Λo + Λi). For refraction pbrt's choice of the same function is taken; the exact
    /// one would be a Beta function \[Heitz2016\].
    #[default]
    Correlated,
    /// Independent, G2 = G1(wo)·G1(wi), as in Mitsuba.
    Separable,
    /// [`Masking::Correlated`], and the light that single scattering loses comes out again: see [`super::energy`].
    Compensated,
}

/// If both α are below this, the surface is perfectly smooth: the lobe is then narrower than 0.1°.
const SMOOTH: f32 = 1e-3;
/// The smaller α of an anisotropic surface is at least this.
const LEAST: f32 = 1e-4;

/// Roughness in x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// α along x, in [10⁻⁴, 1].
    ax: f32,
    /// α along y.
    ay: f32,
}

impl Ggx {
    /// From α along x and y, brought into [10⁻⁴, 1]; NaN counts as the least.
    #[inline]
    pub fn new(alpha: [f32; 2]) -> Self {
        let [ax, ay] = alpha.map(|a| bounded(a, LEAST, 1.0));
        Self { ax, ay }
    }

    /// α along x and y.
    #[inline]
    pub fn alpha(&self) -> [f32; 2] {
        [self.ax, self.ay]
    }

    /// True if both α are below 10⁻³: treat it as a mirror.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.ax.max(self.ay) < SMOOTH
    }

    /// Geometric mean of both α; 0 if smooth.
    #[inline]
    pub fn roughness(&self) -> f32 {
        if self.is_smooth() { 0.0 } else { (self.ax * self.ay).sqrt() }
    }

    /// D(m), 1/sr, of a unit normal with z ≥ 0.
    #[inline]
    pub fn d(&self, m: Vec3) -> f32 {
        let (x, y) = (m.x / self.ax, m.y / self.ay);
        let q = x * x + y * y + m.z * m.z;
        1.0 / (PI * self.ax * self.ay * q * q)
    }

    /// σ(w).
    #[inline]
    pub fn projected(&self, w: Vec3) -> f32 {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        (w.z * w.z + x * x + y * y).sqrt()
    }

    /// G2(wo, wi)/(2·zo) from the |z| and σ of both, at least one z above 0.
    #[inline]
    pub fn masking(&self, masking: Masking, (zo, so): (f32, f32), (zi, si): (f32, f32)) -> f32 {
        if masking == Masking::Separable {
            2.0 * zi / ((zo + so) * (zi + si))
        } else {
            zi / (so * zi + si * zo)
        }
    }

    /// A normal that `wo` (z > 0) sees, with density `D(m)·|wo·m|·2/(zo + σo)` per solid angle.
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let w = Vec3::new(self.ax * wo.x, self.ay * wo.y, wo.z).normalize();
        let t = u[0] * (1.0 + w.z); // 1 − z of a point on the cap z > −w.z
        let sin = (t * (2.0 - t)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = float::sin_cos(2.0 * PI * u[1]);
        let h = Vec3::new(sin * cos_phi + w.x, sin * sin_phi + w.y, (1.0 - u[0]) * (1.0 + w.z));
        Vec3::new(self.ax * h.x, self.ay * h.y, h.z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::{DensityCheck, sidak};

    #[test]
    fn visible_normals_follow_their_density() {
        let mut seed = 40;
        for alpha in [[0.05, 0.05], [1.0, 1.0], [0.1, 0.6]] {
            for wo in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.7, -0.7, 0.1).normalize()] {
                let g = Ggx::new(alpha);
                seed += 1;
                let check = DensityCheck { samples: 100_000, theta_bins: 40, phi_bins: 80, seed };
                let report = check.run(
                    |rng| Some(g.sample_visible(wo, [rng.next_f32(), rng.next_f32()]).to_array()),
                    |m| {
                        let m = Vec3::from(m);
                        let seen = wo.dot(m).max(0.0) * 2.0 / (wo.z + g.projected(wo));
                        if m.z > 0.0 { g.d(m) * seen } else { 0.0 }
                    },
                );
                assert!(report.passes(sidak(0.01, 9)), "{alpha:?} {wo}: {report}");
                assert!((report.integral - 1.0).abs() < 1e-3, "{alpha:?} {wo}: {report}");
            }
        }
    }
}
