//! Broken mesh files, through the whole command: it answers as their index says, in time, and never ends by a signal.

#![allow(clippy::print_stdout, reason = "what is not run must be said")]

use super::{Folder, text};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The folder of broken files, if it is there; says loudly if it is not.
fn bad_inputs() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let root = std::env::var_os("PENOMBRE_TESTDATA").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let folder = root.join("bad-inputs");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("NOT RUN: the test data bad-inputs are not there; set PENOMBRE_TESTDATA to their folder");
    None
}

#[test]
fn broken_meshes_answer_as_their_index_says() {
    let Some(inputs) = bad_inputs() else { return };
    let folder = Folder::new();
    let index = std::fs::read_to_string(inputs.join("INDEX.tsv")).unwrap();
    let mut seen = 0;
    for line in index.lines() {
        let [name, class, ..] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
        if !["obj/", "off/", "ply/", "stl/"].iter().any(|f| name.starts_with(f)) || line.starts_with('#') {
            continue;
        }
        let path = inputs.join(name);
        let begin = Instant::now();
        let path = path.to_str().unwrap();
        let output = folder.run(&["render", path, "--size", "32x24", "--spp", "1", "-o", "out.png"]);
        assert!(begin.elapsed().as_secs_f32() < 2.0, "{name}");
        let (status, said) = (output.status.code(), text(&output.stderr));
        let allowed: &[i32] = match class {
            "ERR" => &[2],
            "OK" => &[0],
            _ => &[0, 2],
        };
        assert!(status.is_some_and(|s| allowed.contains(&s)), "{name}: {status:?} {said}");
        let stem = Path::new(name).file_stem().and_then(|s| s.to_str()).unwrap();
        assert!(class == "OK" || said.contains(stem), "{name}: {said}");
        seen += 1;
    }
    assert!(seen > 50, "{seen}");
}
