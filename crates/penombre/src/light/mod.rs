//! Lights.
//!
//! In the `classic` integrator a light's shape is no surface: rays do not see it, it hides nothing, it shines to
//! both sides, and its light does not fall off with distance.
//!
//! [`sampling`] holds what the physically based integrators need: directions towards lights and their densities.

pub mod sampling;

use crate::registry::{Context, registry};
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A source of light.
pub trait Light: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// Its colour in the `classic` integrator.
    fn classic_color(&self) -> Spectrum;

    /// Its middle, world space, metres.
    fn center(&self) -> Vec3;

    /// Number of shadow rays per shaded point in the `classic` integrator; 0: the light is a point.
    fn shadow_samples(&self) -> u32 {
        0
    }

    /// The point of the light for `u` in the unit square, uniform over its area.
    fn sample_point(&self, _u: Vec2) -> Vec3 {
        self.center()
    }
}

/// Declares the lights: the module, then the type.
macro_rules! lights {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any light.
            AnyLight: Light { $($module::$type),+ }
        }

        impl AnyLight {
            /// Its colour in the `classic` integrator.
            pub fn classic_color(&self) -> Spectrum {
                match self { $(Self::$type(l) => l.classic_color()),+ }
            }

            /// Its middle, world space, metres.
            pub fn center(&self) -> Vec3 {
                match self { $(Self::$type(l) => l.center()),+ }
            }

            /// Number of shadow rays per shaded point in the `classic` integrator; 0: the light is a point.
            pub fn shadow_samples(&self) -> u32 {
                match self { $(Self::$type(l) => l.shadow_samples()),+ }
            }

            /// The point of the light for `u` in the unit square, uniform over its area.
            pub fn sample_point(&self, u: Vec2) -> Vec3 {
                match self { $(Self::$type(l) => l.sample_point(u)),+ }
            }
        }
    };
}

lights! {
    point::Point,
    quad::QuadLight,
}

const COLOR: ParamSpec = ParamSpec::with_default(
    "color",
    Kind::Color(Range::NON_NEGATIVE),
    ParamDefault::Color([1.0; 3]),
    "Colour and strength in the `classic` integrator.",
);
