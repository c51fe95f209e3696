//! `--set PATH=VALUE`: changes of single parameters from the command line.
//!
//! PATH is `role.name.parameter`, where the name may be left out if the role has one node only; further parts
//! lead into tables and lists (`material.floor.color.texture`, `render.size.0`). VALUE is a TOML value, or a bare
//! word, which is a text.

use crate::description::{Node, NodeId, Param, Role, SceneDescription, Value, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::native::has_type;
use crate::span::{FileId, Span};
use crate::suggest::help_for;
use crate::toml::{read_key_path, read_value};

/// How messages call the text of an argument.
pub const SOURCE_NAME: &str = "--set argument";

/// Applies one argument to the scene, or reports faults that point into it and changes nothing. `file` names the
/// text of the argument.
pub fn apply(argument: &str, file: FileId, scene: &mut SceneDescription, out: &mut Diagnostics) {
    let Some(set) = parse(argument, file, out) else { return };
    let mut setter = Setter { scene, out, path: &set.path };
    if let Some(target) = setter.target() {
        setter.assign(target, set.value);
    }
}

struct Set {
    path: Vec<Part>,
    value: Value,
}

/// One word of the path.
struct Part {
    word: String,
    span: Span,
}

/// What a path means: a node, and where in it.
struct Target {
    node: NodeId,
    /// Index of the part that is the parameter.
    param: usize,
}

fn span_of(file: FileId, start: usize, len: usize) -> Span {
    let clamp = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Span { file, start: clamp(start), len: clamp(len) }
}

fn parse(argument: &str, file: FileId, out: &mut Diagnostics) -> Option<Set> {
    const HELP: &str = "write PATH=VALUE, for example camera.fov=40 or material.red.diffuse=[1,0,0]";
    let all = span_of(file, 0, argument.len());
    let Some(equals) = equals_sign(argument) else {
        out.error("set::syntax", all, "the argument has no `=`, expected PATH=VALUE").help = HELP.to_owned();
        return None;
    };
    let (path, rest) = (&argument[..equals], &argument[equals + 1..]);
    let Some(parts) = read_key_path(path, file) else {
        let at = span_of(file, 0, equals);
        out.error("set::syntax", at, format!("{path:?} is no path, expected words with points between"))
            .help = HELP.to_owned();
        return None;
    };
    let start = equals + 1 + (rest.len() - rest.trim_start().len());
    let text = rest.trim();
    let at = span_of(file, start, text.len());
    let value = read_value(text, file, start)
        .or_else(|| is_word(text).then(|| Value { kind: ValueKind::String(text.to_owned()), span: at }));
    let Some(value) = value else {
        let found = if text.is_empty() { "nothing".to_owned() } else { format!("{text:?}") };
        let message =
            format!("the value is {found}, expected a number, a word, a list [..], a table or a \"text\"");
        out.error("set::syntax", at, message).help = HELP.to_owned();
        return None;
    };
    Some(Set { path: parts.into_iter().map(|(word, span)| Part { word, span }).collect(), value })
}

/// The first `=` outside quotes.
fn equals_sign(text: &str) -> Option<usize> {
    let mut quote = None;
    let mut escaped = false;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '=') => return Some(i),
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), _) if q == c && !escaped => quote = None,
            _ => {}
        }
        // As in TOML: only double quotes know escapes.
        escaped = quote == Some('"') && c == '\\' && !escaped;
    }
    None
}

/// Words that need no quotes: names, file names, colour codes.
fn is_word(text: &str) -> bool {
    let first = text.chars().next().is_some_and(|c| c.is_alphanumeric() || "#._/".contains(c));
    first && text.chars().all(|c| c.is_alphanumeric() || "#._-/+ ".contains(c))
}

struct Setter<'a> {
    scene: &'a mut SceneDescription,
    out: &'a mut Diagnostics,
    path: &'a [Part],
}

