//! `mix`: two materials in one.
//!
//! A share `amount` of the surface is made of `b`, the rest of `a`: f = (1 − amount)·fₐ + amount·f_b. Each hit of a path
//! is answered by one of both, chosen in these proportions. A part that is not entirely there (`opacity`) has the less of a
//! share; the opacity of the mix is (1 − amount)·opacityₐ + amount·opacity_b, times its own. Mixes may be mixed again.
//! What the parts emit is blended.
//! In `classic` the factors are blended; the larger share says whether it is a mirror or glass.
//!
//! ```toml
//! [material.rust]
//! type = "mix"
//! a = "iron"
//! b = "oxide"
//! amount = { texture = "stains" }
//! ```

use super::common::{Common, EMISSION, OPACITY};
use super::emissive::Emissive;
use super::{AnyMaterial, Material, PhongView, Shade};
use crate::bsdf::Bsdf;
use crate::registry::Context;
use crate::texture::FloatSource;
use penombre_math::Spectrum;
use penombre_scene::params::Params;
use penombre_scene::{
    Kind, Node, NodeId, ParamDefault, ParamSpec, Range, Role, SceneDescription, Span, Value, ValueKind,
};

/// Parts of a mix at most, those of mixes in it included: `classic` looks at all.
const MOST_PARTS: usize = 256;

/// Two materials in one.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// Indices of the materials.
    parts: [u32; 2],
    amount: FloatSource,
    common: Common,
    contents: Contents,
}

/// What the parts of a mix have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Contents {
    textured: bool,
    cut_out: bool,
    emissive: bool,
}

impl Material for Mix {
    const TYPE_NAME: &'static str = "mix";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("a", Kind::Reference(Role::Material), "A material."),
        ParamSpec::required("b", Kind::Reference(Role::Material), "Another material."),
        ParamSpec::with_default(
            "amount",
            Kind::FloatTexture(Range::UNIT),
            ParamDefault::Float(0.5),
            "Share of `b`.",
        ),
        OPACITY,
        EMISSION,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let contents = contents(p, context)?;
        let parts = [p.reference("a")?, p.reference("b")?].map(|id| context.position(id));
        let amount = FloatSource::new(p.float_texture("amount"), context);
        Some(Self { parts, amount, common: Common::of_any(p, context), contents })
    }

    fn common(&self) -> &Common {
        &self.common
    }

    fn opacity(&self, shade: &Shade<'_>) -> f32 {
        let inner = if self.contents.cut_out {
            let [a, b] = self.shares(shade);
            a + b
        } else {
            1.0
        };
        self.common.opacity(shade) * inner.min(1.0)
    }

    fn has_opacity(&self) -> bool {
        self.common.has_opacity() || self.contents.cut_out
    }

    fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
        let [a, b] = [0, 1].map(|i| self.part(i, shade).phong_view(shade));
        let share = self.share_of_b(shade);
        let rest = 1.0 - share;
        PhongView {
            ambient: a.ambient * rest + b.ambient * share,
            diffuse: a.diffuse * rest + b.diffuse * share,
            specular: a.specular * rest + b.specular * share,
            shininess: a.shininess * rest + b.shininess * share,
            kind: if share > 0.5 { b.kind } else { a.kind },
        }
    }

    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
        let share = self.share_of_b(shade);
        let rest = 1.0 - share;
        let (i, u) = if shade.u < rest { (0, shade.u / rest) } else { (1, (shade.u - rest) / share) };
        // Rounded, the quotient may be 1.
        let u = u.min(1.0 - f32::EPSILON / 2.0);
        self.part(i, shade).bsdf(&Shade { u, ..*shade })
    }

    fn emitted(&self, shade: &Shade<'_>, outside: bool) -> Spectrum {
        let own = self.common.emitted(shade, outside);
        if !self.contents.emissive {
            return own;
        }
        let [a, b] = [0, 1].map(|i| self.part(i, shade).emitted(shade, outside));
        let share = self.share_of_b(shade);
        own + a * (1.0 - share) + b * share
    }

    fn is_emissive(&self) -> bool {
        self.common.is_emissive() || self.contents.emissive
    }

    fn has_textured_emission(&self) -> bool {
        self.common.emission().is_texture() || self.contents.emissive && self.is_textured()
    }

    fn is_textured(&self) -> bool {
        self.amount.is_texture() || self.contents.textured
    }
}

