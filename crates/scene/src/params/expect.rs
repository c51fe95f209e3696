//! What messages say about values: what was found, what was expected.

use crate::description::{Value, ValueKind};
use crate::schema::{Kind, ParamDefault, ParamSpec, Range};

/// A number as people write it: short, and with a point only where it has a fraction.
pub fn number(v: f64) -> String {
    if v.is_finite() && v != 0.0 && !(1e-4..1e16).contains(&v.abs()) {
        format!("{v:e}")
    } else {
        format!("{v}")
    }
}

/// Which value was found, in a few words.
pub fn found(value: &Value) -> String {
    match &value.kind {
        ValueKind::Bool(b) => format!("the boolean {b}"),
        ValueKind::Int(i) => i.to_string(),
        // As the reader has numbers that overflow.
        ValueKind::Float(f64::MAX) => "above 1.79e308".to_owned(),
        ValueKind::Float(f64::MIN) => "below -1.79e308".to_owned(),
        ValueKind::Float(v) if v.is_finite() => {
            let text = number(*v);
            if text.contains(['.', 'e']) { text } else { text + ".0" }
        }
        ValueKind::Float(v) => v.to_string().to_lowercase(),
        ValueKind::String(s) => format!("the text {}", quoted(s)),
        ValueKind::Array(list) => match list.len() {
            0 => "an empty list".to_owned(),
            1 => "a list with one entry".to_owned(),
            n => format!("a list with {n} entries"),
        },
        ValueKind::Table(_) => "a table".to_owned(),
    }
}

/// A text in quotes, cut after 40 characters, control characters escaped.
pub fn quoted(text: &str) -> String {
    const MOST: usize = 40;
    let mut short: String = text.chars().take(MOST).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("{:?}", short)
}

/// The numbers of a range after the word for the kind of number: " from 0 to 1", " greater than 0 m", "".
pub fn range(range: &Range, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let lower = range.min > f64::MIN;
    let upper = range.max < f64::MAX;
    let low = number(range.min);
    let high = number(range.max);
    match (lower, upper) {
        (false, false) => String::new(),
        (true, false) if range.min_open => format!(" greater than {low}{unit}"),
        (true, false) => format!(" of at least {low}{unit}"),
        (false, true) if range.max_open => format!(" less than {high}{unit}"),
        (false, true) => format!(" of at most {high}{unit}"),
        (true, true) => match (range.min_open, range.max_open) {
            (false, false) => format!(" from {low} to {high}{unit}"),
            (true, true) => format!(" between {low} and {high}{unit}, both excluded"),
            (true, false) => format!(" greater than {low} and at most {high}{unit}"),
            (false, true) => format!(" of at least {low} and less than {high}{unit}"),
        },
    }
}

/// What a number of that range is called: "a number greater than 0 m".
pub fn expected_number(limits: &Range, whole: bool, unit: &str) -> String {
    let noun = if whole { "a whole number" } else { "a number" };
    format!("{noun}{}", range(limits, unit))
}

/// What a parameter of that kind must be, in a few words.
pub fn expected(kind: &Kind, unit: &str) -> String {
    let text = match kind {
        Kind::Bool => "true or false",
        Kind::Int(limits) => return expected_number(limits, true, unit),
        Kind::Float(limits) => return expected_number(limits, false, unit),
        Kind::Vec2(_) => "two numbers, [x, y]",
        Kind::Int2(_) => "two whole numbers, [x, y]",
        Kind::Vec3 => "three numbers, [x, y, z]",
        Kind::Direction => "a direction, [x, y, z]",
        Kind::Sides => "two vectors, [[x, y, z], [x, y, z]]",
        Kind::Color(_) => "a colour",
        Kind::ColorTexture(_) => "a colour or { texture = \"NAME\" }",
        Kind::FloatTexture(limits) => {
            return format!("{} or {{ texture = \"NAME\" }}", expected_number(limits, false, unit));
        }
        Kind::Choice(words) => {
            return words.iter().map(|w| format!("{w:?}")).collect::<Vec<_>>().join(" or ");
        }
        Kind::Text => "a text in quotes",
        Kind::File => "the name of a file in quotes",
        Kind::Reference(role) => return format!("the name of a {} in quotes", role.name()),
        Kind::Transform => "a list of steps",
        Kind::Transforms => "a list of transforms, each a list of steps",
        Kind::Vec3List => "a list of points, [[x, y, z], …]",
        Kind::Vec2List => "a list of pairs, [[u, v], …]",
        Kind::ColorList => "a list of colours",
        Kind::Faces => "a list of faces, [[0, 1, 2], …]",
    };
    text.to_owned()
}

