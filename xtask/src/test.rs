//! `cargo xtask test`: every check in order, each announced and timed, stopping at the first that fails.

mod apt;
mod bits;
pub mod python;
mod strace;
mod tally;
pub mod window;

use std::time::Instant;

use crate::run::{Call, Outcome, release_binary, test_data};
use crate::{format, tidy};
use tally::Tally;
use window::Screen;

type Action = Box<dyn FnOnce(&mut Tally) -> Outcome>;

/// One check: its name, what to type to repeat it, and what it does.
struct Step {
    name: &'static str,
    repeat: String,
    action: Action,
}

impl Step {
    fn call(name: &'static str, call: Call) -> Self {
        Self { name, repeat: call.typed(), action: Box::new(move |_| call.status()) }
    }

    /// A run of `cargo test`, whose results are counted.
    fn tests(name: &'static str, call: Call) -> Self {
        let call = match test_data() {
            Some(folder) => call.env("PENOMBRE_TESTDATA", folder),
            None => call,
        };
        Self {
            name,
            repeat: call.typed(),
            action: Box::new(move |tally| call.lines(|line| tally.line(line))),
        }
    }
}

/// Runs all steps; `slow` adds the long ones.
pub fn run(slow: bool) -> Outcome {
    let mut tally = Tally::default();
    require_components()?;
    if test_data().is_none() {
        tally.not_run("NOT RUN: tests on the big corpora: no folder `shared` beside the workspace and no PENOMBRE_TESTDATA");
    }
    let python = python::find_or_install();
    if python.is_none() {
        tally.not_run("NOT RUN: comparison with the oracle: no python3 of 3.11 or newer (Debian: apt-get install python3)");
    }
    if !strace::is_there_or_installed() {
        tally.not_run("NOT RUN: what the command opens: no strace (Debian: apt-get install strace)");
    }
    // Before the tests: those of the window draw with the driver that may have to be installed.
    let screen = Screen::find_or_install();
    if !screen.is_whole() {
        tally.not_run(&format!("NOT RUN: the window under Xvfb: {}", screen.why_not()));
    }
    tally.print_not_run();
    run_steps(steps(slow, python.as_deref(), &screen), tally)
}

/// The steps in order: cheap ones first.
fn steps(slow: bool, python: Option<&str>, screen: &Screen) -> Vec<Step> {
    let clippy = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    let tests = window_tests(Call::cargo(&["test", "--workspace", "--", "--show-output"]), screen);
    let docs = Call::cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    let mut steps = vec![
        Step {
            name: "format",
            repeat: "cargo xtask fmt --check".into(),
            action: Box::new(|_| format::run(true)),
        },
        Step { name: "tidy", repeat: "cargo xtask tidy".into(), action: Box::new(|_| tidy::run()) },
        Step::call("clippy", Call::cargo(&clippy)),
        Step::tests("tests", tests),
        Step::call("documentation", docs),
        Step::call("release build", Call::cargo(&["build", "--release", "-p", "penombre-cli"])),
    ];
    if let Some(python) = python {
        steps.extend(window_steps(python, screen));
        let unit = Call::new(python, &["-B", "-m", "unittest", "discover", "tests/oracle"]);
        steps.push(Step::call("oracle's own tests", unit));
        let size = if slow { [].as_slice() } else { ["--quick"].as_slice() };
        let arguments = [["-B", "tests/oracle/compare.py"].as_slice(), size].concat();
        let compare = Call::new(python, &arguments).env("PENOMBRE_BIN", release_binary());
        steps.push(Step::call("comparison with the oracle", compare));
    }
    if slow {
        let sweeps = Call::cargo(&["test", "--workspace", "--release", "--", "--show-output"]);
        steps.push(Step::tests("slow tests", window_tests(sweeps.env("PENOMBRE_SLOW", "1"), screen)));
        steps.push(Step {
            name: "same bits without optimisation",
            repeat: "cargo xtask test --slow".into(),
            action: Box::new(|_| bits::compare_profiles()),
        });
    }
    steps
}

/// Tells a run of `cargo test` that tests which draw with Vulkan can run.
fn window_tests(tests: Call, screen: &Screen) -> Call {
    if screen.driver { tests.env("PENOMBRE_WINDOW_TESTS", "1") } else { tests }
}

