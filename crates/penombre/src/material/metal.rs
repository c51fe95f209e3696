//! `metal`: a conductor, polished or rough.
//!
//! Microscopic facets with Fresnel's reflectance of the complex index n + ik, per red, green and blue; their slopes follow
//! the GGX distribution with roughness α; formulas in [`RoughConductor`]. Below α = 0.001 it is a perfect mirror. n and k
//! are those of a `metal` by name, from measured spectra ([`metals`]), or given. `alpha` is α along
//! the first axis of the surface and, unless `alpha_y` says otherwise, along the second; `roughness` is √α. `compensate`
//! gives back what single scattering loses \[Kulla2017\]; without it, `masking` is that of \[Heitz2014\] or of
//! \[Walter2007\]. In `classic` its colours are the reflectance at normal incidence, and from phase 3 on a smooth one is a
//! mirror.
//!
//! ```toml
//! [material.ring]
//! type = "metal"
//! metal = "gold"
//! alpha = 0.2
//! ```

use super::common::{
    ALPHA, ALPHA_Y, COMPENSATE, Common, EMISSION, Facets, MASKING, OPACITY, ROUGHNESS, TWO_SIDED, shininess,
};
use super::{Material, PhongView, Shade, Specular};
use crate::bsdf::metals::{self, METALS};
use crate::bsdf::{Bsdf, Ggx, RoughConductor, fresnel};
use crate::registry::Context;
use crate::texture::ColorSource;
use penombre_math::Spectrum;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// Names of the known metals.
const NAMES: [&str; METALS.len()] = {
    let mut names = [""; METALS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = METALS[i].name;
        i += 1;
    }
    names
};

/// What n and k may be.
const INDEX: Kind = Kind::Color(Range::closed(0.0, 1000.0));

/// A conductor.
#[derive(Clone, Debug, PartialEq)]
pub struct Metal {
    n: [f32; 3],
    k: [f32; 3],
    facets: Facets,
    tint: ColorSource,
    common: Common,
}

impl Material for Metal {
    const TYPE_NAME: &'static str = "metal";
    const ALIASES: &'static [&'static str] = &["conductor", "rough_conductor"];
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "metal",
            Kind::Choice(&NAMES),
            ParamDefault::Text("aluminium"),
            "Which metal it is.",
        ),
        ParamSpec::optional("n", INDEX, "Instead of `metal`: index of refraction of red, green, blue."),
        ParamSpec::optional("k", INDEX, "Along with `n`: extinction coefficient of red, green, blue."),
        ALPHA,
        ALPHA_Y,
        ROUGHNESS,
        ParamSpec::with_default(
            "tint",
            Kind::ColorTexture(Range::UNIT),
            ParamDefault::Color([1.0; 3]),
            "Factor of the reflectance; 1 for real matter.",
        ),
        MASKING,
        COMPENSATE,
        OPACITY,
        EMISSION,
        TWO_SIDED,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let (index, facets) = (index(p, context), Facets::new(p, context));
        let ((n, k), facets) = (index?, facets?);
        let tint = ColorSource::new(p.color_texture("tint"), context);
        Some(Self { n, k, facets, tint, common: Common::of_reflector(p, context) })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        let tint = self.tint.color(&shade.point, shade.textures);
        let reflectance = tint * fresnel::conductor(1.0, self.n, self.k);
        let alpha = self.facets.alpha(shade);
        PhongView {
            ambient: Spectrum::BLACK,
            diffuse: reflectance,
            specular: reflectance,
            shininess: shininess(alpha),
            kind: if Ggx::new(alpha).is_smooth() { Specular::Mirror } else { Specular::None },
        }
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        let tint = self.tint.color(&shade.point, shade.textures);
        RoughConductor::new(self.facets.alpha(shade), self.n, self.k, tint, self.facets.masking()).into()
    }

    fn is_textured(&self) -> bool {
        self.tint.is_texture() || self.facets.is_textured()
    }
}

