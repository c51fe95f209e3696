//! What parameters a type of node has: one table that decodes, checks, documents.

use crate::description::Role;

/// Numbers that a parameter accepts. NaN and infinities are never accepted unless `infinite` says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// True if `min` itself is refused.
    pub min_open: bool,
    /// True if `max` itself is refused.
    pub max_open: bool,
    /// True if infinities within the range are accepted.
    pub infinite: bool,
}

impl Range {
    /// Any finite number.
    pub const ANY: Self = Self::closed(f64::MIN, f64::MAX);
    /// Finite and greater than zero.
    pub const POSITIVE: Self = Self { min_open: true, ..Self::closed(0.0, f64::MAX) };
    /// Finite and at least zero.
    pub const NON_NEGATIVE: Self = Self::closed(0.0, f64::MAX);
    /// 0 to 1.
    pub const UNIT: Self = Self::closed(0.0, 1.0);

    /// `min` to `max`, both included.
    pub const fn closed(min: f64, max: f64) -> Self {
        Self { min, max, min_open: false, max_open: false, infinite: false }
    }

    /// Between `min` and `max`, neither included.
    pub const fn open(min: f64, max: f64) -> Self {
        Self { min, max, min_open: true, max_open: true, infinite: false }
    }

    /// The same, infinity included.
    pub const fn or_infinite(self) -> Self {
        Self { infinite: true, max: f64::INFINITY, ..self }
    }

    /// True if `v` is accepted.
    pub fn contains(&self, v: f64) -> bool {
        let above = if self.min_open { v > self.min } else { v >= self.min };
        let below = if self.max_open { v < self.max } else { v <= self.max };
        above && below && (v.is_finite() || self.infinite)
    }
}

/// What a parameter's value must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `true` or `false`.
    Bool,
    /// A whole number within the range.
    Int(Range),
    /// A number within the range.
    Float(Range),
    /// Two numbers, each within the range.
    Vec2(Range),
    /// Two whole numbers, each within the range.
    Int2(Range),
    /// A point or vector: three finite numbers.
    Vec3,
    /// A vector that is not zero.
    Direction,
    /// Two vectors, `[[x, y, z], [x, y, z]]`, neither zero nor parallel.
    Sides,
    /// A colour: three numbers in linear Rec. 709 within the range, or one number for grey, or `"#rrggbb"` (sRGB).
    Color(Range),
    /// A colour or `{ texture = "NAME" }`.
    ColorTexture(Range),
    /// A number or `{ texture = "NAME" }`.
    FloatTexture(Range),
    /// One of the words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// A file, relative to the scene file's folder.
    File,
    /// The name of a node of that role.
    Reference(Role),
    /// A list of `{ translate = [x,y,z] }`, `{ scale = s }`, `{ scale = [x,y,z] }`,
    /// `{ rotate = [axis], angle = degrees }`, `{ matrix = [16 numbers, row by row] }`, applied in this order.
    Transform,
    /// A list of transforms.
    Transforms,
    /// A list of points or vectors.
    Vec3List,
    /// A list of pairs of numbers.
    Vec2List,
    /// A list of colours.
    ColorList,
    /// A list of triangles or polygons: lists of three or more indices from 0.
    Faces,
}

/// The value of a parameter that is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamDefault {
    /// It must be given.
    Required,
    /// It may be absent.
    Absent,
    /// This truth value.
    Bool(bool),
    /// This whole number.
    Int(i64),
    /// This number.
    Float(f64),
    /// This pair.
    Vec2([f64; 2]),
    /// This triple.
    Vec3([f64; 3]),
    /// This colour, linear Rec. 709.
    Color([f32; 3]),
    /// This text.
    Text(&'static str),
}

/// One parameter of a type of node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamSpec {
    /// The key in scene files.
    pub name: &'static str,
    /// What its value must be.
    pub kind: Kind,
    /// The value if it is not given.
    pub default: ParamDefault,
    /// Its unit; empty for none.
    pub unit: &'static str,
    /// What it means, in one or two sentences.
    pub doc: &'static str,
}

impl ParamSpec {
    /// A required parameter without a unit.
    pub const fn required(name: &'static str, kind: Kind, doc: &'static str) -> Self {
        Self { name, kind, default: ParamDefault::Required, unit: "", doc }
    }

    /// A parameter that may be left out.
    pub const fn optional(name: &'static str, kind: Kind, doc: &'static str) -> Self {
        Self { name, kind, default: ParamDefault::Absent, unit: "", doc }
    }

    /// A parameter with a default.
    pub const fn with_default(
        name: &'static str,
        kind: Kind,
        default: ParamDefault,
        doc: &'static str,
    ) -> Self {
        Self { name, kind, default, unit: "", doc }
    }

    /// The same with a unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}
