//! `spot`: light from one point into a cone.
//!
//! `intensity` is that of the axis, which runs from `position` along `direction` or to `target`. Up to `angle` − `blend`
//! degrees from the axis the strength is full, beyond `angle` there is none; between, it is smoothstep in the cosine,
//! t²·(3 − 2t) with t = (cos θ − cos θ₁)/(cos θ₀ − cos θ₁) \[PBRT4\], 12.2.1.
//!
//! Physically based integrators use `intensity`, and the light falls off with the square of the distance; `classic` uses
//! `color`, and it does not.
//!
//! ```toml
//! [light.lamp]
//! type = "spot"
//! position = [0, 4, 0]
//! target = [0, 0, 0]      # or: direction = [0, -1, 0]
//! angle = 30              # half of the whole cone
//! blend = 5
//! color = [1, 1, 1]
//! intensity = [100, 100, 100]
//! ```

use super::sampling::power;
use super::sampling::punctual::{SpotCone, towards_point};
use super::{COLOR, INTENSITY, Light, LightSample};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// Light from one point into a cone.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    position: Vec3,
    cone: SpotCone,
    color: Spectrum,
    intensity: Spectrum,
}

impl Light for Spot {
    const TYPE_NAME: &'static str = "spot";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("position", Kind::Vec3, "Where it stands.").unit("m"),
        ParamSpec::optional("direction", Kind::Direction, "The way of the light on its axis, of any length."),
        ParamSpec::optional("target", Kind::Vec3, "A point on its axis; instead of `direction`.").unit("m"),
        ParamSpec::with_default(
            "angle",
            Kind::Float(Range::closed(0.0, 180.0)),
            ParamDefault::Float(30.0),
            "From the axis to where the light ends.",
        )
        .unit("degrees"),
        ParamSpec::with_default(
            "blend",
            Kind::Float(Range::closed(0.0, 180.0)),
            ParamDefault::Float(5.0),
            "Width of the rim in which it grows weaker; at most `angle`.",
        )
        .unit("degrees"),
        COLOR,
        INTENSITY,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| Spectrum::from_rgb(p.color(name));
        let (position, angle) = (p.vec3("position"), p.f32("angle"));
        let axis = axis(p, position, context)?;
        let cone = SpotCone::new(axis, angle - p.f32("blend"), angle);
        Some(Self { position, cone, color: color("color"), intensity: color("intensity") })
    }

    fn classic_color(&self) -> Spectrum {
        self.color
    }

    fn is_directed(&self) -> bool {
        true
    }

    fn classic_color_at(&self, from: Vec3) -> Spectrum {
        let way = (from.as_dvec3() - self.position.as_dvec3()).normalize_or_zero().as_vec3();
        self.color * self.cone.share(way)
    }

    fn center(&self) -> Vec3 {
        self.position
    }

    fn sample_towards(&self, from: Vec3, _: Vec2) -> Option<LightSample> {
        let way = towards_point(from, self.position)?;
        let share = self.cone.share(-way.wi);
        let sample = LightSample::without_extent(way, self.position, self.intensity * share);
        (share > 0.0).then_some(LightSample { is_directed: true, ..sample })
    }

    fn power(&self, _: f32) -> f32 {
        power::of_spot(self.intensity.luminance(), &self.cone)
    }
}

/// The unit vector along the axis, from `direction` or `target`.
fn axis(p: &Params, position: Vec3, context: &mut Context<'_, '_>) -> Option<Vec3> {
    let path = context.description.node(context.node).path();
    let mut fault = |param: &str, message: String| {
        context.out.error("scene::light-axis", p.span(param), message).help =
            "give `direction = [x, y, z]`, or `target = [x, y, z]` away from `position`".to_owned();
    };
    let way = match (p.opt_vec3("direction"), p.opt_vec3("target")) {
        (Some(direction), None) => direction.as_dvec3(),
        (None, Some(target)) => target.as_dvec3() - position.as_dvec3(),
        (Some(_), Some(_)) => {
            fault("target", format!("`{path}` has both `direction` and `target`, expected one of them"));
            return None;
        }
        (None, None) => {
            // A faulty one was reported.
            if !(p.is_given("direction") || p.is_given("target")) {
                fault(
                    "direction",
                    format!("`{path}` has neither `direction` nor `target`, expected one of them"),
                );
            }
            return None;
        }
    };
    let axis = way.try_normalize().map(|axis| axis.as_vec3());
    if axis.is_none() {
        fault(
            "target",
            format!("`target` of `{path}` is its `position`, so that the light has no direction"),
        );
    }
    axis
}
