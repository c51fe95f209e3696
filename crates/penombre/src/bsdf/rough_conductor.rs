//! Metal with GGX microfacets; a perfect mirror with Fresnel's reflectance where both α are below 10⁻³.
//!
//! f = F(wo·m)·D(m)·G2(wo, wi)/(4·cos θo·cos θi), m halfway between `wo` and `wi`, F of the complex index n + ik in
//! each colour lane, times a tint. Directions mirror `wo` at visible normals; those that fall below the surface are
//! absorbed. Source: \[Walter2007\], \[Heitz2014\], \[Dupuy2023\].
//!
//! With [`Masking::Compensated`], f gains c·l(wo)·l(wi)/(π·L): l is the share of light that single scattering loses,
//! L its mean, c = F̄²·Ē/(1 − F̄·(1 − Ē)) the colour of light that met the metal more than once, F̄ the mean of F
//! (Schlick's, from F at normal incidence) and Ē = 1 − L, \[Kulla2017\]. The sum is reciprocal.

use super::energy::Losses;
use super::sampling::cosine_hemisphere;
use super::{
    BsdfEval, BsdfSample, GRAZING, Ggx, Masking, Scatter, Transport, bounded, fresnel, turned, unit_color,
    upper,
};
use penombre_math::{Spectrum, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Rough metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    tint: Spectrum,
    ggx: Ggx,
    n: [f32; 3],
    k: [f32; 3],
    /// c/(π·L).
    bounces: [f32; 3],
    losses: Losses,
    masking: Masking,
}

impl RoughConductor {
    /// From α along x and y (brought into [10⁻⁴, 1]), the complex index (see [`super::metals`]; each number brought
    /// into [0, 1000], NaN to 0) and a factor of the reflectance in [0, 1].
    #[inline]
    pub fn new(alpha: [f32; 2], n: [f32; 3], k: [f32; 3], tint: Spectrum, masking: Masking) -> Self {
        let usable = |v: f32| bounded(v, 0.0, 1e3);
        let (n, k) = (n.map(usable), k.map(usable));
        let (tint, ggx) = (unit_color(tint), Ggx::new(alpha));
        let mut metal = Self { tint, ggx, n, k, bounces: [0.0; 3], losses: Losses::default(), masking };
        if masking == Masking::Compensated && !ggx.is_smooth() {
            metal.losses = Losses::conductor(&ggx);
            metal.bounces = metal.bounces();
        }
        metal
    }

    fn bounces(&self) -> [f32; 3] {
        let lost = self.losses.mean(false);
        let normal = (self.tint * fresnel::conductor(1.0, self.n, self.k)).to_rgb();
        let tint = self.tint.to_rgb();
        std::array::from_fn(|i| {
            let mean = (tint[i] + 20.0 * normal[i]) / 21.0;
            let color = mean * mean * (1.0 - lost) / (1.0 - mean * lost).max(1e-6);
            color * FRAC_1_PI / lost.max(1e-9)
        })
    }

    /// Both directions above the surface.
    #[inline]
    fn eval_upper(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let h = wo + wi;
        let m = h * (1.0 / h.length());
        let (so, si) = (self.ggx.projected(wo), self.ggx.projected(wi));
        let d = self.ggx.d(m);
        let f = self.tint * fresnel::conductor(bounded(wo.dot(m), 0.0, 1.0), self.n, self.k);
        let single = BsdfEval {
            f_cos: f * (0.5 * d * self.ggx.masking(self.masking, (wo.z, so), (wi.z, si))),
            pdf: 0.5 * d / (wo.z + so),
        };
        if self.masking != Masking::Compensated {
            return single;
        }
        let (lo, li) = (self.losses.at(false, wo.z), self.losses.at(false, wi.z));
        BsdfEval {
            f_cos: single.f_cos + Spectrum::from_rgb(self.bounces) * (lo * li * wi.z),
            pdf: (1.0 - lo) * single.pdf + lo * wi.z * FRAC_1_PI,
        }
    }

    /// Light from many bounces leaves diffusely, and is chosen as often as it occurs; else a facet mirrors.
    #[inline]
    fn choose(&self, wo: Vec3, u: [f32; 3]) -> Vec3 {
        if self.masking == Masking::Compensated && u[2] < self.losses.at(false, wo.z) {
            return cosine_hemisphere([u[0], u[1]]);
        }
        let m = self.ggx.sample_visible(wo, [u[0], u[1]]);
        (m * (2.0 * wo.dot(m)) - wo).normalize()
    }
}

