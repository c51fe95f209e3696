//! `mirror`: a perfect mirror.
//!
//! From phase 3 of `classic` on, its colour is that of the reflected ray; in the phases before it is shaded as a
//! `phong` surface with the same parameters.
//!
//! ```toml
//! [material.ball]
//! type = "mirror"
//! diffuse = [1, 1, 1]     # phases 1 and 2
//! ```

use super::common::{
    AMBIENT, Common, EMISSION, OPACITY, SHININESS, TWO_SIDED, diffuse_param, specular_param,
};
use super::phong::Factors;
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{self, Bsdf};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A perfect mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    reflectance: ColorSource,
    phong: Factors,
    common: Common,
}

impl Material for Mirror {
    const TYPE_NAME: &'static str = "mirror";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "reflectance",
            Kind::ColorTexture(Range::UNIT),
            ParamDefault::Color([1.0; 3]),
            "Share of the light that it sends back, in physically based integrators.",
        ),
        diffuse_param(1.0),
        specular_param(1.0),
        AMBIENT,
        SHININESS,
        OPACITY,
        EMISSION,
        TWO_SIDED,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let reflectance = ColorSource::new(p.color_texture("reflectance"), context);
        let common = Common::of_reflector(p, context);
        Some(Self { reflectance, phong: Factors::new(p, context), common })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        self.phong.view(shade, Specular::Mirror)
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        bsdf::Mirror::new(self.reflectance.color(&shade.point, shade.textures)).into()
    }

    fn is_textured(&self) -> bool {
        self.phong.is_textured()
    }
}
