//! Rough glass: a boundary between dielectrics with GGX microfacets.
//!
//! Reflection as for metal, with the dielectric's F. Refraction, with η the index on the side of `wi` relative to that
//! of `wo` and m along ±(wo + η·wi):
//! f = (1 − F)·D(m)·G2·|wo·m|·|wi·m|·η²/(cos θo·cos θi·|wo + η·wi|²) in [`Transport::Importance`], divided by η² in
//! [`Transport::Radiance`]. Normals are drawn among the visible ones, then reflection or refraction in proportion to F
//! and 1 − F, tints included. Source: \[Walter2007\], \[PBRT4\], 9.7, \[Dupuy2023\].
//!
//! Reciprocal up to the index: `f(wo, wi)` in one mode is `f(wi, wo)` in the other.
//!
//! With [`Masking::Compensated`], f gains x·l(wo)·l(wi)/(π·L) for reflection and (1 − x)·l(wo)·l(wi)/(π·L′) for
//! refraction (Importance): l is the share of light that single scattering loses on the side of its argument, L and L′
//! its means on the side of `wo` and on the other, \[Kulla2017\]. It keeps reciprocity if (1 − x)/(L′·η²) is the same on
//! both sides; we take 1 − x = (1 − F̄)·L′/max(L, L′), F̄ the mean of F.
//!
//! If both α are below 10⁻³, or the larger times |η − 1| is below 10⁻⁵ (lobes narrower than single precision resolves),
//! it is a [`SmoothDielectric`].

use super::dielectric::usable_eta;
use super::energy::Losses;
use super::sampling::cosine_hemisphere;
use super::{
    BsdfEval, BsdfSample, GRAZING, Ggx, Masking, Scatter, SmoothDielectric, Transport, bounded, fresnel,
    turned, unit_color, upper,
};
use penombre_math::{Spectrum, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Rough glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    reflect: Spectrum,
    transmit: Spectrum,
    ggx: Ggx,
    eta: f32,
    losses: Losses,
    /// Light of many bounces, seen from the rarer side and from the denser one.
    bounces: [Bounces; 2],
    masking: Masking,
    is_smooth: bool,
}

/// Where light goes that met the surface more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bounces {
    /// x: the share that stays on its side.
    reflected: f32,
    /// 1/(π·L).
    scale: f32,
}

/// One side of the boundary: η from there, and whether that is the denser side.
#[derive(Clone, Copy, Debug)]
struct Side {
    eta: f32,
    dense: bool,
}

impl RoughDielectric {
    /// From α along x and y (brought into [10⁻⁴, 1]), the index of the inside (−z) relative to the outside (brought
    /// into [10⁻³, 10³]) and tints of reflection and transmission in [0, 1] (1 for real matter).
    #[inline]
    pub fn new(alpha: [f32; 2], eta: f32, reflect: Spectrum, transmit: Spectrum, masking: Masking) -> Self {
        let (ggx, eta) = (Ggx::new(alpha), usable_eta(eta));
        let [ax, ay] = ggx.alpha();
        let mut glass = Self {
            reflect: unit_color(reflect),
            transmit: unit_color(transmit),
            ggx,
            eta,
            losses: Losses::default(),
            bounces: [Bounces::default(); 2],
            masking,
            is_smooth: ggx.is_smooth() || ax.max(ay) * (eta - 1.0).abs().min((1.0 / eta - 1.0).abs()) < 1e-5,
        };
        if masking == Masking::Compensated && !glass.is_smooth {
            glass.losses = Losses::dielectric(&ggx, eta);
            glass.bounces = glass.bounces();
        }
        glass
    }

    fn bounces(&self) -> [Bounces; 2] {
        let eta = self.eta.max(1.0 / self.eta);
        let refracted = 1.0 - fresnel::dielectric_mean(eta);
        let lost = [self.losses.mean(false), self.losses.mean(true)].map(|l| l.max(1e-9));
        let larger = lost[0].max(lost[1]);
        [(refracted, 0, 1), (refracted / (eta * eta), 1, 0)].map(|(refracted, here, there)| Bounces {
            reflected: 1.0 - refracted * lost[there] / larger,
            scale: FRAC_1_PI / lost[here],
        })
    }

    #[inline]
    fn smooth(&self) -> SmoothDielectric {
        SmoothDielectric { eta: self.eta, reflect: self.reflect, transmit: self.transmit }
    }

    #[inline]
    fn side(&self, side: f32) -> Side {
        let eta = if side > 0.0 { self.eta } else { 1.0 / self.eta };
        Side { eta, dense: eta < 1.0 }
    }

    /// Probability of reflection at a facet.
    #[inline]
    fn reflection(&self, f: f32) -> f32 {
        let (r, t) = (f * self.reflect.luminance(), (1.0 - f) * self.transmit.luminance());
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }

