//! What the materials share: opacity and sides, parameters of Phong's terms, the roughness of microfacets.

use super::{PhongView, Shade, Specular};
use crate::bsdf::Masking;
use crate::registry::Context;
use crate::texture::{ColorSource, FloatSource};
use penombre_math::Spectrum;
use penombre_scene::params::{FloatInput, Params};
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// Share of the surface that is there.
pub const OPACITY: ParamSpec = ParamSpec::with_default(
    "opacity",
    Kind::FloatTexture(Range::UNIT),
    ParamDefault::Float(1.0),
    "Share of the surface that is there: 0 is a hole. Rays pass the rest as if nothing were there.",
);

/// Light of its own.
pub const EMISSION: ParamSpec = ParamSpec::with_default(
    "emission",
    Kind::ColorTexture(Range::NON_NEGATIVE),
    ParamDefault::Color([0.0; 3]),
    "Radiance that it emits besides: on its outside, and on its inside if it is `two_sided`. Not in `classic`.",
)
.unit("W/(sr m²)");

/// For materials that only reflect.
pub const TWO_SIDED: ParamSpec = ParamSpec::with_default(
    "two_sided",
    Kind::Bool,
    ParamDefault::Bool(true),
    "If false, the inside, where the geometric normal points away, is black.",
);

/// What every material has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Common {
    opacity: FloatSource,
    /// Radiance that it emits, W/(sr·m²).
    emission: ColorSource,
    emits_inside: bool,
    /// False: the inside is black.
    two_sided: bool,
}

impl Common {
    /// Entirely there, both sides alike.
    pub const PLAIN: Self = Self {
        opacity: FloatSource::Constant(1.0),
        emission: ColorSource::Constant(Spectrum::BLACK),
        emits_inside: false,
        two_sided: true,
    };

    /// Of a material with the parameters `opacity`, `emission` and `two_sided`.
    pub fn of_reflector(p: &Params, context: &Context<'_, '_>) -> Self {
        let two_sided = p.bool("two_sided");
        Self { two_sided, emits_inside: two_sided, ..Self::of_any(p, context) }
    }

    /// Of a material with the parameters `opacity` and `emission`.
    pub fn of_any(p: &Params, context: &Context<'_, '_>) -> Self {
        Self {
            emission: ColorSource::new(p.color_texture("emission"), context),
            ..Self::of_opacity(p, context)
        }
    }

    /// Of a lamp with the parameters `opacity`, `radiance` and `two_sided`, which says where it shines.
    pub fn of_lamp(p: &Params, context: &Context<'_, '_>) -> Self {
        let emission = ColorSource::new(p.color_texture("radiance"), context);
        Self { emission, emits_inside: p.bool("two_sided"), ..Self::of_opacity(p, context) }
    }

    fn of_opacity(p: &Params, context: &Context<'_, '_>) -> Self {
        Self { opacity: FloatSource::new(p.float_texture("opacity"), context), ..Self::PLAIN }
    }

    /// Radiance that it emits, W/(sr·m²), on its outside or its inside.
    #[inline]
    pub fn emitted(&self, shade: &Shade<'_>, outside: bool) -> Spectrum {
        if outside || self.emits_inside {
            self.emission.color(&shade.point, shade.textures)
        } else {
            Spectrum::BLACK
        }
    }

    /// What it emits, anywhere.
    #[inline]
    pub fn emission(&self) -> ColorSource {
        self.emission
    }

    /// True if it may emit light.
    #[inline]
    pub fn is_emissive(&self) -> bool {
        self.emission != ColorSource::Constant(Spectrum::BLACK)
    }

    /// Share of the surface that is there, in [0, 1].
    #[inline]
    pub fn opacity(&self, shade: &Shade<'_>) -> f32 {
        let opacity = self.opacity.value(&shade.point, shade.textures);
        if opacity > 0.0 { opacity.min(1.0) } else { 0.0 }
    }

    /// True if the surface may not be entirely there.
    #[inline]
    pub fn has_opacity(&self) -> bool {
        self.opacity != FloatSource::Constant(1.0)
    }

    /// True if the side that is seen is black.
    #[inline]
    pub fn hides(&self, shade: &Shade<'_>) -> bool {
        !(self.two_sided || shade.outside)
    }
}

/// Factor of the cosine term.
pub const fn diffuse_param(default: f32) -> ParamSpec {
    ParamSpec::with_default(
        "diffuse",
        Kind::ColorTexture(Range::NON_NEGATIVE),
        ParamDefault::Color([default; 3]),
        "Factor of the cosine term; the whole colour in phase 1 of `classic`.",
    )
}

/// Factor of the highlight.
pub const fn specular_param(default: f32) -> ParamSpec {
    ParamSpec::with_default(
        "specular",
        Kind::ColorTexture(Range::NON_NEGATIVE),
        ParamDefault::Color([default; 3]),
        "Factor of the highlight.",
    )
}

