//! `--memory-limit`, and what is said while files are read.

use super::{Folder, text};
use penombre_image::{Image, WriteOptions, save};
use std::fmt::Write;
use std::time::Instant;

/// A folder with a scene of a large picture and a mesh.
fn textured(edge: u32) -> Folder {
    let folder = Folder::new();
    save(&folder.path("large.png"), &Image::new(edge, edge, 3), &WriteOptions::default()).unwrap();
    let scene = "penombre = 1\n[texture.t]\ntype = \"image\"\nfile = \"large.png\"\n\
                 [material.m]\ntype = \"diffuse\"\ncolor = { texture = \"t\" }\n\
                 [shape.s]\ntype = \"mesh\"\nfile = \"m.obj\"\nmaterial = \"m\"\n\
                 [light.l]\ntype = \"point\"\nposition = [1, 1, 3]\n";
    folder.write("scene.toml", scene);
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder
}

/// A height field as OBJ, with 2·n² triangles.
fn field(n: u32) -> String {
    let mut text = String::new();
    for i in 0..(n + 1) * (n + 1) {
        let (x, y) = (f64::from(i % (n + 1)) / f64::from(n), f64::from(i / (n + 1)) / f64::from(n));
        _ = writeln!(text, "v {x:.5} {y:.5} {:.5}", 0.1 * (9.0 * x * y).fract());
    }
    for i in (1..(n + 1) * n).filter(|i| i % (n + 1) != 0) {
        _ = writeln!(text, "f {i} {} {}\nf {i} {} {}", i + 1, i + n + 2, i + n + 2, i + n + 1);
    }
    text
}

#[test]
fn what_is_too_large_is_refused_at_once_and_its_parts_are_listed() {
    let folder = textured(4096);
    folder.write("field.obj", &field(300));
    let cases: [(&[&str], &str, &str); 7] = [
        (&["render", "scene.toml"], "40M", "needed: images 48.0 MiB, film"),
        (&["info", "scene.toml"], "0.04G", "needed: images 48.0 MiB"),
        (&["check", "scene.toml"], "40MiB", "needed: images 48.0 MiB"),
        (&["trace", "scene.toml", "--pixel", "1,1"], "40MB", "needed: images 48.0 MiB"),
        (&["render", "cornell", "--size", "4000x4000"], "1G", "needed: film 1.1 GiB, image files"),
        (
            &["render", "cornell", "--size", "2000x2000", "--aov", "normal,variance"],
            "1G",
            "needed: film 1.4 GiB",
        ),
        (&["render", "field.obj", "--size", "64x48"], "32M", "needed: the acceleration structure 3"),
    ];
    for (arguments, limit, expected) in cases {
        let begin = Instant::now();
        let output = folder.run(&[arguments, &["--memory-limit", limit]].concat());
        assert!(begin.elapsed().as_secs_f32() < 2.0, "{arguments:?}");
        let said = text(&[output.stdout, output.stderr].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected) && said.contains("`--memory-limit` is"), "{arguments:?}: {said}");
        assert!(said.contains("help: nothing was built; "), "{said}");
        assert_eq!(said.matches("of memory are needed").count(), 1, "{said}");
    }
    // With enough of it all is well, and single paths need no film.
    folder.ok(&["render", "cornell", "--size", "64x48", "--spp", "1", "--memory-limit", "1G"]);
    folder.ok(&["trace", "cornell", "--size", "4000x4000", "--pixel", "1,1", "--memory-limit", "1G"]);
    for bad in ["8X", "-1", "12", "much"] {
        let said = folder.refused(&["render", "cornell", "--memory-limit", bad]);
        assert!(said.contains(bad) && said.contains("512M") || said.contains("GiB"), "{said}");
    }
}

