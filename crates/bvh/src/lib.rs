//! Which surface does a ray meet first? Bounding volume hierarchies over triangles, spheres, parallelograms,
//! disks, instances and primitives of the caller's making.
//!
//! The crate knows rays and ids, no materials and no shading. Build a [`Bvh`] once from [`Geometry`], then
//! ask it for the closest hit ([`Bvh::closest`]) or for any hit at all ([`Bvh::occluded`]), one ray at a time
//! or, better, in batches.
//!
//! ```
//! use penombre_bvh::{BuildOptions, Bvh, Geometry, Quad, Ray, Sphere};
//! use penombre_math::Vec3;
//!
//! let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
//! let floor = Quad { origin: Vec3::new(-5.0, -1.0, -5.0), sides: [Vec3::X * 10.0, Vec3::Z * 10.0] };
//! let geometries = vec![Geometry::Spheres(vec![ball]), Geometry::Quads(vec![floor])];
//! let bvh = Bvh::build(geometries, &BuildOptions::default())?;
//!
//! let hit = bvh.closest(&Ray::new(Vec3::new(0.0, 0.0, 4.0), -Vec3::Z, 0.0, f32::INFINITY));
//! assert!(hit.is_hit());
//! assert_eq!((hit.geometry, hit.prim, hit.t), (0, 0, 3.0));
//!
//! // Right below the ball, the floor cannot see the sky.
//! assert!(bvh.occluded(&Ray::new(Vec3::new(0.0, -0.999, 0.0), Vec3::Y, 1e-3, 10.0)));
//! # Ok::<(), penombre_bvh::BuildError>(())
//! ```
//!
//! # The whole of it
//!
//! | | |
//! |---|---|
//! | [`Bvh::build`], [`Bvh::refit`] | from a list of [`Geometry`], with [`BuildOptions`]; moves along with it |
//! | [`Bvh::closest`], [`Bvh::closest_batch`] | the nearest [`Hit`] of one [`Ray`], of many |
//! | [`Bvh::occluded`], [`Bvh::occluded_batch`] | whether a ray hits anything |
//! | [`closest_where`](Bvh::closest_where), [`closest_batch_where`](Bvh::closest_batch_where), [`occluded_where`](Bvh::occluded_where), [`occluded_batch_where`](Bvh::occluded_batch_where) | the same, of those hits alone that a [`Filter`] accepts: cut-outs by a closure, ray masks by [`Masks`] |
//! | [`Geometry`] | [`Triangles`], [`Sphere`]s, [`Quad`]s, [`Disk`]s, [`Instance`]s of another hierarchy, or whatever implements [`UserPrimitives`] |
//! | [`Bvh::bounds`], [`Bvh::stats`], [`Bvh::build_time`] | what came of it |
//! | [`InstructionSet`] | what the processor has, and how to use less of it |
//!
//! # What holds
//!
//! * **One answer.** The hit returned is the one that a loop over all primitives would find, bit for bit:
//!   boxes are conservative for the *computed* distance of every primitive, and among equal distances the
//!   smallest (top-level geometry, nested geometry, primitive) wins. Instruction sets, the tree's shape, one
//!   ray a call or a batch change nothing. The same holds for the hits that a filter accepts.
//! * **Watertight.** No ray slips between triangles that share an edge (\[Woop2013\]), nor between
//!   parallelograms that do.
//! * **Bad data harms nobody.** Degenerate or non-finite primitives are never hit and counted in [`Stats`];
//!   rays with a zero or non-finite direction or origin hit nothing.
//! * Distances are measured in the length of `dir`, which need not be 1, and survive the change into the
//!   space of an instance.
//! * Direction components below 2⁻⁴⁰ of the largest count as zero.
#![deny(unsafe_code)]

mod builder;
mod bvh;
mod few;
mod filter;
mod flight;
mod geometry;
mod instructions;
mod kernel;
mod lanes;
mod node;
mod prepared;
mod primitive;
mod query;
mod ray;
mod ready;
mod stats;
#[cfg(test)]
mod tests;
mod traverse;
mod user;

pub use builder::{BuildError, BuildOptions, Quality, RefitError};
pub use bvh::Bvh;
pub use filter::{Filter, Masks};
pub use geometry::{Disk, Geometry, Instance, Quad, Sphere, Triangles};
pub use instructions::{InstructionSet, UnknownInstructionSet};
pub use ray::{Hit, Ray};
pub use stats::{PrimitiveCounts, Stats};
pub use user::{UserHit, UserPrimitives};
