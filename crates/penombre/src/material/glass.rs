//! `glass`: a smooth dielectric.
//!
//! From phase 4 of `classic` on, its colour is F times that of the reflected ray plus 1 − F times that of the
//! refracted one, F by Fresnel's equations; in the phases before it is shaded as a `phong` surface with the same
//! parameters. The side of the geometric normal is the outside.
//!
//! ```toml
//! [material.ball]
//! type = "glass"
//! ior = 1.4
//! diffuse = [1, 0, 0]     # phases 1 to 3
//! ```

use super::phong::Phong;
use super::{AMBIENT, Material, PhongView, SHININESS, Shade, Specular, diffuse_param, specular_param};
use crate::registry::Context;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A smooth dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    phong: Phong,
    ior: f32,
}

impl Material for Glass {
    const TYPE_NAME: &'static str = "glass";
    const ALIASES: &'static [&'static str] = &["dielectric"];
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "ior",
            Kind::Float(Range { min_open: true, ..Range::closed(0.0, 1000.0) }),
            ParamDefault::Float(1.5),
            "Index of refraction of the inside against the outside: 1.33 water, 1.5 glass, 2.42 diamond.",
        ),
        diffuse_param(1.0),
        specular_param(1.0),
        AMBIENT,
        SHININESS,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let ior = p.f32("ior");
        Phong::build(p, context).map(|phong| Self { phong, ior })
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        self.phong.view(shade, Specular::Glass(self.ior))
    }

    fn is_textured(&self) -> bool {
        self.phong.is_textured()
    }
}
