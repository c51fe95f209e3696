//! What the native scene format means, whichever way it is written (TOML or JSON): from a tree of keys to nodes.

use crate::description::{Node, Param, Role, SceneDescription, Value, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::span::{FileId, Span};
use crate::suggest::help_for;

/// Version of the format that this reader knows, the value of the key `penombre`.
pub const FORMAT_VERSION: i64 = 1;

/// A scene file as it stands, before the files that it includes are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NativeScene {
    /// Its nodes in file order.
    pub description: SceneDescription,
    /// The files that it includes, in file order.
    pub includes: Vec<Include>,
    /// False if the text has faults of syntax: then the description is empty.
    pub readable: bool,
}

/// One entry of `include`.
#[derive(Clone, Debug, PartialEq)]
pub struct Include {
    /// The file's name as it stands.
    pub name: String,
    /// Its place.
    pub span: Span,
}

/// True for the roles whose nodes have a `type` key.
pub(crate) fn has_type(role: Role) -> bool {
    !matches!(role, Role::Render | Role::Integrator | Role::Instance)
}

/// Longest line that the writers make before they break a list into one entry a line.
pub(crate) const WIDTH: usize = 100;

/// How a writer spells what is not the same in all formats.
pub(crate) struct Spelling {
    pub float: fn(f64) -> String,
    pub text: fn(&str) -> String,
    pub key: fn(&str) -> String,
    /// What stands between a key and its value.
    pub between: &'static str,
    /// Around the entries of a table; empty tables are `{}`.
    pub braces: [&'static str; 2],
}

impl Spelling {
    /// A value on one line.
    pub fn inline(&self, value: &Value) -> String {
        match &value.kind {
            ValueKind::Bool(b) => b.to_string(),
            ValueKind::Int(i) => i.to_string(),
            ValueKind::Float(v) => (self.float)(*v),
            ValueKind::String(s) => (self.text)(s),
            ValueKind::Array(list) => {
                format!("[{}]", list.iter().map(|v| self.inline(v)).collect::<Vec<_>>().join(", "))
            }
            ValueKind::Table(entries) if entries.is_empty() => "{}".to_owned(),
            ValueKind::Table(entries) => {
                let entry = |p: &Param| (self.key)(&p.name) + self.between + &self.inline(&p.value);
                let [open, close] = self.braces;
                format!("{open}{}{close}", entries.iter().map(entry).collect::<Vec<_>>().join(", "))
            }
        }
    }
}

/// How hints are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Syntax {
    Toml,
    Json,
}

impl Syntax {
    /// A key with a value.
    fn entry(self, key: &str, value: &str) -> String {
        match self {
            Self::Toml => format!("{key} = {value}"),
            Self::Json => format!("\"{key}\": {value}"),
        }
    }

    /// A table of a scene.
    fn table(self, role: &str, name: &str) -> String {
        match (self, name) {
            (Self::Toml, "") => format!("[{role}]"),
            (Self::Toml, name) => format!("[{role}.{name}]"),
            (Self::Json, "") => format!("\"{role}\": {{ … }}"),
            (Self::Json, name) => format!("\"{role}\": {{ \"{name}\": {{ … }} }}"),
        }
    }
}

/// Makes nodes of the entries of a scene file and reports faults to `out`. `text` is that of the file.
pub(crate) fn read(
    root: Vec<Param>,
    text: &str,
    file: FileId,
    syntax: Syntax,
    out: &mut Diagnostics,
) -> NativeScene {
    let mut reader = Reader { text, file, syntax, out, nodes: Vec::new(), includes: Vec::new() };
    reader.version(&root);
    for entry in root {
        match entry.name.as_str() {
            "penombre" => {}
            // For editors.
            "$schema" if syntax == Syntax::Json => {}
            "include" => reader.include(entry.value),
            word => match Role::from_name(word) {
                Some(role) => reader.role(role, entry),
                None => reader.unknown_role(&entry),
            },
        }
    }
    let mut nodes = reader.nodes;
    // Dotted keys may lie apart; scenes keep the order of the file.
    nodes.sort_by_key(|n| n.span.start);
    let mut description = SceneDescription::default();
    for node in nodes {
        description.add(node);
    }
    NativeScene { description, includes: reader.includes, readable: true }
}

struct Reader<'a> {
    text: &'a str,
    file: FileId,
    syntax: Syntax,
    out: &'a mut Diagnostics,
    nodes: Vec<Node>,
    includes: Vec<Include>,
}

