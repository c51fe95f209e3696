//! From nodes to a TOML text.

use crate::description::{Node, Role, SceneDescription, Value, ValueKind};
use crate::native::{FORMAT_VERSION, Spelling, WIDTH, has_type};
use std::fmt::Write;

const TOML: Spelling = Spelling { float, text, key, between: " = ", braces: ["{ ", " }"] };

/// Writes a scene as TOML, the nodes in their order.
/// Numbers are written with as many digits as bring the same value back; the same scene gives the same text.
pub fn write_toml(scene: &SceneDescription) -> String {
    let mut text = format!("penombre = {FORMAT_VERSION}\n");
    for (_, node) in scene.iter() {
        text.push('\n');
        write_node(node, &mut text);
    }
    text
}

fn write_node(node: &Node, out: &mut String) {
    match node.role {
        Role::Render => out.push_str("[render]\n"),
        role => push(out, format_args!("[{}.{}]\n", role.name(), key(&node.name))),
    }
    if has_type(node.role) {
        push(out, format_args!("type = {}\n", text(&node.type_name)));
    }
    for param in &node.params {
        let name = key(&param.name);
        let line = TOML.inline(&param.value);
        if name.len() + 3 + line.len() <= WIDTH {
            push(out, format_args!("{name} = {line}\n"));
        } else {
            push(out, format_args!("{name} = {}\n", broken(&param.value, line)));
        }
    }
}

fn push(out: &mut String, arguments: std::fmt::Arguments<'_>) {
    out.write_fmt(arguments).expect("a String takes all text");
}

/// A long list with one entry a line; other values as they are (inline tables cannot be broken).
fn broken(value: &Value, line: String) -> String {
    match &value.kind {
        ValueKind::Array(list) => {
            let mut text = "[\n".to_owned();
            for entry in list {
                push(&mut text, format_args!("    {},\n", TOML.inline(entry)));
            }
            text + "]"
        }
        _ => line,
    }
}

fn float(v: f64) -> String {
    if v.is_nan() {
        return "nan".to_owned();
    }
    // Rust's shortest form that reads back: "1.0", "1e-7", "inf" are TOML as well.
    format!("{v:?}")
}

fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_');
    if bare { name.to_owned() } else { text(name) }
}

/// A basic string.
fn text(s: &str) -> String {
    let mut quoted = "\"".to_owned();
    for c in s.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            c if c.is_control() => push(&mut quoted, format_args!("\\u{:04X}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}
