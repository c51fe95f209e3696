//! From values to checked parameters.

use super::expect::{documentation, expected, expected_number, found, how_to_write, quoted, without_quotes};
use super::{ColorInput, Decoded, Entry, FloatInput};
use crate::description::{Node, NodeId, Param, Role, SceneDescription, Value, ValueKind};
use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::schema::{Kind, ParamDefault, ParamSpec, Range};
use crate::span::Span;
use crate::suggest::help_for;
use penombre_math::{Vec2, Vec3};

/// Faults listed for one parameter: more than that in a long list are one fault, made many times.
const MOST_FAULTS: usize = 20;

/// Decodes all parameters in the order of the schema. `brief`: help does not list the names of nodes.
pub fn entries(
    node: &Node,
    schema: &'static [ParamSpec],
    scene: &SceneDescription,
    brief: bool,
    out: &mut Diagnostics,
) -> Vec<Entry> {
    unknown_keys(node, schema, out);
    let entry =
        |spec| Decoder { node, scene, brief, out: &mut *out, spec, steps: Vec::new(), faults: 0 }.entry();
    schema.iter().map(entry).collect()
}

fn unknown_keys(node: &Node, schema: &[ParamSpec], out: &mut Diagnostics) {
    let names: Vec<&str> = schema.iter().map(|s| s.name).collect();
    for param in node.params.iter().filter(|p| !names.contains(&p.name.as_str())) {
        let message = format!("unknown parameter {} of `{}`", ticked(&param.name), node.path());
        let what = match node.role {
            Role::Render => "render has".to_owned(),
            Role::Integrator => format!("the integrator {} has", node.name),
            Role::Instance => "instances have".to_owned(),
            role => format!("{}s of type {} have", role.name(), node.type_name),
        };
        out.error("scene::unknown-parameter", param.name_span, message).help = match names[..] {
            [] => format!("{what} no parameters"),
            _ => help_for(&param.name, &what, &names),
        };
    }
}

/// A key in back ticks, or quoted and cut if it is no plain word.
fn ticked(name: &str) -> String {
    let plain = name.len() <= 40 && name.chars().all(|c| c.is_alphanumeric() || "-_".contains(c));
    if plain { format!("`{name}`") } else { quoted(name) }
}

/// Decodes one parameter of a node; `steps` say where in its value we are.
pub struct Decoder<'a> {
    node: &'a Node,
    scene: &'a SceneDescription,
    brief: bool,
    out: &'a mut Diagnostics,
    spec: &'static ParamSpec,
    steps: Vec<Step>,
    faults: usize,
}

/// A step into a value.
#[derive(Clone, Copy)]
pub enum Step {
    Index(usize),
    Key(&'static str),
}

impl Decoder<'_> {
    fn entry(&mut self) -> Entry {
        let spec = self.spec;
        let Some(param) = self.node.param(spec.name) else {
            if spec.default == ParamDefault::Required {
                self.missing();
            }
            return Entry { value: default_value(spec), span: None };
        };
        let value = self.decode(&spec.kind, &param.value).unwrap_or_else(|| default_value(spec));
        Entry { value, span: Some(param.value.span) }
    }

    fn missing(&mut self) {
        let spec = self.spec;
        let message = format!("`{}` has no parameter `{}`, which it must have", self.node.path(), spec.name);
        let expected = expected(&spec.kind, spec.unit);
        self.out.error("scene::missing-parameter", self.node.span, message).help =
            format!("add `{} = …`: {expected}", spec.name);
    }

