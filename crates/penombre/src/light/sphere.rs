//! `sphere`: light from a ball.
//!
//! Physically based integrators see a surface that emits `radiance` to the outside, 4π²·r²·L watts. `classic` sends
//! `shadow_samples` shadow rays to random points of the sphere and uses `color`.
//!
//! ```toml
//! [light.bulb]
//! type = "sphere"
//! center = [0, 1.5, 0]
//! radius = 0.1
//! color = [1, 1, 1]
//! radiance = [100, 100, 100]
//! shadow_samples = 16
//! ```

use super::sampling::{DirectionSampler, SphericalCap, power};
use super::{COLOR, Lamp, Light, LightSample, RADIANCE, SHADOW_SAMPLES};
use crate::registry::Context;
use crate::shape::AnyShape;
use crate::shape::sphere::Sphere;
use penombre_math::{Spectrum, Vec2, Vec3, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};
use std::f32::consts::TAU;

/// Light from a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereLight {
    center: Vec3,
    radius: f32,
    lamp: Lamp,
}

impl Light for SphereLight {
    const TYPE_NAME: &'static str = "sphere";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("center", Kind::Vec3, "The point in its middle.").unit("m"),
        ParamSpec::with_default(
            "radius",
            Kind::Float(Range::POSITIVE),
            ParamDefault::Float(1.0),
            "Distance from the centre to the surface.",
        )
        .unit("m"),
        COLOR,
        RADIANCE,
        SHADOW_SAMPLES,
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self { center: p.vec3("center"), radius: p.f32("radius"), lamp: Lamp::one_sided(p) })
    }

    fn classic_color(&self) -> Spectrum {
        self.lamp.color
    }

    fn center(&self) -> Vec3 {
        self.center
    }

    fn lamp(&self) -> Option<&Lamp> {
        Some(&self.lamp)
    }

    fn sample_point(&self, u: Vec2) -> Vec3 {
        let z = 1.0 - 2.0 * u.x;
        let across = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = float::sin_cos(u.y * TAU);
        self.center + Vec3::new(across * cos, across * sin, z) * self.radius
    }

    fn surface(&self) -> Option<AnyShape> {
        Some(AnyShape::Sphere(Sphere::new(self.center, self.radius)?))
    }

    fn ball(&self) -> Option<(Vec3, f32, Spectrum)> {
        Some((self.center, self.radius, self.lamp.radiance))
    }

    fn sample_towards(&self, from: Vec3, u: Vec2) -> Option<LightSample> {
        let sample = self.seen_from(from)?.sample(u);
        let normal = (sample.point - self.center).normalize_or_zero();
        Some(LightSample::of_shape(sample, normal, self.lamp.radiance))
    }

    fn pdf_towards(&self, from: Vec3, wi: Vec3, distance: f32) -> f32 {
        self.seen_from(from).map_or(0.0, |seen| seen.pdf_of_hit(wi, distance))
    }

    fn emitted(&self, normal: Vec3, wo: Vec3) -> Spectrum {
        self.lamp.emitted(normal, wo)
    }

    fn power(&self, _: f32) -> f32 {
        power::of_sphere(self.lamp.radiance.luminance(), self.radius)
    }
}

impl SphereLight {
    /// Its shape from that point; `None` inside, where it does not shine.
    fn seen_from(&self, from: Vec3) -> Option<SphericalCap> {
        SphericalCap::new(from, self.center, self.radius).filter(|seen| !seen.is_inside())
    }
}
