//! The modified Phong model: diffuse plus a cosine lobe about the mirrored direction.
//!
//! f = kd/π + ks·(n + 2)/(2π)·cosⁿ α, α the angle between `wi` and the mirrored `wo`, 0 beyond 90°. It is reciprocal
//! and, with kd + ks ≤ 1, conserves energy. The lobe is drawn with density (n + 1)/(2π)·cosⁿ α; what of it goes below
//! the surface is absorbed. One of both parts is chosen in proportion to the luminances of kd and ks. Source:
//! \[Lafortune1994\].

use super::sampling::cosine_hemisphere;
use super::{BsdfEval, BsdfSample, GRAZING, Scatter, Transport, bounded, turned, upper};
use penombre_math::{Frame, Spectrum, Vec3, float};
use std::f32::consts::{FRAC_1_PI, PI};

/// Largest exponent.
const SHARPEST: f32 = 1e6;

/// Diffuse and a cosine lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    diffuse: Spectrum,
    specular: Spectrum,
    exponent: f32,
    /// Probability of the diffuse part.
    choice: f32,
}

impl Phong {
    /// From kd, ks and n. Negative and NaN colours count as 0; if kd + ks exceeds 1 in a lane, both are divided by
    /// the largest sum. n is brought into [0, 10⁶].
    #[inline]
    pub fn new(diffuse: Spectrum, specular: Spectrum, exponent: f32) -> Self {
        let usable = |c: Spectrum| Spectrum::from_rgb(c.to_rgb().map(|v| bounded(v, 0.0, 1e9)));
        let (diffuse, specular) = (usable(diffuse), usable(specular));
        let scale = 1.0 / (diffuse + specular).max_component().max(1.0);
        let (d, s) = (diffuse.luminance(), specular.luminance());
        Self {
            diffuse: diffuse * scale,
            specular: specular * scale,
            exponent: bounded(exponent, 0.0, SHARPEST),
            choice: if d + s > 0.0 { d / (d + s) } else { 1.0 },
        }
    }

    /// cosⁿ α of two unit vectors, by their distance: for sharp lobes their product would be too coarse.
    #[inline]
    fn lobe(&self, mirrored: Vec3, wi: Vec3) -> f32 {
        let x = 0.5 * mirrored.distance_squared(wi); // 1 − cos α
        if x >= 1.0 {
            return 0.0;
        }
        let ln =
            if x < 0.01 { -x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + 0.25 * x))) } else { float::ln(1.0 - x) };
        float::exp(self.exponent * ln)
    }

    /// A direction of the lobe around +z.
    #[inline]
    fn sample_lobe(&self, u: [f32; 2]) -> Vec3 {
        let t = -float::ln(1.0 - u[0]) / (self.exponent + 1.0); // −ln cos α
        let x =
            if t < 0.01 { t * (1.0 - t * (0.5 - t * (1.0 / 6.0 - t / 24.0))) } else { 1.0 - float::exp(-t) };
        let sin = (x * (2.0 - x)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = float::sin_cos(2.0 * PI * u[1]);
        Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - x)
    }
}

impl Scatter for Phong {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Transport) -> BsdfEval {
        let cos = wi.z * 1.0f32.copysign(wo.z);
        if wo.z.abs() <= GRAZING || cos <= GRAZING {
            return BsdfEval::NONE;
        }
        let lobe = self.lobe(Vec3::new(-wo.x, -wo.y, wo.z), wi) * (0.5 * FRAC_1_PI);
        BsdfEval {
            f_cos: (self.diffuse * FRAC_1_PI + self.specular * ((self.exponent + 2.0) * lobe)) * cos,
            pdf: self.choice * (cos * FRAC_1_PI) + (1.0 - self.choice) * ((self.exponent + 1.0) * lobe),
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: Transport) -> Option<BsdfSample> {
        let (_, side) = upper(wo)?;
        let wi = if u[2] < self.choice {
            turned(cosine_hemisphere([u[0], u[1]]), side)
        } else {
            let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
            Frame::from_z(mirrored).to_world(self.sample_lobe([u[0], u[1]])).normalize()
        };
        BsdfSample::from_eval(wi, self.eval(wo, wi, mode), None)
    }

    /// kd + ks·(c + √(c² + 4g²(1 − c²)))/2 with c = |cos θo|, g = 1/√(4 + 2πn): exact for n = 0 and, in the limit,
    /// for large n; the part of the lobe that is cut by the horizon was measured to be within 0.02.
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let c2 = (wo.z * wo.z).min(1.0);
        let root = (c2 + 4.0 * (1.0 - c2) / (4.0 + 2.0 * PI * self.exponent)).sqrt();
        self.diffuse + self.specular * (0.5 * (c2.sqrt() + root))
    }

    #[inline]
    fn is_delta_only(&self) -> bool {
        false
    }

    /// α = √(2/(n + 2)).
    #[inline]
    fn roughness(&self) -> f32 {
        if self.specular.is_black() { 1.0 } else { (2.0 / (self.exponent + 2.0)).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::{Case, check_extremes, check_scatter};
    use super::*;

    #[test]
    fn scatters_as_it_says() {
        let (kd, ks) = (Spectrum::rgb(0.5, 0.2, 0.1), Spectrum::rgb(0.4, 0.6, 0.9));
        for (kd, exponent) in [(kd, 16.0), (kd, 1.0), (kd, 3000.0), (Spectrum::BLACK, 100.0)] {
            let phong = Phong::new(kd, ks, exponent);
            check_scatter(&Case {
                albedo_error: 0.02,
                ..Case::new(&format!("phong {exponent}"), phong.into())
            });
        }
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        for exponent in [0.0, 1e-8, 1.0, 1e6, f32::NAN, f32::INFINITY, -5.0] {
            let phong = Phong::new(Spectrum::WHITE, Spectrum::WHITE, exponent);
            check_extremes(&format!("phong {exponent}"), phong.into());
        }
        check_extremes("black phong", Phong::new(Spectrum::BLACK, Spectrum::BLACK, 3.0).into());
        check_extremes(
            "odd phong",
            Phong::new(Spectrum::rgb(f32::NAN, -1.0, f32::INFINITY), Spectrum::WHITE, 9.0).into(),
        );
    }

    /// Sharper than single precision can tell cosines apart.
    #[test]
    fn a_lobe_of_exponent_a_million_keeps_its_energy() {
        let phong = Phong::new(Spectrum::BLACK, Spectrum::WHITE, 1e6);
        for wo in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
            let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
            for i in 1..1000 {
                let s = phong.sample(wo, [i as f32 / 1000.0, 0.37, 0.5], Transport::Radiance).unwrap();
                let x = f64::from(s.wi.distance(mirrored)).powi(2) / 2.0;
                let expected = 1e6 / (2.0 * std::f64::consts::PI) * (-1e6 * x).exp();
                assert!((f64::from(s.pdf) / expected - 1.0).abs() < 1e-3, "{i}: {} {expected}", s.pdf);
                assert!((s.weight[0] / wo.z - 1.0).abs() < 5e-3);
            }
        }
    }
}
