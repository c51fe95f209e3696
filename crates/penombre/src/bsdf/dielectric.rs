//! A perfectly smooth boundary between dielectrics: glass, water.
//!
//! Reflects the share F by Fresnel's equations and refracts the rest by Snell's law; one of both is chosen in
//! proportion, tints included. In [`Transport::Radiance`] refraction scales by 1/η², η the index on the side of `wi`
//! relative to that of `wo`. An index of 1 lets light pass straight on. Source: \[PBRT4\], 9.5.

use super::{BsdfEval, BsdfSample, Scatter, Transport, fresnel, turned, unit_color, upper};
use penombre_math::{Spectrum, Vec3};

/// Smooth glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothDielectric {
    pub(super) eta: f32,
    pub(super) reflect: Spectrum,
    pub(super) transmit: Spectrum,
}

/// A relative index brought into [10⁻³, 10³]; 1 for NaN.
#[inline]
pub(super) fn usable_eta(eta: f32) -> f32 {
    if eta.is_nan() { 1.0 } else { eta.clamp(1e-3, 1e3) }
}

impl SmoothDielectric {
    /// From the index of the inside (−z) relative to the outside, brought into [10⁻³, 10³], and tints of reflection
    /// and transmission in [0, 1] (1 for real matter).
    #[inline]
    pub fn new(eta: f32, reflect: Spectrum, transmit: Spectrum) -> Self {
        Self { eta: usable_eta(eta), reflect: unit_color(reflect), transmit: unit_color(transmit) }
    }
}

impl SmoothDielectric {
    /// Index of the inside relative to the outside.
    pub fn eta(&self) -> f32 {
        self.eta
    }
}

impl Scatter for SmoothDielectric {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Transport) -> BsdfEval {
        BsdfEval::NONE
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: Transport) -> Option<BsdfSample> {
        let (up, side) = upper(wo)?;
        let eta = if side > 0.0 { self.eta } else { 1.0 / self.eta };
        let (f, cos_t) = fresnel::dielectric(up.z, eta);
        let (r, t) = (f * self.reflect.luminance(), (1.0 - f) * self.transmit.luminance());
        if r + t <= 0.0 {
            return None;
        }
        let probability = r / (r + t);
        if u[2] < probability {
            return Some(BsdfSample::mirrored(wo, self.reflect * (f / probability), probability));
        }
        let wi = if eta == 1.0 { -wo } else { turned(Vec3::new(-up.x / eta, -up.y / eta, -cos_t), side) };
        let pdf = 1.0 - probability;
        let scale = if mode == Transport::Radiance { 1.0 / (eta * eta) } else { 1.0 };
        let weight = self.transmit * ((1.0 - f) / pdf * scale);
        (pdf > 0.0).then_some(BsdfSample { wi, weight, pdf, is_delta: true, is_transmission: true, eta })
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let eta = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        let f = fresnel::dielectric(wo.z.abs().min(1.0), eta).0;
        self.reflect * f + self.transmit * (1.0 - f)
    }

    #[inline]
    fn is_delta_only(&self) -> bool {
        true
    }

    #[inline]
    fn roughness(&self) -> f32 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{Case, check_energy, check_extremes, directions};
    use super::*;

    #[test]
    fn energy_is_conserved_and_tints_apply() {
        for eta in [1.0, 1.5, 1.0 / 1.5, 2.4] {
            let glass = SmoothDielectric::new(eta, Spectrum::WHITE, Spectrum::WHITE);
            check_energy(&Case { least_energy: 0.9999, ..Case::new("glass", glass.into()) });
            let tinted =
                SmoothDielectric::new(eta, Spectrum::rgb(0.9, 0.2, 0.0), Spectrum::rgb(0.1, 1.0, 0.5));
            check_energy(&Case { albedo_error: 0.01, ..Case::new("tinted glass", tinted.into()) });
        }
    }

    #[test]
    fn refracts_by_snell_and_scales_radiance() {
        let glass = SmoothDielectric::new(1.5, Spectrum::WHITE, Spectrum::WHITE);
        for wo in directions() {
            let eta: f32 = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
            let Some(s) = glass.sample(wo, [0.0, 0.0, 0.999_999], Transport::Radiance) else { continue };
            if !s.is_transmission {
                assert!(wo.z < 0.0 && wo.truncate().length() > 1.0 / 1.5, "total reflection");
                continue;
            }
            assert!(s.wi.z * wo.z < 0.0 && (s.wi.length() - 1.0).abs() < 1e-6 && s.eta == eta);
            assert!((s.wi.truncate() * eta + wo.truncate()).length() < 1e-6);
            assert!((s.weight[1] * eta * eta - 1.0).abs() < 1e-6);
            let power = glass.sample(wo, [0.0, 0.0, 0.999_999], Transport::Importance).unwrap();
            assert!((power.weight[1] - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        for eta in [1.0, 1.0 / 1.5, 1.5, 1.0 + 1e-7, 0.0, -1.0, f32::NAN, f32::INFINITY] {
            check_extremes(
                &format!("glass {eta}"),
                SmoothDielectric::new(eta, Spectrum::WHITE, Spectrum::WHITE).into(),
            );
        }
        let straight = SmoothDielectric::new(1.0, Spectrum::WHITE, Spectrum::WHITE);
        for wo in directions() {
            assert_eq!(straight.sample(wo, [0.3; 3], Transport::Radiance).unwrap().wi, -wo);
        }
        check_extremes("black glass", SmoothDielectric::new(1.5, Spectrum::BLACK, Spectrum::BLACK).into());
    }
}
