//! Broken scenes and the exact messages that they must give.
//!
//! Every `tests/faults/NAME.toml` has a `NAME.expected`: all its faults, as shown where there is no terminal. A
//! `NAME.sets` holds `--set` arguments, one a line. `PENOMBRE_BLESS=1` rewrites the expected texts: read each one
//! that changes as the person who made that mistake would.

use penombre::Plan;
use penombre_scene::Severity;
use penombre_scene::load::{LoadOptions, load};
use penombre_scene::report::render_all_plain;
use std::fs;
use std::path::Path;

/// Relative, so that messages name the same files on every machine: tests run in the crate's folder.
const FOLDER: &str = "tests/faults";

/// All messages of a scene, with short file names and forward slashes.
fn messages(name: &str) -> String {
    let sets = fs::read_to_string(format!("{FOLDER}/{name}.sets")).unwrap_or_default();
    let options = LoadOptions { sets: sets.lines().map(str::to_owned).collect(), ..LoadOptions::default() };
    let mut loaded = load(&format!("{FOLDER}/{name}.toml"), &options);
    if loaded.readable {
        let plan = Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics);
        assert!(plan.is_none() || !loaded.diagnostics.has_errors(), "{name}: built in spite of its faults");
    }
    for d in loaded.diagnostics.iter() {
        assert!(loaded.sources.locate(d.span).is_some(), "{name}: no place for: {}", d.message);
        assert!(!d.message.is_empty() && !d.message.ends_with('.'), "{name}: {}", d.message);
        assert!(!d.help.is_empty(), "{name}: no help for: {}", d.message);
    }
    assert!(loaded.diagnostics.count(Severity::Error) > 0, "{name}: no fault was found");
    let text = render_all_plain(&loaded.diagnostics, &loaded.sources);
    let here = Path::new(FOLDER).canonicalize().expect("tests run in the crate's folder");
    let folders = [
        here.as_path(),
        here.parent().expect("below the crate"),
        here.ancestors().nth(2).expect("the crate"),
    ];
    let named = folders.iter().zip(["FOLDER", "FOLDER/..", "FOLDER/../.."]);
    let short = named.fold(text, |text, (path, name)| text.replace(&path.display().to_string(), name));
    short.replace('\\', "/").replace(&format!("{FOLDER}/"), "")
}

#[test]
fn every_broken_scene_gives_its_messages() {
    let bless = std::env::var_os("PENOMBRE_BLESS").is_some();
    let mut names: Vec<String> = Vec::new();
    for entry in fs::read_dir(FOLDER).expect("the corpus is there") {
        let path = entry.expect("the corpus can be listed").path();
        if path.extension().is_some_and(|e| e == "toml") {
            names.push(path.file_stem().expect("has a name").to_string_lossy().into_owned());
        }
    }
    names.sort();
    assert!(names.len() >= 40, "{} scenes", names.len());
    let mut wrong = Vec::new();
    for name in &names {
        let found = messages(name);
        let file = format!("{FOLDER}/{name}.expected");
        if bless {
            fs::write(&file, &found).expect("the expected text can be written");
        }
        let expected = fs::read_to_string(&file).unwrap_or_default();
        if found != expected {
            wrong.push(format!("{name}: found\n{found}\nexpected\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {} differ:\n{}", wrong.len(), names.len(), wrong.join("\n----\n"));
}