impl Reader<'_> {
    fn version(&mut self, root: &[Param]) {
        let line = self.syntax.entry("penombre", &FORMAT_VERSION.to_string());
        let Some(entry) = root.iter().find(|p| p.name == "penombre") else {
            let message = "the file does not say which version of the scene format it has";
            let at = Span { file: self.file, start: 0, len: 0 };
            self.out.error("scene::missing-version", at, message).help = match self.syntax {
                Syntax::Toml => format!("begin the file with the line `{line}`"),
                Syntax::Json => format!("begin the file with `{{ {line},`"),
            };
            return;
        };
        let found = &entry.value;
        if found.kind != ValueKind::Int(FORMAT_VERSION) {
            let shown = crate::params::found(found);
            let message = format!("`penombre` is {shown}, expected the format version {FORMAT_VERSION}");
            let newer = matches!(found.kind, ValueKind::Int(v) if v > FORMAT_VERSION);
            self.out.error("scene::version", found.span, message).help = if newer {
                "the file was written for a newer penombre".to_owned()
            } else {
                format!("write `{line}`")
            };
        }
    }

    fn include(&mut self, list: Value) {
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
        self.out.error("scene::include", found.span, message).help =
            format!("write {}", self.syntax.entry("include", "[\"materials.toml\"]"));
    }

    fn unknown_role(&mut self, entry: &Param) {
        let word = &entry.name;
        let mut names: Vec<&str> = Role::ALL.iter().map(|r| r.name()).collect();
        names.extend(["penombre", "include"]);
        let shown: String = word.chars().take(40).collect();
        let what = if matches!(entry.value.kind, ValueKind::Table(_)) { "table" } else { "key" };
        self.out.error("scene::unknown-role", entry.name_span, format!("unknown {what} `{shown}`")).help =
            help_for(word, "a scene has", &names);
    }

    fn role(&mut self, role: Role, entry: Param) {
        let word = role.name();
        let header = self.header(&entry);
        let ValueKind::Table(table) = entry.value.kind else {
            let message = format!("`{word}` is {}, expected a table", crate::params::found(&entry.value));
            let name = if role == Role::Render { "" } else { "NAME" };
            self.out.error("scene::not-a-table", entry.value.span, message).help =
                format!("write {}", self.syntax.table(word, name));
            return;
        };
        if role == Role::Render {
            let mut node = Node::new(role, word, "");
            (node.span, node.type_span) = (header, header);
            node.params = table;
            self.nodes.push(node);
            return;
        }
        let stray = table.iter().find(|p| !matches!(p.value.kind, ValueKind::Table(_)));
        let has_stray = stray.is_some();
        if let Some(stray) = stray {
            let message = format!("`{word}` has the key `{}` but no name", stray.name);
            self.out.error("scene::missing-name", header, message).help =
                format!("name it, for example {}: a scene can have several", self.syntax.table(word, "main"));
        }
        for inner in table {
            let header = self.header(&inner);
            let start = inner.value.span.start;
            if let ValueKind::Table(params) = inner.value.kind {
                if has_stray && !self.is_surely_a_node(role, start, &params) {
                    continue;
                }
                self.node(role, inner.name, header, params);
            }
        }
    }

    /// Beside keys that belong to a node without a name a table may be a value of that node too: surely a node is
    /// what has a header or a type of its own.
    fn is_surely_a_node(&self, role: Role, start: u32, table: &[Param]) -> bool {
        self.is_header(start) || !has_type(role) || table.iter().any(|p| p.name == "type")
    }

    fn is_header(&self, start: u32) -> bool {
        self.syntax == Syntax::Toml && self.text.as_bytes().get(start as usize) == Some(&b'[')
    }

    /// Place of the header of a table, or of its key where it has none.
    fn header(&self, entry: &Param) -> Span {
        let is_table = matches!(entry.value.kind, ValueKind::Table(_));
        if is_table && self.is_header(entry.value.span.start) { entry.value.span } else { entry.name_span }
    }

    fn node(&mut self, role: Role, name: String, header: Span, params: Vec<Param>) {
        let mut node = Node::new(role, "", name);
        (node.span, node.type_span) = (header, header);
        if node.name.is_empty() {
            let message = format!("a {} has an empty name", role.name());
            self.out.error("scene::missing-name", header, message).help =
                format!("name it, for example {}", self.syntax.table(role.name(), "main"));
            return;
        }
        node.params = params;
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
            self.out.error("scene::missing-type", node.span, message).help =
                format!("add {}", type_line(node.role, self.syntax));
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
                self.out.error("scene::missing-type", value.span, message).help =
                    format!("write {}", type_line(node.role, self.syntax));
            }
        }
    }
}

/// The line that gives a node of a role its type, with an example.
fn type_line(role: Role, syntax: Syntax) -> String {
    let example = match role {
        Role::Camera => "perspective",
        Role::Texture => "image",
        Role::Material => "phong",
        Role::Shape => "sphere",
        Role::Light => "point",
        Role::Render | Role::Integrator | Role::Instance => role.name(),
    };
    let line = syntax.entry("type", &format!("{example:?}"));
    format!("a line with the type of the {}, for example {line}", role.name())
}
