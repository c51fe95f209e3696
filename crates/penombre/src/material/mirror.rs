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

use super::phong::Phong;
use super::{AMBIENT, Material, PhongView, SHININESS, Shade, Specular, diffuse_param, specular_param};
use crate::registry::Context;
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

/// A perfect mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    phong: Phong,
}

impl Material for Mirror {
    const TYPE_NAME: &'static str = "mirror";
    const SCHEMA: &'static [ParamSpec] = &[diffuse_param(1.0), specular_param(1.0), AMBIENT, SHININESS];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        Phong::build(p, context).map(|phong| Self { phong })
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        self.phong.view(shade, Specular::Mirror)
    }

    fn is_textured(&self) -> bool {
        self.phong.is_textured()
    }
}