/// How to write a value of that kind; empty where [`expected`] says it all.
pub fn how_to_write(kind: &Kind) -> String {
    let text = match kind {
        Kind::Color(_) | Kind::ColorTexture(_) | Kind::ColorList => COLOR_HELP,
        Kind::Transform => TRANSFORM_HELP,
        Kind::Transforms => "write [[{ translate = [1, 0, 0] }], [{ scale = 2 }, { translate = [2, 0, 0] }]]",
        Kind::Reference(role) => {
            return format!("define it as [{}.NAME] and give its name here", role.name());
        }
        _ => "",
    };
    text.to_owned()
}

/// What a parameter means, with its unit and default: "`fov` (degrees, default 45): field of view from …". For
/// transforms how to write them.
pub fn documentation(spec: &ParamSpec) -> String {
    if matches!(spec.kind, Kind::Transform | Kind::Transforms) {
        return how_to_write(&spec.kind);
    }
    let default = default_text(&spec.default).map(|text| format!("default {text}"));
    let unit = Some(spec.unit.to_owned()).filter(|unit| !unit.is_empty());
    let notes = [unit, default].into_iter().flatten().collect::<Vec<_>>().join(", ");
    let notes = if notes.is_empty() { notes } else { format!(" ({notes})") };
    format!("`{}`{notes}: {}", spec.name, uncapitalized(spec.doc.trim_end_matches('.')))
}

/// A sentence as the part of another: "The eye" becomes "the eye", "OFF meshes" stays.
fn uncapitalized(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(first), second) if !second.is_some_and(char::is_uppercase) => {
            first.to_lowercase().chain(text.chars().skip(1)).collect()
        }
        _ => text.to_owned(),
    }
}

/// A default as scene files write it; `None` if there is none.
fn default_text(default: &ParamDefault) -> Option<String> {
    let list = |numbers: &[f64]| numbers.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ");
    Some(match default {
        ParamDefault::Required | ParamDefault::Absent => return None,
        ParamDefault::Bool(b) => b.to_string(),
        ParamDefault::Int(i) => i.to_string(),
        ParamDefault::Float(v) => number(*v),
        ParamDefault::Vec2(v) => format!("[{}]", list(v)),
        ParamDefault::Vec3(v) => format!("[{}]", list(v)),
        ParamDefault::Color([r, g, b]) => format!("[{r}, {g}, {b}]"),
        ParamDefault::Text(text) => format!("{text:?}"),
    })
}

/// The help for a number or truth value that stands in quotes.
pub fn without_quotes(value: &Value) -> Option<String> {
    let ValueKind::String(text) = &value.kind else { return None };
    let bare = text.parse::<f64>().is_ok() || text.parse::<bool>().is_ok();
    (bare && text.len() <= 40).then(|| format!("write {text} without quotes"))
}

/// How to write a colour.
pub const COLOR_HELP: &str =
    "write three linear numbers [r, g, b], one number for grey, or \"#rrggbb\" for an sRGB colour";
/// How to write a transform.
pub const TRANSFORM_HELP: &str =
    "write [{ scale = 2 }, { rotate = [0, 1, 0], angle = 30 }, { translate = [1, 0, 0] }]";
