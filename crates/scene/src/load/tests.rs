use super::*;
use crate::Severity;
use crate::description::{Role, ValueKind};
use crate::report::render_all_plain;
use std::fs;
use tempfile::TempDir;

/// A folder with files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = dir.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    dir
}

fn load_in(dir: &TempDir, name: &str, sets: &[&str]) -> Loaded {
    let options =
        LoadOptions { sets: sets.iter().map(|s| (*s).to_owned()).collect(), ..LoadOptions::default() };
    load(dir.path().join(name).to_str().unwrap(), &options)
}

/// All messages, the folder's name left out.
fn faults(loaded: &Loaded, dir: &TempDir) -> String {
    let text = render_all_plain(&loaded.diagnostics, &loaded.sources);
    let canonical = dir.path().canonicalize().unwrap();
    text.replace(&format!("{}/", canonical.display()), "").replace(&format!("{}/", dir.path().display()), "")
}

fn loads(files: &[(&str, &str)], name: &str) -> Loaded {
    let dir = folder(files);
    let loaded = load_in(&dir, name, &[]);
    assert_eq!(faults(&loaded, &dir), "");
    assert!(loaded.readable);
    loaded
}

fn fails(files: &[(&str, &str)], name: &str, expected: &str) -> Loaded {
    let dir = folder(files);
    let loaded = load_in(&dir, name, &[]);
    assert_eq!(faults(&loaded, &dir), expected);
    loaded
}

const RED: &str = "penombre = 1\n[material.red]\ntype = \"phong\"\n";

#[test]
fn built_ins_are_found_by_their_bare_names() {
    for name in builtin::NAMES {
        let loaded = load(name, &LoadOptions::default());
        assert!(loaded.diagnostics.is_empty() && loaded.readable && !loaded.bare_mesh);
        assert_eq!(Some(loaded.description), builtin::builtin(name));
        assert_eq!(loaded.name, name);
    }
}

#[test]
fn files_are_named_by_their_stem_and_endings_may_be_upper_case() {
    let loaded = loads(&[("dir/Box.two.TOML", RED)], "dir/Box.two.TOML");
    assert_eq!(loaded.name, "Box.two");
    assert_eq!(loaded.description.len(), 1);
}

#[test]
fn includes_are_merged_before_the_file_that_names_them() {
    let main = "penombre = 1\ninclude = [\"parts/a.toml\", \"b.toml\"]\n[shape.s]\ntype = \"sphere\"\n";
    let a = "penombre = 1\ninclude = [\"../b.toml\"]\n[material.a]\ntype = \"phong\"\n";
    // b is included twice and read once.
    let b = "penombre = 1\n[material.b]\ntype = \"phong\"\n";
    let loaded = loads(&[("main.toml", main), ("parts/a.toml", a), ("b.toml", b)], "main.toml");
    let paths: Vec<String> = loaded.description.iter().map(|(_, n)| n.path()).collect();
    assert_eq!(paths, ["material.b", "material.a", "shape.s"]);
    let names: Vec<&str> = loaded.sources.iter().map(|s| s.name.rsplit('/').next().unwrap()).collect();
    assert_eq!(names, ["main.toml", "a.toml", "b.toml"]);
}

#[test]
fn include_cycles_show_the_chain() {
    let a = "penombre = 1\ninclude = [\"b.toml\"]\n";
    let b = "penombre = 1\n\ninclude = [\"a.toml\"]\n";
    let expected = "error: `a.toml` includes itself: a.toml → b.toml → a.toml\n  --> b.toml:3:12\n  help: remove one of these includes\n";
    let loaded = fails(&[("a.toml", a), ("b.toml", b)], "a.toml", expected);
    assert!(!loaded.readable);
    let own = "penombre = 1\ninclude = [\"./x/../own.toml\"]\n";
    let expected = "error: `own.toml` includes itself: own.toml → own.toml\n  --> own.toml:2:12\n  help: remove one of these includes\n";
    fails(&[("own.toml", own), ("x/y", "")], "own.toml", expected);
}

#[test]
fn missing_and_forbidden_includes() {
    let main = "penombre = 1\ninclude = [\"materials.toml\", \"../x.toml\", \"mesh.obj\", \"broken.toml\"]\n";
    let files =
        [("main.toml", main), ("material.toml", RED), ("mesh.obj", "v 0 0 0\n"), ("broken.toml", "x = [\n")];
    let dir = folder(&files);
    let loaded = load_in(&dir, "main.toml", &[]);
    let text = faults(&loaded, &dir);
    assert_eq!(loaded.diagnostics.count(Severity::Error), 4, "{text}");
    assert!(text.contains(
        "there is no file `materials.toml`\n  --> main.toml:2:12\n  help: did you mean `material.toml`?"
    ));
    assert!(text.contains("found `../x.toml`, which lies outside"), "{text}");
    assert!(text.contains("looked for materials.toml"), "{text}");
    assert!(text.contains("--asset-root"), "{text}");
    assert!(
        text.contains("`mesh.obj`: byte 0: found a mesh, expected a scene file\n  --> main.toml:2:43"),
        "{text}"
    );
    assert!(text.contains("  --> broken.toml:1:"), "{text}");
}

