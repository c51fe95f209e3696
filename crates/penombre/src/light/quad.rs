//! `quad`: light from a parallelogram, the source of soft shadows.
//!
//! The points `origin` + u·`sides[0]` + v·`sides[1]` with u, v in 0..1. Physically based integrators see a surface
//! that emits `radiance` on the side of sides\[0\] × sides\[1\], or on both; `classic` sends `shadow_samples` shadow rays to
//! random points of it and uses `color`.
//!
//! ```toml
//! [light.ceiling]
//! type = "quad"
//! origin = [-0.5, 1.5, -0.5]
//! sides = [[1, 0, 0], [0, 0, 1]]
//! color = [1, 1, 1]
//! radiance = [12, 12, 12]
//! two_sided = false
//! shadow_samples = 16
//! ```

use super::sampling::{Parallelogram, power};
use super::{COLOR, Lamp, Light, LightSample, RADIANCE, SHADOW_SAMPLES, TWO_SIDED};
use crate::registry::Context;
use crate::shape::AnyShape;
use crate::shape::quad::Quad;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamSpec};

/// Light from a parallelogram.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadLight {
    origin: Vec3,
    sides: [Vec3; 2],
    /// `None`: it has no area.
    shape: Option<Parallelogram>,
    lamp: Lamp,
}

impl QuadLight {
    fn normal(&self) -> Vec3 {
        self.shape.map_or(Vec3::ZERO, |shape| shape.normal())
    }
}

impl Light for QuadLight {
    const TYPE_NAME: &'static str = "quad";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("origin", Kind::Vec3, "One corner.").unit("m"),
        ParamSpec::required("sides", Kind::Sides, "The two edges that leave that corner.").unit("m"),
        COLOR,
        RADIANCE,
        TWO_SIDED,
        SHADOW_SAMPLES,
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        let (origin, sides) = (p.vec3("origin"), p.sides("sides"));
        Some(Self { origin, sides, shape: Parallelogram::new(origin, sides), lamp: Lamp::of_sides(p) })
    }

    fn classic_color(&self) -> Spectrum {
        self.lamp.color
    }

    fn center(&self) -> Vec3 {
        self.sample_point(Vec2::splat(0.5))
    }

    fn lamp(&self) -> Option<&Lamp> {
        Some(&self.lamp)
    }

    fn sample_point(&self, u: Vec2) -> Vec3 {
        self.origin + self.sides[0] * u.x + self.sides[1] * u.y
    }

    #[inline]
    fn parallelogram(&self) -> Option<(Vec3, [Vec3; 2])> {
        Some((self.origin, self.sides))
    }

    fn surface(&self) -> Option<AnyShape> {
        Some(AnyShape::Quad(Quad::new(self.origin, self.sides)?))
    }

    #[inline]
    fn sample_towards(&self, from: Vec3, u: Vec2) -> Option<LightSample> {
        let sample = self.seen_from(from)?.sample_from(from, u)?;
        Some(LightSample::of_shape(sample, self.normal(), self.lamp.radiance))
    }

    #[inline]
    fn pdf_towards(&self, from: Vec3, _: Vec3, distance: f32) -> f32 {
        self.seen_from(from).map_or(0.0, |shape| shape.pdf_from(from, distance))
    }

    #[inline]
    fn emitted(&self, normal: Vec3, wo: Vec3) -> Spectrum {
        self.lamp.emitted(normal, wo)
    }

    fn power(&self, _: f32) -> f32 {
        let area = self.shape.map_or(0.0, |shape| shape.area());
        power::of_surface(self.lamp.radiance.luminance(), area, self.lamp.two_sided)
    }
}

impl QuadLight {
    /// Its shape if it shines towards that point.
    #[inline]
    fn seen_from(&self, from: Vec3) -> Option<&Parallelogram> {
        self.shape.as_ref().filter(|shape| self.lamp.two_sided || shape.faces(from))
    }
}
