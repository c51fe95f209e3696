//! The native scene format, TOML: reader and writer.
//!
//! ```toml
//! penombre = 1                  # version of the format
//! include = ["materials.toml"]  # relative to this file
//!
//! [render]
//! spp = 64
//!
//! [shape.ball]                  # [ROLE.NAME]
//! type = "sphere"
//! radius = 1
//! ```
//!
//! `type` is reserved: it names the type of a camera, texture, material, shape or light. The type of an
//! integrator is its name; `render` and instances have none. Dotted keys, inline tables and headers mean the same.

mod read;
mod syntax;
#[cfg(test)]
mod tests;
mod values;
mod write;

use crate::description::{Role, SceneDescription};
use crate::span::Span;

pub use read::read_toml;
pub(crate) use values::{read_key_path, read_value};
pub use write::write_toml;

/// Version of the format that this reader knows, the value of the key `penombre`.
pub const FORMAT_VERSION: i64 = 1;

/// A scene file as it stands, before the files that it includes are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TomlScene {
    /// Its nodes in file order.
    pub description: SceneDescription,
    /// The files that it includes, in file order.
    pub includes: Vec<Include>,
    /// False if the text is no TOML: then the description is empty.
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
