//! `point`: light from one point.
//!
//! ```toml
//! [light.lamp]
//! type = "point"
//! position = [-5, 5, 5]
//! color = [1, 1, 1]
//! ```

use super::{COLOR, Light};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamSpec};

/// Light from one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    position: Vec3,
    color: Spectrum,
}

impl Light for Point {
    const TYPE_NAME: &'static str = "point";
    const SCHEMA: &'static [ParamSpec] =
        &[ParamSpec::required("position", Kind::Vec3, "Where it stands.").unit("m"), COLOR];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self { position: p.vec3("position"), color: Spectrum::from_rgb(p.color("color")) })
    }

    fn classic_color(&self) -> Spectrum {
        self.color
    }

    fn center(&self) -> Vec3 {
        self.position
    }
}