    /// `wo` above the surface, neither direction in it.
    #[inline]
    fn eval_upper(&self, wo: Vec3, wi: Vec3, side: Side, mode: Transport) -> BsdfEval {
        let scale = if mode == Transport::Radiance { 1.0 / (side.eta * side.eta) } else { 1.0 };
        let tint = if wi.z > 0.0 { self.reflect } else { self.transmit * scale };
        let single = self.single(wo, wi, side.eta);
        if self.masking != Masking::Compensated {
            return BsdfEval { f_cos: tint * single.0, pdf: single.1 };
        }
        let (many, choice) = self.many(wo, wi, side);
        let lo = self.losses.at(side.dense, wo.z);
        BsdfEval {
            f_cos: tint * (single.0 + many),
            pdf: (1.0 - lo) * single.1 + lo * choice * wi.z.abs() * FRAC_1_PI,
        }
    }

    /// Light that met one facet: f·cos without tint, in `Importance`, and density.
    #[inline]
    fn single(&self, wo: Vec3, wi: Vec3, eta: f32) -> (f32, f32) {
        let is_reflection = wi.z > 0.0;
        let h = wo + wi * if is_reflection { 1.0 } else { eta };
        let length2 = h.length_squared();
        let m = h * (1.0f32.copysign(h.z) / length2.sqrt());
        let (co, ci) = (wo.dot(m), wi.dot(m) * 1.0f32.copysign(wi.z));
        // Facets seen from behind, and h = 0, for which m is NaN.
        if !(co > 0.0 && ci > 0.0) {
            return (0.0, 0.0);
        }
        // Near total reflection the cosine behind the boundary is known better from `wi` than from Snell's law.
        let f = if is_reflection {
            fresnel::dielectric(co.min(1.0), eta).0
        } else {
            fresnel::dielectric_of_pair(co, ci, eta)
        };
        let r = self.reflection(f);
        let (share, choice) = if is_reflection { (f, r) } else { (1.0 - f, 1.0 - r) };
        let jacobian = if is_reflection { 0.25 } else { co * ci * eta * eta / length2 };
        let (so, si) = (self.ggx.projected(wo), self.ggx.projected(wi));
        let facets = 2.0 * self.ggx.d(m) * jacobian;
        let masking = self.ggx.masking(self.masking, (wo.z, so), (wi.z.abs(), si));
        (share * facets * masking, choice * facets / (wo.z + so))
    }

    /// Light of many bounces: f·cos without tint, in `Importance`, and the probability of the side of `wi`.
    #[inline]
    fn many(&self, wo: Vec3, wi: Vec3, side: Side) -> (f32, f32) {
        let [here, there] = [usize::from(side.dense), usize::from(!side.dense)];
        let is_reflection = wi.z > 0.0;
        let x = self.bounces[here].reflected;
        let (share, target) = if is_reflection { (x, here) } else { (1.0 - x, there) };
        let losses = self.losses.at(side.dense, wo.z) * self.losses.at(target == 1, wi.z.abs());
        (share * losses * self.bounces[target].scale * wi.z.abs(), share)
    }

    #[inline]
    fn choose(&self, wo: Vec3, u: [f32; 3], side: Side) -> Vec3 {
        let mut choice = u[2];
        if self.masking == Masking::Compensated {
            let lost = self.losses.at(side.dense, wo.z);
            if choice < lost {
                let reflected = self.bounces[usize::from(side.dense)].reflected;
                let w = cosine_hemisphere([u[0], u[1]]);
                return if choice < lost * reflected { w } else { -w };
            }
            choice = (choice - lost) / (1.0 - lost);
        }
        let m = self.ggx.sample_visible(wo, [u[0], u[1]]);
        let cos = wo.dot(m);
        let (f, cos_t) = fresnel::dielectric(bounded(cos, 0.0, 1.0), side.eta);
        if choice < self.reflection(f) {
            let w = m * (2.0 * cos) - wo;
            if w.z > 0.0 { w.normalize() } else { Vec3::ZERO }
        } else {
            let w = m * (cos / side.eta - cos_t) - wo / side.eta;
            if w.z < 0.0 { w.normalize() } else { Vec3::ZERO }
        }
    }
}