impl Mix {
    fn part<'a>(&self, i: usize, shade: &Shade<'a>) -> &'a AnyMaterial {
        &shade.materials[self.parts[i] as usize].value
    }

    /// Shares of the surface that are there and made of each part.
    fn shares(&self, shade: &Shade<'_>) -> [f32; 2] {
        let amount = self.amount.value(&shade.point, shade.textures);
        let b = if amount > 0.0 { amount.min(1.0) } else { 0.0 };
        let opacity = |i| if self.contents.cut_out { self.part(i, shade).opacity(shade) } else { 1.0 };
        [(1.0 - b) * opacity(0), b * opacity(1)]
    }

    /// The second part's share of what is there; 0 if nothing is.
    fn share_of_b(&self, shade: &Shade<'_>) -> f32 {
        let [a, b] = self.shares(shade);
        if b > 0.0 { b / (a + b) } else { 0.0 }
    }
}

/// Looks through all parts. Circles and too many parts are errors: `None` then, as for a mix that holds a faulty one.
fn contents(p: &Params, context: &mut Context<'_, '_>) -> Option<Contents> {
    let mut walk = Walk { description: context.description, path: vec![context.node], parts: 0 };
    let mut found = Contents::default();
    for name in ["a", "b"] {
        let part = p.reference(name)?;
        match walk.enter(part, &mut found) {
            Ok(()) => {}
            Err(Trouble::Elsewhere) => return None,
            Err(trouble) => {
                report(trouble, &context.description.node(context.node).path(), p.span(name), context);
                return None;
            }
        }
    }
    Some(found)
}

/// Why a mix cannot be.
enum Trouble {
    /// It contains itself: the way from it back to it.
    Circle(Vec<String>),
    TooMany,
    /// A mix in it contains itself, or has a part that is not there: its own error.
    Elsewhere,
}

fn report(trouble: Trouble, path: &str, span: Span, context: &mut Context<'_, '_>) {
    let (code, message, help) = match trouble {
        Trouble::Circle(way) => (
            "scene::mix-circle",
            format!("`{path}` contains itself: {}", way.join(" → ")),
            "name a material that is not made of this one".to_owned(),
        ),
        Trouble::TooMany => (
            "scene::mix-parts",
            format!("`{path}` has more than {MOST_PARTS} parts"),
            "mixes of mixes count by all materials in them: mix fewer".to_owned(),
        ),
        Trouble::Elsewhere => return,
    };
    context.out.error(code, span, message).help = help;
}

/// A way down through mixes, by the description, for the materials are not built yet.
struct Walk<'a> {
    description: &'a SceneDescription,
    /// From the mix in question.
    path: Vec<NodeId>,
    parts: usize,
}

impl Walk<'_> {
    /// Looks into a part. No deeper than [`MOST_PARTS`], for each level has a part more.
    fn enter(&mut self, id: NodeId, found: &mut Contents) -> Result<(), Trouble> {
        let node = self.description.node(id);
        if id == self.path[0] {
            let way = self.path.iter().chain([&id]);
            return Err(Trouble::Circle(way.map(|id| self.description.node(*id).name.clone()).collect()));
        }
        if self.path.contains(&id) {
            return Err(Trouble::Elsewhere);
        }
        self.parts += 1;
        if self.parts > MOST_PARTS {
            return Err(Trouble::TooMany);
        }
        found.emissive |= node.type_name == Emissive::TYPE_NAME || node.param("emission").is_some();
        found.textured |= node.params.iter().any(|p| matches!(p.value.kind, ValueKind::Table(_)));
        found.cut_out |= node.param("opacity").is_some_and(|p| !is_one(&p.value));
        if node.type_name != Mix::TYPE_NAME {
            return Ok(());
        }
        self.path.push(id);
        for part in ["a", "b"] {
            self.enter(self.part_of(node, part)?, found)?;
        }
        self.path.pop();
        Ok(())
    }

    fn part_of(&self, mix: &Node, name: &str) -> Result<NodeId, Trouble> {
        match mix.param(name).map(|p| &p.value.kind) {
            Some(ValueKind::String(s)) => self.description.find(Role::Material, s).ok_or(Trouble::Elsewhere),
            _ => Err(Trouble::Elsewhere),
        }
    }
}