/// Factor of the ambient light.
pub const AMBIENT: ParamSpec = ParamSpec::with_default(
    "ambient",
    Kind::ColorTexture(Range::NON_NEGATIVE),
    ParamDefault::Color([0.0; 3]),
    "Factor of the scene's ambient light.",
);

/// Exponent of the highlight.
pub const SHININESS: ParamSpec = ParamSpec::with_default(
    "shininess",
    Kind::Float(Range::NON_NEGATIVE),
    ParamDefault::Float(16.0),
    "Exponent of the highlight: larger is smaller and sharper.",
);

/// Index of refraction of glass.
pub const IOR: ParamSpec = ParamSpec::with_default(
    "ior",
    Kind::Float(Range { min_open: true, ..Range::closed(0.0, 1000.0) }),
    ParamDefault::Float(1.5),
    "Index of refraction of the inside against the outside: 1.33 water, 1.5 glass, 2.42 diamond.",
);

/// Tint of reflected light.
pub const REFLECT: ParamSpec = ParamSpec::with_default(
    "reflect",
    Kind::ColorTexture(Range::UNIT),
    ParamDefault::Color([1.0; 3]),
    "Factor of reflected light; 1 for real matter. Not in `classic`.",
);

/// Tint of transmitted light.
pub const TRANSMIT: ParamSpec = ParamSpec::with_default(
    "transmit",
    Kind::ColorTexture(Range::UNIT),
    ParamDefault::Color([1.0; 3]),
    "Factor of transmitted light at each passage of the surface; 1 for real matter. Not in `classic`.",
);

/// Roughness of microfacets.
pub const ALPHA: ParamSpec = ParamSpec::with_default(
    "alpha",
    Kind::FloatTexture(Range::UNIT),
    ParamDefault::Float(0.1),
    "Roughness: GGX's α, the typical slope of the facets. Below 0.001 the surface is perfectly smooth.",
);

/// Roughness across.
pub const ALPHA_Y: ParamSpec = ParamSpec::optional(
    "alpha_y",
    Kind::FloatTexture(Range::UNIT),
    "GGX's α along the second axis of the surface, `alpha` being that along the first. If absent, `alpha`.",
);

/// Roughness as artists have it.
pub const ROUGHNESS: ParamSpec = ParamSpec::optional(
    "roughness",
    Kind::FloatTexture(Range::UNIT),
    "Instead of `alpha`: its square root, which looks evenly spaced.",
);

/// Masking of facets.
pub const MASKING: ParamSpec = ParamSpec::with_default(
    "masking",
    Kind::Choice(&["correlated", "separable"]),
    ParamDefault::Text("correlated"),
    "How facets hide each other, with `compensate = false`: by their height, or independently for both directions.",
);

/// Energy compensation.
pub const COMPENSATE: ParamSpec = ParamSpec::with_default(
    "compensate",
    Kind::Bool,
    ParamDefault::Bool(true),
    "Light that meets several facets comes out again, so that rough surfaces are not too dark.",
);

/// The microfacets of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facets {
    x: FloatSource,
    y: FloatSource,
    /// The sources are square roots of α.
    is_root: bool,
    masking: Masking,
}

impl Facets {
    /// Of a material with the parameters `alpha`, `alpha_y`, `roughness`, `masking` and `compensate`. `None` and an
    /// error if it says the roughness twice.
    pub fn new(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let is_root = p.is_given("roughness");
        if let Some(other) = ["alpha", "alpha_y"].into_iter().find(|name| is_root && p.is_given(name)) {
            let path = context.description.node(context.node).path();
            let message = format!("`{path}` has both `roughness` and `{other}`, expected one of them");
            context.out.error("scene::roughness", p.span("roughness"), message).help =
                "`alpha` is the square of `roughness`: take one of both away".to_owned();
            return None;
        }
        let source = |input: FloatInput| FloatSource::new(input, context);
        let x = source(p.float_texture(if is_root { "roughness" } else { "alpha" }));
        let y = if p.is_given("alpha_y") { source(p.float_texture("alpha_y")) } else { x };
        Some(Self { x, y, is_root, masking: masking(p, context) })
    }

    /// α along both axes, in [0, 1].
    #[inline]
    pub fn alpha(&self, shade: &Shade<'_>) -> [f32; 2] {
        [self.x, self.y].map(|source| {
            let v = source.value(&shade.point, shade.textures);
            let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
            if self.is_root { v * v } else { v }
        })
    }

    /// What facets do to each other.
    #[inline]
    pub fn masking(&self) -> Masking {
        self.masking
    }

    /// True if α may vary over the surface.
    pub fn is_textured(&self) -> bool {
        self.x.is_texture() || self.y.is_texture()
    }
}

fn masking(p: &Params, context: &mut Context<'_, '_>) -> Masking {
    if p.bool("compensate") {
        if p.is_given("masking") && p.choice("masking") != "correlated" {
            let path = context.description.node(context.node).path();
            let message = format!("`masking` of `{path}` has no effect: energy compensation is correlated");
            context.out.warning("scene::no-effect", p.span("masking"), message).help =
                "add `compensate = false`, or take `masking` away".to_owned();
        }
        return Masking::Compensated;
    }
    if p.choice("masking") == "separable" { Masking::Separable } else { Masking::Correlated }
}

