//! From a TOML text to nodes.

use super::syntax::report_syntax;
use super::values::{params, span, value};
use super::{FORMAT_VERSION, Include, TomlScene, has_type};
use crate::description::{Node, Param, Role, SceneDescription, Value, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::span::{FileId, Span};
use crate::suggest::help_for;
use ::toml::Spanned;
use ::toml::de::{DeString, DeTable, DeValue};

/// Reads a scene file and reports all its faults to `out`. Spans count in `text`, under the name `file`. The
/// types of nodes and their parameters are not checked here.
pub fn read_toml(text: &str, file: FileId, out: &mut Diagnostics) -> TomlScene {
    let (root, errors) = DeTable::parse_recoverable(text);
    if report_syntax(file, text, &errors, out) {
        return TomlScene::default();
    }
    let mut reader = Reader { text, file, out, nodes: Vec::new(), includes: Vec::new() };
    reader.version(root.get_ref());
    for (key, entry) in root.get_ref() {
        match key.get_ref().as_ref() {
            "penombre" => {}
            "include" => reader.include(entry),
            word => match Role::from_name(word) {
                Some(role) => reader.role(role, key, entry),
                None => reader.unknown_role(key, entry.get_ref().is_table()),
            },
        }
    }
    let mut nodes = reader.nodes;
    // The parser sorts by name; scenes keep the order of the file.
    nodes.sort_by_key(|n| n.span.start);
    let mut description = SceneDescription::default();
    for node in nodes {
        description.add(node);
    }
    TomlScene { description, includes: reader.includes, readable: true }
}

struct Reader<'a> {
    text: &'a str,
    file: FileId,
    out: &'a mut Diagnostics,
    nodes: Vec<Node>,
    includes: Vec<Include>,
}