    /// Reports a fault at the present place: "`name[1]` of `shape.ball` is FOUND, expected EXPECTED".
    pub fn fault(&mut self, code: &'static str, value: &Value, expected: &str) -> Fault<'_> {
        let message = format!("{} is {}, expected {expected}", self.place(), found(value));
        self.report(code, value.span, message)
    }

    /// Reports a fault in words of its own. The help is what the parameter means, until something better is said.
    pub fn report(&mut self, code: &'static str, span: Span, message: String) -> Fault<'_> {
        self.faults += 1;
        let diagnostic = Diagnostic::new(Severity::Error, code, span, message).help(documentation(self.spec));
        Fault { diagnostic: Some(diagnostic), out: self.out }
    }

    /// How messages call the present place: "`sides[0]` of `shape.wall`".
    pub fn place(&self) -> String {
        let mut path = self.spec.name.to_owned();
        for step in &self.steps {
            match step {
                Step::Index(i) => path.push_str(&format!("[{i}]")),
                Step::Key(key) => path.push_str(&format!(".{key}")),
            }
        }
        format!("`{path}` of `{}`", self.node.path())
    }

    /// Decodes a part of a value.
    pub fn within<T>(&mut self, step: Step, decode: impl FnOnce(&mut Self) -> T) -> T {
        self.steps.push(step);
        let part = decode(self);
        self.steps.pop();
        part
    }

    fn decode(&mut self, kind: &Kind, value: &Value) -> Option<Decoded> {
        match kind {
            Kind::Bool => match value.kind {
                ValueKind::Bool(b) => Some(Decoded::Bool(b)),
                _ => self.wrong_type(kind, value),
            },
            Kind::Int(range) => self.int(value, range).map(Decoded::Int),
            Kind::Float(range) => self.number(value, range).map(Decoded::Float),
            Kind::Vec2(range) => self.numbers::<2>(value, kind, range).map(Decoded::Pair),
            Kind::Int2(range) => {
                let ints = self.array::<2, _>(value, kind, |d, v| d.int(v, range))?;
                Some(Decoded::Ints(ints))
            }
            Kind::Vec3 => self.vector(value, kind).map(Decoded::Vector),
            Kind::Direction => self.direction(value).map(Decoded::Vector),
            Kind::Sides => self.sides(value).map(Decoded::Sides),
            Kind::Color(range) => self.color(value, range, kind).map(Decoded::Color),
            Kind::ColorTexture(range) => self.color_input(value, range, kind).map(Decoded::ColorInput),
            Kind::FloatTexture(range) => self.float_input(value, range, kind).map(Decoded::FloatInput),
            Kind::Choice(words) => self.choice(value, words, kind),
            Kind::Text | Kind::File => self.text(value, kind),
            Kind::Reference(role) => self.reference(value, *role, kind).map(Decoded::Reference),
            Kind::Transform => self.transform(value).map(Decoded::Transform),
            Kind::Transforms => self.list(value, kind, |d, v| d.transform(v)).map(Decoded::Transforms),
            Kind::Vec3List => self.list(value, kind, |d, v| d.vector(v, &Kind::Vec3)).map(Decoded::Vectors),
            Kind::Vec2List => {
                let pair = |d: &mut Self, v: &Value| d.numbers::<2>(v, &Kind::Vec2(Range::ANY), &Range::ANY);
                let pairs = self.list(value, kind, pair)?;
                Some(Decoded::Pairs(pairs.into_iter().map(|[x, y]| Vec2::new(x as f32, y as f32)).collect()))
            }
            Kind::ColorList => {
                self.list(value, kind, |d, v| d.color(v, &Range::ANY, kind)).map(Decoded::Colors)
            }
            Kind::Faces => self.list(value, kind, Self::face).map(Decoded::Faces),
        }
    }

    /// Reports that the value is of a kind that the parameter does not take.
    pub fn wrong_type<T>(&mut self, kind: &Kind, value: &Value) -> Option<T> {
        let expected = expected(kind, self.spec.unit);
        let help = without_quotes(value).unwrap_or_else(|| how_to_write(kind));
        self.fault("scene::wrong-type", value, &expected).help(help);
        None
    }

    fn int(&mut self, value: &Value, range: &Range) -> Option<i64> {
        let expected = expected_number(range, true, self.spec.unit);
        let ValueKind::Int(i) = value.kind else {
            let help = match value.kind {
                ValueKind::Float(v) if v.fract() == 0.0 && v.abs() < 9e15 => format!("write {v}"),
                _ => without_quotes(value).unwrap_or_default(),
            };
            self.fault("scene::wrong-type", value, &expected).help(help);
            return None;
        };
        if !range.contains(i as f64) {
            self.fault("scene::out-of-range", value, &expected);
            return None;
        }
        Some(i)
    }

    /// A number within the range, which stays within it when rounded to single precision.
    pub fn number(&mut self, value: &Value, range: &Range) -> Option<f64> {
        let v = match value.kind {
            ValueKind::Int(i) => i as f64,
            ValueKind::Float(v) => v,
            _ => return self.wrong_type(&Kind::Float(*range), value),
        };
        let single = f64::from(v as f32);
        let rounded_out = (range.min_open && single <= range.min) || (range.max_open && single >= range.max);
        if range.contains(v) && !rounded_out && (single.is_finite() || v.is_infinite()) {
            return Some(v);
        }
        let unit = self.spec.unit;
        let finite = if v.is_finite() || *range != Range::ANY { "" } else { "finite " };
        let expected =
            expected_number(range, false, unit).replacen("a number", &format!("a {finite}number"), 1);
        let help = if !range.contains(v) {
            ""
        } else if single.is_infinite() {
            "numbers are kept in single precision, which ends at 3.4e38"
        } else {
            "numbers are kept in single precision, and rounded to it this one is the excluded end of the range"
        };
        self.fault("scene::out-of-range", value, &expected).help(help);
        None
    }

    /// Exactly `N` entries, each decoded; all faulty entries are reported.
    fn array<const N: usize, T: Copy>(
        &mut self,
        value: &Value,
        kind: &Kind,
        decode: impl Fn(&mut Self, &Value) -> Option<T>,
    ) -> Option<[T; N]> {
        let ValueKind::Array(list) = &value.kind else { return self.wrong_type(kind, value) };
        if list.len() != N {
            let expected = expected(kind, self.spec.unit);
            self.fault("scene::wrong-length", value, &expected).help(how_to_write(kind));
            return None;
        }
        let decode = |(i, v)| self.within(Step::Index(i), |d| decode(d, v));
        let parts: Vec<Option<T>> = list.iter().enumerate().map(decode).collect();
        let parts: Option<Vec<T>> = parts.into_iter().collect();
        parts.and_then(|p| <[T; N]>::try_from(p).ok())
    }

    /// `N` numbers, each within the range.
    pub fn numbers<const N: usize>(&mut self, value: &Value, kind: &Kind, range: &Range) -> Option<[f64; N]> {
        self.array::<N, _>(value, kind, |d, v| d.number(v, range))
    }

    /// Three finite numbers in single precision.
    fn vector(&mut self, value: &Value, kind: &Kind) -> Option<Vec3> {
        self.numbers::<3>(value, kind, &Range::ANY).map(|v| Vec3::from_array(v.map(|x| x as f32)))
    }

    /// A vector that is not zero. Where its squared length leaves single precision it is scaled to about 1.
    fn direction(&mut self, value: &Value) -> Option<Vec3> {
        let v = self.numbers::<3>(value, &Kind::Direction, &Range::ANY)?;
        let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            let message = format!("{} is [0, 0, 0], expected a direction", self.place());
            self.report("scene::zero-direction", value.span, message);
            return None;
        }
        let plain = Vec3::from_array(v.map(|x| x as f32));
        let usable = plain.length_squared().is_normal();
        Some(if usable { plain } else { Vec3::from_array(v.map(|x| (x / largest) as f32)) })
    }

    fn sides(&mut self, value: &Value) -> Option<[Vec3; 2]> {
        let kind = Kind::Sides;
        let [a, b] = self.array::<2, _>(value, &kind, |d, v| d.vector(v, &Kind::Vec3))?;
        let (wide_a, wide_b) = (a.as_dvec3(), b.as_dvec3());
        let area = wide_a.cross(wide_b).length();
        // Six digits of single precision: nearer to parallel, the rounding of the sides decides the plane.
        if area <= 1e-6 * wide_a.length() * wide_b.length() {
            let zero = a == Vec3::ZERO || b == Vec3::ZERO;
            let what = if zero { "have a zero vector" } else { "are parallel" };
            let message = format!("the vectors of {} {what}, expected two that span an area", self.place());
            let help = "these are the two edges that leave one corner, for example [[1, 0, 0], [0, 1, 0]]";
            self.report("scene::parallel-sides", value.span, message).help(help);
            return None;
        }
        Some([a, b])
    }

    fn float_input(&mut self, value: &Value, range: &Range, kind: &Kind) -> Option<FloatInput> {
        match &value.kind {
            ValueKind::Table(entries) => self.texture(value, entries).map(FloatInput::Texture),
            ValueKind::Int(_) | ValueKind::Float(_) => {
                self.number(value, range).map(|v| FloatInput::Constant(v as f32))
            }
            _ => self.wrong_type(kind, value),
        }
    }

    fn color_input(&mut self, value: &Value, range: &Range, kind: &Kind) -> Option<ColorInput> {
        match &value.kind {
            ValueKind::Table(entries) => self.texture(value, entries).map(ColorInput::Texture),
            _ => self.color(value, range, kind).map(ColorInput::Constant),
        }
    }

    /// `{ texture = "NAME" }`.
    fn texture(&mut self, value: &Value, entries: &[Param]) -> Option<NodeId> {
        if self.unknown_entries(entries, &["texture"]) {
            return None;
        }
        let Some(entry) = entries.iter().find(|e| e.name == "texture") else {
            self.fault("scene::wrong-type", value, "{ texture = \"NAME\" }");
            return None;
        };
        let kind = Kind::Reference(Role::Texture);
        self.within(Step::Key("texture"), |d| d.reference(&entry.value, Role::Texture, &kind))
    }

    /// Reports the keys of an inline table that are not among `names`.
    pub fn unknown_entries(&mut self, entries: &[Param], names: &[&str]) -> bool {
        let before = self.faults;
        for entry in entries.iter().filter(|e| !names.contains(&e.name.as_str())) {
            let message = format!("unknown key {} in {}", ticked(&entry.name), self.place());
            let help = help_for(&entry.name, "known keys", names);
            self.report("scene::unknown-key", entry.name_span, message).help(help);
        }
        self.faults > before
    }

    fn choice(&mut self, value: &Value, words: &[&'static str], kind: &Kind) -> Option<Decoded> {
        let ValueKind::String(word) = &value.kind else { return self.wrong_type(kind, value) };
        if words.contains(&word.as_str()) {
            return Some(Decoded::Text(word.clone()));
        }
        let help = help_for(word, "known words", words);
        self.fault("scene::unknown-word", value, &expected(kind, "")).help(help);
        None
    }

    fn text(&mut self, value: &Value, kind: &Kind) -> Option<Decoded> {
        match &value.kind {
            ValueKind::String(s) => Some(Decoded::Text(s.clone())),
            _ => self.wrong_type(kind, value),
        }
    }

    fn reference(&mut self, value: &Value, role: Role, kind: &Kind) -> Option<NodeId> {
        let ValueKind::String(name) = &value.kind else { return self.wrong_type(kind, value) };
        let found = self.scene.find(role, name);
        if found.is_none() {
            let message = format!(
                "{} names {}, but there is no {} of that name",
                self.place(),
                quoted(name),
                role.name()
            );
            let help = if self.brief {
                how_to_write(kind)
            } else {
                let names: Vec<&str> = self.scene.of_role(role).map(|(_, n)| n.name.as_str()).collect();
                help_for(name, &format!("{}s in this scene", role.name()), &names)
            };
            self.report("scene::missing-reference", value.span, message).help(help);
        }
        found
    }

    /// A list of any length; all faulty entries are reported up to a limit.
    fn list<T>(
        &mut self,
        value: &Value,
        kind: &Kind,
        decode: impl Fn(&mut Self, &Value) -> Option<T>,
    ) -> Option<Vec<T>> {
        let ValueKind::Array(list) = &value.kind else { return self.wrong_type(kind, value) };
        let mut good = Vec::with_capacity(list.len());
        for (i, v) in list.iter().enumerate() {
            good.extend(self.within(Step::Index(i), |d| decode(d, v)));
            if self.faults >= MOST_FAULTS && i + 1 < list.len() {
                let message =
                    format!("{} has more than {MOST_FAULTS} faults; the rest is not checked", self.place());
                let help = "mend the first of them: the others are often the same mistake";
                self.report("scene::many-faults", value.span, message).help(help);
                return None;
            }
        }
        (good.len() == list.len()).then_some(good)
    }

    fn face(&mut self, value: &Value) -> Option<Vec<u32>> {
        const EXPECTED: &str = "a list of three or more indices from 0";
        let ValueKind::Array(list) = &value.kind else {
            self.fault("scene::wrong-type", value, EXPECTED);
            return None;
        };
        if list.len() < 3 {
            self.fault("scene::wrong-length", value, EXPECTED);
            return None;
        }
        let range = Range::closed(0.0, f64::from(u32::MAX));
        let index = |(i, v)| self.within(Step::Index(i), |d| d.int(v, &range)).map(|i| i as u32);
        let indices: Vec<Option<u32>> = list.iter().enumerate().map(index).collect();
        indices.into_iter().collect()
    }

    /// True if the scene has a texture of that name: a colour that is a mere name probably means it.
    pub fn is_texture(&self, name: &str) -> bool {
        self.scene.find(Role::Texture, name).is_some()
    }
}

/// A fault under construction: reported when dropped.
pub struct Fault<'a> {
    diagnostic: Option<Diagnostic>,
    out: &'a mut Diagnostics,
}

impl Fault<'_> {
    /// Says what to do; an empty text leaves the help as it is.
    pub fn help(mut self, help: impl Into<String>) {
        let help = help.into();
        if let Some(diagnostic) = self.diagnostic.as_mut().filter(|_| !help.is_empty()) {
            diagnostic.help = help;
        }
    }
}

