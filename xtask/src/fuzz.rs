//! `cargo xtask fuzz`: the fuzz targets of `fuzz/` for so many minutes of processor time each.
//!
//! New inputs gather in `fuzz/target/corpus/TARGET`, findings in `fuzz/artifacts/TARGET`. `--keep` takes those inputs
//! into the kept corpus that lead where none of it leads; the normal tests replay it.

use crate::run::{Call, Outcome, root};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Minutes of processor time of a target unless told otherwise.
const MINUTES: f64 = 1.0;
/// Longest input, bytes: headers and a few elements; what is longer finds little and takes long.
const MAX_LENGTH: &str = "-max_len=4096";
/// Longest input that is kept, bytes.
const MAX_KEPT: &str = "-max_len=1024";
/// What counts when inputs are kept is whether code is reached, not how often.
const REACH: &str = "-use_counters=0";
/// Ticks of the processor time in `/proc/PID/stat` each second, on all Linux systems.
const TICKS: f64 = 100.0;
/// What libFuzzer ends with when it is interrupted.
const INTERRUPTED: i32 = 72;

/// What the command line asks for.
#[derive(Debug, PartialEq)]
struct Options {
    targets: Vec<String>,
    minutes: f64,
    keep: bool,
}

/// Fuzzes the targets that are named, or all.
pub fn run(words: &[&str]) -> Outcome {
    let options = parse(words, &targets()?)?;
    let build = fuzzer(&["build", "-s", "none"])?;
    build.status()?;
    for target in &options.targets {
        let said = fuzz(target, options.minutes * 60.0)?;
        println!("{target}: {said}");
        if options.keep {
            keep(target)?;
        }
    }
    Ok(())
}

fn parse(words: &[&str], known: &[String]) -> Result<Options, String> {
    let mut options = Options { targets: Vec::new(), minutes: MINUTES, keep: false };
    let mut words = words.iter();
    while let Some(word) = words.next() {
        match *word {
            "--keep" => options.keep = true,
            "--minutes" => {
                let minutes = words.next().and_then(|w| w.parse().ok()).filter(|m| *m > 0.0);
                options.minutes = minutes.ok_or("`--minutes`: expected a number above 0")?;
            }
            target if known.iter().any(|k| k == target) => options.targets.push(target.to_owned()),
            other => return Err(format!("no fuzz target `{other}`: {}", known.join(", "))),
        }
    }
    if options.targets.is_empty() {
        options.targets = known.to_vec();
    }
    Ok(options)
}

/// The names of all targets.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("fuzz/fuzz_targets");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let stem = |e: std::io::Result<std::fs::DirEntry>| Some(e.ok()?.path().file_stem()?.to_str()?.to_owned());
    let mut names: Vec<String> = entries.filter_map(stem).collect();
    names.sort();
    Ok(names)
}

/// `cargo fuzz`, which needs the flags of a nightly compiler.
fn fuzzer(words: &[&str]) -> Result<Call, String> {
    if !Call::cargo(&["fuzz", "--version"]).succeeds() {
        return Err("`cargo fuzz` is missing: cargo install cargo-fuzz --locked".to_owned());
    }
    // `cargo` of rustup knows `+nightly`, the one that started this program does not.
    if Call::new("cargo", &["+nightly", "--version"]).succeeds() {
        return Ok(Call::new("cargo", &[["+nightly", "fuzz"].as_slice(), words].concat()));
    }
    Ok(Call::new("cargo", &[["fuzz"].as_slice(), words].concat()).env("RUSTC_BOOTSTRAP", "1"))
}

/// The program of a target.
fn program(target: &str) -> PathBuf {
    let triple = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    root().join("fuzz/target").join(triple).join("release").join(target)
}

