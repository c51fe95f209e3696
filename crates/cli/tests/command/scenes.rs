//! `penombre convert` of scenes.

use super::{Folder, names, text};
use std::path::{Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Digest of a small render.
fn digest(folder: &Folder, scene: &str, more: &[&str]) -> String {
    // Of the shape that the camera of a mesh is fitted to.
    let fixed = ["render", scene, "--size", "24x18", "--spp", "1", "--json", "-q"];
    folder.json(&[&fixed, more].concat())["digest"].as_str().unwrap().to_owned()
}

#[test]
fn scenes_keep_their_picture() {
    let folder = Folder::new();
    let files = ["scenes", "tests/scenes"].map(|f| std::fs::read_dir(Path::new(ROOT).join(f)).unwrap());
    let mut scenes: Vec<PathBuf> = files.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    scenes.extend(penombre_scene::builtin::NAMES.map(PathBuf::from));
    scenes.push(Path::new(ROOT).join("assets/meshes/spot.obj"));
    assert!(scenes.len() > 8, "{scenes:?}");
    let roots = ["--asset-root", ROOT];
    for scene in scenes {
        let scene = scene.to_str().unwrap();
        let expected = digest(&folder, scene, &roots);
        folder.ok(&[&["convert", scene, "a.json"], &roots[..]].concat());
        folder.ok(&[&["convert", "a.json", "a.toml"], &roots[..]].concat());
        folder.ok(&[&["convert", "a.toml", "b.json"], &roots[..]].concat());
        for converted in ["a.json", "a.toml", "b.json"] {
            assert_eq!(digest(&folder, converted, &roots), expected, "{scene}: {converted}");
        }
        let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert_eq!(bytes("a.json"), bytes("b.json"), "{scene}");
    }
}

/// A scene of two files in two folders with a mesh and its library.
fn parts() -> Folder {
    let folder = Folder::new();
    for name in ["parts", "new"] {
        std::fs::create_dir(folder.path(name)).unwrap();
    }
    folder.write("parts/mesh.obj", "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("parts/m.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    folder.write("parts/thing.toml", "penombre = 1\n[shape.thing]\ntype = \"mesh\"\nfile = \"mesh.obj\"\n");
    let camera = "[light.sky]\ntype = \"environment\"\n[camera.main]\ntype = \"perspective\"\nposition = [0.1, 0.30000000000000004, 3]\n";
    folder.write("main.toml", &format!("penombre = 1\ninclude = [\"parts/thing.toml\"]\n{camera}"));
    folder
}

#[test]
fn included_files_become_one_and_names_are_told_from_the_new_folder() {
    let folder = parts();
    let expected = digest(&folder, "main.toml", &[]);
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let said = folder.run(&["convert", "main.toml", "-o", "one.toml", "-o", "new/one.json"]);
    assert_eq!(said.status.code(), Some(0));
    assert_eq!(text(&said.stdout), "one.toml  3 nodes, from main\nnew/one.json  3 nodes, from main\n");
    assert!(read("one.toml").contains("file = \"parts/mesh.obj\"") && !read("one.toml").contains("include"));
    assert!(read("one.toml").contains("0.30000000000000004"), "numbers keep their last digit");
    assert!(!read("one.toml").contains("red"), "what the library says stays in the library");
    assert_eq!(digest(&folder, "one.toml", &[]), expected);
    // The mesh is not below the new folder: the command says what a render will need.
    let parts = folder.path("parts").canonicalize().unwrap();
    let warning = format!(
        "warning: new/one.json names files that do not lie below its folder\n  help: render it with --asset-root {}\n",
        parts.display()
    );
    assert_eq!(text(&said.stderr), warning);
    assert!(read("new/one.json").contains("\"file\": \"../parts/mesh.obj\""));
    assert!(folder.refused(&["render", "new/one.json", "-o", "a.png"]).contains("lies outside"));
    assert_eq!(digest(&folder, "new/one.json", &["--asset-root", "parts"]), expected);
    // A mesh becomes the scene around it.
    folder.ok(&["convert", "parts/mesh.obj", "mesh.toml"]);
    assert!(
        read("mesh.toml").contains("file = \"parts/mesh.obj\"") && read("mesh.toml").contains("[light.key]")
    );
    let bare = digest(&folder, "parts/mesh.obj", &[]);
    assert_eq!(digest(&folder, "mesh.toml", &[]), bare);
}

#[test]
fn changes_from_the_command_line_are_kept() {
    let folder = parts();
    let sets = ["--set", "camera.fov=20", "--set", "material.\"thing/red\".diffuse=[0, 1, 0]"];
    let expected = digest(&folder, "main.toml", &sets);
    assert_ne!(digest(&folder, "main.toml", &[]), expected);
    folder.ok(&[&["convert", "main.toml", "green.toml"], &sets[..]].concat());
    assert_eq!(digest(&folder, "green.toml", &[]), expected);
    // Many at once, into a folder.
    folder.ok(&["convert", "main.toml", "green.toml", "cornell", "-o", "new", "--format", "json", "-q"]);
    assert_eq!(names(&folder.path("new")), ["cornell.json", "green.json", "main.json"]);
}

#[test]
fn wrong_conversions_of_scenes_are_refused() {
    let folder = parts();
    folder.write("bad.toml", "penombre = 1\n[shape.s]\ntype = \"spere\"\n");
    folder.write("old.toml", "keep me");
    let before = names(folder.0.path());
    for (arguments, expected) in [
        (vec!["bad.toml", "old.toml"], "bad.toml:3:8"),
        (vec!["main.toml", "main.toml"], "would replace main.toml"),
        (vec!["main.toml", "parts/thing.toml"], "a part of the scene"),
        (vec!["main.toml", "a.png"], "main.toml is a scene, and a.png is not"),
        (vec!["cornell", "a.xyz"], "`penombre render cornell -o a.xyz` renders it"),
        (vec!["cornell", "a.gltf"], "a.gltf: scenes are written as .toml or .json only"),
        (vec!["parts/mesh.obj", "a.ply"], "a.ply: scenes are written as .toml or .json only"),
        (vec!["none.toml", "a.toml"], "there is no file `none.toml`"),
        (vec!["cornell", "a.toml", "--tone", "raw"], "are for images"),
        (vec!["cornell", "nowhere/a.toml"], "nowhere"),
    ] {
        let said = folder.refused(&[vec!["convert"], arguments].concat());
        assert!(said.contains(expected), "{said}");
    }
    assert_eq!(names(folder.0.path()), before);
    assert_eq!(std::fs::read_to_string(folder.path("old.toml")).unwrap(), "keep me");
}
