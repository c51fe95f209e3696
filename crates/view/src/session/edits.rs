//! Changes of a scene that are options of the command at the same time.

use penombre_math::{DVec3, Vec3};
use penombre_scene::{Diagnostics, Node, SceneDescription, Sources, Value, ValueKind, set};
use std::path::Path;

/// One change.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// `--size`.
    Size([u32; 2]),
    /// `--spp`.
    Spp(u32),
    /// `--integrator`.
    Integrator(String),
    /// `--phase`.
    Phase(u8),
    /// `--hard-shadows`, or `--set` where the scene has them and they are not wanted.
    HardShadows(bool),
    /// `--set PATH=VALUE`.
    Set(String),
}

impl Edit {
    /// Sets a parameter of a node that has a name.
    pub fn set(node: &Node, param: &str, value: Value) -> Self {
        Self::Set(format!("{}.{}.{param}={}", node.role.name(), key(&node.name), written(&value)))
    }

    /// What loading must know, as an argument of `--set`.
    pub fn early(&self) -> Option<String> {
        match self {
            Self::Size([w, h]) => Some(format!("render.size=[{w}, {h}]")),
            _ => None,
        }
    }

    /// The words of the command line.
    pub fn options(&self) -> Vec<String> {
        let with = |name: &str, value: String| vec![name.to_owned(), value];
        match self {
            Self::Size([w, h]) => with("--size", format!("{w}x{h}")),
            Self::Spp(n) => with("--spp", n.to_string()),
            Self::Integrator(name) => with("--integrator", name.clone()),
            Self::Phase(n) => with("--phase", n.to_string()),
            Self::HardShadows(true) => vec!["--hard-shadows".to_owned()],
            Self::HardShadows(false) => with("--set", self.argument()),
            Self::Set(argument) => with("--set", argument.clone()),
        }
    }

    /// The change as an argument of `--set`.
    fn argument(&self) -> String {
        match self {
            Self::Size([w, h]) => format!("render.size=[{w}, {h}]"),
            Self::Spp(n) => format!("render.spp={n}"),
            Self::Integrator(name) => format!("render.integrator={}", text(name)),
            Self::Phase(n) => format!("integrator.classic.phase={n}"),
            Self::HardShadows(on) => format!("integrator.classic.hard_shadows={on}"),
            Self::Set(argument) => argument.clone(),
        }
    }

    /// Changes the description, by the code that reads `--set`. Faults point into `sources`.
    pub fn apply(&self, description: &mut SceneDescription, sources: &mut Sources, out: &mut Diagnostics) {
        let argument = self.argument();
        let file = sources.add(Path::new(""), set::SOURCE_NAME, argument.as_str());
        set::apply(&argument, file, description, out);
    }
}

/// Numbers as short as they can be written such that rounding to `f32`, as cameras do, gives `v` again: 6.1 and not
/// 6.099999904632568.
pub fn wide(v: Vec3) -> DVec3 {
    let number = |c: f32| c.to_string().parse::<f64>().unwrap_or(f64::from(c));
    DVec3::from_array(v.to_array().map(number))
}

/// The same as a value.
pub fn short(v: Vec3) -> Value {
    wide(v).to_array().into()
}

/// A value as TOML; numbers read back as the same bits.
fn written(value: &Value) -> String {
    match &value.kind {
        ValueKind::Bool(v) => v.to_string(),
        ValueKind::Int(v) => v.to_string(),
        ValueKind::Float(v) => format!("{v:?}"),
        ValueKind::String(v) => text(v),
        ValueKind::Array(list) => {
            format!("[{}]", list.iter().map(written).collect::<Vec<_>>().join(","))
        }
        ValueKind::Table(entries) => {
            let entry = |p: &penombre_scene::Param| format!("{}={}", key(&p.name), written(&p.value));
            format!("{{{}}}", entries.iter().map(entry).collect::<Vec<_>>().join(","))
        }
    }
}

/// A key of TOML: bare if it may be, else quoted.
fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) { name.to_owned() } else { text(name) }
}

/// A basic string of TOML.
fn text(v: &str) -> String {
    let mut result = String::from("\"");
    for c in v.chars() {
        match c {
            '\\' => result.push_str("\\\\"),
            // Written as a number, a quote is not taken for the end by those who look for `=` outside quotes.
            c if c == '"' || c.is_control() => result.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => result.push(c),
        }
    }
    result.push('"');
    result
}

/// The node as lines of a scene file.
pub fn toml(node: &Node) -> String {
    let mut lines = format!("[{}.{}]\ntype = {}\n", node.role.name(), key(&node.name), text(&node.type_name));
    for param in &node.params {
        lines += &format!("{} = {}\n", key(&param.name), written(&param.value));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_scene::Role;

    /// Writes a value with `--set` and reads it back.
    fn round_trip(name: &str, value: Value) -> Option<Value> {
        let mut d = SceneDescription::default();
        let id = d.add(Node::new(Role::Camera, "perspective", name));
        d.add(Node::new(Role::Camera, "perspective", "another"));
        let mut out = Diagnostics::default();
        Edit::set(d.node(id), "value", value).apply(&mut d, &mut Sources::default(), &mut out);
        assert!(out.is_empty(), "{out:?}");
        d.node(id).param("value").map(|p| p.value.clone())
    }

    #[test]
    fn numbers_come_back_as_the_same_bits() {
        let mut random = 1u64;
        let extremes = [0.0, -0.0, 1e21, -1e300, 5e-324, f64::MAX, 0.1, 6.1, 1.0 / 3.0, 1e16];
        let hashed = std::iter::repeat_with(|| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from_bits(random)
        });
        for v in extremes.into_iter().chain(hashed.filter(|v| v.is_finite()).take(2000)) {
            let Some(ValueKind::Float(found)) = round_trip("main", v.into()).map(|v| v.kind) else {
                panic!("{v:?} did not come back as a number");
            };
            assert_eq!(found.to_bits(), v.to_bits());
        }
    }

    #[test]
    fn short_numbers_round_to_the_same_single_precision() {
        let mut bits = 1u32;
        for _ in 0..5000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let v = f32::from_bits(bits);
            if !v.is_finite() {
                continue;
            }
            let ValueKind::Array(list) = short(Vec3::splat(v)).kind else { panic!() };
            let ValueKind::Float(wide) = list[0].kind else { panic!() };
            assert_eq!((wide as f32).to_bits(), v.to_bits());
        }
        assert_eq!(written(&short(Vec3::new(6.1, -0.25, 3.0))), "[6.1,-0.25,3.0]");
    }

    #[test]
    fn any_name_and_text_comes_back() {
        for name in ["main", "my cam", "a.b", "é", "q\"q", "back\\slash", "x=y", "tab\there"] {
            let value: Value = name.into();
            assert_eq!(round_trip(name, value.clone()), Some(value), "{name}");
        }
        assert_eq!(round_trip("m", vec![1, 2].into()), Some(vec![1, 2].into()));
    }
}