#[test]
fn one_name_in_two_files_names_both_places() {
    let main = "penombre = 1\ninclude = [\"red.toml\"]\n\n[material.red]\ntype = \"glass\"\n";
    let expected = "error: `material.red` is defined twice: first in red.toml:2\n  --> main.toml:4:1\n  help: rename or remove one of them; to change single values use --set\n";
    let loaded = fails(&[("main.toml", main), ("red.toml", RED)], "main.toml", expected);
    assert!(loaded.readable, "the rest of the scene can be checked");
}

#[test]
fn missing_files_suggest_what_is_there() {
    fails(
        &[("cornell-box.toml", RED)],
        "cornel-box.toml",
        "error: there is no file `cornel-box.toml`\n  help: did you mean `cornell-box.toml`?\n",
    );
    fails(&[], "x/a.toml", "error: there is no file `x/a.toml`\n  help: there is no folder `x`\n");
    let loaded = load("cornel", &LoadOptions::default());
    let text = render_all_plain(&loaded.diagnostics, &loaded.sources);
    assert!(text.starts_with("error: there is no file or built-in scene `cornel`\n  help: did you mean `cornell`? built-in scenes: sphere,"), "{text}");
    assert!(!loaded.readable);
}

#[test]
fn other_kinds_of_files_are_called_by_their_name() {
    let dir = folder(&[
        ("a.gltf", "{}"),
        ("a.JSON", "{}"),
        ("empty.toml", " \n"),
        ("no-ending", "# mine\n\npenombre = 1\n"),
        ("mesh", "OFF\n3 1 0\n"),
        ("mesh2", "v 0 0 0\n"),
        ("mesh3", "ply\nformat ascii 1.0\n"),
        ("words.txt", "hello"),
    ]);
    for (name, bytes) in [
        ("z.obj", &b"\x1f\x8b\x08"[..]),
        ("zlib.obj", b"x\x9c\xcb"),
        ("p.toml", b"\x89PNG\r\n"),
        ("u.toml", b"\xff\xfea\0"),
        ("f.stl", b"Kaydara FBX Binary  \0\x1a\0"),
        ("w.obj", b"\xff\xfe\0\0v\0\0\0"),
        ("g", b"glTF\x02"),
        ("q.gltf", b"\x89PNG"),
    ] {
        fs::write(dir.path().join(name), bytes).unwrap();
    }
    let message = |name: &str| faults(&load_in(&dir, name, &[]), &dir);
    assert!(
        message("a.gltf")
            .starts_with("error: `a.gltf`: byte 0: found a glTF scene, which is planned and not read yet")
    );
    assert!(
        message("mesh3").contains("found what looks like a PLY mesh") && message("mesh3").contains(".ply")
    );
    assert!(message("empty.toml").contains("found an empty file"));
    assert!(
        message("mesh").contains("found what looks like an OFF mesh") && message("mesh").contains(".off")
    );
    assert!(message("mesh2").contains("found what looks like an OBJ mesh"));
    assert!(message("words.txt").contains(r#"found "hello", expected a scene"#));
    assert!(
        message("z.obj").contains("found data compressed with gzip")
            && message("z.obj").contains("unpack it, or give it a name")
    );
    assert!(message("zlib.obj").contains("found data compressed with zlib"));
    assert!(message("p.toml").contains("found a PNG image"));
    assert!(message("u.toml").contains("found text in UTF-16") && message("u.toml").contains("UTF-8"));
    assert!(message("f.stl").contains("found an FBX scene, which is planned"));
    assert!(message("w.obj").contains("found text in UTF-32"));
    assert!(message("g").contains("found a binary glTF scene, which is planned and not read yet"));
    assert!(message("q.gltf").contains("found a PNG image"), "what a file is counts more than its name");
    assert!(message("").contains("found a folder, expected a scene file or a built-in scene"));
    let guessed = load_in(&dir, "no-ending", &[]);
    assert!(guessed.readable && !guessed.diagnostics.has_errors());
    assert_eq!(guessed.diagnostics.count(Severity::Warning), 1);
}

#[cfg(unix)]
#[test]
fn devices_are_not_read() {
    let loaded = load("/dev/zero", &LoadOptions::default());
    let text = render_all_plain(&loaded.diagnostics, &loaded.sources);
    assert!(text.contains("`/dev/zero`: found a device or a pipe"), "{text}");
}

#[test]
fn texts_that_are_no_utf8_are_told_with_the_byte() {
    let dir = folder(&[]);
    fs::write(dir.path().join("a.toml"), b"penombre = 1\n# caf\xe9\n").unwrap();
    let text = faults(&load_in(&dir, "a.toml", &[]), &dir);
    assert_eq!(
        text,
        "error: `a.toml`: byte 18: found 0xe9, expected text in UTF-8\n  --> a.toml:2:6\n  help: save the file as UTF-8\n"
    );
}

#[test]
fn sets_are_applied_in_order_and_their_faults_are_told_once() {
    let dir = folder(&[("a.toml", RED)]);
    let loaded =
        load_in(&dir, "a.toml", &["render.spp=1", "render.spp=2", "material.shininess=3", "camera.fov=2"]);
    let spp =
        loaded.description.node(loaded.description.find(Role::Render, "").unwrap()).param("spp").unwrap();
    assert_eq!(spp.value.kind, ValueKind::Int(2));
    assert_eq!(
        faults(&loaded, &dir),
        "error: the scene has no camera\n  --> --set argument:1:1\n  help: add [camera.NAME] to the scene file first\n"
    );
}

/// `links/` beside `files/` with a mesh, its library, and a scene with a part and the mesh.
#[cfg(unix)]
fn linked() -> TempDir {
    let scene = "penombre = 1\ninclude = [\"part.toml\"]\n[shape.m]\ntype = \"mesh\"\nfile = \"tri.obj\"\n";
    let mesh = "mtllib tri.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let dir = folder(&[
        ("files/tri.obj", mesh),
        ("files/tri.mtl", "newmtl a\nKd 1 0 0\n"),
        ("files/blob", mesh),
        ("files/scene.toml", scene),
        ("files/part.toml", RED),
        // What stands beside the links is not meant.
        ("links/tri.mtl", "newmtl a\nKd bad\n"),
        ("links/part.toml", "bad"),
    ]);
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, dir.path().join(name)).unwrap();
    link("../files/tri.obj", "links/mesh.obj");
    link("../files/scene.toml", "links/box.toml");
    link("../files/blob", "links/blob.obj");
    link("blob", "files/blob.obj");
    dir
}

