//! Mesh files: readers, materials and assets, from outside the crate.
// The helpers are tests too: they may unwrap, and say on standard error what does not run.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod common;
mod corpus;
mod fuzzed;
mod materials;
mod mutated;
mod obj;
mod off;
mod packed;
mod ply;
mod ply_values;
mod smoothing;
mod stl;
