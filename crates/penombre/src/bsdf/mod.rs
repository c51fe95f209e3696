//! Scattering at surfaces: how much light goes from one direction to another, and how to choose directions.
//!
//! The models of the path tracer, one file each, in pbrt's terms \[PBRT4\]. They know no textures and no scene:
//! a material reads its textures and returns a [`Bsdf`].
//!
//! Conventions. All directions are unit vectors in the local frame, shading normal at +z, and point away from
//! the surface. `wo` is where the path comes from, `wi` where it goes on. Models that only reflect answer alike
//! on both sides; a one-sided material returns [`Bsdf::Black`] for its back. +z is the outside of dielectrics.
//! Directions within 10⁻¹⁰ of the horizon scatter nothing. Constructors bring their parameters into range, so
//! that no value is ever NaN, infinite or negative.

use penombre_math::{Spectrum, Vec3};

pub mod dielectric;
pub mod energy;
mod energy_table;
pub mod fresnel;
pub mod ggx;
pub mod lambert;
pub mod metals;
pub mod mirror;
pub mod null;
pub mod phong;
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod sampling;
pub mod shading_normal;

#[cfg(test)]
mod check;
#[cfg(test)]
mod tests;

pub use dielectric::SmoothDielectric;
pub use ggx::{Ggx, Masking};
pub use lambert::Lambert;
pub use mirror::Mirror;
pub use null::{Black, Null};
pub use phong::Phong;
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;

/// What is carried along the path, which decides how refraction scales it (\[Veach1997\], chapter 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transport {
    /// The path starts at the camera: refraction scales radiance by the square of the relative index.
    #[default]
    Radiance,
    /// The path starts at a light: power is conserved.
    Importance,
}

/// Value and density for a pair of directions. Perfectly specular parts are in neither.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfEval {
    /// f(wo, wi)·|cos θi|, 1/sr.
    pub f_cos: Spectrum,
    /// Density per solid angle with which [`Scatter::sample`] returns `wi`.
    pub pdf: f32,
}

impl BsdfEval {
    /// Nothing is scattered.
    pub const NONE: Self = Self { f_cos: Spectrum::BLACK, pdf: 0.0 };
}

/// A chosen direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where the path goes on, unit.
    pub wi: Vec3,
    /// f·|cos θi| / pdf: what the path's throughput is multiplied by.
    pub weight: Spectrum,
    /// Density per solid angle, or probability if `is_delta`. Above 0.
    pub pdf: f32,
    /// True if the direction was the only possible one of its kind.
    pub is_delta: bool,
    /// True if `wi` lies on the other side of the surface.
    pub is_transmission: bool,
    /// Index of refraction on the side of `wi` relative to that of `wo`; 1 for reflection.
    pub eta: f32,
}

impl BsdfSample {
    /// Of a direction drawn with the density of `eval`; none if that density is 0. `eta` for transmission.
    #[inline]
    fn from_eval(wi: Vec3, eval: BsdfEval, transmitted_eta: Option<f32>) -> Option<Self> {
        let inverse = 1.0 / eval.pdf;
        (eval.pdf > 0.0 && inverse < f32::MAX).then(|| Self {
            wi,
            weight: eval.f_cos * inverse,
            pdf: eval.pdf,
            is_delta: false,
            is_transmission: transmitted_eta.is_some(),
            eta: transmitted_eta.unwrap_or(1.0),
        })
    }

    /// The mirrored direction, chosen with a probability.
    #[inline]
    fn mirrored(wo: Vec3, weight: Spectrum, probability: f32) -> Self {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        Self { wi, weight, pdf: probability, is_delta: true, is_transmission: false, eta: 1.0 }
    }
}

/// A scattering model.
pub trait Scatter: Copy {
    /// Value and density for two directions.
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Transport) -> BsdfEval;

    /// Draws `wi` by three uniform numbers in [0, 1): two for the direction, the third for the choice among
    /// lobes. `None`: absorbed.
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: Transport) -> Option<BsdfSample>;

    /// Share of the power from `wo` that is scattered, in [0, 1]; an approximation for models without a
    /// closed form. For feature images and choices, not for estimates.
    fn albedo(&self, wo: Vec3) -> Spectrum;

    /// True if all directions are delta: light sampling is in vain.
    fn is_delta_only(&self) -> bool;

    /// Width of the narrowest lobe as a GGX α, in [0, 1]; 0 for perfectly specular, 1 for diffuse.
    fn roughness(&self) -> f32;
}

