//! Parameters decoded and checked against a schema.
//!
//! [`Params::decode`] reports every fault of a node and puts a harmless value in the place of each faulty one, so
//! that building goes on and finds the faults of the other nodes too.

mod color;
mod decode;
mod expect;
#[cfg(test)]
mod tests;
mod transform;

use crate::description::{Node, NodeId, SceneDescription};
use crate::diagnostic::Diagnostics;
use crate::schema::ParamSpec;
use crate::span::Span;
use penombre_math::{DAffine3, Vec2, Vec3};

pub(crate) use expect::found;

/// A colour that is constant or comes from a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorInput {
    /// Linear Rec. 709.
    Constant([f32; 3]),
    /// A node of role texture.
    Texture(NodeId),
}

/// A number that is constant or comes from a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// The same everywhere.
    Constant(f32),
    /// A node of role texture.
    Texture(NodeId),
}

/// A decoded value, by kind.
#[derive(Clone, Debug, PartialEq)]
enum Decoded {
    Absent,
    Bool(bool),
    Int(i64),
    Float(f64),
    Pair([f64; 2]),
    Ints([i64; 2]),
    Vector(Vec3),
    Sides([Vec3; 2]),
    Color([f32; 3]),
    ColorInput(ColorInput),
    FloatInput(FloatInput),
    Text(String),
    Reference(NodeId),
    Transform(DAffine3),
    Transforms(Vec<DAffine3>),
    Vectors(Vec<Vec3>),
    Pairs(Vec<Vec2>),
    Colors(Vec<[f32; 3]>),
    Faces(Vec<Vec<u32>>),
}

#[derive(Clone, Debug)]
struct Entry {
    value: Decoded,
    span: Option<Span>,
}

/// The parameters of one node: every one of its schema has a value of its kind.
#[derive(Clone, Debug)]
pub struct Params {
    schema: &'static [ParamSpec],
    entries: Vec<Entry>,
    header: Span,
}

/// One getter per kind: the value, or a panic if the schema has no such parameter of that kind.
macro_rules! getters {
    ($($(#[$doc:meta])* $name:ident -> $type:ty { $pattern:pat => $value:expr } else $absent:expr;)+) => {
        $($(#[$doc])*
        pub fn $name(&self, name: &str) -> $type {
            match self.value(name) {
                $pattern => $value,
                Decoded::Absent => $absent,
                other => panic!("parameter `{name}` is declared as {other:?}, not for `{}`", stringify!($name)),
            }
        })+
    };
}

impl Params {
    /// Decodes the parameters of `node` and reports all its faults: unknown, missing, of the wrong type, out of
    /// range, not finite, names of nodes that do not exist. In place of a faulty value stands its default, or a
    /// harmless value of its kind.
    pub fn decode(
        node: &Node,
        schema: &'static [ParamSpec],
        scene: &SceneDescription,
        out: &mut Diagnostics,
    ) -> Self {
        let mut faults = Diagnostics::default();
        let entries = decode::entries(node, schema, scene, out.is_long(), &mut faults);
        faults.sort_by_place();
        out.extend(faults);
        Self { schema, entries, header: node.span }
    }

    fn entry(&self, name: &str) -> &Entry {
        let index = self.schema.iter().position(|s| s.name == name);
        let index = index.unwrap_or_else(|| panic!("parameter `{name}` is not in the schema"));
        &self.entries[index]
    }

    fn value(&self, name: &str) -> &Decoded {
        &self.entry(name).value
    }

    /// True if the node has this parameter, faulty or not.
    pub fn is_given(&self, name: &str) -> bool {
        self.entry(name).span.is_some()
    }

    /// Place of the value, or of the node's header if it is not given.
    pub fn span(&self, name: &str) -> Span {
        self.entry(name).span.unwrap_or(self.header)
    }

    /// Place of the node's header.
    pub fn header(&self) -> Span {
        self.header
    }

    getters! {
        /// A truth value; false if absent.
        bool -> bool { Decoded::Bool(v) => *v } else false;
        /// A whole number; 0 if absent.
        int -> i64 { Decoded::Int(v) => *v } else 0;
        /// A number; 0 if absent.
        f64 -> f64 { Decoded::Float(v) => *v } else 0.0;
        /// A number rounded to single precision (finite unless the schema accepts infinities); 0 if absent.
        f32 -> f32 { Decoded::Float(v) => *v as f32 } else 0.0;
        /// A number rounded to single precision.
        opt_f32 -> Option<f32> { Decoded::Float(v) => Some(*v as f32) } else None;
        /// A pair of numbers; zero if absent.
        vec2 -> Vec2 { Decoded::Pair([x, y]) => Vec2::new(*x as f32, *y as f32) } else Vec2::ZERO;
        /// A pair of whole numbers; zero if absent.
        int2 -> [i64; 2] { Decoded::Ints(v) => *v } else [0; 2];
        /// A point, vector or direction; zero if absent.
        vec3 -> Vec3 { Decoded::Vector(v) => *v } else Vec3::ZERO;
        /// A point, vector or direction.
        opt_vec3 -> Option<Vec3> { Decoded::Vector(v) => Some(*v) } else None;
        /// Two sides that span a parallelogram; along x and y if absent.
        sides -> [Vec3; 2] { Decoded::Sides(v) => *v } else [Vec3::X, Vec3::Y];
        /// A colour, linear Rec. 709; black if absent.
        color -> [f32; 3] { Decoded::Color(v) => *v } else [0.0; 3];
        /// A colour, linear Rec. 709.
        opt_color -> Option<[f32; 3]> { Decoded::Color(v) => Some(*v) } else None;
        /// A colour or texture; black if absent.
        color_texture -> ColorInput { Decoded::ColorInput(v) => *v } else ColorInput::Constant([0.0; 3]);
        /// A number or texture; 0 if absent.
        float_texture -> FloatInput { Decoded::FloatInput(v) => *v } else FloatInput::Constant(0.0);
        /// One of the words of the schema; empty if absent.
        choice -> &str { Decoded::Text(v) => v } else "";
        /// A text.
        text -> Option<&str> { Decoded::Text(v) => Some(v) } else None;
        /// A file's name as the scene has it.
        file -> Option<&str> { Decoded::Text(v) => Some(v) } else None;
        /// A node of the role that the schema names.
        reference -> Option<NodeId> { Decoded::Reference(v) => Some(*v) } else None;
        /// An invertible map; the identity if absent.
        transform -> DAffine3 { Decoded::Transform(v) => *v } else DAffine3::IDENTITY;
        /// Invertible maps; none if absent.
        transforms -> Vec<DAffine3> { Decoded::Transforms(v) => v.clone() } else Vec::new();
        /// Points or vectors; none if absent.
        vec3_list -> Vec<Vec3> { Decoded::Vectors(v) => v.clone() } else Vec::new();
        /// Pairs of numbers; none if absent.
        vec2_list -> Vec<Vec2> { Decoded::Pairs(v) => v.clone() } else Vec::new();
        /// Colours, linear Rec. 709; none if absent.
        color_list -> Vec<[f32; 3]> { Decoded::Colors(v) => v.clone() } else Vec::new();
        /// Polygons as lists of three or more indices from 0; none if absent.
        faces -> Vec<Vec<u32>> { Decoded::Faces(v) => v.clone() } else Vec::new();
    }
}
