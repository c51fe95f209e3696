//! From nodes to a JSON text.

use crate::description::{Node, Role, SceneDescription, Value, ValueKind};
use crate::native::{FORMAT_VERSION, Spelling, WIDTH, has_type};

const JSON: Spelling = Spelling { float, text, key: text, between: ": ", braces: ["{", "}"] };

/// Writes a scene as JSON: roles in a fixed order, the nodes of each in theirs.
/// Numbers are written with as many digits as bring the same value back; the same scene gives the same text.
pub fn write_json(scene: &SceneDescription) -> String {
    let mut entries = vec![("penombre".to_owned(), FORMAT_VERSION.to_string())];
    for role in Role::ALL {
        let nodes: Vec<&Node> = scene.iter().map(|(_, node)| node).filter(|node| node.role == role).collect();
        let texts = nodes.iter().map(|node| (node.name.clone(), of_node(node)));
        match (role, nodes.first()) {
            (_, None) => {}
            (Role::Render, Some(node)) => entries.push((role.name().to_owned(), of_node(node))),
            _ => entries.push((role.name().to_owned(), object(texts, 1))),
        }
    }
    object(entries.into_iter(), 0) + "\n"
}

fn of_node(node: &Node) -> String {
    let depth = if node.role == Role::Render { 1 } else { 2 };
    let own = has_type(node.role).then(|| ("type".to_owned(), text(&node.type_name)));
    let params = node.params.iter().map(|p| (p.name.clone(), value(&p.value, depth + 1)));
    object(own.into_iter().chain(params), depth)
}

/// An object with one entry a line.
fn object(entries: impl Iterator<Item = (String, String)>, depth: usize) -> String {
    let lines: Vec<String> =
        entries.map(|(key, value)| format!("{}{}: {value}", indent(depth + 1), text(&key))).collect();
    if lines.is_empty() { "{}".to_owned() } else { format!("{{\n{}\n{}}}", lines.join(",\n"), indent(depth)) }
}

fn indent(depth: usize) -> String {
    "  ".repeat(depth)
}

/// A value on one line, or a list with one entry a line if that is too long.
fn value(of: &Value, depth: usize) -> String {
    let line = JSON.inline(of);
    match &of.kind {
        ValueKind::Array(list) if line.len() > WIDTH => {
            let lines: Vec<String> = list.iter().map(|v| indent(depth + 1) + &JSON.inline(v)).collect();
            format!("[\n{}\n{}]", lines.join(",\n"), indent(depth))
        }
        _ => line,
    }
}

fn float(v: f64) -> String {
    match v {
        // Refused when it is read, in its place: no other number would say what is wrong.
        v if v.is_nan() => "NaN".to_owned(),
        f64::INFINITY => "Infinity".to_owned(),
        f64::NEG_INFINITY => "-Infinity".to_owned(),
        v => format!("{v:?}"),
    }
}

fn text(s: &str) -> String {
    serde_json::Value::from(s).to_string()
}