fn is_one(value: &Value) -> bool {
    matches!(value.kind, ValueKind::Int(1)) || matches!(value.kind, ValueKind::Float(1.0))
}

#[cfg(test)]
mod tests {
    use crate::bsdf::{Black, Bsdf, Lambert, Mirror};
    use crate::material::Specular;
    use crate::testing::{Bench, fault};
    use penombre_math::Spectrum;

    /// Diffuse materials `red`, `green` and a mirror.
    const OTHERS: &str = "
        [material.red]\ntype = \"diffuse\"\ncolor = [1, 0, 0]
        [material.green]\ntype = \"diffuse\"\ncolor = [0, 1, 0]
        [material.shiny]\ntype = \"mirror\"";

    fn mix(params: &str) -> Bench {
        Bench::new(&format!("type = \"mix\"\n{params}\n{OTHERS}"))
    }

    fn red() -> Bsdf {
        Lambert::new(Spectrum::rgb(1.0, 0.0, 0.0)).into()
    }

    fn green() -> Bsdf {
        Lambert::new(Spectrum::rgb(0.0, 1.0, 0.0)).into()
    }

    fn shiny() -> Bsdf {
        Mirror::new(Spectrum::WHITE).into()
    }

    /// Share of equidistant choices that give a model.
    fn share(bench: &Bench, u: f32, of: Bsdf) -> f32 {
        (0..1000).filter(|i| bench.chosen(u, *i as f32 / 1000.0) == of).count() as f32 / 1000.0
    }

    #[test]
    fn parts_are_chosen_by_their_shares() {
        for (amount, expected) in [("0", 0.0), ("0.25", 0.25), ("1", 1.0), ("1e-8", 0.0)] {
            let bench = mix(&format!("a = \"red\"\nb = \"green\"\namount = {amount}"));
            assert!((share(&bench, 0.3, green()) - expected).abs() < 1.5e-3, "{amount}");
            assert!((share(&bench, 0.3, red()) - (1.0 - expected)).abs() < 1.5e-3, "{amount}");
        }
        let bench = mix("a = \"red\"\nb = \"shiny\"\namount = { texture = \"half\" }");
        assert_eq!([share(&bench, 0.25, shiny()), share(&bench, 0.75, shiny())], [0.5, 1.0]);
        assert!(bench.material().is_textured() && !bench.material().has_opacity());
    }

    #[test]
    fn mixes_are_mixed() {
        let inner = "[material.inner]\ntype = \"mix\"\na = \"red\"\nb = \"green\"\namount = 0.25";
        let bench = Bench::new(&format!(
            "type = \"mix\"\na = \"inner\"\nb = \"shiny\"\namount = 0.2\n{inner}{OTHERS}"
        ));
        for (of, expected) in [(red(), 0.6), (green(), 0.2), (shiny(), 0.2)] {
            assert!((share(&bench, 0.3, of) - expected).abs() < 2e-3);
        }
        assert_eq!(bench.chosen(0.3, 1.0 - f32::EPSILON / 2.0), shiny());
        assert!(!bench.material().is_textured());
    }

