//! The `penombre` command: the only part of the project that prints.
//!
//! Exit status: 0 done, 1 failure, 2 scene or usage error, 130 interrupted (what is done is saved). Results go to
//! standard output; progress, warnings and errors to standard error.
#![forbid(unsafe_code)]

mod args;
mod check;
mod convert;
mod diff;
mod info;
mod interrupt;
mod limits;
mod loading;
mod memory;
mod outputs;
mod planned;
mod progress;
mod render;
mod report;
mod scene;
mod schema;
mod shell;
mod statistics;
mod terminal;
mod trace;
mod view;

use args::{Cli, Command};
use clap::Parser;
use penombre::InstructionSet;
use std::process::ExitCode;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// All is done.
    Done,
    /// Something outside the scene failed: a disk, a file system; or images differ.
    Failure,
    /// The scene or the command line is wrong.
    Usage,
    /// Stopped by the user; what was done is saved.
    Interrupted,
    /// As a program that was started: its status.
    As(u8),
}

impl Exit {
    fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failure => 1,
            Self::Usage => 2,
            Self::Interrupted => interrupt::STATUS as u8,
            Self::As(status) => status,
        }
    }
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return planned::answer(&error),
    };
    report::set_panic_message();
    penombre_sys::return_large_blocks();
    penombre_sys::fail_beyond_file_size_limit();
    if let Err(unknown) = InstructionSet::from_environment() {
        report::error(
            &format!("{}: {unknown}", InstructionSet::VARIABLE),
            "unset it to use all that the processor has",
        );
        return ExitCode::from(Exit::Usage.code());
    }
    // A last net: no input should get here, and if one does it is a fault of ours, said shortly.
    let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| match &cli.command {
        Command::Render(args) => render::run(args, &cli.verbosity),
        Command::View(args) => view::run(args),
        Command::Info(args) => info::run(args, &cli.verbosity),
        Command::Check(args) => check::run(args, &cli.verbosity),
        Command::Convert(args) => convert::run(args, &cli.verbosity),
        Command::Diff(args) => diff::run(args, &cli.verbosity),
        Command::Trace(args) => trace::run(args, &cli.verbosity),
        Command::Schema => schema::run(),
        Command::Completions(args) => shell::completions(args.shell),
        Command::Man => shell::man(),
    }));
    let code = ended.map_or(1, Exit::code);
    // A result that could not be written is no success.
    ExitCode::from(if code == 0 && terminal::has_failed() { 1 } else { code })
}
