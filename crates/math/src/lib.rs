//! Numbers for rendering: vectors, transforms, bounds, rounding, spectra, elementary functions,
//! random and low-discrepancy points, distributions.
//!
//! Everything here is a pure function of its arguments and gives the same bits on every run, thread and
//! x86-64 machine: no system transcendental functions, no approximate reciprocals, no implicit fused
//! multiply-add. No input or output of any kind.

#![forbid(unsafe_code)]

pub mod bounds;
pub mod color;
pub mod distribution;
pub mod float;
pub mod frame;
pub mod hash;
pub mod quick;
pub mod rounding;
pub mod sobol;
pub mod spectrum;
pub mod transform;

pub use bounds::Bounds3;
pub use frame::Frame;
pub use glam::{DAffine3, DMat3, DVec2, DVec3, Mat3, UVec2, Vec2, Vec3, Vec3A, Vec3Swizzles, Vec4};
pub use spectrum::Spectrum;
pub use transform::Transform;