impl Drop for Fault<'_> {
    fn drop(&mut self) {
        if let Some(diagnostic) = self.diagnostic.take() {
            self.out.push(diagnostic);
        }
    }
}

/// The value of a parameter that is absent or faulty.
fn default_value(spec: &ParamSpec) -> Decoded {
    let default = match spec.default {
        ParamDefault::Required => return harmless(&spec.kind),
        ParamDefault::Absent => return Decoded::Absent,
        given => given,
    };
    let float = || match default {
        ParamDefault::Float(v) => v,
        ParamDefault::Int(i) => i as f64,
        _ => 0.0,
    };
    let color = || match default {
        ParamDefault::Color(c) => c,
        ParamDefault::Vec3(v) => v.map(|x| x as f32),
        _ => [float() as f32; 3],
    };
    match (&spec.kind, default) {
        (Kind::Bool, ParamDefault::Bool(b)) => Decoded::Bool(b),
        (Kind::Int(_), ParamDefault::Int(i)) => Decoded::Int(i),
        (Kind::Float(_), _) => Decoded::Float(float()),
        (Kind::Vec2(_), ParamDefault::Vec2(v)) => Decoded::Pair(v),
        (Kind::Int2(_), ParamDefault::Vec2(v)) => Decoded::Ints(v.map(|x| x as i64)),
        (Kind::Vec3 | Kind::Direction, ParamDefault::Vec3(v)) => {
            Decoded::Vector(Vec3::from_array(v.map(|x| x as f32)))
        }
        (Kind::Color(_), _) => Decoded::Color(color()),
        (Kind::ColorTexture(_), _) => Decoded::ColorInput(ColorInput::Constant(color())),
        (Kind::FloatTexture(_), _) => Decoded::FloatInput(FloatInput::Constant(float() as f32)),
        (Kind::Choice(_) | Kind::Text | Kind::File, ParamDefault::Text(t)) => Decoded::Text(t.to_owned()),
        (kind, default) => panic!("`{}`: {default:?} is no default of {kind:?}", spec.name),
    }
}

