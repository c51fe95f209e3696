//! Rendering: from a scene description to an image.
//!
//! A [`penombre_scene::SceneDescription`] is built into an immutable [`scene::Scene`]; a scene, an integrator
//! and a [`render::Job`] make work units; [`render::Render`] folds their results into a film. The same scene,
//! job and seed give the same bits for any number of threads, size or order of tiles.
//!
//! This crate opens no file or socket, prints nothing, reads no clock and keeps no global state.
//!
//! Rooms, each importing only those before it: `texture, shape, bsdf, material, light, camera, scene, sampler,
//! film, integrator, render`.
#![forbid(unsafe_code)]

mod registry;

pub mod texture;

pub mod shape;

pub mod bsdf;

pub mod material;

pub mod light;

pub mod camera;

pub mod scene;

pub mod sampler;

pub mod film;

pub mod integrator;

pub mod render;

#[cfg(test)]
mod testing;

pub use penombre_bvh::InstructionSet;
pub use registry::TypeInfo;
pub use render::{Event, Job, Observer, Outcome, Plan, Render, UnitResult, WorkUnit};
pub use scene::Scene;
