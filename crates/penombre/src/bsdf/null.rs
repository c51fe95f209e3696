//! Surfaces that do not scatter: [`Null`] lets light pass straight on, [`Black`] absorbs it.
//!
//! A material with opacity α is itself with probability α and `Null` otherwise; one that only emits is `Black`.

use super::{BsdfEval, BsdfSample, Scatter, Transport, unit_color};
use penombre_math::{Spectrum, Vec3};

/// Lets light pass straight on, in all directions, along the surface too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Null {
    transmittance: Spectrum,
}

impl Null {
    /// With a transmittance, brought into [0, 1].
    #[inline]
    pub fn new(transmittance: Spectrum) -> Self {
        Self { transmittance: unit_color(transmittance) }
    }
}

impl Default for Null {
    fn default() -> Self {
        Self { transmittance: Spectrum::WHITE }
    }
}

impl Scatter for Null {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Transport) -> BsdfEval {
        BsdfEval::NONE
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: [f32; 3], _: Transport) -> Option<BsdfSample> {
        let weight = self.transmittance;
        Some(BsdfSample { wi: -wo, weight, pdf: 1.0, is_delta: true, is_transmission: true, eta: 1.0 })
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.transmittance
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

/// Absorbs all light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Black;

impl Scatter for Black {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Transport) -> BsdfEval {
        BsdfEval::NONE
    }

    #[inline]
    fn sample(&self, _: Vec3, _: [f32; 3], _: Transport) -> Option<BsdfSample> {
        None
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        Spectrum::BLACK
    }

    /// True: there is nothing to sample lights for.
    #[inline]
    fn is_delta_only(&self) -> bool {
        true
    }

    #[inline]
    fn roughness(&self) -> f32 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{check_extremes, directions};
    use super::*;

    #[test]
    fn null_passes_and_black_absorbs() {
        let null = Null::default();
        for wo in directions() {
            let s = null.sample(wo, [0.1, 0.9, 0.5], Transport::Importance).unwrap();
            assert_eq!((s.wi, s.weight, s.eta), (-wo, Spectrum::WHITE, 1.0));
            assert!(s.is_delta && s.is_transmission && null.is_delta_only());
            assert_eq!(Black.sample(wo, [0.5; 3], Transport::Radiance), None);
        }
        check_extremes("null", null.into());
        check_extremes("black", Black.into());
    }
}
