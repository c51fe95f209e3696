//! What a scene file says: nodes with parameters, each with its place.

use crate::span::Span;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// What a node is for: the first word of its table's name in a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// `[render]`: size, samples, integrator; one per scene.
    Render,
    /// `[integrator.NAME]`: parameters of the integrator of that name.
    Integrator,
    /// `[camera.NAME]`.
    Camera,
    /// `[texture.NAME]`.
    Texture,
    /// `[material.NAME]`.
    Material,
    /// `[shape.NAME]`.
    Shape,
    /// `[instance.NAME]`: another appearance of a shape.
    Instance,
    /// `[light.NAME]`.
    Light,
}

impl Role {
    /// Every role, in the order in which a writer puts them.
    pub const ALL: [Self; 8] = [
        Self::Render,
        Self::Integrator,
        Self::Camera,
        Self::Texture,
        Self::Material,
        Self::Shape,
        Self::Instance,
        Self::Light,
    ];

    /// The word in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Render => "render",
            Self::Integrator => "integrator",
            Self::Camera => "camera",
            Self::Texture => "texture",
            Self::Material => "material",
            Self::Shape => "shape",
            Self::Instance => "instance",
            Self::Light => "light",
        }
    }

    /// The role of that word.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|r| r.name() == name)
    }
}

/// Index of a node in its [`SceneDescription`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// One thing of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it is for.
    pub role: Role,
    /// The value of its `type` key. For roles without types the role's name; for integrators the node's name.
    pub type_name: String,
    /// Place of the `type` value, or of the node's header if it has none.
    pub type_span: Span,
    /// Its name, unique among the nodes of its role. Empty for `[render]`.
    pub name: String,
    /// Its parameters in file order, without `type`.
    pub params: Vec<Param>,
    /// Nodes that belong to this one (inline definitions); empty in flat scenes.
    pub children: Vec<NodeId>,
    /// Place of its header.
    pub span: Span,
}

impl Node {
    /// A node without parameters or place.
    pub fn new(role: Role, type_name: impl Into<String>, name: impl Into<String>) -> Self {
        Self {
            role,
            type_name: type_name.into(),
            type_span: Span::NONE,
            name: name.into(),
            params: Vec::new(),
            children: Vec::new(),
            span: Span::NONE,
        }
    }

    /// Adds a parameter; for building scenes in programs.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.set(name, value.into());
        self
    }

    /// The parameter of that name.
    pub fn param(&self, name: &str) -> Option<&Param> {
        self.params.iter().find(|p| p.name == name)
    }

    /// Sets a parameter, replacing the value of one that is there.
    pub fn set(&mut self, name: &str, value: Value) {
        match self.params.iter_mut().find(|p| p.name == name) {
            Some(p) => p.value = value,
            None => self.params.push(Param { name: name.to_owned(), name_span: value.span, value }),
        }
    }

    /// True if both say the same, to the last bit of every number: the same things are built from both. Places do not
    /// count.
    pub fn says_the_same(&self, other: &Self) -> bool {
        self.role == other.role
            && self.type_name == other.type_name
            && self.name == other.name
            && self.children == other.children
            && same_params(&self.params, &other.params)
    }

    /// `role.name`, or the role alone where there are no names: how messages and `--set` call it.
    pub fn path(&self) -> String {
        if self.name.is_empty() {
            self.role.name().to_owned()
        } else {
            format!("{}.{}", self.role.name(), self.name)
        }
    }
}

/// A named value.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// The key.
    pub name: String,
    /// Place of the key.
    pub name_span: Span,
    /// The value.
    pub value: Value,
}

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// The value.
    pub kind: ValueKind,
    /// Its place.
    pub span: Span,
}

fn same_params(a: &[Param], b: &[Param]) -> bool {
    let same = |(a, b): (&Param, &Param)| a.name == b.name && a.value.says_the_same(&b.value);
    a.len() == b.len() && a.iter().zip(b).all(same)
}

impl Value {
    /// As equality, but 0 and -0 differ, and a number that is none is the same as itself.
    fn says_the_same(&self, other: &Self) -> bool {
        match (&self.kind, &other.kind) {
            (ValueKind::Float(a), ValueKind::Float(b)) => a.to_bits() == b.to_bits(),
            (ValueKind::Array(a), ValueKind::Array(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.says_the_same(b))
            }
            (ValueKind::Table(a), ValueKind::Table(b)) => same_params(a, b),
            (a, b) => a == b,
        }
    }
}

