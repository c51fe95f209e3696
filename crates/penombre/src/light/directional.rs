//! `directional` (also `sun`, `distant`): parallel light, as from the sun.
//!
//! It travels along `direction` and gives every surface across it the irradiance `irradiance`; a tilted one gets
//! E·|cos θ|. No distance weakens it. `classic` uses `color`.
//!
//! ```toml
//! [light.sun]
//! type = "directional"
//! direction = [-0.3, -1, -0.2]
//! color = [1, 1, 1]
//! irradiance = [3, 3, 3]
//! ```

use super::sampling::power;
use super::sampling::punctual::against;
use super::{COLOR, Light, LightSample};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// Distance of the point that stands for it in `classic`, metres: directions towards it from points up to 10⁵ m around
/// the origin differ by at most 10⁻⁷, the grain of single precision. Its cube still fits that.
const FAR_AWAY: f32 = 1e12;

/// Parallel light.
#[derive(Clone, Debug, PartialEq)]
pub struct Directional {
    /// Unit.
    direction: Vec3,
    color: Spectrum,
    irradiance: Spectrum,
}

impl Light for Directional {
    const TYPE_NAME: &'static str = "directional";
    const ALIASES: &'static [&'static str] = &["sun", "distant"];
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("direction", Kind::Direction, "The way of the light, of any length."),
        COLOR,
        ParamSpec::with_default(
            "irradiance",
            Kind::Color(Range::NON_NEGATIVE),
            ParamDefault::Color([1.0; 3]),
            "On a surface across it; physically based integrators only.",
        )
        .unit("W/m²"),
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| Spectrum::from_rgb(p.color(name));
        let direction = p.vec3("direction").as_dvec3().try_normalize()?.as_vec3();
        Some(Self { direction, color: color("color"), irradiance: color("irradiance") })
    }

    fn classic_color(&self) -> Spectrum {
        self.color
    }

    fn center(&self) -> Vec3 {
        self.direction * -FAR_AWAY
    }

    fn sample_towards(&self, _: Vec3, _: Vec2) -> Option<LightSample> {
        Some(LightSample::without_extent(against(self.direction), self.center(), self.irradiance))
    }

    fn is_infinite(&self) -> bool {
        true
    }

    fn power(&self, scene_radius: f32) -> f32 {
        power::of_directional(self.irradiance.luminance(), scene_radius)
    }
}