/// Runs a target and tells what it did. A finding is a failure.
fn fuzz(target: &str, seconds: f64) -> Result<String, String> {
    let folders =
        ["fuzz/target/corpus", "fuzz/corpus", "fuzz/artifacts"].map(|f| root().join(f).join(target));
    for folder in &folders {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    let [found, kept, artifacts] = folders;
    let log = root().join("fuzz/target").join(format!("{target}.log"));
    let file = File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
    let mut command = Command::new(program(target));
    command.args([&found, &kept]).arg(format!("-artifact_prefix={}/", artifacts.display()));
    command.args([MAX_LENGTH, "-timeout=100", "-rss_limit_mb=3000", "-print_final_stats=1"]);
    let words = root().join(format!("fuzz/dictionaries/{target}.dict"));
    if words.is_file() {
        command.arg(format!("-dict={}", words.display()));
    }
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file).spawn();
    let child = child.map_err(|e| format!("cannot start the target {target}: {e}"))?;
    let used = watch(child, seconds)?;
    let text = std::fs::read(&log).map_err(|e| format!("{}: {e}", log.display()))?;
    let text = String::from_utf8_lossy(&text);
    used.map(|used| summary(&text, used)).ok_or_else(|| {
        format!(
            "{target}: a finding, kept in {}; the end of {}:\n{}",
            artifacts.display(),
            log.display(),
            tail(&text)
        )
    })
}

/// Waits until a target has used so much processor time, and ends it. `None`: it ended by itself.
fn watch(mut child: Child, seconds: f64) -> Result<Option<f64>, String> {
    let mut used = 0.0;
    loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            return Ok((status.code() == Some(INTERRUPTED)).then_some(used));
        }
        used = cpu_seconds(child.id()).unwrap_or(used);
        if used >= seconds {
            Call::new("kill", &["-INT", &child.id().to_string()]).status()?;
            let status = child.wait().map_err(|e| e.to_string())?;
            return Ok(matches!(status.code(), Some(0 | INTERRUPTED)).then_some(used));
        }
        std::thread::sleep(Duration::from_millis(500));
    }
}

/// Processor time that a process has used.
fn cpu_seconds(process: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // Behind the name, which may hold anything: state is the first, the times are the 12th and 13th.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS)
}

/// Runs, reach and time.
fn summary(log: &str, used: f64) -> String {
    let last = |key: &str| {
        let after = log.rsplit_once(key).map_or("", |(_, after)| after).trim_start();
        after.split_whitespace().next().unwrap_or("?").to_owned()
    };
    let (runs, reach) = (last("stat::number_of_executed_units:"), last(" cov:"));
    format!("{runs} inputs in {used:.0} s of processor time, {reach} edges reached, no finding")
}

fn tail(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(20)..].join("\n")
}

/// Takes the inputs that reach more into the kept corpus.
fn keep(target: &str) -> Outcome {
    let [kept, found] = ["fuzz/corpus", "fuzz/target/corpus"].map(|f| root().join(f).join(target));
    let files = |folder: &Path| std::fs::read_dir(folder).map_or(0, Iterator::count);
    let before = files(&kept);
    let words = ["-set_cover_merge=1", REACH, MAX_KEPT, &kept.to_string_lossy(), &found.to_string_lossy()]
        .map(str::to_owned);
    let merge = Call::new(program(target), &words.each_ref().map(String::as_str));
    if !merge.succeeds() {
        return Err(format!("`{}` failed", merge.typed()));
    }
    println!("{target}: {before} inputs kept before, {} now", files(&kept));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_and_minutes_are_told_apart() {
        let known = ["obj".to_owned(), "ply".to_owned()];
        let options = parse(&["obj", "--minutes", "0.5", "--keep"], &known).unwrap();
        assert_eq!(options, Options { targets: vec!["obj".into()], minutes: 0.5, keep: true });
        assert_eq!(parse(&[], &known).unwrap().targets, known);
        assert!(parse(&["stl"], &known).unwrap_err().contains("obj, ply"));
        assert!(parse(&["--minutes", "0"], &known).is_err() && parse(&["--minutes"], &known).is_err());
    }

    #[test]
    fn every_reader_has_a_target() {
        let found = targets().unwrap();
        for name in
            ["obj", "mtl", "off", "ply", "stl", "gzip", "toml", "json", "scene", "png", "jpeg", "exr", "hdr"]
        {
            assert!(found.iter().any(|t| t == name), "{name}");
        }
    }

    #[test]
    fn a_log_is_summed_up() {
        let log = "#9\tREDUCE cov: 12 ft: 3\n#10\tDONE   cov: 15 ft: 4\nstat::number_of_executed_units: 77\n";
        let said = summary(log, 61.2);
        assert_eq!(said, "77 inputs in 61 s of processor time, 15 edges reached, no finding");
        assert_eq!(tail("a\nb"), "a\nb");
    }

    #[test]
    fn processor_time_of_this_process_is_known() {
        assert!(cpu_seconds(std::process::id()).is_some_and(|s| s >= 0.0));
    }
}