/// The kinds of values that scene files have.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// `true`, `false`.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// A number with a point or exponent, `nan`, `inf`.
    Float(f64),
    /// A text.
    String(String),
    /// A list.
    Array(Vec<Value>),
    /// An inline table.
    Table(Vec<Param>),
}

impl ValueKind {
    /// How messages call values of this kind.
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Bool(_) => "a boolean",
            Self::Int(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::String(_) => "a text",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

impl From<ValueKind> for Value {
    fn from(kind: ValueKind) -> Self {
        Self { kind, span: Span::NONE }
    }
}
impl From<bool> for Value {
    fn from(v: bool) -> Self {
        ValueKind::Bool(v).into()
    }
}
impl From<i64> for Value {
    fn from(v: i64) -> Self {
        ValueKind::Int(v).into()
    }
}
impl From<f64> for Value {
    fn from(v: f64) -> Self {
        ValueKind::Float(v).into()
    }
}
impl From<&str> for Value {
    fn from(v: &str) -> Self {
        ValueKind::String(v.to_owned()).into()
    }
}
impl From<String> for Value {
    fn from(v: String) -> Self {
        ValueKind::String(v).into()
    }
}
impl<T: Into<Self>> From<Vec<T>> for Value {
    fn from(v: Vec<T>) -> Self {
        ValueKind::Array(v.into_iter().map(Into::into).collect()).into()
    }
}
impl<T: Into<Self>, const N: usize> From<[T; N]> for Value {
    fn from(v: [T; N]) -> Self {
        ValueKind::Array(v.into_iter().map(Into::into).collect()).into()
    }
}
impl<const N: usize> From<[(&str, Value); N]> for Value {
    fn from(entries: [(&str, Value); N]) -> Self {
        let param =
            |(name, value): (&str, Self)| Param { name: name.to_owned(), name_span: Span::NONE, value };
        ValueKind::Table(entries.map(param).into_iter().collect()).into()
    }
}

/// A scene as data: a flat list of nodes that refer to each other by name.
///
/// A copy shares the nodes with the original until one of the two changes them: copies are cheap, however large the
/// meshes in the nodes are.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    nodes: Vec<Arc<Node>>,
    /// Made when first asked for, and anew after a node was changed.
    index: OnceLock<Arc<Index>>,
}

/// What is looked up.
#[derive(Clone, Debug, Default)]
struct Index {
    /// The first node of each role and name.
    names: HashMap<Role, HashMap<String, NodeId>>,
    /// The nodes of each role.
    of_role: HashMap<Role, Vec<NodeId>>,
    /// Place of each node among the nodes of its role.
    ranks: Vec<u32>,
}

impl PartialEq for SceneDescription {
    fn eq(&self, other: &Self) -> bool {
        self.nodes == other.nodes
    }
}

fn enter(index: &mut Index, id: NodeId, node: &Node) {
    index.names.entry(node.role).or_default().entry(node.name.clone()).or_insert(id);
    let of_role = index.of_role.entry(node.role).or_default();
    index.ranks.push(of_role.len() as u32);
    of_role.push(id);
}

impl SceneDescription {
    /// Adds a node.
    pub fn add(&mut self, node: Node) -> NodeId {
        self.add_shared(Arc::new(node))
    }

    /// Adds a node of another description, sharing it.
    pub fn add_shared(&mut self, node: Arc<Node>) -> NodeId {
        let id = NodeId(u32::try_from(self.nodes.len()).expect("fewer than 2^32 nodes"));
        if let Some(index) = self.index.get_mut() {
            enter(Arc::make_mut(index), id, &node);
        }
        self.nodes.push(node);
        id
    }

    /// The node; ids come from [`SceneDescription::add`] and iteration.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// The node as copies of this description share it.
    pub fn shared(&self, id: NodeId) -> &Arc<Node> {
        &self.nodes[id.0 as usize]
    }

    /// The node, to change it.
    pub fn node_mut(&mut self, id: NodeId) -> &mut Node {
        self.index = OnceLock::new();
        Arc::make_mut(&mut self.nodes[id.0 as usize])
    }

