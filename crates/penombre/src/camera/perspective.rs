//! `perspective`: a pinhole camera.
//!
//! ```toml
//! [camera.main]
//! type = "perspective"
//! position = [0, 0, 6.1]
//! target = [0, 0, 0]
//! up = [0, 1, 0]
//! fov = 45                # vertical, degrees
//! near = 4.1
//! ```

use super::view::{FAR, NEAR, POSITION, TARGET, UP};
use super::{Camera, CameraRay, View};
use crate::registry::Context;
use penombre_math::{Vec2, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Perspective {
    view: View,
    /// Half the height of the image at depth 1.
    half_height: f32,
}

impl Camera for Perspective {
    const TYPE_NAME: &'static str = "perspective";
    const SCHEMA: &'static [ParamSpec] = &[
        POSITION,
        TARGET,
        UP,
        ParamSpec::with_default(
            "fov",
            Kind::Float(Range::open(0.0, 180.0)),
            ParamDefault::Float(45.0),
            "Field of view from the lower to the upper edge.",
        )
        .unit("degrees"),
        NEAR,
        FAR,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let half_height = float::tan_degrees(p.f64("fov") * 0.5) as f32;
        Some(Self { view: View::build(p, context)?, half_height })
    }

    fn ray(&self, screen: Vec2) -> Option<CameraRay> {
        let v = &self.view;
        let at = screen * self.half_height;
        let dir = (v.forward + v.right * at.x + v.up * at.y).normalize();
        Some(v.limit(v.position, dir))
    }

    fn view(&self) -> &View {
        &self.view
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_math::Vec3;
    use penombre_scene::{Node, Role, SceneDescription};

    fn course_camera() -> Perspective {
        let node = Node::new(Role::Camera, "perspective", "main")
            .with("position", [0.0, 0.0, 6.1])
            .with("near", 4.1);
        let mut d = SceneDescription::default();
        let node_id = d.add(node);
        let (assets, mut out) = (Default::default(), Default::default());
        let mut context = Context { description: &d, assets: &assets, out: &mut out, node: node_id };
        let params = context.decode(d.node(node_id), Perspective::SCHEMA);
        let camera = Perspective::build(&params, &mut context).unwrap();
        assert!(out.is_empty());
        camera
    }

    /// The half-extents of the view at z = 2, 0 and −2 that the course's camera has.
    #[test]
    fn sees_the_extents_of_the_course() {
        let ray = course_camera().ray(Vec2::new(1.0, 1.0)).unwrap().ray;
        for (z, extent) in [(2.0, 1.6983), (0.0, 2.5267), (-2.0, 3.3551)] {
            let at = ray.origin + ray.dir * ((z - ray.origin.z) / ray.dir.z);
            assert!((at.x - extent).abs() < 1e-4 && (at.y - extent).abs() < 1e-4, "{at}");
        }
    }

    /// The front wall at z = 2 lies in the near plane: it is out of sight even in the corners of the image.
    #[test]
    fn the_near_plane_is_a_depth() {
        let camera = course_camera();
        for screen in [Vec2::ZERO, Vec2::ONE, Vec2::new(-1.7, 1.0)] {
            let ray = camera.ray(screen).unwrap().ray;
            let wall = (2.0 - ray.origin.z) / ray.dir.z;
            assert!(wall < ray.t_min, "{wall} {}", ray.t_min);
            assert!(wall * 1.0001 > ray.t_min);
            assert!((ray.dir.length() - 1.0).abs() < 1e-6);
        }
        assert_eq!(camera.view().forward, -Vec3::Z);
    }
}