#[cfg(unix)]
#[test]
fn links_are_followed_to_the_files_folder_and_keep_their_name() {
    let dir = linked();
    let mesh = load_in(&dir, "links/mesh.obj", &[]);
    assert_eq!(faults(&mesh, &dir), "");
    assert_eq!((mesh.name.as_str(), mesh.bare_mesh), ("mesh", true));
    assert_eq!(mesh.assets.content_hashes().count(), 1);
    let red = mesh.description.of_role(Role::Material).find(|(_, n)| n.name.ends_with("/a")).unwrap();
    assert_eq!(red.1.param("diffuse").unwrap().value, [1.0, 0.0, 0.0].into());
    let scene = load_in(&dir, "links/box.toml", &[]);
    assert_eq!(faults(&scene, &dir), "");
    assert_eq!(scene.name, "box");
    assert!(scene.description.find(Role::Material, "red").is_some());
    assert_eq!(scene.assets.content_hashes().count(), 1);
    let place = scene.description.of_role(Role::Shape).next().unwrap().1.span;
    assert!(scene.sources.locate(place).unwrap().name.ends_with("links/box.toml"));
}

#[cfg(unix)]
#[test]
fn a_link_in_the_files_own_folder_tells_the_format() {
    let dir = linked();
    let mesh = load_in(&dir, "files/blob.obj", &[]);
    assert_eq!(faults(&mesh, &dir), "");
    assert_eq!(mesh.name, "blob");
    assert_eq!(mesh.assets.content_hashes().count(), 1);
}

#[test]
fn bare_meshes_become_scenes_that_can_be_changed() {
    let dir = folder(&[("tri.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")]);
    let loaded = load_in(&dir, "tri.off", &["camera.fov=20", "render.spp=3"]);
    assert_eq!(faults(&loaded, &dir), "");
    assert!(loaded.bare_mesh && loaded.readable && loaded.name == "tri");
    let (_, camera) = loaded.description.of_role(Role::Camera).next().unwrap();
    assert_eq!(camera.param("fov").unwrap().value.kind, ValueKind::Int(20));
    assert_eq!(loaded.assets.content_hashes().count(), 1);
}

