//! Printing that survives a closed pipe.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

static FAILED: AtomicBool = AtomicBool::new(false);

/// Writes a text and a newline to standard output. A reader that has gone away is no fault; a full disk is, and is
/// told once.
pub fn out(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let written = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
    let fault = written.err().filter(|e| e.kind() != ErrorKind::BrokenPipe);
    if let Some(error) = fault.filter(|_| !FAILED.swap(true, Ordering::Relaxed)) {
        err(&format!("error: cannot write to standard output: {error}"));
    }
}

/// True if something could not be written to standard output.
pub fn has_failed() -> bool {
    FAILED.load(Ordering::Relaxed)
}

/// Writes a text and a newline to standard error.
pub fn err(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// True if standard error is a terminal that a person looks at.
pub fn is_interactive() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|t| t != "dumb")
}
