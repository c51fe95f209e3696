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

pub use read::read_toml;
pub(crate) use values::{read_key_path, read_value};
pub use write::write_toml;