/// The window from outside, and the tests of the programs that look at it.
fn window_steps(python: &str, screen: &Screen) -> Vec<Step> {
    let unit = Call::new(python, &["-B", "-m", "unittest", "discover", "tests/window"]);
    let mut steps = vec![Step::call("the window driver's own tests", unit)];
    if screen.is_whole() {
        let drive = window::drive_call(python);
        steps.push(Step {
            name: "the window under Xvfb",
            repeat: drive.typed(),
            action: Box::new(move |_| window::drive(&drive)),
        });
    }
    steps
}

fn run_steps(steps: Vec<Step>, mut tally: Tally) -> Outcome {
    let (count, start) = (steps.len(), Instant::now());
    let mut summary = Vec::new();
    let mut failure = None;
    for (i, step) in steps.into_iter().enumerate() {
        println!("\n=== {}/{count} {}: {}", i + 1, step.name, step.repeat);
        let begin = Instant::now();
        let outcome = (step.action)(&mut tally);
        let (word, seconds) = (if outcome.is_ok() { "ok" } else { "FAILED" }, begin.elapsed().as_secs_f64());
        println!("=== {word}: {} ({seconds:.1} s)", step.name);
        summary.push(format!("{word:>6} {seconds:7.1} s  {}", step.name));
        if let Err(message) = outcome {
            failure = Some(format!("{}: {message}\nrepeat it with: {}", step.name, step.repeat));
            break;
        }
    }
    println!("\n{}", summary.join("\n"));
    tally.print_totals();
    tally.print_not_run();
    let failed = usize::from(failure.is_some());
    println!("whole run: {:.0} s", start.elapsed().as_secs_f64());
    if failed > 0 {
        println!("steps after the failure, not run: {}", count - summary.len());
    }
    println!("{} passed, {failed} failed", summary.len() - failed);
    failure.map_or(Ok(()), Err)
}

/// Refuses to begin without the two components that a minimal toolchain lacks.
fn require_components() -> Outcome {
    for (command, component) in [("fmt", "rustfmt"), ("clippy", "clippy")] {
        if !Call::cargo(&[command, "--version"]).succeeds() {
            return Err(format!("`cargo {command}` is missing: rustup component add {component}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn names(steps: &[Step]) -> Vec<&str> {
        steps.iter().map(|s| s.name).collect()
    }

    #[test]
    fn the_oracle_needs_python_and_slow_adds_steps() {
        let steps = |slow, python| steps(slow, python, &Screen::default());
        let plain = steps(false, Some("python3"));
        assert!(plain.iter().any(|s| s.repeat.contains("compare.py --quick")));
        let slow = steps(true, Some("python3"));
        assert!(slow.iter().any(|s| s.repeat.ends_with("compare.py")));
        assert!(names(&slow).contains(&"slow tests") && !names(&plain).contains(&"slow tests"));
        assert!(!names(&steps(false, None)).iter().any(|n| n.contains("oracle")));
    }

    #[test]
    fn the_window_needs_its_screen_and_its_tests_are_told_of_the_driver() {
        let whole = Screen { driver: true, missing: Vec::new() };
        let found = steps(false, Some("python3"), &whole);
        assert!(found.iter().any(|s| s.repeat.contains("penombre-view") && s.repeat.contains("drive.py")));
        assert!(found.iter().any(|s| s.repeat.contains("PENOMBRE_WINDOW_TESTS=1 ")));
        let bare = steps(true, Some("python3"), &Screen { driver: false, missing: vec!["Xvfb"] });
        assert!(!bare.iter().any(|s| s.repeat.contains("drive.py") || s.repeat.contains("WINDOW_TESTS")));
        assert!(!names(&steps(false, None, &whole)).iter().any(|n| n.contains("window")));
    }

    #[test]
    fn a_failing_step_ends_the_run_and_names_the_command() {
        let ran = Arc::new(AtomicUsize::new(0));
        let step = |name, result: Outcome| {
            let ran = Arc::clone(&ran);
            let action: Action = Box::new(move |_| {
                ran.fetch_add(1, Ordering::Relaxed);
                result
            });
            Step { name, repeat: format!("type {name}"), action }
        };
        let steps = vec![step("one", Ok(())), step("two", Err("broke".into())), step("three", Ok(()))];
        let message = run_steps(steps, Tally::default()).unwrap_err();
        assert_eq!(ran.load(Ordering::Relaxed), 2);
        assert!(message.contains("two: broke") && message.contains("repeat it with: type two"));
    }
}