impl Reader<'_> {
    fn span(&self, range: std::ops::Range<usize>) -> Span {
        span(self.file, range)
    }

    fn version(&mut self, root: &DeTable<'_>) {
        let Some(entry) = root.get("penombre") else {
            let message = "the file does not say which version of the scene format it has";
            let at = self.span(0..0);
            self.out.error("toml::missing-version", at, message).help =
                format!("begin the file with the line `penombre = {FORMAT_VERSION}`");
            return;
        };
        let found = value(self.file, entry);
        if found.kind != ValueKind::Int(FORMAT_VERSION) {
            let shown = crate::params::found(&found);
            let message = format!("`penombre` is {shown}, expected the format version {FORMAT_VERSION}");
            let newer = matches!(found.kind, ValueKind::Int(v) if v > FORMAT_VERSION);
            self.out.error("toml::version", found.span, message).help = if newer {
                "the file was written for a newer penombre".to_owned()
            } else {
                format!("write `penombre = {FORMAT_VERSION}`")
            };
        }
    }

    fn include(&mut self, entry: &Spanned<DeValue<'_>>) {
        let list = value(self.file, entry);
        let ValueKind::Array(names) = list.kind else {
            self.bad_include(&list);
            return;
        };
        for name in names {
            match name.kind {
                ValueKind::String(text) if !text.is_empty() => {
                    self.includes.push(Include { name: text, span: name.span });
                }
                _ => self.bad_include(&name),
            }
        }
    }

    fn bad_include(&mut self, found: &Value) {
        let shown = crate::params::found(found);
        let message = format!("`include` has {shown}, expected a list of file names");
        self.out.error("toml::include", found.span, message).help =
            "write include = [\"materials.toml\"]".to_owned();
    }

    fn unknown_role(&mut self, key: &Spanned<DeString<'_>>, is_table: bool) {
        let word = key.get_ref();
        let mut names: Vec<&str> = Role::ALL.iter().map(|r| r.name()).collect();
        names.extend(["penombre", "include"]);
        let at = self.span(key.span());
        let shown: String = word.chars().take(40).collect();
        let what = if is_table { "table" } else { "key" };
        self.out.error("toml::unknown-role", at, format!("unknown {what} `{shown}`")).help =
            help_for(word, "a scene has", &names);
    }

    fn role(&mut self, role: Role, key: &Spanned<DeString<'_>>, entry: &Spanned<DeValue<'_>>) {
        let word = role.name();
        let header = self.header(key, entry);
        let DeValue::Table(table) = entry.get_ref() else {
            let found = value(self.file, entry);
            let message = format!("`{word}` is {}, expected a table", crate::params::found(&found));
            let header = if role == Role::Render { "[render]".to_owned() } else { format!("[{word}.NAME]") };
            self.out.error("toml::not-a-table", found.span, message).help = format!("write {header}");
            return;
        };
        if role == Role::Render {
            let mut node = Node::new(role, word, "");
            (node.span, node.type_span) = (header, header);
            node.params = params(self.file, table);
            self.nodes.push(node);
            return;
        }
        let stray = table.iter().find(|(_, v)| !v.get_ref().is_table());
        if let Some((key, _)) = stray {
            let message = format!("`{word}` has the key `{}` but no name", key.get_ref());
            self.out.error("toml::missing-name", header, message).help =
                format!("name it, for example [{word}.main]: a scene can have several");
        }
        for (name, entry) in table {
            if let DeValue::Table(table) = entry.get_ref() {
                if stray.is_some() && !self.is_surely_a_node(role, entry.span().start, table) {
                    continue;
                }
                let header = self.header(name, entry);
                self.node(role, name, header, table);
            }
        }
    }

    /// Beside keys that belong to a node without a name a table may be a value of that node too: surely a node is
    /// what has a header or a type of its own.
    fn is_surely_a_node(&self, role: Role, start: usize, table: &DeTable<'_>) -> bool {
        let is_header = self.text.as_bytes().get(start) == Some(&b'[');
        is_header || !has_type(role) || table.contains_key("type")
    }

    /// Place of the header of a table, or of its key where it has none.
    fn header(&self, key: &Spanned<DeString<'_>>, entry: &Spanned<DeValue<'_>>) -> Span {
        let range = entry.span();
        let is_header = self.text.as_bytes().get(range.start) == Some(&b'[') && entry.get_ref().is_table();
        self.span(if is_header { range } else { key.span() })
    }

    fn node(&mut self, role: Role, name: &Spanned<DeString<'_>>, header: Span, table: &DeTable<'_>) {
        let mut node = Node::new(role, "", name.get_ref().to_string());
        (node.span, node.type_span) = (header, header);
        if node.name.is_empty() {
            let message = format!("a {} has an empty name", role.name());
            self.out.error("toml::missing-name", header, message).help =
                format!("name it, for example [{}.main]", role.name());
            return;
        }
        node.params = params(self.file, table);
        match role {
            Role::Integrator => node.type_name = node.name.clone(),
            Role::Instance => node.type_name = role.name().to_owned(),
            _ => self.take_type(&mut node),
        }
        debug_assert!(has_type(role) || !node.type_name.is_empty());
        self.nodes.push(node);
    }

    /// Moves `type` from the parameters to its own place. Without one the node keeps an empty type name: it stays
    /// so that references to it are found, and the fault is told here once.
    fn take_type(&mut self, node: &mut Node) {
        let Some(at) = node.params.iter().position(|p| p.name == "type") else {
            let message = format!("`{}` has no `type`", node.path());
            self.out.error("toml::missing-type", node.span, message).help =
                format!("add {}", type_line(node.role));
            return;
        };
        let Param { value, .. } = node.params.remove(at);
        node.type_span = value.span;
        match value.kind {
            ValueKind::String(name) if !name.is_empty() => node.type_name = name,
            _ => {
                let found = crate::params::found(&value);
                let message =
                    format!("`type` of `{}` is {found}, expected the name of a type in quotes", node.path());
                self.out.error("toml::missing-type", value.span, message).help =
                    format!("write {}", type_line(node.role));
            }
        }
    }
}

/// The line that gives a node of a role its type, with an example.
fn type_line(role: Role) -> String {
    let example = match role {
        Role::Camera => "perspective",
        Role::Texture => "image",
        Role::Material => "phong",
        Role::Shape => "sphere",
        Role::Light => "point",
        Role::Render | Role::Integrator | Role::Instance => role.name(),
    };
    format!("a line with the type of the {}, for example type = {example:?}", role.name())
}
