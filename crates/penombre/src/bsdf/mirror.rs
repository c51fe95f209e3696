//! A perfect mirror.
//!
//! All light leaves in the mirrored direction, times a reflectance that does not depend on the angle. (A metal
//! with Fresnel's reflectance is a [`super::RoughConductor`] of roughness 0.) Source: \[PBRT4\], 9.3.

use super::{BsdfEval, BsdfSample, Scatter, Transport, unit_color, upper};
use penombre_math::{Spectrum, Vec3};

/// A mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    reflectance: Spectrum,
}

impl Mirror {
    /// With a reflectance, brought into [0, 1].
    #[inline]
    pub fn new(reflectance: Spectrum) -> Self {
        Self { reflectance: unit_color(reflectance) }
    }
}

impl Scatter for Mirror {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Transport) -> BsdfEval {
        BsdfEval::NONE
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: [f32; 3], _: Transport) -> Option<BsdfSample> {
        upper(wo).map(|_| BsdfSample::mirrored(wo, self.reflectance, 1.0))
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.reflectance
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
    use super::super::check::{check_extremes, directions};
    use super::*;

    #[test]
    fn reflects_on_both_sides() {
        let mirror = Mirror::new(Spectrum::rgb(0.9, 0.5, 1.5));
        for wo in directions() {
            let s = mirror.sample(wo, [0.5; 3], Transport::Radiance).unwrap();
            assert_eq!(s.wi, Vec3::new(-wo.x, -wo.y, wo.z));
            assert_eq!((s.weight, s.pdf, s.is_delta), (Spectrum::rgb(0.9, 0.5, 1.0), 1.0, true));
        }
        check_extremes("mirror", mirror.into());
    }
}