/// Declares the closed enum and its dispatch.
macro_rules! bsdfs {
    ($($(#[$doc:meta])* $type:ident),+ $(,)?) => {
        /// Any scattering model.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Bsdf { $($(#[$doc])* $type($type)),+ }

        impl Bsdf {
            /// The delta lobe of reflection or transmission: a sample of it, whose weight is the lobe's value and whose
            /// density is the probability with which [`Scatter::sample`] chooses it.
            #[inline]
            pub fn delta_lobe(&self, wo: Vec3, transmitted: bool) -> Option<BsdfSample> {
                let choice = if transmitted { 1.0f32.next_down() } else { 0.0 };
                let s = self.sample(wo, [0.5, 0.5, choice], Transport::Radiance)?;
                let right = s.is_delta && s.is_transmission == transmitted;
                right.then(|| BsdfSample { weight: s.weight * s.pdf, ..s })
            }

            /// False if the third number of [`Scatter::sample`] is of no use.
            #[inline]
            pub fn uses_lobe_choice(&self) -> bool {
                !matches!(self, Self::Lambert(_) | Self::Mirror(_) | Self::Null(_) | Self::Black(_))
            }
        }

        impl Scatter for Bsdf {
            #[inline]
            fn eval(&self, wo: Vec3, wi: Vec3, mode: Transport) -> BsdfEval {
                match self { $(Self::$type(b) => b.eval(wo, wi, mode)),+ }
            }

            #[inline]
            fn sample(&self, wo: Vec3, u: [f32; 3], mode: Transport) -> Option<BsdfSample> {
                match self { $(Self::$type(b) => b.sample(wo, u, mode)),+ }
            }

            #[inline]
            fn albedo(&self, wo: Vec3) -> Spectrum {
                match self { $(Self::$type(b) => b.albedo(wo)),+ }
            }

            #[inline]
            fn is_delta_only(&self) -> bool {
                match self { $(Self::$type(b) => b.is_delta_only()),+ }
            }

            #[inline]
            fn roughness(&self) -> f32 {
                match self { $(Self::$type(b) => b.roughness()),+ }
            }
        }

        $(impl From<$type> for Bsdf {
            #[inline]
            fn from(b: $type) -> Self {
                Self::$type(b)
            }
        })+
    };
}

bsdfs! {
    /// Diffuse.
    Lambert,
    /// Diffuse and a cosine lobe.
    Phong,
    /// Perfect mirror.
    Mirror,
    /// Smooth glass.
    SmoothDielectric,
    /// Rough glass.
    RoughDielectric,
    /// Metal.
    RoughConductor,
    /// Lets light pass straight on.
    Null,
    /// Absorbs everything.
    Black,
}

/// Cosines to the normal below this scatter nothing: products of two of them are still far from underflow.
const GRAZING: f32 = 1e-10;

/// A number brought into `least..=most`; NaN gives `least`.
#[inline]
fn bounded(v: f32, least: f32, most: f32) -> f32 {
    if v > least { v.min(most) } else { least }
}

/// A tint or reflectance: each lane brought into [0, 1], NaN to 0.
#[inline]
fn unit_color(color: Spectrum) -> Spectrum {
    Spectrum::from_rgb(color.to_rgb().map(|v| bounded(v, 0.0, 1.0)))
}

/// Turns both directions so that `wo` lies above the surface. `None` if it lies in it.
#[inline]
fn upper(wo: Vec3) -> Option<(Vec3, f32)> {
    let side = 1.0f32.copysign(wo.z);
    (wo.z.abs() > GRAZING).then(|| (Vec3::new(wo.x, wo.y, wo.z.abs()), side))
}

/// The direction with z times `side`, which is 1 or −1.
#[inline]
fn turned(w: Vec3, side: f32) -> Vec3 {
    Vec3::new(w.x, w.y, w.z * side)
}
