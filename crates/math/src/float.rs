//! Elementary functions that give the same bits everywhere.
//!
//! The system's `sin`, `exp`, `pow` differ between machines and library versions; these are our own. Each
//! takes and returns `f32`, works in double precision on minimax polynomials (Remez exchange, coefficients
//! computed for this crate), uses only `+ − × ÷` and `sqrt`, and rounds once at the end. The error is
//! therefore half an ulp plus the small part that double precision leaves.
//!
//! Measured against the system's double precision over all 2³² inputs (`atan2`, `pow`: 2³² hashed pairs), in
//! ulps of the result (half an ulp is perfect; the tests hold 0.5001, `pow` 0.5005):
//!
//! | functions | largest error |
//! |---|---|
//! | [`asin`], [`acos`], [`atan`], [`atan2`], [`ln`], [`log2`] | 0.500000 |
//! | [`sin`], [`cos`], [`tan`] | 0.500002 |
//! | [`exp`], [`exp2`], [`pow`] | 0.500017 |
//!
//! NaN gives NaN, signed zeros keep their sign where the function is odd, and subnormal inputs and results
//! are rounded like all others.

mod degrees;
mod exponential;
mod inverse;
mod trigonometric;

#[cfg(test)]
mod tests;

pub use degrees::{sin_cos_degrees, tan_degrees};
pub(crate) use exponential::pow_wide;
pub use exponential::{exp, exp2, ln, log2, pow};
pub use inverse::{acos, asin, atan, atan2};
pub use trigonometric::{cos, sin, sin_cos, tan};

/// 1.5·2⁵²: adding it to a number below 2⁵¹ in size rounds that to an integer (ties to even), which then
/// stands in the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
