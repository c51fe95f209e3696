//! Broken meshes and images, through the whole command: it answers as their index says, in time and memory, says what is
//! wrong where, and never ends by a signal.

use super::{Folder, names, test_data, text};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Memory beyond the file that an answer may take, bytes.
pub const MOST_MEMORY: u64 = 256 << 20;

/// Runs the command on a broken file. Checks status, words, time, memory and that nothing is left of a failure.
/// `class`: `ERR`, `OK` or `WARN`, where both are well. `file`: the one that messages must name.
pub fn answer(folder: &Folder, arguments: &[&str], file: &Path, class: &str) -> String {
    let (size, before) = (file.metadata().unwrap().len(), names(folder.0.path()));
    let begin = Instant::now();
    let output = folder.limited(arguments, MOST_MEMORY + size).output().unwrap();
    let (time, said) = (begin.elapsed().as_secs_f32(), text(&output.stderr));
    let mut wrong = String::new();
    let mut check = |is_well: bool, what: &str| {
        if !is_well {
            writeln!(wrong, "{what}").unwrap();
        }
    };
    // No status: a signal, as after memory that was not to be had.
    let status = output.status.code();
    let allowed: &[i32] = match class {
        "ERR" => &[2],
        "OK" => &[0],
        _ => &[0, 2],
    };
    check(status.is_some_and(|s| allowed.contains(&s)), &format!("status {status:?}"));
    check(time < if size > 1 << 20 { 10.0 } else { 2.0 }, &format!("{time} s"));
    let is_panic = ["panicked", "internal fault", "backtrace"].iter().any(|word| said.contains(word));
    check(!is_panic, "a panic");
    if status == Some(0) {
        std::fs::remove_file(folder.path(arguments.last().unwrap())).unwrap();
    } else {
        let stem = file.file_stem().unwrap().to_str().unwrap();
        check(said.contains(stem), "the file is not named");
        for error in errors(&said) {
            check(has_place(error), "an error without a place");
            check(error.contains("found"), "an error without what was found");
            check(error.contains("expected"), "an error without what was expected");
        }
    }
    check(names(folder.0.path()) == before, "something was left behind");
    assert!(wrong.is_empty(), "{arguments:?}, {class}:\n{wrong}{said}");
    said
}

/// The errors among what was said, each with its lines.
fn errors(said: &str) -> impl Iterator<Item = &str> {
    let starts =
        said.match_indices("error: ").map(|(at, _)| at).filter(|at| *at == 0 || said[..*at].ends_with('\n'));
    let ends = |start: usize| said[start..].find("\nwarning: ").map_or(said.len(), |at| start + at);
    let starts: Vec<usize> = starts.collect();
    let next = starts.clone().into_iter().skip(1).chain([said.len()]);
    starts.into_iter().zip(next).map(move |(start, next)| &said[start..next.min(ends(start))])
}

/// True for `file:LINE:COLUMN` and `byte N`.
fn has_place(error: &str) -> bool {
    let digit_after = |mark: &str| {
        error
            .match_indices(mark)
            .any(|(at, _)| error[at + mark.len()..].starts_with(|c: char| c.is_ascii_digit()))
    };
    digit_after("byte ") || (error.contains("  --> ") && digit_after(":"))
}

/// The cases of the index in some folders: name and class.
fn cases(inputs: &Path, families: &[&str]) -> Vec<(String, String)> {
    let index = std::fs::read_to_string(inputs.join("INDEX.tsv")).unwrap();
    let fields = index.lines().filter(|l| !l.starts_with('#')).map(|l| l.split('\t').collect::<Vec<_>>());
    let cases = fields.filter(|f| f.len() > 1 && families.contains(&f[0].split('/').next().unwrap()));
    cases.map(|f| (f[0].to_owned(), f[1].to_owned())).collect()
}

const SMALL: [&str; 6] = ["--size", "32x24", "--spp", "1", "-o", "out.png"];

#[test]
fn broken_meshes_answer_as_their_index_says() {
    let Some(inputs) = test_data("bad-inputs") else { return };
    let folder = Folder::new();
    let cases = cases(&inputs, &["obj", "off", "ply", "stl", "misc"]);
    assert!(cases.len() > 60, "{}", cases.len());
    for (name, class) in cases {
        let path = inputs.join(&name);
        let said =
            answer(&folder, &[&["render", path.to_str().unwrap()], &SMALL[..]].concat(), &path, &class);
        if name.ends_with("glb-named.gltf") {
            assert!(said.contains("found a binary glTF scene, which is planned and not read yet"), "{said}");
        }
    }
    let given = inputs.join("misc/folder.gltf");
    let said = folder.refused(&["render", given.to_str().unwrap()]);
    assert!(said.contains("folder.gltf`: found a folder, expected a scene file"), "{said}");
}

/// A scene with one textured sphere.
pub fn textured(image: &str) -> String {
    format!(
        "penombre = 1\n[texture.bad]\ntype = \"image\"\nfile = \"{image}\"\n[material.m]\ntype = \"diffuse\"\ncolor = {{ \
         texture = \"bad\" }}\n[shape.s]\ntype = \"sphere\"\nmaterial = \"m\"\n[camera.c]\ntype = \"perspective\"\n"
    )
}

#[test]
fn broken_images_answer_as_their_index_says() {
    let Some(inputs) = test_data("bad-inputs") else { return };
    let (folder, scene) = (Folder::new(), Folder::new());
    let cases = cases(&inputs, &["images"]);
    assert!(cases.len() > 90, "{}", cases.len());
    for (name, class) in cases {
        let path = inputs.join(&name);
        answer(&folder, &["convert", path.to_str().unwrap(), "out.exr"], &path, &class);
        let file = path.file_name().unwrap().to_str().unwrap();
        // A copy beside the scene that can be removed: those of the corpus are write-protected.
        std::fs::write(scene.path(file), std::fs::read(&path).unwrap()).unwrap();
        scene.write("scene.toml", &textured(file));
        let scene_file = scene.path("scene.toml");
        answer(&folder, &[&["render", scene_file.to_str().unwrap()], &SMALL[..]].concat(), &path, &class);
        std::fs::remove_file(scene.path(file)).unwrap();
    }
}

#[test]
fn the_measure_finds_what_it_should() {
    let folder = Folder::new();
    folder.write("bare.obj", "v 1\n");
    let path = folder.path("bare.obj");
    let wrong = |run: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err();
    assert!(wrong(&|| _ = answer(&folder, &["render", "bare.obj", "-o", "out.png"], &path, "OK")));
    assert!(wrong(
        &|| _ = answer(&folder, &["render", "bare.obj", "--spp", "0", "-o", "o.png"], &path, "ERR")
    ));
    assert!(has_place("error: x\n  --> a.obj:3:4\n") && has_place("a, byte 3: y"));
    assert!(!has_place("error: x: 3 found\n  help: in `byte`"));
    let said = "warning: w\nerror: a\n  --> b\nwarning: v\nerror: c\nend\n";
    assert_eq!(errors(said).collect::<Vec<_>>(), ["error: a\n  --> b", "error: c\nend\n"]);
    // Memory is really limited: an image of 100 MB in floats does not fit 64 MiB.
    let header = b"P6 3000 3000 255\n".to_vec();
    std::fs::write(folder.path("a.ppm"), [header, vec![7; 27_000_000]].concat()).unwrap();
    let limited = folder.limited(&["convert", "a.ppm", "a.pfm"], 64 << 20).output().unwrap();
    assert_ne!(limited.status.code(), Some(0));
    folder.ok(&["convert", "a.ppm", "a.pfm"]);
}