/// Exponent of a highlight as narrow as a GGX lobe: 2/α² − 2 \[Walter2007\], at most 10⁴.
pub fn shininess(alpha: [f32; 2]) -> f32 {
    let squared = (alpha[0] * alpha[1]).max(1e-8);
    (2.0 / squared - 2.0).min(1e4)
}

/// A surface that is black in `classic`.
pub const BLACK_VIEW: PhongView = PhongView {
    ambient: Spectrum::BLACK,
    diffuse: Spectrum::BLACK,
    specular: Spectrum::BLACK,
    shininess: 1.0,
    kind: Specular::None,
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Black, Bsdf};
    use crate::material::AnyMaterial;
    use crate::testing::{Bench, fault};

    #[test]
    fn every_material_has_an_opacity() {
        let rest = "[material.paint]\ntype = \"diffuse\"";
        for info in AnyMaterial::TYPES {
            let parts = if info.name == "mix" { "a = \"paint\"\nb = \"paint\"" } else { "" };
            let material =
                |opacity: &str| format!("type = \"{}\"\n{parts}\nopacity = {opacity}\n{rest}", info.name);
            let opaque = Bench::new(&material("1"));
            assert!(!opaque.material().has_opacity() && opaque.opacity(0.75) == 1.0, "{}", info.name);
            let textured = Bench::new(&material("{ texture = \"half\" }"));
            assert!(textured.material().has_opacity(), "{}", info.name);
            assert_eq!([0.25, 0.75].map(|u| textured.opacity(u)), [0.5, 1.0], "{}", info.name);
            assert_eq!(Bench::new(&material("0")).opacity(0.1), 0.0, "{}", info.name);
            assert!(fault(&material("1.1")).0.contains("`opacity` of `material.it` is 1.1"));
        }
    }

    #[test]
    fn every_material_may_shine() {
        let (half, white) = (Spectrum::splat(0.5), Spectrum::WHITE);
        for info in AnyMaterial::TYPES.iter().filter(|info| info.name != "emissive") {
            let parts = if info.name == "mix" { "a = \"paint\"\nb = \"paint\"" } else { "" };
            let rest = "[material.paint]\ntype = \"diffuse\"";
            let bench =
                |more: &str| Bench::new(&format!("type = \"{}\"\n{parts}\n{more}\n{rest}", info.name));
            assert!(!bench("").material().is_emissive() && bench("").emitted(0.3, true).is_black());
            let shining = bench("emission = [0.5, 0.5, 0.5]");
            assert!(shining.material().is_emissive() && !shining.material().has_textured_emission());
            assert_eq!(shining.emitted(0.3, true), half, "{}", info.name);
            let is_reflector = info.schema.iter().any(|p| p.name == "two_sided");
            assert_eq!(shining.emitted(0.3, false), if is_reflector { half } else { Spectrum::BLACK });
            assert_eq!(shining.bsdf(true), bench("").bsdf(true));
            if is_reflector {
                assert!(bench("emission = [1, 1, 1]\ntwo_sided = false").emitted(0.3, false).is_black());
            }
            let textured = bench("emission = { texture = \"half\" }");
            assert!(textured.material().has_textured_emission(), "{}", info.name);
            assert_eq!([0.25, 0.75].map(|u| textured.emitted(u, true)), [half, white], "{}", info.name);
        }
    }

    #[test]
    fn reflectors_are_two_sided_unless_told() {
        for name in ["phong", "diffuse", "mirror", "metal"] {
            let plain = Bench::new(&format!("type = \"{name}\""));
            assert_eq!(plain.bsdf(true), plain.bsdf(false));
            let bench = Bench::new(&format!("type = \"{name}\"\ntwo_sided = false"));
            assert_eq!(bench.bsdf(true), plain.bsdf(true));
            assert_ne!(bench.bsdf(true), Black.into());
            assert_eq!(bench.bsdf(false), Bsdf::Black(Black));
            assert_eq!((bench.view(true), bench.view(false)), (plain.view(true), BLACK_VIEW));
        }
        assert!(fault("type = \"glass\"\ntwo_sided = false").0.contains("unknown parameter `two_sided`"));
    }

    #[test]
    fn textures_beyond_the_range_are_limited() {
        let wild = "[texture.wild]\ntype = \"checker\"\nscale = [2, 1]\na = [9, 9, 9]\nb = [1, 0, 0.5]";
        let bench = Bench::new(&format!("type = \"glass\"\nopacity = {{ texture = \"wild\" }}\n{wild}"));
        assert_eq!([0.25, 0.75].map(|u| bench.opacity(u)), [1.0, 0.5]);
    }

    #[test]
    fn exponents_of_lobes() {
        assert_eq!(shininess([1.0; 2]), 0.0);
        assert_eq!(shininess([0.25, 1.0]), 6.0);
        assert_eq!(shininess([0.0, 1.0]), 1e4);
    }
}
