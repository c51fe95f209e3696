//! Faults on the terminal.

use crate::terminal;
use penombre_scene::report::{render_plain, report};
use penombre_scene::{Diagnostics, Severity, Sources};

/// Errors, warnings and remarks that are printed, of each so many: the first of them say enough.
const MOST: usize = 20;

/// Prints faults to standard error: drawn for people at a terminal, plain elsewhere. `quiet` leaves out all but
/// errors. Of many the first are printed, and how many more there are.
pub fn print(diagnostics: &Diagnostics, sources: &Sources, quiet: bool) {
    let drawn = terminal::is_interactive();
    let mut printed = [0; 3];
    for diagnostic in diagnostics.iter().filter(|d| !quiet || d.severity == Severity::Error) {
        let count = &mut printed[diagnostic.severity as usize];
        *count += 1;
        if *count > MOST {
            continue;
        }
        if drawn {
            terminal::err(format!("{:?}", report(diagnostic, sources)).trim_end());
        } else {
            terminal::err(render_plain(diagnostic, sources).trim_end());
        }
    }
    for (count, what) in printed.into_iter().zip(["error", "warning", "remark"]) {
        if count > MOST {
            let (more, plural) = (count - MOST, if count == MOST + 1 { "" } else { "s" });
            terminal::err(&format!("… and {more} more {what}{plural}: `penombre check --json` tells all"));
        }
    }
}

/// Prints a fault that has no place in a file.
pub fn error(message: &str, help: &str) {
    let help = if help.is_empty() { String::new() } else { format!("\n  help: {help}") };
    terminal::err(&format!("error: {message}{help}"));
}

/// Replaces the standard message of a panic: no input should cause one, so it is a fault of the program.
pub fn set_panic_message() {
    std::panic::set_hook(Box::new(|info| {
        if penombre_image::panic_is_contained() {
            return;
        }
        let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        let cause = info.payload_as_str().unwrap_or("no message");
        error(
            &format!("internal fault{place}: {cause}"),
            "this is a bug of penombre: please report it with the scene and the command",
        );
    }));
}