impl Scatter for RoughConductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Transport) -> BsdfEval {
        let Some((up, side)) = upper(wo) else { return BsdfEval::NONE };
        let wi = turned(wi, side);
        if wi.z <= GRAZING || self.ggx.is_smooth() {
            return BsdfEval::NONE;
        }
        self.eval_upper(up, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], _: Transport) -> Option<BsdfSample> {
        let (up, side) = upper(wo)?;
        if self.ggx.is_smooth() {
            return Some(BsdfSample::mirrored(wo, self.albedo(wo), 1.0));
        }
        let wi = self.choose(up, u);
        if wi.z <= GRAZING {
            return None;
        }
        BsdfSample::from_eval(turned(wi, side), self.eval_upper(up, wi), None)
    }

    /// F at the angle of `wo`: exact if smooth; the losses of rough metal are left out, and the facets' other angles.
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.tint * fresnel::conductor(wo.z.abs().min(1.0), self.n, self.k)
    }

    #[inline]
    fn is_delta_only(&self) -> bool {
        self.ggx.is_smooth()
    }

    #[inline]
    fn roughness(&self) -> f32 {
        self.ggx.roughness()
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{Case, check_energy, check_extremes, check_scatter, directions};
    use super::super::metals::Metal;
    use super::*;

    const MASKINGS: [Masking; 3] = [Masking::Correlated, Masking::Separable, Masking::Compensated];

    fn metal(name: &str, alpha: [f32; 2], masking: Masking) -> RoughConductor {
        let m = Metal::find(name).unwrap();
        RoughConductor::new(alpha, m.n, m.k, Spectrum::WHITE, masking)
    }

    fn white(alpha: [f32; 2], masking: Masking) -> RoughConductor {
        RoughConductor::new(alpha, [0.0; 3], [1.0; 3], Spectrum::WHITE, masking)
    }

    #[test]
    fn scatters_as_it_says() {
        for alpha in [[0.05, 0.05], [0.3, 0.3], [1.0, 1.0], [0.1, 0.5]] {
            for masking in MASKINGS {
                let gold = metal("gold", alpha, masking);
                check_scatter(&Case::new(&format!("gold {alpha:?} {masking:?}"), gold.into()));
            }
        }
    }

    #[test]
    fn compensated_white_metal_loses_less_than_a_hundredth() {
        for alpha in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 1.0] {
            let name = format!("white {alpha}");
            let b = white([alpha; 2], Masking::Compensated).into();
            check_energy(&Case { least_energy: 0.99, albedo_error: 0.02, ..Case::new(&name, b) });
        }
    }

    #[test]
    fn anisotropic_metal_gains_no_energy() {
        for alpha in [[0.05, 1.0], [0.2, 0.3], [1.0, 0.8], [0.45, 0.5], [0.3, 0.05]] {
            for masking in MASKINGS {
                check_energy(&Case::new(
                    &format!("white {alpha:?} {masking:?}"),
                    white(alpha, masking).into(),
                ));
            }
        }
    }

    #[test]
    fn smooth_metal_is_a_mirror() {
        let gold = metal("gold", [1e-8, 9e-4], Masking::Compensated);
        assert!(gold.is_delta_only() && gold.roughness() == 0.0);
        for wo in directions() {
            let s = gold.sample(wo, [0.5; 3], Transport::Radiance).unwrap();
            assert!(s.is_delta && s.wi == Vec3::new(-wo.x, -wo.y, wo.z) && s.pdf == 1.0);
            assert_eq!(s.weight, fresnel::conductor(wo.z.abs().min(1.0), gold.n, gold.k));
        }
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        for alpha in [[0.0; 2], [1e-8; 2], [1e-3; 2], [1.0; 2], [1e-8, 1.0], [f32::NAN, 0.5], [2.0, -1.0]] {
            for masking in MASKINGS {
                check_extremes(&format!("white {alpha:?} {masking:?}"), white(alpha, masking).into());
                check_extremes(&format!("gold {alpha:?} {masking:?}"), metal("gold", alpha, masking).into());
            }
        }
        for (n, k) in [(0.0, 0.0), (f32::NAN, f32::INFINITY), (-1.0, 1e30)] {
            let odd = RoughConductor::new([0.3; 2], [n; 3], [k; 3], Spectrum::WHITE, Masking::Compensated);
            check_extremes("odd metal", odd.into());
        }
    }
}
