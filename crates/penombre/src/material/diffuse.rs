//! `diffuse`: a matt surface of one colour.
//!
//! In Phong's terms the colour is the factor of the cosine term and there is no highlight.
//!
//! ```toml
//! [material.floor]
//! type = "diffuse"
//! color = { texture = "checks" }
//! ```

use super::common::{AMBIENT, Common, EMISSION, OPACITY, TWO_SIDED};
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{Bsdf, Lambert};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_math::Spectrum;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A matt surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffuse {
    color: ColorSource,
    ambient: ColorSource,
    common: Common,
}

impl Default for Diffuse {
    fn default() -> Self {
        Self {
            color: ColorSource::Constant(Spectrum::splat(0.8)),
            ambient: ColorSource::Constant(Spectrum::BLACK),
            common: Common::PLAIN,
        }
    }
}

impl Material for Diffuse {
    const TYPE_NAME: &'static str = "diffuse";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "color",
            Kind::ColorTexture(Range::UNIT),
            ParamDefault::Color([0.8; 3]),
            "Share of the light that it sends back.",
        ),
        AMBIENT,
        OPACITY,
        EMISSION,
        TWO_SIDED,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| ColorSource::new(p.color_texture(name), context);
        Some(Self {
            color: color("color"),
            ambient: color("ambient"),
            common: Common::of_reflector(p, context),
        })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        let color = |source: ColorSource| source.color(&shade.point, shade.textures);
        PhongView {
            ambient: color(self.ambient),
            diffuse: color(self.color) * shade.vertex_color,
            specular: Spectrum::BLACK,
            shininess: 1.0,
            kind: Specular::None,
        }
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        Lambert::new(self.color.color(&shade.point, shade.textures) * shade.vertex_color).into()
    }

    fn is_textured(&self) -> bool {
        self.color.is_texture() || self.ambient.is_texture()
    }
}
