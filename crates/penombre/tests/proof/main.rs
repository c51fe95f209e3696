//! Proof that the path tracer is right: closed forms, pictures of another renderer, and itself by other ways.
//!
//! The normal run takes seconds; `PENOMBRE_SLOW=1` takes many times the samples.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "figures, and what is not run, must be said")]

mod caustics;
mod common;
mod furnace;
mod references;
mod scale;
mod terminator;
mod witness;
