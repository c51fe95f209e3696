//! Whatever names a file: nothing outside the scene's folder is read, and what is refused says how to allow it.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre_scene::load::{LoadOptions, Loaded, load};
use penombre_scene::report::render_all_plain;
use std::fs;
use std::path::PathBuf;

/// The secret that must never be seen.
const SECRET: &str = "newmtl secret_4711\nKd 1 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A folder `scene` beside a folder `other` with files of all kinds.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["scene", "other"] {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        for name in ["f.obj", "f.mtl", "f.toml", "f.ppm"] {
            let text = if name == "f.ppm" { "P3 1 1 255 1 2 3" } else { SECRET };
            fs::write(folder.path().join("other").join(name), text).unwrap();
        }
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().canonicalize().unwrap().join(name)
    }

    /// Loads the scene with one file named by `what`, which brings its own ending.
    fn load(&self, what: &str, name: &str, roots: &[&str]) -> Loaded {
        let quoted = format!("{name:?}");
        let write = |file: &str, text: String| fs::write(self.path("scene").join(file), text).unwrap();
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
        let mesh = "[shape.s]\ntype = \"mesh\"\nfile = \"own.obj\"\n";
        let scene = match what {
            "mesh" => format!("[shape.s]\ntype = \"mesh\"\nfile = {quoted}\n"),
            "texture" => format!("[texture.t]\ntype = \"image\"\nfile = {quoted}\n"),
            "light" => format!("[light.l]\ntype = \"environment\"\nfile = {quoted}\n"),
            "include" => format!("include = [{quoted}]\n"),
            "mtllib" => {
                write("own.obj", format!("mtllib {name}\n{triangle}"));
                mesh.to_owned()
            }
            _ => {
                write("own.obj", format!("mtllib own.mtl\n{triangle}"));
                write("own.mtl", format!("newmtl m\n{what} {name}\n"));
                mesh.to_owned()
            }
        };
        write("scene.toml", format!("penombre = 1\n{scene}"));
        let asset_roots = roots.iter().map(|root| self.path(root)).collect();
        let options = LoadOptions { asset_roots, ..LoadOptions::default() };
        load(self.path("scene/scene.toml").to_str().unwrap(), &options)
    }
}

const ENDINGS: [(&str, &str); 9] = [
    ("mesh", "obj"),
    ("texture", "ppm"),
    ("light", "ppm"),
    ("include", "toml"),
    ("mtllib", "mtl"),
    ("map_Kd", "ppm"),
    ("map_Ks", "ppm"),
    ("map_d", "ppm"),
    ("map_Ke", "ppm"),
];

fn told(loaded: &Loaded) -> String {
    render_all_plain(&loaded.diagnostics, &loaded.sources)
}

#[test]
fn nothing_outside_is_read_whatever_names_it() {
    let place = Place::new();
    let other = place.path("other");
    let mut links = vec![("no-link".to_owned(), false)];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&other, place.path("scene/link")).unwrap();
        links.push(("link/f.ENDING".to_owned(), true));
        links.push(("./link/../link/f.ENDING".to_owned(), true));
    }
    let absolute = other.join("f.ENDING").to_str().unwrap().to_owned();
    let names = [
        "../other/f.ENDING",
        "sub/../../other/f.ENDING",
        "../../../../../../../../etc/passwd",
        "/etc/passwd",
        "/dev/zero",
        "/dev/stdin",
        "/proc/self/environ",
        "//server/share/f.ENDING",
        "\\\\server\\share\\f.ENDING",
        "C:\\f.ENDING",
        "file:///etc/passwd",
        "file:f.ENDING",
        "http://127.0.0.1:9/f.ENDING",
        "https://example.org/f.ENDING",
        "ftp://example.org/f.ENDING",
        absolute.as_str(),
    ];
    let names = names.map(|name| (name.to_owned(), true));
    for (what, ending) in ENDINGS {
        for (name, refused) in names.iter().chain(&links) {
            let name = name.replace("ENDING", ending);
            let loaded = place.load(what, &name, &[]);
            let text = told(&loaded);
            assert!(!text.contains("4711") && !text.contains("root:"), "{what} {name}: {text}");
            if !refused {
                continue;
            }
            assert!(loaded.diagnostics.has_errors(), "{what} {name}: {text}");
            assert!(text.contains("--asset-root"), "{what} {name}: {text}");
            let shown = if text.contains(&name) { name.clone() } else { name.replace('\\', "/") };
            assert!(text.contains(&shown), "{what} {name}: {text}");
            let may_be_read = usize::from(what.starts_with("m") && what != "mesh");
            assert!(loaded.assets.content_hashes().count() <= may_be_read, "{what} {name}");
        }
    }
}

#[test]
fn an_asset_root_allows_it() {
    let place = Place::new();
    for (what, ending) in ENDINGS.iter().filter(|(what, _)| *what != "include") {
        let absolute = place.path("other").join(format!("f.{ending}"));
        for name in [format!("../other/f.{ending}"), absolute.to_str().unwrap().to_owned()] {
            let loaded = place.load(what, &name, &["other"]);
            assert!(!loaded.diagnostics.has_errors(), "{what} {name}: {}", told(&loaded));
            assert!(!told(&loaded).contains("--asset-root"), "{what} {name}: {}", told(&loaded));
        }
    }
    // It does not allow what is not below it, devices least of all.
    for root in ["other", "/dev"] {
        let loaded = place.load("texture", "/dev/zero", &[root]);
        assert!(loaded.diagnostics.has_errors() && loaded.assets.bytes() == 0, "{root}");
    }
}
