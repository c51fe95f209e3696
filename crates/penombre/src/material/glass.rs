//! `glass`: a smooth dielectric.
//!
//! Light is reflected in the share F of Fresnel's equations and refracted for the rest, each times its tint
//! ([`SmoothDielectric`]). From phase 4 of `classic` on, its colour is F times that of the reflected ray plus 1 − F times that of the
//! refracted one, F by Fresnel's equations; in the phases before it is shaded as a `phong` surface with the same
//! parameters. The side of the geometric normal is the outside.
//!
//! ```toml
//! [material.ball]
//! type = "glass"
//! ior = 1.4
//! transmit = [0.9, 1, 0.9]
//! diffuse = [1, 0, 0]     # phases 1 to 3
//! ```

use super::common::{
    AMBIENT, Common, EMISSION, IOR, OPACITY, REFLECT, SHININESS, TRANSMIT, diffuse_param, specular_param,
};
use super::phong::Factors;
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{Bsdf, SmoothDielectric};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

/// A smooth dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    phong: Factors,
    ior: f32,
    reflect: ColorSource,
    transmit: ColorSource,
    common: Common,
}

impl Material for Glass {
    const TYPE_NAME: &'static str = "glass";
    const ALIASES: &'static [&'static str] = &["dielectric"];
    const SCHEMA: &'static [ParamSpec] = &[
        IOR,
        REFLECT,
        TRANSMIT,
        diffuse_param(1.0),
        specular_param(1.0),
        AMBIENT,
        SHININESS,
        OPACITY,
        EMISSION,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| ColorSource::new(p.color_texture(name), context);
        Some(Self {
            phong: Factors::new(p, context),
            ior: p.f32("ior"),
            reflect: color("reflect"),
            transmit: color("transmit"),
            common: Common::of_any(p, context),
        })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        self.phong.view(shade, Specular::Glass(self.ior))
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        let color = |source: ColorSource| source.color(&shade.point, shade.textures);
        SmoothDielectric::new(self.ior, color(self.reflect), color(self.transmit)).into()
    }

    fn is_textured(&self) -> bool {
        self.phong.is_textured()
    }
}

#[cfg(test)]
mod tests {
    use crate::bsdf::SmoothDielectric;
    use crate::testing::{Bench, fault};
    use penombre_math::Spectrum;

    #[test]
    fn gives_the_glass_that_is_asked_for() {
        let glass = Bench::new("type = \"glass\"");
        assert_eq!(glass.bsdf(true), SmoothDielectric::new(1.5, Spectrum::WHITE, Spectrum::WHITE).into());
        let tinted = Bench::new(
            "type = \"dielectric\"\nior = 1\nreflect = [1, 0.5, 0]\ntransmit = { texture = \"half\" }",
        );
        for (u, transmit) in [(0.25, Spectrum::splat(0.5)), (0.75, Spectrum::WHITE)] {
            let expected = SmoothDielectric::new(1.0, Spectrum::rgb(1.0, 0.5, 0.0), transmit);
            assert_eq!(tinted.bsdf_at(u), expected.into());
        }
        // `classic` does not see the tints.
        assert!(!tinted.material().is_textured());
        assert!(fault("type = \"glass\"\nreflect = [1, 2, 1]").0.contains("`reflect[1]` of `material.it`"));
    }
}
