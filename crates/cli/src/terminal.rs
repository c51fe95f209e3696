//! Printing that survives a closed pipe.

use std::io::{IsTerminal, Write};

/// Writes a text and a newline to standard output. A reader that has gone away is no fault.
pub fn out(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
}

/// Writes a text and a newline to standard error.
pub fn err(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// True if standard error is a terminal that a person looks at.
pub fn is_interactive() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|t| t != "dumb")
}
