//! The machine: what the renderer needs from the operating system and the standard library does not give.
//!
//! Files that appear whole or not at all ([`write_atomic`]), checks before long work ([`check_writable`],
//! [`available_space`]), what the process used ([`peak_rss`], [`process_cpu_time`]), threads that yield to others
//! ([`lower_thread_priority`]), memory that goes back ([`return_large_blocks`]), files that
//! grow too large ([`fail_beyond_file_size_limit`]), and the processor's wider vectors
//! ([`vectorize`]). Every function has a portable fallback; `unsafe` stands in two small modules.

mod cgroup;
mod file;
mod machine;
mod vectorize;

pub use file::{TEMPORARY_SUFFIX, check_writable, write_atomic};
pub use machine::{
    available_memory, available_space, fail_beyond_file_size_limit, lower_thread_priority, peak_rss,
    process_cpu_time, return_large_blocks,
};
pub use vectorize::{Vectorizable, vectorize};