impl Setter<'_> {
    fn fault(&mut self, part: usize, message: String, help: String) {
        self.out.error("set::target", self.path[part].span, message).help = help;
    }

    /// The node and parameter that the path names; a missing `render` or `integrator.NAME` is created.
    fn target(&mut self) -> Option<Target> {
        let word = &self.path[0].word;
        let Some(role) = Role::from_name(word) else {
            let names = Role::ALL.map(Role::name);
            let help = help_for(word, "a path begins with", &names);
            self.fault(0, format!("unknown word `{word}`"), help);
            return None;
        };
        let target = match role {
            Role::Render if self.path.len() < 2 => {
                self.fault(
                    0,
                    "`render` needs a parameter".to_owned(),
                    "write render.PARAMETER=VALUE".to_owned(),
                );
                return None;
            }
            Role::Render => Target { node: self.find_or_add(role, ""), param: 1 },
            _ => self.named(role)?,
        };
        if target.param < self.path.len() {
            return Some(target);
        }
        let path = self.scene.node(target.node).path();
        self.fault(
            target.param - 1,
            format!("`{path}` needs a parameter"),
            format!("write {path}.PARAMETER=VALUE"),
        );
        None
    }

    fn find_or_add(&mut self, role: Role, name: &str) -> NodeId {
        if let Some(id) = self.scene.find(role, name) {
            return id;
        }
        let type_name = if name.is_empty() { role.name() } else { name };
        let mut node = Node::new(role, type_name, name);
        let span = self.path[usize::from(!name.is_empty())].span;
        (node.span, node.type_span) = (span, span);
        self.scene.add(node)
    }

    /// A node of a role that has names, by its name or as the only one.
    fn named(&mut self, role: Role) -> Option<Target> {
        let nodes: Vec<(NodeId, String)> =
            self.scene.of_role(role).map(|(id, n)| (id, n.name.clone())).collect();
        let word = self.path.get(1).map_or("", |part| &part.word);
        if let Some((id, _)) = nodes.iter().find(|(_, name)| name == word) {
            return Some(Target { node: *id, param: 2 });
        }
        if role == Role::Integrator && self.path.len() > 2 {
            return Some(Target { node: self.find_or_add(role, word), param: 2 });
        }
        match &nodes[..] {
            [(id, _)] if self.path.len() == 2 || self.scene.node(*id).param(word).is_some() => {
                Some(Target { node: *id, param: 1 })
            }
            _ => {
                self.no_node(role, &nodes.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>());
                None
            }
        }
    }

    /// Tells why the path names none of the nodes of a role.
    fn no_node(&mut self, role: Role, names: &[&str]) {
        let role_word = role.name();
        let all = format!("{role_word}s in this scene");
        match self.path {
            [_] if names.len() == 1 => {
                let help = format!("write {role_word}.PARAMETER=VALUE");
                self.fault(0, format!("`{role_word}` needs a parameter"), help);
            }
            _ if names.is_empty() && role == Role::Integrator => {
                let help = "write integrator.NAME.PARAMETER=VALUE, for example integrator.classic.phase=2";
                self.fault(0, "the path does not say which integrator".to_owned(), help.to_owned());
            }
            _ if names.is_empty() => {
                let help = format!("add [{role_word}.NAME] to the scene file first");
                self.fault(0, format!("the scene has no {role_word}"), help);
            }
            [_, name, _, ..] => {
                let help = help_for(&name.word, &all, names);
                self.fault(1, format!("there is no {role_word} `{}`", name.word), help);
            }
            _ => {
                let message =
                    format!("the scene has {} {role_word}s and the path does not say which", names.len());
                let help = format!("write {role_word}.NAME.PARAMETER=VALUE; {}", help_for("", &all, names));
                self.fault(0, message, help);
            }
        }
    }

    fn assign(&mut self, target: Target, value: Value) {
        let part = &self.path[target.param];
        let node = self.scene.node(target.node);
        if part.word == "type" && has_type(node.role) {
            self.assign_type(target, value);
            return;
        }
        if target.param + 1 == self.path.len() {
            put(self.scene.params_mut(target.node), part, value);
            return;
        }
        let absent = Value { kind: ValueKind::Table(Vec::new()), span: value.span };
        let mut whole = node.param(&part.word).map_or(absent, |p| p.value.clone());
        match descend(&mut whole, &self.path[target.param + 1..], value) {
            Ok(()) => put(self.scene.params_mut(target.node), part, whole),
            Err(lost) => {
                let at = target.param + 1 + lost.part;
                let path: Vec<&str> = self.path[..at].iter().map(|p| p.word.as_str()).collect();
                let message = format!(
                    "`{}` is {} and has no part `{}`",
                    path.join("."),
                    lost.found,
                    self.path[at].word
                );
                self.fault(at, message, "lists have parts 0, 1, 2, …; tables have parts by name".to_owned());
            }
        }
    }

    fn assign_type(&mut self, target: Target, value: Value) {
        let node = self.scene.node_mut(target.node);
        match value.kind {
            ValueKind::String(name) if target.param + 1 == self.path.len() && !name.is_empty() => {
                (node.type_name, node.type_span) = (name, value.span);
            }
            _ => {
                let message = format!("`type` of `{}` must be the name of a type", node.path());
                let help = format!("write {}.type=NAME, for example shape.ball.type=sphere", node.path());
                self.out.error("set::type", value.span, message).help = help;
            }
        }
    }
}

/// A part of a path that leads nowhere.
struct Lost {
    part: usize,
    /// What is there instead.
    found: String,
}

/// Sets the part of a value that the rest of the path names.
fn descend(at: &mut Value, path: &[Part], value: Value) -> Result<(), Lost> {
    let (part, rest) = path.split_first().expect("a path has at least one part here");
    let inner = match &mut at.kind {
        ValueKind::Table(entries) => {
            if rest.is_empty() {
                put(entries, part, value);
                return Ok(());
            }
            entries.iter_mut().find(|p| p.name == part.word).map(|p| &mut p.value)
        }
        ValueKind::Array(list) => part.word.parse().ok().and_then(|i: usize| list.get_mut(i)),
        _ => None,
    };
    let Some(inner) = inner else {
        return Err(Lost { part: 0, found: crate::params::found(at) });
    };
    if rest.is_empty() {
        *inner = value;
        return Ok(());
    }
    descend(inner, rest, value).map_err(|lost| Lost { part: lost.part + 1, ..lost })
}

/// Sets an entry, replacing one of that name.
fn put(params: &mut Vec<Param>, part: &Part, value: Value) {
    let param = Param { name: part.word.clone(), name_span: part.span, value };
    match params.iter_mut().find(|p| p.name == param.name) {
        Some(old) => *old = param,
        None => params.push(param),
    }
}

#[cfg(test)]
mod tests;