    /// The parameters of a node, to change them. Cheaper than [`SceneDescription::node_mut`] in large scenes: the node
    /// stays what it is called.
    pub fn params_mut(&mut self, id: NodeId) -> &mut Vec<Param> {
        &mut Arc::make_mut(&mut self.nodes[id.0 as usize]).params
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// True if there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// All nodes in file order.
    pub fn iter(&self) -> impl Iterator<Item = (NodeId, &Node)> {
        self.nodes.iter().enumerate().map(|(i, n)| (NodeId(i as u32), &**n))
    }

    /// The nodes of a role in file order.
    pub fn of_role(&self, role: Role) -> impl Iterator<Item = (NodeId, &Node)> {
        let ids = self.index().of_role.get(&role).map_or(&[][..], |ids| ids);
        ids.iter().map(|id| (*id, self.node(*id)))
    }

    /// The node of that role and name.
    pub fn find(&self, role: Role, name: &str) -> Option<NodeId> {
        self.index().names.get(&role)?.get(name).copied()
    }

    /// Place of a node among the nodes of its role, from 0: the index of what is built from it.
    pub fn rank(&self, id: NodeId) -> u32 {
        self.index().ranks[id.0 as usize]
    }

    fn index(&self) -> &Index {
        self.index.get_or_init(|| {
            let mut index = Index::default();
            self.iter().for_each(|(id, node)| enter(&mut index, id, node));
            Arc::new(index)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_found_by_role_and_name_whatever_happened_before() {
        let mut scene = SceneDescription::default();
        assert_eq!(scene.find(Role::Shape, "a"), None);
        let [shape, light] = [Role::Shape, Role::Light].map(|role| scene.add(Node::new(role, "t", "a")));
        let second = scene.add(Node::new(Role::Shape, "t", "a"));
        assert_eq!((scene.find(Role::Shape, "a"), scene.find(Role::Light, "a")), (Some(shape), Some(light)));
        assert_eq!([shape, light, second].map(|id| scene.rank(id)), [0, 0, 1]);
        scene.node_mut(shape).name = "b".to_owned();
        assert_eq!((scene.find(Role::Shape, "a"), scene.find(Role::Shape, "b")), (Some(second), Some(shape)));
        assert_eq!(scene, scene.clone());
    }

    #[test]
    fn copies_share_nodes_until_they_change() {
        let mut first = SceneDescription::default();
        let [a, b] = ["a", "b"].map(|name| first.add(Node::new(Role::Shape, "t", name).with("x", 1)));
        assert_eq!(first.find(Role::Shape, "b"), Some(b));
        let mut second = first.clone();
        second.params_mut(b)[0].value = 2.into();
        let third = second.add_shared(first.shared(a).clone());
        assert!(Arc::ptr_eq(first.shared(a), second.shared(a)));
        assert!(Arc::ptr_eq(first.shared(a), second.shared(third)));
        let x = |d: &SceneDescription| d.node(b).param("x").map(|p| p.value.kind.clone());
        assert_eq!([x(&first), x(&second)], [1, 2].map(|n| Some(ValueKind::Int(n))));
        // Each has an index of its own.
        assert_eq!([&first, &second].map(|d| d.of_role(Role::Shape).count()), [2, 3]);
        second.node_mut(third).name = "c".to_owned();
        assert_eq!((second.find(Role::Shape, "c"), second.rank(third)), (Some(third), 2));
        assert_eq!((first.find(Role::Shape, "c"), first.find(Role::Shape, "a")), (None, Some(a)));
    }

    #[test]
    fn nodes_that_say_the_same_do_so_bit_by_bit() {
        let node = |value: Value| Node::new(Role::Shape, "t", "a").with("x", value);
        let list = |x: f64| Value::from([("inner", vec![1.0, x].into())]);
        for x in [0.0, -0.0, 1.5, f64::NAN] {
            let mut moved = node(list(x));
            moved.span = Span { file: crate::span::FileId(3), start: 4, len: 5 };
            assert!(node(list(x)).says_the_same(&moved), "{x}");
        }
        let base = node(list(0.0));
        let others = [list(-0.0), list(1.0), vec![1.0].into(), 1.into(), true.into(), "0".into()];
        assert!(others.into_iter().all(|value| !base.says_the_same(&node(value))));
        let mut nodes = vec![base.clone(); 5];
        nodes[0].name = "b".to_owned();
        nodes[1].type_name = "u".to_owned();
        nodes[2].role = Role::Light;
        nodes[3].params.clear();
        nodes[4].children.push(NodeId(0));
        assert!(nodes.iter().all(|node| !base.says_the_same(node) && !node.says_the_same(&base)));
    }
}
