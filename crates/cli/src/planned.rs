//! Answers to command lines that do not parse, and to parts of the contract that this version does not have.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::io::Write;
use std::process::ExitCode;

/// Options and commands that are promised but not built: they get a plain word instead of "unexpected argument".
const PLANNED: &[&str] = &[
    "--at",
    "--checkpoint",
    "--checkpoint-every",
    "--resume",
    "--slice",
    "--frames",
    "--denoise",
    "--preview",
    "merge",
    "bench",
    "submit",
];

/// Prints what clap says of the command line, or that the thing is not built yet. Help and version are no faults.
pub fn answer(error: &clap::Error) -> ExitCode {
    let found = match error.get(ContextKind::InvalidArg).or_else(|| error.get(ContextKind::InvalidSubcommand))
    {
        Some(ContextValue::String(s)) => s.split(['=', ' ']).next().unwrap_or(s).to_owned(),
        _ => String::new(),
    };
    let unknown = matches!(error.kind(), ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand);
    if unknown && PLANNED.contains(&found.as_str()) {
        let text = format!(
            "error: `{found}` is planned but not built yet: this version ({}) does not have it\n  help: `penombre \
             --help` lists what there is\n",
            env!("CARGO_PKG_VERSION")
        );
        // A closed standard error leaves nobody to tell.
        let _ = std::io::stderr().write_all(text.as_bytes());
        return ExitCode::from(2);
    }
    let _ = error.print();
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}
