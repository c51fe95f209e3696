//! `disk`: light from a flat round plate.
//!
//! Physically based integrators see a surface that emits `radiance` on the side of `normal`, or on both: π·r²·π·L watts
//! a side. `classic` sends `shadow_samples` shadow rays to random points of it and uses `color`.
//!
//! ```toml
//! [light.lamp]
//! type = "disk"
//! center = [0, 1.9, 0]
//! normal = [0, -1, 0]
//! radius = 0.5
//! color = [1, 1, 1]
//! radiance = [12, 12, 12]
//! two_sided = false
//! shadow_samples = 16
//! ```

use super::sampling::{DirectionSampler, SphericalDisk, power};
use super::{COLOR, Lamp, Light, LightSample, RADIANCE, SHADOW_SAMPLES, TWO_SIDED};
use crate::registry::Context;
use crate::shape::AnyShape;
use crate::shape::disk::Disk;
use penombre_math::{Frame, Spectrum, Vec2, Vec3, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};
use std::f32::consts::{PI, TAU};

/// Light from a flat round plate.
#[derive(Clone, Debug, PartialEq)]
pub struct DiskLight {
    center: Vec3,
    frame: Frame,
    radius: f32,
    lamp: Lamp,
}

impl Light for DiskLight {
    const TYPE_NAME: &'static str = "disk";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("center", Kind::Vec3, "The point in its middle.").unit("m"),
        ParamSpec::required("normal", Kind::Direction, "The direction that it faces, of any length."),
        ParamSpec::with_default(
            "radius",
            Kind::Float(Range::POSITIVE),
            ParamDefault::Float(1.0),
            "Distance from the centre to the edge.",
        )
        .unit("m"),
        COLOR,
        RADIANCE,
        TWO_SIDED,
        SHADOW_SAMPLES,
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        let normal = p.vec3("normal").as_dvec3().try_normalize()?.as_vec3();
        Some(Self {
            center: p.vec3("center"),
            frame: Frame::from_z(normal),
            radius: p.f32("radius"),
            lamp: Lamp::of_sides(p),
        })
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
        let (sin, cos) = float::sin_cos(u.y * TAU);
        let r = self.radius * u.x.sqrt();
        self.center + self.frame.x * (r * cos) + self.frame.y * (r * sin)
    }

    fn surface(&self) -> Option<AnyShape> {
        Some(AnyShape::Disk(Disk::new(self.center, self.frame.z, self.radius)?))
    }

    fn sample_towards(&self, from: Vec3, u: Vec2) -> Option<LightSample> {
        Some(LightSample::of_shape(self.seen_from(from)?.sample(u), self.frame.z, self.lamp.radiance))
    }

    fn pdf_towards(&self, from: Vec3, wi: Vec3, distance: f32) -> f32 {
        self.seen_from(from).map_or(0.0, |seen| seen.pdf_of_hit(wi, distance))
    }

    fn emitted(&self, normal: Vec3, wo: Vec3) -> Spectrum {
        self.lamp.emitted(normal, wo)
    }

    fn power(&self, _: f32) -> f32 {
        power::of_surface(self.lamp.radiance.luminance(), PI * self.radius * self.radius, self.lamp.two_sided)
    }
}

impl DiskLight {
    /// Its shape from that point; `None` if it does not shine there.
    fn seen_from(&self, from: Vec3) -> Option<SphericalDisk> {
        let seen = SphericalDisk::new(from, self.center, self.frame.z, self.radius)?;
        (self.lamp.two_sided || seen.is_in_front()).then_some(seen)
    }
}
