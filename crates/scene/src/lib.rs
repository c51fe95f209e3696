//! Scenes as plain data: descriptions, readers, writers, diagnostics and assets.
//!
//! A [`SceneDescription`] is what a file says, before anything is built from it: nodes with a role, a type
//! name, a name and parameters, each with its place in the source. This crate knows no material, light or
//! shape: readers emit type names and parameters, and the renderer's registry decides what they mean.
#![forbid(unsafe_code)]

pub mod assets;
pub mod auto;
pub mod builtin;
pub mod description;
pub mod diagnostic;
mod digest;
pub mod json;
pub mod load;
pub mod mesh;
pub mod native;
pub mod params;
mod portable;
mod printable;
pub mod readers;
pub mod report;
pub mod schema;
pub mod set;
pub mod span;
mod suggest;
pub mod toml;

pub use assets::Assets;
pub use description::{Node, NodeId, Param, Role, SceneDescription, Value, ValueKind};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use mesh::TriangleMesh;
pub use params::{ColorInput, FloatInput, Params};
pub use portable::Portable;
pub use printable::harmless;
pub use readers::{Folders, MeshFile};
pub use schema::{Kind, ParamDefault, ParamSpec, Range};
pub use span::{FileId, SourceFile, Sources, Span};
pub use suggest::{help_for, nearest};
