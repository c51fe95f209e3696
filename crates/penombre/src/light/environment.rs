//! `environment` (also `constant`, `envmap`, `infinite`): light from infinity in all directions.
//!
//! `radiance` alone: the same from everywhere. With `file`, an equirectangular image, of which `radiance` is a factor: +y is
//! up, the top row is straight up, the middle of the image lies towards −z and its right half towards +x; u =
//! ½ + atan2(x, −z)/2π, v = acos(y)/π downwards. `rotate` turns it about +y, counter-clockwise seen from above, and then
//! `transform`, which may turn, mirror and scale alike, takes it to the world.
//!
//! Images are sampled in proportion to the luminance above its mean \[Karlik2019\]; what lies below is left to rays that
//! surfaces scatter. Constant radiance is not sampled at all: for it, rays that are scattered with the density
//! cos θ/π of a diffuse surface have no variance but that of visibility, where directions uniform over the sphere have,
//! without any occluder, ∫(cos θ/π)²·4π dω − 1 = 5/3 of the squared mean; and no shadow ray is spent.
//!
//! In `classic` it gives no light, and rays that hit nothing are black.
//!
//! ```toml
//! [light.sky]
//! type = "environment"
//! file = "sky.hdr"
//! radiance = [1, 1, 1]
//! rotate = 90
//! ```

use super::sampling::{Environment, EnvironmentSampling, power};
use super::{Escaped, Light, LightSample, RADIANCE};
use crate::registry::Context;
use crate::shape::uniform_scale;
use penombre_image::Image;
use penombre_math::{DMat3, DVec3, Mat3, Spectrum, Vec2, Vec3, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};
use std::sync::Arc;

/// Light from infinity.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    /// The radiance, or the factor of the image.
    radiance: Spectrum,
    image: Option<Turned>,
}

/// An image and how it stands in the world.
#[derive(Clone, Debug)]
struct Turned {
    environment: Environment,
    /// World directions of the image's own axes: orthogonal, perhaps left-handed.
    to_world: Mat3,
}

impl Light for EnvironmentLight {
    const TYPE_NAME: &'static str = "environment";
    const ALIASES: &'static [&'static str] = &["constant", "envmap", "infinite"];
    const SCHEMA: &'static [ParamSpec] = &[
        RADIANCE,
        ParamSpec::optional("file", Kind::File, "An equirectangular image; `radiance` is a factor of it."),
        ParamSpec::with_default(
            "rotate",
            Kind::Float(Range::ANY),
            ParamDefault::Float(0.0),
            "Turns the image about +y, counter-clockwise seen from above.",
        )
        .unit("degrees"),
        ParamSpec::optional(
            "transform",
            Kind::Transform,
            "Where the image stands, after `rotate`: it may turn, mirror and scale alike.",
        ),
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let radiance = Spectrum::from_rgb(p.color("radiance"));
        let to_world = to_world(p, context)?;
        if !p.is_given("file") {
            return Some(Self { radiance, image: None });
        }
        // A missing image was reported when the assets were loaded.
        Self::of_image(context.assets.image(context.node)?.clone(), radiance, to_world)
    }

    fn classic_color(&self) -> Spectrum {
        Spectrum::BLACK
    }

    fn center(&self) -> Vec3 {
        Vec3::ZERO
    }

    fn sample_towards(&self, _: Vec3, u: Vec2) -> Option<LightSample> {
        let Turned { environment, to_world } = self.image.as_ref()?;
        let sample = environment.sample(u);
        Some(LightSample {
            wi: *to_world * sample.wi,
            point: Vec3::ZERO,
            distance: f32::INFINITY,
            radiance: sample.radiance * self.radiance,
            pdf: sample.pdf,
            by_area: false,
            normal: Vec3::ZERO,
            aside: 0.0,
            is_delta: false,
            is_directed: false,
        })
    }

    fn escaped(&self, dir: Vec3) -> Option<Escaped> {
        let Some(Turned { environment, to_world }) = &self.image else {
            return Some(Escaped { radiance: self.radiance, pdf: 0.0 });
        };
        let own = to_world.transpose() * dir;
        Some(Escaped { radiance: environment.radiance(own) * self.radiance, pdf: environment.pdf(own) })
    }

    fn is_infinite(&self) -> bool {
        true
    }

    fn power(&self, scene_radius: f32) -> f32 {
        let Some(image) = &self.image else { return 0.0 };
        let mean = image.environment.mean_radiance() * self.radiance;
        power::of_environment(mean.luminance(), scene_radius)
    }
}

impl EnvironmentLight {
    /// An image, a factor of it, and the orthogonal map from its own directions to those of the world. `None` if it has no
    /// pixels.
    pub fn of_image(image: Arc<Image>, radiance: Spectrum, to_world: DMat3) -> Option<Self> {
        let environment = Environment::new(image, EnvironmentSampling::Compensated)?;
        Some(Self { radiance, image: Some(Turned { environment, to_world: to_world.as_mat3() }) })
    }
}

/// The turn about +y, counter-clockwise seen from above.
pub(super) fn turn(degrees: f64) -> DMat3 {
    let (sin, cos) = float::sin_cos_degrees(degrees);
    DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos))
}

/// The turn of the image's axes; reports a transform that bends them.
fn to_world(p: &Params, context: &mut Context<'_, '_>) -> Option<DMat3> {
    let map = p.transform("transform");
    let Some(scale) = uniform_scale(&map) else {
        let message = format!(
            "the transform of `{}` scales directions differently",
            context.description.node(context.node).path()
        );
        context.out.error("scene::transform", p.span("transform"), message).help =
            "the environment is infinitely far away: turn it by { rotate = [0, 1, 0], angle = 90 }"
                .to_owned();
        return None;
    };
    Some(map.matrix3 * (1.0 / scale) * turn(p.f64("rotate")))
}