/// A value that breaks nothing, for required parameters.
fn harmless(kind: &Kind) -> Decoded {
    let within = |r: &Range| if r.contains(1.0) { 1.0 } else { 0.5 * (r.min.max(-1e6) + r.max.min(1e6)) };
    match kind {
        Kind::Bool => Decoded::Bool(false),
        Kind::Int(r) => Decoded::Int(within(r) as i64),
        Kind::Float(r) => Decoded::Float(within(r)),
        Kind::Vec2(r) => Decoded::Pair([within(r); 2]),
        Kind::Int2(r) => Decoded::Ints([within(r) as i64; 2]),
        Kind::Vec3 => Decoded::Vector(Vec3::ZERO),
        Kind::Direction => Decoded::Vector(Vec3::Z),
        Kind::Sides => Decoded::Sides([Vec3::X, Vec3::Y]),
        Kind::Color(r) => Decoded::Color([within(r) as f32; 3]),
        Kind::ColorTexture(r) => Decoded::ColorInput(ColorInput::Constant([within(r) as f32; 3])),
        Kind::FloatTexture(r) => Decoded::FloatInput(FloatInput::Constant(within(r) as f32)),
        Kind::Choice(words) => Decoded::Text(words.first().map_or("", |w| w).to_owned()),
        Kind::Text | Kind::File | Kind::Reference(_) => Decoded::Absent,
        Kind::Transform | Kind::Transforms => Decoded::Absent,
        Kind::Vec3List | Kind::Vec2List | Kind::ColorList | Kind::Faces => Decoded::Absent,
    }
}
