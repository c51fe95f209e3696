//! `emissive`: a surface that shines and reflects nothing.
//!
//! It shines on its outside, the side of the geometric normal, or on both.
//!
//! ```toml
//! [material.lamp]
//! type = "emissive"
//! radiance = [12, 12, 12]
//! two_sided = false
//! ```

use super::common::{Common, OPACITY};
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{Black, Bsdf};
use crate::registry::Context;
use penombre_math::Spectrum;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A surface that shines.
#[derive(Clone, Debug, PartialEq)]
pub struct Emissive {
    common: Common,
}

impl Emissive {
    /// What surfaces of lights are made of: the light itself knows what it emits.
    pub const OF_LIGHTS: Self = Self { common: Common::PLAIN };
}

impl Material for Emissive {
    const TYPE_NAME: &'static str = "emissive";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "radiance",
            Kind::ColorTexture(Range::NON_NEGATIVE),
            ParamDefault::Color([1.0; 3]),
            "Emitted radiance.",
        )
        .unit("W/(sr m²)"),
        ParamSpec::with_default(
            "two_sided",
            Kind::Bool,
            ParamDefault::Bool(false),
            "It shines on the inside, too.",
        ),
        OPACITY,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self { common: Common::of_lamp(p, context) })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        PhongView {
            ambient: Spectrum::BLACK,
            diffuse: self.common.emission().color(&shade.point, shade.textures).clamp(0.0, 1.0),
            specular: Spectrum::BLACK,
            shininess: 1.0,
            kind: Specular::None,
        }
    }

    fn bsdf(&self, _: &Shade<'_>) -> Bsdf {
        Black.into()
    }

    fn is_textured(&self) -> bool {
        self.common.emission().is_texture()
    }
}