#[test]
fn without_a_limit_the_machine_is_the_limit() {
    // About 180 GB. A machine that has them would render it.
    let table = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total = table.split_whitespace().nth(1).and_then(|n| n.parse::<u64>().ok());
    if total.is_none_or(|kilobytes| kilobytes > 150_000_000) {
        eprintln!(
            "NOT RUN: without_a_limit_the_machine_is_the_limit (for Linux with at most 150 GB of memory)"
        );
        return;
    }
    let folder = Folder::new();
    let layers = "albedo,normal,position,depth,uv,variance";
    let begin = Instant::now();
    let said =
        folder.refused(&["render", "cornell", "--size", "16384x16384", "--aov", layers, "--time", "1"]);
    assert!(begin.elapsed().as_secs_f32() < 2.0);
    assert!(said.contains("needed: film ") && said.contains(" are free"), "{said}");
    // Its pixels are none that this machine must hold to say what is in the scene.
    folder.ok(&["info", "cornell", "--size", "16384x16384"]);
}

/// The estimate is near the measured peak: never below 0.9 of it, nor above twice.
#[cfg(target_os = "linux")]
#[test]
fn estimates_are_near_the_peaks_that_are_measured() {
    let folder = textured(4096);
    folder.write("field.obj", &field(250));
    let runs: [&[&str]; 5] = [
        &["cornell"],
        &["scene.toml", "--size", "64x64"],
        &["field.obj"],
        &["cornell", "--size", "1500x1500"],
        &["cornell", "--size", "1000x1000", "--aov", "normal,albedo,variance", "-o", "a.exr"],
    ];
    for run in runs {
        let fixed = ["--spp", "1", "--integrator", "aov", "--threads", "2", "--json"];
        let line = folder.json(&[&["render"], run, &fixed].concat());
        let number = |key: &str| line[key].as_f64().unwrap();
        let ratio = number("memory_estimate_mb") / number("peak_rss_mb");
        assert!((0.9..2.0).contains(&ratio), "{run:?}: {ratio} {line}");
    }
}

#[test]
fn files_are_told_with_their_contents_when_asked() {
    let folder = textured(64);
    let output = folder.run(&["check", "scene.toml", "-v"]);
    let said = text(&output.stderr);
    let lines: Vec<&str> = said.lines().filter(|l| l.ends_with(" s")).collect();
    assert_eq!(lines.len(), 2, "{said}");
    assert!(said.contains("m.obj: 32 B, 1 triangles, ") && said.contains("large.png: "), "{said}");
    assert!(said.contains(", 64×64 pixels, "), "{said}");
    assert!(!text(&folder.run(&["check", "scene.toml"]).stderr).contains("triangles"));
}

/// Before the first sample, and soon: what is wrong with files, outputs and memory.
#[test]
fn wrong_set_ups_are_told_at_once() {
    let folder = textured(512);
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    folder.write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    folder.write("broken.png", "no image");
    let long = ["--spp", "100000", "--size", "2000x2000"];
    let texture = |file: &str| format!("texture.t.file=\"{file}\"");
    let (missing, broken, outside) = (texture("none.png"), texture("broken.png"), texture("../x.png"));
    let cases: [(&[&str], &str); 13] = [
        (&["none.toml"], "there is no file `none.toml`"),
        (&["broken.obj"], "broken.obj"),
        (&["scene.toml", "--set", &missing], "there is no file `none.png`"),
        (&["scene.toml", "--set", &broken], "broken.png"),
        (&["scene.toml", "--set", &outside], "--asset-root"),
        (&["scene.toml", "-o", "none/a.png"], "none"),
        (&["scene.toml", "-o", "folder.png"], "it is a folder"),
        (&["scene.toml", "-o", "a.tiff"], ".tiff"),
        (&["scene.toml", "-o", "a"], "extension"),
        (&["scene.toml", "-o", "a.png", "-o", "./a.png"], "asked for twice"),
        (&["scene.toml", "--camera", "none"], "no such camera"),
        (&["scene.toml", "--aov", "normal", "-o", "-"], "no file for the layers"),
        (&["scene.toml", "--memory-limit", "100M"], "of memory are needed"),
    ];
    for (arguments, expected) in cases {
        let begin = Instant::now();
        let said = folder.refused(&[&["render"], arguments, &long].concat());
        assert!(begin.elapsed().as_secs_f32() < 2.0, "{arguments:?}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}