#[test]
fn digests_follow_what_is_said_and_not_where() {
    let mesh = "penombre = 1\n[shape.m]\ntype = \"mesh\"\nfile = \"a.off\"\nx = 1\n";
    let tri = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let digest = |files: &[(&str, &str)]| {
        let loaded = loads(files, "s.toml");
        loaded.description.digest(&loaded.assets)
    };
    let first = digest(&[("s.toml", mesh), ("a.off", tri)]);
    assert_eq!(first.len(), 64);
    let moved = mesh
        .replace("a.off", "b.off")
        .replace("\nx = 1", "")
        .replace("[shape.m]", "# note\n[shape.m]\nx = 1");
    assert_eq!(digest(&[("s.toml", &moved), ("b.off", tri)]), first);
    assert_ne!(digest(&[("s.toml", mesh), ("a.off", &tri.replace("1 0 0", "2 0 0"))]), first);
    assert_ne!(digest(&[("s.toml", &mesh.replace("x = 1", "x = 2")), ("a.off", tri)]), first);
    assert_ne!(digest(&[("s.toml", &mesh.replace("shape.m", "shape.n")), ("a.off", tri)]), first);
    let values = [
        "x = 1",
        "x = 1.0",
        "x = true",
        "x = \"1\"",
        "x = [1]",
        "x = [[1]]",
        "x = { a = 1 }",
        "x = [1, 1]",
        "y = 1",
    ];
    let digests: std::collections::BTreeSet<String> =
        values.iter().map(|v| digest(&[("s.toml", &format!("penombre = 1\n[render]\n{v}\n"))])).collect();
    assert_eq!(digests.len(), values.len());
}

#[test]
fn images_are_told_from_scenes_by_their_kind() {
    let tga: &[u8] = b"\0\0\x02\0\0\0\0\0\0\0\0\0\x02\0\x01\0\x18\x20abcdef";
    let images: [(&[u8], &str); 13] = [
        (b"\x89PNG\r\n\x1a\n", "a PNG"),
        (b"\xff\xd8\xff\xe0", "a JPEG"),
        (b"\x76\x2f\x31\x01\x02", "an OpenEXR"),
        (b"#?RADIANCE\n", "a Radiance"),
        (b"P6\n2 1\n255\n", "a PPM"),
        (b"P3 2 1 255", "a PPM"),
        (b"P5\n2 1\n255\n", "a PGM"),
        (b"PF\n2 1\n-1.0\n", "a PFM"),
        (tga, "a TGA"),
        (b"BM\x36\0\0\0\0\0\0\0", "a BMP"),
        (b"RIFF\x10\0\0\0WEBPVP8 ", "a WebP"),
        (b"GIF89a\x01\0", "a GIF"),
        (b"II*\0\x08\0\0\0", "a TIFF"),
    ];
    for (bytes, what) in images {
        for name in ["a.toml", "a", "a.img"] {
            let dir = tempfile::tempdir().unwrap();
            fs::write(dir.path().join(name), bytes).unwrap();
            let loaded = load_in(&dir, name, &[]);
            let fault = loaded.diagnostics.iter().next().unwrap();
            assert_eq!((loaded.readable, fault.code), (false, "load::kind"), "{name} {what}");
            assert!(
                fault.message.contains(&format!("found {what} image, expected a scene")),
                "{}",
                fault.message
            );
            assert!(fault.help.contains("texture"), "{}", fault.help);
        }
    }
    // Texts that begin alike.
    for text in ["#? a remark\n", "BM.x = 1\n", "P3.x = 1\n"] {
        let dir = folder(&[("a.toml", &format!("{text}penombre = 1\n"))]);
        let told = faults(&load_in(&dir, "a.toml", &[]), &dir);
        assert!(!told.contains("image"), "{text}: {told}");
    }
}

#[test]
fn a_mesh_that_is_too_large_for_a_camera_is_named_with_its_box() {
    let text = "v -3e38 0 0\nv 3e38 0 1\nv 0 1 0\nf 1 2 3\n";
    let dir = folder(&[("m.obj", text)]);
    let loaded = load_in(&dir, "m.obj", &[]);
    let only: Vec<_> = loaded.diagnostics.iter().map(|d| (d.code, d.message.as_str())).collect();
    let [("mesh::too-far", message)] = only[..] else { panic!("{only:?}") };
    assert!(
        message
            .contains("m.obj`: byte 0: found a box from (-3e38, 0e0, 0e0) to (3e38, 1e0, 1e0), expected one"),
        "{message}"
    );
}
