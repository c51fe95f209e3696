//! Perfectly diffuse reflection.
//!
//! f = ρ/π, ρ the reflectance. Directions are drawn with density |cos θi|/π, so that every weight is ρ. Source:
//! \[PBRT4\], 9.2.

use super::sampling::cosine_hemisphere;
use super::{BsdfEval, BsdfSample, GRAZING, Scatter, Transport, turned, unit_color, upper};
use penombre_math::{Spectrum, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A diffuse reflector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    reflectance: Spectrum,
}

impl Lambert {
    /// With a reflectance, brought into [0, 1].
    #[inline]
    pub fn new(reflectance: Spectrum) -> Self {
        Self { reflectance: unit_color(reflectance) }
    }
}

impl Scatter for Lambert {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Transport) -> BsdfEval {
        let cos = wi.z * 1.0f32.copysign(wo.z);
        if wo.z.abs() <= GRAZING || cos <= GRAZING {
            return BsdfEval::NONE;
        }
        let pdf = cos * FRAC_1_PI;
        BsdfEval { f_cos: self.reflectance * pdf, pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], _: Transport) -> Option<BsdfSample> {
        let (_, side) = upper(wo)?;
        let wi = turned(cosine_hemisphere([u[0], u[1]]), side);
        let pdf = wi.z.abs() * FRAC_1_PI;
        let weight = self.reflectance;
        Some(BsdfSample { wi, weight, pdf, is_delta: false, is_transmission: false, eta: 1.0 })
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.reflectance
    }

    #[inline]
    fn is_delta_only(&self) -> bool {
        false
    }

    #[inline]
    fn roughness(&self) -> f32 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{Case, check_extremes, check_scatter};
    use super::*;

    #[test]
    fn scatters_as_it_says() {
        let gray = Lambert::new(Spectrum::rgb(0.2, 0.5, 1.0));
        check_scatter(&Case { albedo_error: 0.01, ..Case::new("lambert", gray.into()) });
        check_extremes("lambert", gray.into());
        check_extremes("odd lambert", Lambert::new(Spectrum::rgb(f32::NAN, -1.0, f32::INFINITY)).into());
    }
}
