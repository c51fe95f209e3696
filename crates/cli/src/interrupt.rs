//! Ctrl-C and SIGTERM: once, finish what is in hand and save; twice, leave at once.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Exit status of an interrupted command.
pub const STATUS: i32 = 130;

static REQUESTS: AtomicUsize = AtomicUsize::new(0);

/// Listens from now on.
///
/// # Errors
/// A text if the system does not let us.
pub fn listen() -> Result<(), String> {
    let heard = || {
        if REQUESTS.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(STATUS);
        }
    };
    ctrlc::set_handler(heard).map_err(|e| format!("cannot listen for Ctrl-C: {e}"))
}

/// True once the user has asked to stop.
pub fn requested() -> bool {
    REQUESTS.load(Ordering::Relaxed) > 0
}
