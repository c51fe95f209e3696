//! `penombre view`: starts the window, which is a program of its own, for this one needs no display.

use crate::args::ViewArgs;
use crate::{Exit, report};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::{Child, Command};

/// Name of the program, without the ending that the system gives to programs.
const PROGRAM: &str = "penombre-view";

const MISSING_HELP: &str =
    "build it: `cargo build --release -p penombre-view`; or install it: `cargo install --path crates/view`";

/// Runs the window's program until it ends, with these arguments. Both belong to the terminal, so Ctrl-C ends both.
pub fn run(args: &ViewArgs) -> Exit {
    let ended = match start(args) {
        Ok(mut child) => child.wait(),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let message =
                format!("the window's program `{PROGRAM}` is neither beside `penombre` nor on the PATH");
            report::error(&message, MISSING_HELP);
            return Exit::Failure;
        }
        Err(error) => Err(error),
    };
    match ended {
        // A program that was ended by a signal has no status of its own.
        Ok(status) => Exit::As(status.code().map_or(1, |code| u8::try_from(code).unwrap_or(1))),
        Err(error) => {
            report::error(&format!("cannot run `{PROGRAM}`: {error}"), "");
            Exit::Failure
        }
    }
}

/// Starts the program beside this one, or else that on the PATH.
fn start(args: &ViewArgs) -> std::io::Result<Child> {
    let named = PathBuf::from(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX));
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name(&named));
    let there = beside.filter(|program| program.is_file());
    Command::new(there.unwrap_or(named)).args(&args.arguments).spawn()
}
