//! Project tasks: `cargo xtask test [--slow] | fmt [--check] | tidy | gallery | contact-sheet DIR | fuzz | bench [NAME] | help`.
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command of the workshop talks to a person")]

mod bench;
mod contact_sheet;
mod format;
mod fuzz;
mod gallery;
mod json;
mod run;
mod test;
mod tidy;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask TASK

  test [--slow]    everything that must hold before a change is taken: format, tidy, clippy, tests, documentation,
                   release build, the window on a virtual screen, comparison with the oracle. --slow adds long sweeps
                   and the unoptimised build
  fmt [--check]    rustfmt over every source file, also those that `cargo fmt` does not find
  tidy             house rules: crate and room graph, lengths, forbidden calls, citations
  gallery          renders the pictures of the README into docs/images/
  contact-sheet DIR  draws all meshes, scenes and images below a folder into target/contact-sheet/sheet.png
  fuzz [TARGET…]   the fuzz targets of fuzz/, all or those named: --minutes N of processor time each (default: 1); --keep
                   takes inputs that reach more into the kept corpus. Needs cargo-fuzz and a C++ compiler
  bench [NAME]     figures on this machine: kernels, cornell (default: both); agree: where the kernels and Embree differ,
                   who is right; scale: from 10^3 to 10^7 triangles, and 10^6 instances; window: how soon it shows input.
                   kernels and agree take options: --only NAME-PART of a built-in mesh, --mesh FILE (OBJ or OFF,
                   repeatable), --rays N, --reps N, --json; scale: --largest TRIANGLES, --instances N, --rays N, --reps N,
                   --svg FILE, --json; with EMBREE_LIB naming Embree 4's library they compare (agree needs it).
                   peers: against other renderers, options are those of peers/bench.py; load: a mesh of 2 million triangles beside
                   Mitsuba, --reps N, --edge N; convergence: error by samples per
                   pixel, --most N; noise: true by promised error of --noise, --size N, --spp N. They need the test data's
                   `peers`, installed by its setup.sh
  help             this page

Needs: the toolchain of rust-toolchain or rust-version with rustfmt and clippy, a C linker (Debian: build-essential),
python3 for the oracle and the window, and for the window xvfb, xdotool and a Vulkan driver. On Debian, as root, `test`
installs what is missing of these.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["test"] => test::run(false),
        ["test", "--slow"] => test::run(true),
        ["fmt"] => format::run(false),
        ["fmt", "--check"] => format::run(true),
        ["tidy"] => tidy::run(),
        ["gallery"] => gallery::run(),
        ["contact-sheet", folder] => contact_sheet::run(folder),
        ["fuzz", options @ ..] => fuzz::run(options),
        ["bench"] => bench::run(None, &[]),
        ["bench", name, options @ ..] => bench::run(Some(name), options),
        [] | ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        other => {
            eprintln!("error: unknown task `{}`\n\n{HELP}", other.join(" "));
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
