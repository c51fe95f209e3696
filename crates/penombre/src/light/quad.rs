//! `quad`: light from a parallelogram, the source of soft shadows.
//!
//! The points `origin` + u·`sides[0]` + v·`sides[1]` with u, v in 0..1. Physically based integrators see a surface
//! that emits `radiance` on the side of sides\[0\] × sides\[1\]; `classic` sends `shadow_samples` shadow rays to
//! random points of it and uses `color`.
//!
//! ```toml
//! [light.ceiling]
//! type = "quad"
//! origin = [-0.5, 1.5, -0.5]
//! sides = [[1, 0, 0], [0, 0, 1]]
//! color = [1, 1, 1]
//! radiance = [12, 12, 12]
//! shadow_samples = 16
//! ```

use super::{COLOR, Light};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// Most shadow rays per shaded point and light.
const MOST_SHADOW_SAMPLES: f64 = 65536.0;

/// Light from a parallelogram.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadLight {
    origin: Vec3,
    sides: [Vec3; 2],
    color: Spectrum,
    shadow_samples: u32,
}

impl Light for QuadLight {
    const TYPE_NAME: &'static str = "quad";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("origin", Kind::Vec3, "One corner.").unit("m"),
        ParamSpec::required("sides", Kind::Sides, "The two edges that leave that corner.").unit("m"),
        COLOR,
        ParamSpec::with_default(
            "radiance",
            Kind::Color(Range::NON_NEGATIVE),
            ParamDefault::Color([1.0; 3]),
            "Emitted radiance; physically based integrators only.",
        )
        .unit("W/(sr m²)"),
        ParamSpec::with_default(
            "shadow_samples",
            Kind::Int(Range::closed(1.0, MOST_SHADOW_SAMPLES)),
            ParamDefault::Int(16),
            "Shadow rays per shaded point in `classic`.",
        ),
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self {
            origin: p.vec3("origin"),
            sides: p.sides("sides"),
            color: Spectrum::from_rgb(p.color("color")),
            shadow_samples: p.int("shadow_samples") as u32,
        })
    }

    fn classic_color(&self) -> Spectrum {
        self.color
    }

    fn center(&self) -> Vec3 {
        self.sample_point(Vec2::splat(0.5))
    }

    fn shadow_samples(&self) -> u32 {
        self.shadow_samples
    }

    fn sample_point(&self, u: Vec2) -> Vec3 {
        self.origin + self.sides[0] * u.x + self.sides[1] * u.y
    }
}