impl Scatter for RoughDielectric {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Transport) -> BsdfEval {
        let Some((up, side)) = upper(wo) else { return BsdfEval::NONE };
        if wi.z.abs() <= GRAZING || self.is_smooth {
            return BsdfEval::NONE;
        }
        self.eval_upper(up, turned(wi, side), self.side(side), mode)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: Transport) -> Option<BsdfSample> {
        if self.is_smooth {
            return self.smooth().sample(wo, u, mode);
        }
        let (up, turn) = upper(wo)?;
        let side = self.side(turn);
        let wi = self.choose(up, u, side);
        if wi.z.abs() <= GRAZING {
            return None; // the chosen direction lies on the wrong side of the surface
        }
        let eval = self.eval_upper(up, wi, side, mode);
        BsdfSample::from_eval(turned(wi, turn), eval, (wi.z < 0.0).then_some(side.eta))
    }

    /// That of the smooth boundary; the losses of rough glass are left out, and the facets' other angles.
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.smooth().albedo(wo)
    }

    #[inline]
    fn is_delta_only(&self) -> bool {
        self.is_smooth
    }

    #[inline]
    fn roughness(&self) -> f32 {
        if self.is_smooth { 0.0 } else { self.ggx.roughness() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{Case, check_energy, check_extremes, check_scatter, pairs};
    use super::*;

    const MASKINGS: [Masking; 3] = [Masking::Correlated, Masking::Separable, Masking::Compensated];

    fn glass(alpha: [f32; 2], eta: f32, masking: Masking) -> RoughDielectric {
        RoughDielectric::new(alpha, eta, Spectrum::WHITE, Spectrum::WHITE, masking)
    }

    #[test]
    fn scatters_as_it_says() {
        for (alpha, eta) in [
            ([0.05; 2], 1.5),
            ([0.3; 2], 1.5),
            ([1.0; 2], 1.5),
            ([0.1, 0.5], 1.5),
            ([0.3; 2], 1.0 / 1.5),
            ([0.5; 2], 2.4),
        ] {
            for masking in MASKINGS {
                let name = format!("rough glass {alpha:?} {eta} {masking:?}");
                check_scatter(&Case::new(&name, glass(alpha, eta, masking).into()));
            }
        }
    }

    #[test]
    fn tints_keep_weight_and_density_together() {
        let (r, t) = (Spectrum::rgb(0.9, 0.1, 0.3), Spectrum::rgb(0.1, 0.8, 1.0));
        for masking in MASKINGS {
            check_scatter(&Case::new("tinted", RoughDielectric::new([0.4; 2], 1.5, r, t, masking).into()));
        }
    }

    #[test]
    fn compensated_glass_loses_less_than_three_thousandths() {
        for eta in [1.33, 1.5, 1.0 / 1.5, 1.8, 2.42] {
            for alpha in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 1.0] {
                let name = format!("glass {alpha} {eta}");
                let b = glass([alpha; 2], eta, Masking::Compensated).into();
                check_energy(&Case { least_energy: 0.997, albedo_error: 0.02, ..Case::new(&name, b) });
            }
        }
    }

    #[test]
    fn no_glass_gains_energy() {
        for masking in MASKINGS {
            for alpha in [[0.05, 1.0], [0.2, 0.3], [1.0, 0.8], [0.02, 0.02], [0.6, 0.6]] {
                for eta in [1.5, 1.05, 1.2, 1.0 / 3.0, 10.0] {
                    let name = format!("glass {alpha:?} {eta} {masking:?}");
                    let case = Case::new(&name, glass(alpha, eta, masking).into());
                    // What is given back is in all weights, what is lost in one of 10⁴ or 10⁵: it must be met.
                    let is_rare = masking == Masking::Compensated && alpha == [0.02; 2];
                    let samples = if is_rare { 400_000 } else { case.samples };
                    check_energy(&Case { samples, ..case });
                }
            }
        }
    }

    /// Radiance is scaled by 1/η² against importance, and then f/η² of refraction is symmetric.
    #[test]
    fn refraction_is_reciprocal_up_to_the_square_of_the_index() {
        for masking in MASKINGS {
            let b = glass([0.5, 0.3], 1.5, masking);
            for (wo, wi) in pairs(2000).filter(|(wo, wi)| wo.z * wi.z < 0.0) {
                let eta: f32 = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
                let f = |a, b: Vec3, mode, g: &RoughDielectric| g.eval(a, b, mode).f_cos[0] / b.z.abs();
                let (there, back) = (f(wo, wi, Transport::Radiance, &b), f(wi, wo, Transport::Radiance, &b));
                let power = f(wo, wi, Transport::Importance, &b);
                assert!((there * eta * eta - power).abs() <= 1e-5 * power);
                assert!(
                    (there * eta * eta - back).abs() <= 1e-3 * back.max(1e-4),
                    "{wo} {wi}: {there} {back}"
                );
            }
        }
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        for alpha in [[0.0; 2], [1e-8; 2], [1e-3; 2], [0.3; 2], [1.0; 2], [1e-8, 1.0], [f32::NAN, 0.5]] {
            for eta in [1.0, 1.0 / 1.5, 1.5, 1.0 + 1e-6, 1.0001, 0.0, f32::NAN, f32::INFINITY] {
                for masking in MASKINGS {
                    check_extremes(
                        &format!("glass {alpha:?} {eta} {masking:?}"),
                        glass(alpha, eta, masking).into(),
                    );
                }
            }
        }
    }
}
