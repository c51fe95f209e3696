//! `point`: light from one point.
//!
//! Physically based integrators use `intensity`, and the light falls off with the square of the distance; `classic` uses
//! `color`, and it does not.
//!
//! ```toml
//! [light.lamp]
//! type = "point"
//! position = [-5, 5, 5]
//! color = [1, 1, 1]
//! intensity = [100, 100, 100]
//! ```

use super::sampling::power;
use super::sampling::punctual::towards_point;
use super::{COLOR, INTENSITY, Light, LightSample};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamSpec};

/// Light from one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    position: Vec3,
    color: Spectrum,
    intensity: Spectrum,
}

impl Light for Point {
    const TYPE_NAME: &'static str = "point";
    const SCHEMA: &'static [ParamSpec] =
        &[ParamSpec::required("position", Kind::Vec3, "Where it stands.").unit("m"), COLOR, INTENSITY];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| Spectrum::from_rgb(p.color(name));
        Some(Self { position: p.vec3("position"), color: color("color"), intensity: color("intensity") })
    }

    fn classic_color(&self) -> Spectrum {
        self.color
    }

    fn center(&self) -> Vec3 {
        self.position
    }

    fn sample_towards(&self, from: Vec3, _: Vec2) -> Option<LightSample> {
        let way = towards_point(from, self.position)?;
        Some(LightSample::without_extent(way, self.position, self.intensity))
    }

    fn power(&self, _: f32) -> f32 {
        power::of_point(self.intensity.luminance())
    }
}
