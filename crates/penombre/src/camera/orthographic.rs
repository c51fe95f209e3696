//! `orthographic`: parallel rays.
//!
//! ```toml
//! [camera.plan]
//! type = "orthographic"
//! position = [0, 5, 0]
//! target = [0, 0, 0]
//! up = [0, 0, -1]
//! height = 4              # of the view, metres
//! ```

use super::view::{FAR, NEAR, POSITION, TARGET, UP};
use super::{Camera, CameraRay, View};
use crate::registry::Context;
use penombre_math::Vec2;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A camera whose rays are parallel.
#[derive(Clone, Debug, PartialEq)]
pub struct Orthographic {
    view: View,
    half_height: f32,
}

impl Camera for Orthographic {
    const TYPE_NAME: &'static str = "orthographic";
    const SCHEMA: &'static [ParamSpec] = &[
        POSITION,
        TARGET,
        UP,
        ParamSpec::with_default(
            "height",
            Kind::Float(Range::POSITIVE),
            ParamDefault::Float(2.0),
            "Height of the view.",
        )
        .unit("m"),
        NEAR,
        FAR,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self { view: View::build(p, context)?, half_height: p.f32("height") * 0.5 })
    }

    fn ray(&self, screen: Vec2) -> Option<CameraRay> {
        let v = &self.view;
        let at = screen * self.half_height;
        Some(v.limit(v.position + v.right * at.x + v.up * at.y, v.forward))
    }

    fn view(&self) -> &View {
        &self.view
    }
}
