//! `phong`: the course's material.
//!
//! Per light, with N turned toward the viewer, L toward the light, V toward the viewer and R = 2(N·L)N − L,
//! I = ambient·Iₐ + visible·C·(diffuse·max(0, N·L) + specular·max(0, R·V)^shininess) \[Phong1975\].
//!
//! ```toml
//! [material.red]
//! type = "phong"
//! diffuse = [1, 0, 0]
//! specular = [1, 0, 0]
//! shininess = 16
//! ```

use super::common::{
    AMBIENT, Common, EMISSION, OPACITY, SHININESS, TWO_SIDED, diffuse_param, specular_param,
};
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{self, Bsdf};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

/// A surface by Phong's model.
#[derive(Clone, Debug, PartialEq)]
pub struct Phong {
    factors: Factors,
    common: Common,
}

/// The four factors of Phong's model; mirror and glass have them too, for the phases in which they are shaded.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Factors {
    ambient: ColorSource,
    diffuse: ColorSource,
    specular: ColorSource,
    shininess: f32,
}

impl Factors {
    /// From the parameters of a material that has them.
    pub(super) fn new(p: &Params, context: &Context<'_, '_>) -> Self {
        let color = |name| ColorSource::new(p.color_texture(name), context);
        Self {
            ambient: color("ambient"),
            diffuse: color("diffuse"),
            specular: color("specular"),
            shininess: p.f32("shininess"),
        }
    }

    /// True if a factor may vary over the surface.
    pub(super) fn is_textured(&self) -> bool {
        [self.ambient, self.diffuse, self.specular].into_iter().any(ColorSource::is_texture)
    }

    /// The view with the given continuation.
    pub(super) fn view(&self, shade: &Shade<'_>, kind: Specular) -> PhongView {
        let color = |source: ColorSource| source.color(&shade.point, shade.textures);
        PhongView {
            ambient: color(self.ambient),
            diffuse: color(self.diffuse) * shade.vertex_color,
            specular: color(self.specular),
            shininess: self.shininess,
            kind,
        }
    }
}

impl Material for Phong {
    const TYPE_NAME: &'static str = "phong";
    const SCHEMA: &'static [ParamSpec] =
        &[diffuse_param(0.8), specular_param(0.0), AMBIENT, SHININESS, OPACITY, EMISSION, TWO_SIDED];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        Some(Self { factors: Factors::new(p, context), common: Common::of_reflector(p, context) })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        self.factors.view(shade, Specular::None)
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        let view = self.factors.view(shade, Specular::None);
        bsdf::Phong::new(view.diffuse, view.specular, view.shininess).into()
    }

    fn is_textured(&self) -> bool {
        self.factors.is_textured()
    }
}
