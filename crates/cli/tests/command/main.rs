//! The command as a user meets it: files, exit status, what is said where.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]
#![allow(clippy::print_stderr, reason = "what was not run is said")]

mod bits;
mod convert;
mod corpus;
mod editors;
mod hostile;
mod limits;
mod memory;
mod outside;
mod saves;
mod scenes;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A fresh folder in which the command runs.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_penombre"));
        command.args(arguments).current_dir(self.0.path()).env("NO_COLOR", "1");
        command
    }

    /// The command with that much memory for its data, bytes; on Linux, where a process can be limited so.
    fn limited(&self, arguments: &[&str], memory: u64) -> Command {
        if !cfg!(target_os = "linux") {
            return self.command(arguments);
        }
        let mut command = Command::new("sh");
        // The limit counts the stacks of threads, which are reserved and hardly used: 2 MiB each, two for a processor.
        let stacks = std::thread::available_parallelism().map_or(1, |n| n.get() as u64) << 22;
        let limit = format!("ulimit -d {} && exec \"$0\" \"$@\"", (memory + stacks) >> 10);
        command.args(["-c", &limit, env!("CARGO_BIN_EXE_penombre")]).args(arguments);
        command.current_dir(self.0.path()).env("NO_COLOR", "1");
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must succeed and returns standard output.
    fn ok(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    /// Runs what must be refused with status 2 and returns standard error.
    fn refused(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{arguments:?}: {}", text(&output.stdout));
        text(&output.stderr)
    }

    fn json(&self, arguments: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.ok(arguments)).unwrap()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The folder of test data of that name; tells if there is none.
fn test_data(part: &str) -> Option<PathBuf> {
    let root = std::env::var_os("PENOMBRE_TESTDATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let path = root.join(part);
    if path.exists() {
        return Some(path);
    }
    eprintln!("NOT RUN: the test data {part} is not there; set PENOMBRE_TESTDATA to its folder");
    None
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

const SMALL: [&str; 4] = ["--size", "24x16", "--spp", "2"];

fn small<'a>(before: &[&'a str], after: &[&'a str]) -> Vec<&'a str> {
    [before, &SMALL, after].concat()
}

#[test]
fn the_default_output_is_the_scenes_name_and_its_path_size_and_time_are_said() {
    let folder = Folder::new();
    let said = folder.ok(&small(&["render", "cornell"], &[]));
    assert!(said.starts_with("cornell.png  24×16, 2 spp, ") && said.contains(" s, "), "{said}");
    assert_eq!(names(folder.0.path()), ["cornell.png"]);
}

#[test]
fn every_format_is_written_and_read_back() {
    let folder = Folder::new();
    let files = ["a.png", "a.jpg", "a.ppm", "a.pfm", "a.exr", "a.hdr", "a.tga", "a.bmp", "a.webp"];
    let outputs: Vec<&str> = files.iter().flat_map(|f| ["-o", f]).collect();
    let said = folder.ok(&small(&["render", "cornell", "--tone", "srgb"], &outputs));
    assert_eq!(said.lines().count(), files.len());
    folder.ok(&["diff", "a.pfm", "a.exr"]);
    folder.ok(&["diff", "a.png", "a.ppm", "--tolerance", "1e-6"]);
    for file in files {
        let line = folder.run(&["diff", file, "a.pfm", "--json"]);
        let found: serde_json::Value = serde_json::from_slice(&line.stdout).unwrap();
        assert!(found["psnr"].as_f64().is_none_or(|p| p > 15.0), "{file}: {found}");
    }
}

#[test]
fn clamping_is_said() {
    let folder = Folder::new();
    let arguments = ["--integrator", "path", "--json", "--set", "integrator.path.clamp=0.5"];
    let output = folder.run(&small(&["render", "cornell"], &arguments));
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["clamp"], 0.5);
    assert!(text(&output.stderr).contains("limited to 0.5"), "{}", text(&output.stderr));
    let line = folder.json(&small(&["render", "cornell"], &arguments[..3]));
    assert!(line["clamp"].is_null());
}

#[test]
fn tone_curves_change_8_bit_files_only() {
    let folder = Folder::new();
    let curves = ["raw", "srgb", "agx", "aces", "pbr-neutral", "filmic"];
    let bytes = |name: &str| std::fs::read(folder.0.path().join(name)).unwrap();
    let mut files = Vec::new();
    for curve in curves {
        let (ppm, pfm) = (format!("{curve}.ppm"), format!("{curve}.pfm"));
        let options = ["--tone", curve, "--exposure", "0.5", "-o", ppm.as_str(), "-o", pfm.as_str()];
        folder.ok(&small(&["render", "cornell"], &options));
        assert_eq!(bytes(&pfm), bytes("raw.pfm"), "{curve}");
        assert!(!files.contains(&bytes(&ppm)), "{curve}");
        files.push(bytes(&ppm));
    }
    // The default of the course's integrator.
    folder.ok(&small(&["render", "cornell"], &["--exposure", "0.5", "-o", "default.ppm"]));
    assert_eq!(bytes("default.ppm"), files[0]);
}

#[test]
fn statistics_have_the_keys_of_the_contract() {
    let folder = Folder::new();
    let line = folder.json(&small(&["render", "cornell"], &["--json", "--threads", "2"]));
    let keys = "scene integrator width height spp samples rays load_s build_s render_s cpu_s msamples_per_s \
                mrays_per_s threads peak_rss_mb bvh_mb triangles instances mean error non_finite digest outputs";
    for key in keys.split_whitespace() {
        assert!(line.get(key).is_some(), "{key} is missing in {line}");
    }
    assert_eq!(line["samples"], 24 * 16 * 2);
    assert_eq!(line["mean"].as_array().unwrap().len(), 3);
    assert_eq!(line["digest"].as_str().unwrap().len(), 64);
    assert_eq!(line["outputs"], serde_json::json!(["cornell.png"]));
}

#[test]
fn threads_tiles_and_outputs_change_no_bit_and_seeds_do() {
    let folder = Folder::new();
    let digest = |more: &[&str]| {
        folder.json(&small(&["render", "cornell", "--json"], more))["digest"].as_str().unwrap().to_owned()
    };
    let expected = digest(&[]);
    for more in [["--threads", "1"], ["--threads", "3"], ["--tile", "8"], ["--tile", "17"], ["-o", "b.exr"]] {
        assert_eq!(digest(&more), expected, "{more:?}");
    }
    assert_ne!(digest(&["--seed", "1"]), expected);
}

#[test]
fn instruction_sets_change_no_bit() {
    let folder = Folder::new();
    let render = |scene: &str, phase: &str, set: &str| {
        let options = ["--integrator", "classic", "--phase", phase, "--json"];
        let mut command = folder.command(&small(&["render", scene], &options));
        let output = command.env("PENOMBRE_INSTRUCTIONS", set).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        line["digest"].as_str().unwrap().to_owned()
    };
    // A waved sheet: enough triangles for nodes and leaves.
    let vertex = |i: u32| format!("v {} {} {}\n", i % 40, f64::from(i % 40 * (i / 40)).sin() * 2.0, i / 40);
    let face = |i: u32| format!("f {} {} {} {}\n", i + 1, i + 2, i + 42, i + 41);
    let faces = (0..39 * 40).filter(|i| i % 40 < 39).map(face);
    folder.write("waves.obj", &(0..1600).map(vertex).chain(faces).collect::<String>());
    for scene in ["sphere", "square", "cornell", "sphere-as-given", "cornell-as-given", "waves.obj"] {
        for phase in ["2", "4"] {
            let expected = render(scene, phase, "portable");
            // A set that the processor does not have is not used.
            for set in ["avx2", "avx512"] {
                assert_eq!(render(scene, phase, set), expected, "{scene}, phase {phase}, {set}");
            }
        }
    }
    let unknown =
        folder.command(&["render", "sphere"]).env("PENOMBRE_INSTRUCTIONS", "sse9").output().unwrap();
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("`sse9` is no set of instructions"), "{}", text(&unknown.stderr));
}

#[test]
fn standard_output_takes_a_whole_png_and_nothing_else() {
    let folder = Folder::new();
    let output = folder.run(&small(&["render", "square"], &["-o", "-", "--json"]));
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.starts_with(b"\x89PNG\r\n\x1a\n") && output.stdout.ends_with(b"IEND\xaeB`\x82"));
    assert!(text(&output.stderr).contains("\"digest\""));
    assert!(names(folder.0.path()).is_empty());
}

#[test]
fn a_png_without_curve_reads_back_as_what_was_rendered() {
    let folder = Folder::new();
    folder.ok(&small(&["render", "square"], &["-o", "a.png", "-o", "a.exr"]));
    folder.ok(&["diff", "a.png", "a.exr", "--tolerance", "0.002"]);
    let said = folder.refused(&["diff", "a.png", "a.exr", "-o", "a.png"]);
    assert!(said.contains("would replace"), "{said}");
}

#[test]
fn the_courses_format_is_exact() {
    let folder = Folder::new();
    folder.ok(&[
        "render",
        "sphere",
        "--phase",
        "1",
        "--size",
        "5x4",
        "--spp",
        "1",
        "--disable-pixel-jitter",
        "--course-ppm",
        "-o",
        "rendu.ppm",
    ]);
    let written = std::fs::read_to_string(folder.path("rendu.ppm")).unwrap();
    let lines: Vec<&str> = written.split('\n').collect();
    assert_eq!(lines[..3], ["P3", "5 4", "255"]);
    assert_eq!(lines.len(), 5, "all pixels on one line, then an end of line");
    assert_eq!(lines[4], "");
    // 5 × 4 pixels of a sphere of radius 0.8 pixels: the two nearest the middle are white.
    let (black, white) = ("0 0 0 ", "255 255 255 ");
    let row = [black, black, white, black, black].concat();
    assert_eq!(lines[3], [black.repeat(5), row.clone(), row, black.repeat(5)].concat());
}

#[test]
fn pictures_tell_how_they_were_made() {
    let folder = Folder::new();
    folder.ok(&small(&["render", "cornell", "--seed", "7"], &[]));
    let bytes = text(&std::fs::read(folder.path("cornell.png")).unwrap());
    for part in ["penombre:scene-digest", "penombre render cornell --seed 7", "penombre:spp", "Software"] {
        assert!(bytes.contains(part), "{part}");
    }
}

#[test]
fn wrong_places_to_write_are_told_before_the_first_sample() {
    let folder = Folder::new();
    folder.write("file", "");
    let long = ["--spp", "1000000"];
    for (output, expected) in [
        ("a.xyz", "xyz"),
        ("noextension", "extension"),
        ("nowhere/a.png", "nowhere/a.png"),
        ("file/a.png", "file/a.png"),
    ] {
        let said = folder.refused(&[&["render", "cornell", "-o", output], long.as_slice()].concat());
        assert!(said.contains(expected), "{output}: {said}");
    }
}

#[test]
fn wrong_command_lines_are_refused() {
    let folder = Folder::new();
    for (arguments, expected) in [
        (vec!["render", "cornell", "--denoise"], "not built yet"),
        (vec!["render", "cornell", "--resume"], "not built yet"),
        (vec!["merge", "a.part"], "not built yet"),
        (vec!["convert", "cornell", "a.glb"], "scenes are written as .toml or .json only"),
        (vec!["convert", "a.png"], "an image or scene and its new name"),
        (vec!["render", "cornell", "--nose", "0.1"], "--nose"),
        (vec!["render", "cornell", "--size", "0x4"], "0x4"),
        (vec!["render", "cornell", "--spp", "0"], "--spp"),
        (vec!["render", "cornell", "--spp", "-1"], "--spp"),
        (vec!["render", "cornell", "--size", "-1x5"], "whole number of pixels"),
        (vec!["render", "cornell", "--size", "65536x65536"], "pixels"),
        (vec!["render", "cornell", "--course-ppm"], "no output ends in .ppm"),
        (vec!["render", "cornell", "-o", "a.png", "-o", "./a.png"], "twice"),
        (vec!["render", "cornell", "-o", "."], "is a folder"),
        (vec!["render", "cornell", "--phase", "5"], "--phase"),
        (vec!["render", "cornell", "--tone", "AgX"], "raw, srgb, agx, aces, pbr-neutral, filmic"),
        (vec!["render", "cornell", "--integrator", "pat"], "did you mean `path`"),
        (vec!["render", "cornell", "--integrator", "path", "--phase", "3"], "add --integrator classic"),
        (
            vec!["render", "cornell", "--integrator", "ao", "--hard-shadows"],
            "option of the integrator classic",
        ),
        (vec!["render", "cornell", "--set", "integrator.aov.layer=\"normals\""], "did you mean `normal`"),
        (vec!["render", "cornell", "--camera", "left"], "no such camera"),
        (vec!["render", "cornel"], "did you mean `cornell`"),
        (vec!["render", "nowhere.toml"], "nowhere.toml"),
        (vec!["render", "cornell", "--set", "camera.fov=200"], "fov"),
        (vec!["trace", "cornell", "--pixel", "480,0"], "outside"),
    ] {
        let said = folder.refused(&arguments);
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(!said.contains("panicked") && !said.contains("internal fault"), "{said}");
    }
    assert!(names(folder.0.path()).is_empty());
}

#[test]
fn check_tells_all_faults_for_people_and_programs() {
    let folder = Folder::new();
    folder.write("a.toml", "penombre = 1\n[shape.ball]\ntype = \"sphere\"\nradius = -1\nradios = 2\n");
    let output = folder.run(&["check", "a.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("a.toml:4:10") && said.contains("a.toml:5:1"), "{said}");
    assert!(said.contains("did you mean `radius`"), "{said}");
    let output = folder.run(&["check", "a.toml", "--json"]);
    assert_eq!(output.status.code(), Some(2));
    let faults: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        faults.as_array().unwrap().iter().any(|f| f["line"] == 4 && f["severity"] == "error"),
        "{faults}"
    );
    folder.ok(&["check", "cornell"]);
}

#[test]
fn info_and_trace_speak_to_people_and_programs() {
    let folder = Folder::new();
    assert!(folder.ok(&["info", "cornell"]).contains("6 quad, 2 sphere"));
    let info = folder.json(&["info", "cornell", "--json"]);
    assert_eq!(info["shapes"]["quad"], 6);
    assert_eq!(info["cameras"], serde_json::json!(["main"]));
    assert!(info["bvh_nodes"].as_u64() >= Some(1) && info["bvh_build_s"].as_f64() > Some(0.0), "{info}");
    assert!(folder.ok(&["trace", "cornell", "--pixel", "330,380"]).contains("refraction from vertex 0"));
    let path = folder.json(&["trace", "cornell", "--pixel", "330,380", "--sample", "3", "--json"]);
    let vertices = path["vertices"].as_array().unwrap();
    assert_eq!(vertices[0]["surface"]["material_type"], "glass");
    assert!(vertices.len() > 4);
}

#[test]
fn diff_ends_with_0_1_or_2() {
    let folder = Folder::new();
    folder.ok(&small(&["render", "cornell"], &["-o", "a.pfm"]));
    folder.ok(&small(&["render", "cornell", "--seed", "1"], &["-o", "b.pfm"]));
    folder.ok(&["render", "cornell", "--size", "8x8", "--spp", "1", "-o", "c.pfm"]);
    assert!(folder.ok(&["diff", "a.pfm", "a.pfm"]).starts_with("equal"));
    let output = folder.run(&["diff", "a.pfm", "b.pfm", "-o", "heat.png"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).starts_with("different"));
    assert!(folder.path("heat.png").is_file());
    folder.ok(&["diff", "a.pfm", "b.pfm", "--tolerance", "10"]);
    assert!(folder.refused(&["diff", "a.pfm", "c.pfm"]).contains("24"));
    assert!(folder.refused(&["diff", "a.pfm", "none.pfm"]).contains("none.pfm"));
}

/// Starts a long render, waits for `started` and asks it to stop.
#[cfg(unix)]
fn interrupted(folder: &Folder, signal: &str) -> Output {
    use std::process::Stdio;
    let mut command =
        folder.command(&["render", "cornell", "--size", "64x64", "--spp", "10000000", "-o", "out.png"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_saves_what_it_has() {
    for signal in ["-INT", "-TERM"] {
        let folder = Folder::new();
        let output = interrupted(&folder, signal);
        assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("interrupted"));
        assert_eq!(names(folder.0.path()), ["out.png"]);
        folder.ok(&["diff", "out.png", "out.png"]);
    }
}

/// `penombre` with nothing beside it, and a `penombre-view` that says what it was given and ends with status 7.
#[cfg(unix)]
struct Bench(Folder);

#[cfg(unix)]
impl Bench {
    /// On the disk of the command itself, so that a link will do: a program that was just written cannot be started
    /// while another thread starts one too.
    fn new() -> Self {
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        std::fs::hard_link(env!("CARGO_BIN_EXE_penombre"), folder.path().join("penombre")).unwrap();
        Self(Folder(folder))
    }

    /// Writes the program into a new folder below, by another process for the same reason.
    fn program(&self, folder: &str, script: &str) {
        std::fs::create_dir_all(self.0.path(folder)).unwrap();
        let write = "printf '#!/bin/sh\\n%s\\n' \"$1\" > \"$2\" && chmod +x \"$2\"";
        let file = self.0.path(folder).join("penombre-view");
        let written = Command::new("sh").args(["-c", write, "sh", script]).arg(file).status().unwrap();
        assert!(written.success());
    }

    /// Runs `penombre view` with the folders on the PATH.
    fn view(&self, folders: &str, arguments: &[&str]) -> Output {
        let mut command = Command::new(self.0.path("penombre"));
        command.arg("view").args(arguments).current_dir(self.0.0.path());
        command.env("PATH", folders).output().unwrap()
    }
}

#[cfg(unix)]
#[test]
fn the_window_is_started_with_what_was_given_and_its_status_is_passed_on() {
    let bench = Bench::new();
    bench.program("path", "printf '[%s]' path \"$@\"; exit 7");
    let path = bench.0.path("path").display().to_string();
    let given: [&[&str]; 4] = [
        &[],
        &["cornell"],
        &["--live"],
        &["a b.toml", "--set", "camera.fov=40", "--size", "8x9", "--asset-root", "../x", "--set=a=[1, 2]"],
    ];
    for arguments in given {
        let output = bench.view(&path, arguments);
        let expected: String = [&["path"], arguments].concat().iter().map(|a| format!("[{a}]")).collect();
        assert_eq!(text(&output.stdout), expected, "{}", text(&output.stderr));
        assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(7), ""));
    }
    // The one beside the command comes first.
    bench.program(".", "echo beside");
    let output = bench.view(&path, &["cornell"]);
    assert_eq!((text(&output.stdout).as_str(), output.status.code()), ("beside\n", Some(0)));
    bench.program(".", "kill -9 $$");
    assert_eq!(bench.view(&path, &["cornell"]).status.code(), Some(1), "ended by a signal");
}

#[cfg(unix)]
#[test]
fn a_missing_window_is_told_with_what_to_do() {
    let bench = Bench::new();
    let output = bench.view("/nowhere", &["cornell"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for part in
        ["penombre-view", "cargo build --release -p penombre-view", "cargo install --path crates/view"]
    {
        assert!(said.contains(part), "{said}");
    }
    // What cannot be run is told as well.
    std::fs::write(bench.0.path("penombre-view"), "").unwrap();
    let output = bench.view("/nowhere", &["cornell"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("cannot run"), "{}", text(&output.stderr));
}
