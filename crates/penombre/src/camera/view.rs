//! Position, orientation and depth range, common to all cameras.

use super::CameraRay;
use crate::registry::Context;
use penombre_bvh::Ray;
use penombre_math::Vec3;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A surface that lies in the near plane to the last bit counts as in front of it: the course's box has its front
/// wall there. Relative to the depth.
const NEAR_SLACK: f64 = 1e-5;

/// The parameter `position`.
pub const POSITION: ParamSpec =
    ParamSpec::with_default("position", Kind::Vec3, ParamDefault::Vec3([0.0, 0.0, 5.0]), "The eye.")
        .unit("m");
/// The parameter `target`.
pub const TARGET: ParamSpec =
    ParamSpec::with_default("target", Kind::Vec3, ParamDefault::Vec3([0.0; 3]), "The point in the middle.")
        .unit("m");
/// The parameter `up`.
pub const UP: ParamSpec = ParamSpec::with_default(
    "up",
    Kind::Direction,
    ParamDefault::Vec3([0.0, 1.0, 0.0]),
    "The direction that points up in the image.",
);
/// The parameter `near`.
pub const NEAR: ParamSpec = ParamSpec::with_default(
    "near",
    Kind::Float(Range::NON_NEGATIVE),
    ParamDefault::Float(0.0),
    "Nothing closer is seen: depth along the viewing direction.",
)
.unit("m");
/// The parameter `far`.
pub const FAR: ParamSpec = ParamSpec::with_default(
    "far",
    Kind::Float(Range::POSITIVE.or_infinite()),
    ParamDefault::Float(f64::INFINITY),
    "Nothing farther is seen: depth along the viewing direction.",
)
.unit("m");

/// Where a camera stands, how it is turned, and the depths between which it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye, world space, metres.
    pub position: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Unit vector into the image.
    pub forward: Vec3,
    /// Smallest visible depth along `forward`, the slack included, metres.
    near: f64,
    /// Largest visible depth, metres.
    far: f64,
}

impl View {
    /// From the common parameters. Reports a viewing direction of no length, one along `up`, and an empty range
    /// of depths.
    pub fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let path = context.description.node(context.node).path();
        let (near, far) = (p.f64("near"), p.f64("far"));
        let mut sound = true;
        if far <= near {
            let message = format!("`{path}` has far = {far}, expected more than near = {near}");
            let help = "the camera sees what lies between the two depths".to_owned();
            context.out.error("scene::out-of-range", p.span("far"), message).help = help;
            sound = false;
        }
        let (position, target) = (p.vec3("position").as_dvec3(), p.vec3("target").as_dvec3());
        let forward = (target - position).normalize_or_zero();
        let right = forward.cross(p.vec3("up").as_dvec3().normalize_or_zero());
        if forward.length_squared() == 0.0 {
            let message = format!("`{path}` has position and target at the same point, expected two points");
            context.out.error("scene::camera", p.span("target"), message).help =
                "move `target` to what the camera should look at".to_owned();
            return None;
        }
        if right.length() < 1e-6 {
            let message = format!("`{path}` looks along its `up`, expected another direction");
            context.out.error("scene::camera", p.span("up"), message).help =
                "for a camera that looks straight down, use up = [0, 0, -1]".to_owned();
            return None;
        }
        let right = right.normalize();
        let up = right.cross(forward);
        sound.then_some(Self {
            position: p.vec3("position"),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            near: near * (1.0 + NEAR_SLACK),
            far,
        })
    }

    /// The ray from `origin` along the unit vector `dir`, limited to the visible depths: what counts is the depth
    /// along the viewing direction, not the distance.
    pub fn limit(&self, origin: Vec3, dir: Vec3) -> CameraRay {
        let depth_per_t = f64::from(dir.dot(self.forward));
        if self.near == 0.0 && self.far == f64::INFINITY && depth_per_t > 0.0 {
            return CameraRay { ray: Ray::new(origin, dir, 0.0, f32::INFINITY) };
        }
        let (t_min, t_max) = ((self.near / depth_per_t) as f32, (self.far / depth_per_t) as f32);
        CameraRay { ray: Ray::new(origin, dir, t_min, t_max) }
    }
}
