//! `rough_glass`: a rough dielectric, such as frosted glass.
//!
//! A boundary of microscopic facets of smooth glass, whose slopes follow the GGX distribution with roughness α; formulas in
//! [`RoughDielectric`]. `alpha` is α along the first axis of the surface and, unless `alpha_y` says otherwise, along the
//! second; `roughness` is √α. `compensate` gives back what single scattering loses \[Kulla2017\]; without it, `masking` is that
//! of \[Heitz2014\] or of \[Walter2007\]. `classic` shades it in phases 1 to 3 and sees smooth `glass` from phase 4 on. The
//! side of the geometric normal is the outside.
//!
//! ```toml
//! [material.frosted]
//! type = "rough_glass"
//! ior = 1.5
//! roughness = 0.5
//! transmit = [0.9, 1, 0.95]
//! ```

use super::common::{
    ALPHA, ALPHA_Y, COMPENSATE, Common, EMISSION, Facets, IOR, MASKING, OPACITY, REFLECT, ROUGHNESS,
    TRANSMIT, shininess,
};
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::{Bsdf, RoughDielectric};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_math::Spectrum;
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

/// A rough dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughGlass {
    ior: f32,
    facets: Facets,
    reflect: ColorSource,
    transmit: ColorSource,
    common: Common,
}

impl Material for RoughGlass {
    const TYPE_NAME: &'static str = "rough_glass";
    const ALIASES: &'static [&'static str] = &["rough_dielectric"];
    const SCHEMA: &'static [ParamSpec] =
        &[IOR, ALPHA, ALPHA_Y, ROUGHNESS, REFLECT, TRANSMIT, MASKING, COMPENSATE, OPACITY, EMISSION];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let facets = Facets::new(p, context)?;
        let color = |name| ColorSource::new(p.color_texture(name), context);
        Some(Self {
            ior: p.f32("ior"),
            facets,
            reflect: color("reflect"),
            transmit: color("transmit"),
            common: Common::of_any(p, context),
        })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        PhongView {
            ambient: Spectrum::BLACK,
            diffuse: self.transmit.color(&shade.point, shade.textures),
            specular: self.reflect.color(&shade.point, shade.textures),
            shininess: shininess(self.facets.alpha(shade)),
            kind: Specular::Glass(self.ior),
        }
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        let color = |source: ColorSource| source.color(&shade.point, shade.textures);
        let tints = (color(self.reflect), color(self.transmit));
        let (alpha, masking) = (self.facets.alpha(shade), self.facets.masking());
        RoughDielectric::new(alpha, self.ior, tints.0, tints.1, masking).into()
    }

    fn is_textured(&self) -> bool {
        self.reflect.is_texture() || self.transmit.is_texture() || self.facets.is_textured()
    }
}

#[cfg(test)]
mod tests {
    use crate::bsdf::{Bsdf, Masking, RoughDielectric, Scatter, Transport};
    use crate::material::Specular;
    use crate::testing::{Bench, fault};
    use penombre_math::{Spectrum, Vec3};

    const COLORS: (Spectrum, Spectrum) = (Spectrum::WHITE, Spectrum::WHITE);

    fn glass(alpha: [f32; 2], masking: Masking) -> Bsdf {
        RoughDielectric::new(alpha, 1.5, COLORS.0, COLORS.1, masking).into()
    }

    #[test]
    fn gives_the_glass_that_is_asked_for() {
        let check = |params: &str, expected| {
            let bench = Bench::new(&format!("type = \"rough_glass\"\n{params}"));
            assert_eq!(bench.bsdf(true), expected, "{params}");
        };
        check("", glass([0.1; 2], Masking::Compensated));
        check("alpha = 0.3", glass([0.3; 2], Masking::Compensated));
        check("roughness = 0.5\nmasking = \"correlated\"", glass([0.25; 2], Masking::Compensated));
        check("alpha = 0.3\nalpha_y = 0.6\ncompensate = false", glass([0.3, 0.6], Masking::Correlated));
        check("masking = \"separable\"\ncompensate = false", glass([0.1; 2], Masking::Separable));
        let tints = (Spectrum::rgb(0.5, 0.6, 0.7), Spectrum::rgb(0.1, 0.2, 0.3));
        check(
            "ior = 1.33\nreflect = [0.5, 0.6, 0.7]\ntransmit = [0.1, 0.2, 0.3]",
            RoughDielectric::new([0.1; 2], 1.33, tints.0, tints.1, Masking::Compensated).into(),
        );
    }

    #[test]
    fn textures_are_read_where_it_is_hit() {
        let bench = Bench::new(
            "type = \"rough_dielectric\"\nroughness = { texture = \"half\" }\ntransmit = { texture = \"half\" }",
        );
        let half = Spectrum::splat(0.5);
        let expected = |alpha: f32, t| -> Bsdf {
            RoughDielectric::new([alpha; 2], 1.5, Spectrum::WHITE, t, Masking::Compensated).into()
        };
        assert_eq!(bench.bsdf_at(0.25), expected(0.25, half));
        assert_eq!(bench.bsdf_at(0.75), expected(1.0, Spectrum::WHITE));
        assert!(bench.material().is_textured());
        assert!(!Bench::new("type = \"rough_glass\"").material().is_textured());
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        for alpha in ["0", "1e-8", "1"] {
            for ior in ["1", "1.5", "0.001", "1000"] {
                let bench = Bench::new(&format!("type = \"rough_glass\"\nalpha = {alpha}\nior = {ior}"));
                let (view, bsdf) = (bench.view(true), bench.bsdf(true));
                assert!(view.shininess >= 0.0 && view.shininess <= 1e4);
                assert!(matches!(view.kind, Specular::Glass(_)));
                assert_eq!(bsdf.is_delta_only(), alpha != "1" || ior == "1", "{alpha} {ior}");
                let wo = Vec3::new(0.6, 0.0, 0.8);
                for u in [0.0, 0.3, 0.999] {
                    let sample = bsdf.sample(wo, [u; 3], Transport::Importance);
                    assert!(sample.is_none_or(|s| s.weight.is_finite() && s.pdf > 0.0));
                }
            }
        }
    }

    #[test]
    fn faults_are_told() {
        let twice = fault("type = \"rough_glass\"\nalpha = 0.1\nroughness = 0.3");
        assert!(twice.0.contains("`material.it` has both `roughness` and `alpha`"), "{twice:?}");
        assert!(twice.1.contains("square"), "{twice:?}");
        assert!(fault("type = \"rough_glass\"\nroughness = 0.3\nalpha_y = 0.3").0.contains("`alpha_y`"));
        assert!(fault("type = \"rough_glass\"\nalpha = 1.5").0.contains("`alpha` of `material.it` is 1.5"));
        assert!(fault("type = \"rough_glass\"\nior = 0").0.contains("`ior`"));
        assert!(fault("type = \"rough_glass\"\nmasking = \"other\"").0.contains("`masking`"));
        assert!(
            fault("type = \"rough_glass\"\ntwo_sided = false").0.contains("unknown parameter `two_sided`")
        );
        let idle = Bench::new("type = \"rough_glass\"\nmasking = \"separable\"");
        assert!(idle.warnings().iter().any(|w| w.contains("`masking` of `material.it` has no effect")));
    }
}