/// n and k, by name or as given.
fn index(p: &Params, context: &mut Context<'_, '_>) -> Option<([f32; 3], [f32; 3])> {
    let said = (p.is_given("metal"), p.is_given("n"), p.is_given("k"));
    let (found, at) = match said {
        (_, false, false) => {
            let metal = metals::Metal::find(p.choice("metal"))?;
            return Some((metal.n, metal.k));
        }
        (false, true, true) => return Some((p.color("n"), p.color("k"))),
        (true, true, _) => ("both `metal` and `n`", "n"),
        (true, false, true) => ("both `metal` and `k`", "k"),
        (false, true, false) => ("`n` without `k`", "n"),
        (false, false, true) => ("`k` without `n`", "k"),
    };
    let path = context.description.node(context.node).path();
    context.out.error("scene::metal", p.span(at), format!("`{path}` has {found}")).help =
        "give `metal = \"NAME\"`, or `n` and `k`".to_owned();
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Black, Masking, Scatter, Transport};
    use crate::testing::{Bench, fault};
    use penombre_math::Vec3;

    fn metal(name: &str, alpha: [f32; 2], masking: Masking) -> Bsdf {
        let metal = metals::Metal::find(name).unwrap();
        RoughConductor::new(alpha, metal.n, metal.k, Spectrum::WHITE, masking).into()
    }

    #[test]
    fn gives_the_metal_that_is_asked_for() {
        let check = |params: &str, expected| {
            let bench = Bench::new(&format!("type = \"metal\"\n{params}"));
            assert_eq!(bench.bsdf(true), expected, "{params}");
            assert_eq!(bench.bsdf(false), expected, "{params}");
        };
        check("", metal("aluminium", [0.1; 2], Masking::Compensated));
        for name in NAMES {
            check(&format!("metal = \"{name}\""), metal(name, [0.1; 2], Masking::Compensated));
        }
        check("roughness = 0.5\ncompensate = false", metal("Al", [0.25; 2], Masking::Correlated));
        check("alpha = 0.3\nalpha_y = 0.6", metal("Al", [0.3, 0.6], Masking::Compensated));
        check("compensate = false\nmasking = \"separable\"", metal("Al", [0.1; 2], Masking::Separable));
        let (n, k) = ([0.2, 1.0, 1.5], [30.0, 2.0, 1.0]);
        let tint = Spectrum::rgb(1.0, 0.5, 0.25);
        check(
            "n = [0.2, 1, 1.5]\nk = [30, 2, 1]\ntint = [1, 0.5, 0.25]",
            RoughConductor::new([0.1; 2], n, k, tint, Masking::Compensated).into(),
        );
    }

    #[test]
    fn textures_are_read_where_it_is_hit() {
        let bench = Bench::new(
            "type = \"conductor\"\nmetal = \"gold\"\nalpha_y = { texture = \"half\" }\nalpha = 0.2",
        );
        assert_eq!(bench.bsdf_at(0.25), metal("gold", [0.2, 0.5], Masking::Compensated));
        assert_eq!(bench.bsdf_at(0.75), metal("gold", [0.2, 1.0], Masking::Compensated));
        assert!(bench.material().is_textured());
    }

    #[test]
    fn its_inside_is_black_if_one_sided() {
        let bench = Bench::new("type = \"rough_conductor\"\ntwo_sided = false");
        assert_eq!(bench.bsdf(true), metal("aluminium", [0.1; 2], Masking::Compensated));
        assert_eq!(bench.bsdf(false), Black.into());
        assert!(bench.view(false).diffuse.is_black() && !bench.view(true).diffuse.is_black());
    }

    #[test]
    fn stays_sound_at_the_extremes() {
        let expected = [("0", 1e4, true), ("1e-8", 1e4, true), ("0.5", 6.0, false), ("1", 0.0, false)];
        for (alpha, shininess, smooth) in expected {
            // n = 0: a reflectance of 1.
            for index in ["n = 0\nk = 1", "n = 1\nk = 0", "n = 1000\nk = 1000", "metal = \"silver\""] {
                let bench = Bench::new(&format!("type = \"metal\"\nalpha = {alpha}\n{index}"));
                let (view, bsdf) = (bench.view(true), bench.bsdf(true));
                assert_eq!(view.shininess, shininess);
                assert_eq!(view.kind, if smooth { Specular::Mirror } else { Specular::None });
                assert_eq!(bsdf.is_delta_only(), smooth, "{alpha} {index}");
                let wo = Vec3::new(0.6, 0.0, 0.8);
                for u in [0.0, 0.3, 0.999] {
                    let sample = bsdf.sample(wo, [u; 3], Transport::Radiance);
                    assert!(sample.is_none_or(|s| s.weight.is_finite() && s.pdf > 0.0));
                }
                if index.starts_with("n = 0") {
                    assert_eq!(view.specular, Spectrum::WHITE);
                }
            }
        }
    }

    #[test]
    fn faults_are_told() {
        let told = |params: &str| fault(&format!("type = \"metal\"\n{params}"));
        assert!(told("metal = \"goldd\"").1.contains("gold"), "{:?}", told("metal = \"goldd\""));
        let both = told("metal = \"gold\"\nn = [1, 1, 1]\nk = 1");
        assert_eq!(both.0, "`material.it` has both `metal` and `n`");
        assert_eq!(both.1, "give `metal = \"NAME\"`, or `n` and `k`");
        assert_eq!(told("metal = \"gold\"\nk = 1").0, "`material.it` has both `metal` and `k`");
        assert_eq!(told("n = 1").0, "`material.it` has `n` without `k`");
        assert_eq!(told("k = 1").0, "`material.it` has `k` without `n`");
        assert!(told("n = -1\nk = 1").0.contains("`n` of `material.it` is -1"));
        assert!(told("roughness = 1\nalpha = 1").0.contains("has both `roughness` and `alpha`"));
    }
}