    #[test]
    fn classic_blends_the_factors() {
        let bench = mix("a = \"red\"\nb = \"shiny\"\namount = 0.25");
        let view = bench.view(true);
        assert_eq!(view.diffuse, Spectrum::rgb(1.0, 0.25, 0.25));
        assert_eq!((view.specular, view.kind), (Spectrum::splat(0.25), Specular::None));
        assert_eq!(mix("a = \"red\"\nb = \"shiny\"\namount = 0.75").view(true).kind, Specular::Mirror);
    }

    #[test]
    fn parts_with_holes_count_for_less() {
        let others =
            "[material.thin]\ntype = \"diffuse\"\ncolor = [0, 1, 0]\nopacity = 0.5\ntwo_sided = false";
        let bench = Bench::new(&format!("type = \"mix\"\na = \"red\"\nb = \"thin\"\n{others}{OTHERS}"));
        assert!(bench.material().has_opacity());
        assert!((share(&bench, 0.3, green()) - 1.0 / 3.0).abs() < 1.5e-3);
        assert_eq!(bench.opacity(0.3), 0.75);
        let black = Bench::new(&format!("type = \"mix\"\na = \"thin\"\nb = \"thin\"\n{others}{OTHERS}"));
        assert_eq!((black.bsdf(false), black.bsdf(true)), (Black.into(), green()));
        let none = Bench::new(
            "type = \"mix\"\na = \"gone\"\nb = \"gone\"\nopacity = 0.5\n\
            [material.gone]\ntype = \"diffuse\"\nopacity = 0",
        );
        assert_eq!(none.opacity(0.3), 0.0);
        assert!(none.view(true).diffuse.is_finite());
    }

    #[test]
    fn what_parts_emit_is_blended() {
        let bench = Bench::new(&format!(
            "type = \"mix\"\na = \"lamp\"\nb = \"glow\"\namount = 0.25\nemission = [0, 0, 1]\n\
             [material.lamp]\ntype = \"emissive\"\nradiance = [4, 0, 0]\n\
             [material.glow]\ntype = \"diffuse\"\nemission = [0, 8, 0]\n{OTHERS}"
        ));
        assert!(bench.material().is_emissive());
        assert_eq!(
            [true, false].map(|side| bench.emitted(0.3, side)),
            [[3.0, 2.0, 1.0], [0.0, 2.0, 0.0]].map(Spectrum::from_rgb)
        );
    }

    #[test]
    fn faults_are_told() {
        let told = |params: &str| fault(&format!("type = \"mix\"\n{params}\n{OTHERS}"));
        assert_eq!(told("a = \"red\"\nb = \"it\"").0, "`material.it` contains itself: it → it");
        let circle = "a = \"red\"\nb = \"other\"
            [material.other]\ntype = \"mix\"\na = \"green\"\nb = \"it\"";
        assert_eq!(told(circle).0, "`material.it` contains itself: it → other → it");
        assert!(told(circle).1.contains("not made of this one"));
        assert!(told("a = \"red\"").0.contains("no parameter `b`"));
        assert!(told("a = \"red\"\nb = \"gren\"").1.contains("green"));
        assert!(told("a = \"red\"\nb = \"green\"\namount = 2").0.contains("`amount`"));
    }

    #[test]
    fn parts_in_all_are_limited() {
        // Level n has 2ⁿ⁺² − 2 parts.
        let level = |n: usize| {
            let inner = if n == 0 { "red".to_owned() } else { format!("m{}", n - 1) };
            format!("[material.m{n}]\ntype = \"mix\"\na = \"{inner}\"\nb = \"{inner}\"\n")
        };
        let levels = |n| (0..n).map(level).collect::<String>();
        let six = format!("type = \"mix\"\na = \"m4\"\nb = \"m5\"\n{}{OTHERS}", levels(6));
        assert_eq!(Bench::new(&six).chosen(0.3, 0.7), red());
        let far = format!("type = \"mix\"\na = \"m39\"\nb = \"red\"\n{}{OTHERS}", levels(40));
        assert_eq!(fault(&far).0, "`material.it` has more than 256 parts");
    }
}
