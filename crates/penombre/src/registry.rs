//! What every registry of types (materials, lights, shapes, …) tells about its entries.

use penombre_scene::assets::Assets;
use penombre_scene::params::Params;
use penombre_scene::{Diagnostics, Node, NodeId, ParamSpec, SceneDescription};

/// One type of a role: its name in scene files and its parameters.
#[derive(Clone, Copy, Debug)]
pub struct TypeInfo {
    /// The value of `type` in scene files.
    pub name: &'static str,
    /// Other accepted names.
    pub aliases: &'static [&'static str],
    /// The parameters.
    pub schema: &'static [ParamSpec],
}

/// A thing and its name in the scene file.
#[derive(Clone, Debug)]
pub struct Named<T> {
    /// The name; empty if the program made it.
    pub name: String,
    /// The thing.
    pub value: T,
}

/// What building a node may look at, and where its faults go.
pub struct Context<'a, 'd> {
    /// The whole description.
    pub description: &'a SceneDescription,
    /// The files that it names.
    pub assets: &'a Assets,
    /// Faults.
    pub out: &'d mut Diagnostics,
    /// The node being built.
    pub node: NodeId,
}

impl Context<'_, '_> {
    /// Decodes and checks the parameters of a node.
    pub fn decode(&mut self, node: &Node, schema: &'static [ParamSpec]) -> Params {
        Params::decode(node, schema, self.description, self.out)
    }

    /// Position of a node among the nodes of its role: the index of what is built from it.
    pub fn position(&self, id: NodeId) -> u32 {
        self.description.rank(id)
    }
}

/// Finds the position of the node's type among `types`, or reports that there is none of that name. A node whose
/// reader found no type, and said so, has an empty one: nothing is added then.
pub fn find_type(node: &Node, types: &[TypeInfo], out: &mut Diagnostics) -> Option<usize> {
    let wanted = node.type_name.as_str();
    let found = types.iter().position(|t| t.name == wanted || t.aliases.contains(&wanted));
    let was_told = wanted.is_empty() && out.has_errors();
    if found.is_none() && !was_told {
        let names: Vec<&str> = types.iter().map(|t| t.name).collect();
        let role = node.role.name();
        let message = format!("unknown type `{wanted}` of {role} `{}`", node.name);
        let fault = out.error("scene::unknown-type", node.type_span, message);
        fault.label = "not a type of this version".to_owned();
        fault.help = penombre_scene::help_for(wanted, &format!("types of {role}"), &names);
    }
    found
}

/// Declares the modules of a role's types, a closed enum over them, its table of types and its dispatch.
///
/// One entry `module::Type` is all that a new type needs besides its file.
macro_rules! registry {
    ($(#[$doc:meta])* $any:ident: $trait:ident { $($module:ident :: $type:ident),+ $(,)? }) => {
        $(pub mod $module;)+

        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub enum $any {
            $(#[doc = concat!("See [`", stringify!($module), "`].")] $type($module::$type),)+
        }

        impl $any {
            /// Every type, in the order of the registry.
            pub const TYPES: &'static [$crate::TypeInfo] = &[$($crate::TypeInfo {
                name: <$module::$type as $trait>::TYPE_NAME,
                aliases: <$module::$type as $trait>::ALIASES,
                schema: <$module::$type as $trait>::SCHEMA,
            }),+];

            /// The name of this value's type in scene files.
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$type(_) => <$module::$type as $trait>::TYPE_NAME),+ }
            }

            /// Builds the node's type. Faults go to `out`; `None` if the type is unknown or cannot stand.
            pub fn build(
                node: &penombre_scene::Node,
                context: &mut $crate::registry::Context<'_, '_>,
            ) -> Option<Self> {
                let index = $crate::registry::find_type(node, Self::TYPES, context.out)?;
                let params = context.decode(node, Self::TYPES[index].schema);
                let builders: &[fn(
                    &penombre_scene::params::Params,
                    &mut $crate::registry::Context<'_, '_>,
                ) -> Option<Self>] = &[$(
                    |p, c| <$module::$type as $trait>::build(p, c).map(Self::$type)
                ),+];
                builders[index](&params, context)
            }
        }
    };
}

pub(crate) use registry;
