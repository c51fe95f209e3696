//! The machine: what the renderer needs from the operating system and the standard library does not give.
//!
//! Files that appear whole or not at all ([`write_atomic`]), checks before long work ([`check_writable`],
//! [`available_space`]), and what the process used ([`peak_rss`], [`process_cpu_time`]). Every function has a
//! portable fallback; `unsafe` stands in one small module of system calls.

mod file;
mod machine;

pub use file::{TEMPORARY_SUFFIX, check_writable, write_atomic};
pub use machine::{available_space, peak_rss, process_cpu_time};
