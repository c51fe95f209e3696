//! Figures on this machine.

mod convergence;
mod noise;
mod peers;
mod plot;

use crate::json;
use crate::run::{Call, Outcome, built, release_binary, test_data};
use crate::test::python;
use crate::test::window::Screen;
use std::path::{Path, PathBuf};

const RUNS: usize = 3;

/// All benchmarks.
const NAMES: [&str; 9] =
    ["kernels", "agree", "scale", "cornell", "window", "peers", "load", "convergence", "noise"];

/// Runs the benchmark called `name`, or those that take neither a virtual screen nor long: the kernels' and the box. Those of
/// the kernels take options.
pub fn run(name: Option<&str>, options: &[&str]) -> Outcome {
    match (name, options) {
        (Some("kernels"), _) => kernels(None, options),
        (Some(name @ ("agree" | "scale")), _) => kernels(Some(name), options),
        (Some("cornell"), []) => cornell(),
        (Some("window"), []) => window(),
        (Some("peers"), _) => peers::run(options),
        (Some("load"), _) => peers::load(options),
        (Some("convergence"), _) => convergence::run(options),
        (Some("noise"), _) => noise::run(options),
        (None, _) => kernels(None, &[]).and_then(|()| cornell()),
        (Some(name @ ("cornell" | "window")), _) => Err(format!("the benchmark `{name}` takes no options")),
        (Some(other), _) => Err(format!("no benchmark `{other}`: {}", NAMES.join(", "))),
    }
}

/// Times the ray kernels, or does something else with them that has a name; against Embree if `EMBREE_LIB` names its
/// library.
fn kernels(task: Option<&str>, options: &[&str]) -> Outcome {
    let options = with_absolute_files(options)?;
    let mut words = vec!["bench", "-p", "penombre-bvh", "--bench", "kernels", "--"];
    words.extend(task);
    words.extend(options.iter().map(String::as_str));
    let mut call = Call::cargo(&words);
    if let Some(folder) = test_data() {
        call = call.env("PENOMBRE_TESTDATA", absolute(folder)?);
    }
    if let Some(library) = std::env::var_os("EMBREE_LIB").filter(|l| Path::new(l).is_file()) {
        call = call.env("EMBREE_LIB", absolute(library)?);
    }
    call.status()
}

/// The benchmark runs in the folder of its crate: files that follow `--mesh` and `--svg` are made independent of the
/// folder. A leading `--` is left out.
fn with_absolute_files(options: &[&str]) -> Result<Vec<String>, String> {
    let options = options.strip_prefix(&["--"]).unwrap_or(options);
    let mut words = Vec::new();
    for (i, option) in options.iter().enumerate() {
        let is_file = i > 0 && ["--mesh", "--svg"].contains(&options[i - 1]);
        words.push(if is_file {
            absolute(option)?.to_string_lossy().into_owned()
        } else {
            (*option).to_owned()
        });
    }
    Ok(words)
}

fn absolute(path: impl AsRef<Path>) -> Result<PathBuf, String> {
    let path = path.as_ref();
    std::path::absolute(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Builds the command for release.
fn build_command() -> Outcome {
    Call::cargo(&["build", "--release", "-p", "penombre-cli"]).status()
}

/// A temporary folder that goes away with this value.
#[derive(Debug)]
struct Folder(PathBuf);

impl Folder {
    fn new(purpose: &str) -> Result<Self, String> {
        let path = std::env::temp_dir().join(format!("penombre-{purpose}-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self(path))
    }

    fn path(&self) -> &Path {
        &self.0
    }

    /// The path of a file in it.
    fn file(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            eprintln!("{}: {error}", self.0.display());
        }
    }
}

/// relMSE of an image against another, as the command computes it.
fn rel_mse(image: &str, truth: &str) -> Result<f64, String> {
    let line =
        Call::new(release_binary(), &["diff", image, truth, "--json", "--tolerance", "3e38"]).output()?;
    json::number(&line, "rel_mse").ok_or_else(|| format!("no number `rel_mse` in: {line}"))
}

/// The whole number above 0 that follows an option.
fn number_option(options: &[&str], name: &str, default: u32) -> Result<u32, String> {
    let options = options.strip_prefix(&["--"]).unwrap_or(options);
    let Some(place) = options.iter().position(|o| *o == name) else { return Ok(default) };
    let value = options.get(place + 1).and_then(|v| v.parse().ok()).filter(|v| *v > 0);
    value.ok_or_else(|| format!("`{name}`: expected a whole number above 0"))
}

/// Times the built-in box as the command renders it: median of three runs.
fn cornell() -> Outcome {
    build_command()?;
    let folder = Folder::new("bench")?;
    let image = folder.file("cornell.pfm");
    let render = Call::new(release_binary(), &["render", "cornell", "--json", "--no-progress", "-o", &image]);
    let lines: Vec<String> = (0..RUNS).map(|_| render.output()).collect::<Result<_, _>>()?;
    for (key, unit) in [("render_s", "s"), ("mrays_per_s", "Mrays/s"), ("msamples_per_s", "Msamples/s")] {
        let values: Option<Vec<f64>> = lines.iter().map(|line| json::number(line, key)).collect();
        let values = values.ok_or_else(|| format!("`{}`: no number `{key}` in its JSON", render.typed()))?;
        println!("cornell {key}: {:.3} {unit} (median of {RUNS})", median(values));
    }
    Ok(())
}

/// How soon the window shows input, on a virtual screen.
fn window() -> Outcome {
    let screen = Screen::find_or_install();
    if !screen.is_whole() {
        return Err(format!("the window's virtual screen: {}", screen.why_not()));
    }
    let python = python::find_or_install().ok_or("no python3 of 3.11 or newer")?;
    Call::cargo(&["build", "--release", "-p", "penombre-view"]).status()?;
    let measure = Call::new(python, &["-B", "tests/window/latency.py", "--json"]);
    measure.env("PENOMBRE_VIEW_BIN", built("release", "penombre-view")).status()
}

/// Middle value of an odd number of figures.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_is_the_middle_value() {
        assert!((median(vec![3.0, 1.0, 2.0]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn unknown_names_are_refused() {
        assert!(
            run(Some("nothing"), &[]).unwrap_err().contains("kernels, agree, scale, cornell, window, peers")
        );
        assert!(run(Some("window"), &["--json"]).unwrap_err().contains("takes no options"));
    }

    #[test]
    fn options_are_numbers_above_0() {
        assert_eq!(number_option(&["--", "--most", "64"], "--most", 4096), Ok(64));
        assert_eq!(number_option(&[], "--most", 4096), Ok(4096));
        assert!(number_option(&["--most", "x"], "--most", 1).is_err());
        assert!(number_option(&["--most"], "--most", 1).is_err());
    }

    #[test]
    fn files_of_the_kernels_benchmark_are_found_from_its_folder() {
        let words = with_absolute_files(&["--", "--only", "a.obj", "--mesh", "a.obj"]).unwrap();
        assert_eq!(words[..3], ["--only", "a.obj", "--mesh"]);
        assert!(Path::new(&words[3]).is_absolute() && words[3].ends_with("a.obj"), "{words:?}");
    }
}
