//! What every file must stand, whatever it says: what the fuzz targets call, and the replay of what they have kept.

use crate::common::read_in;
use penombre_scene::native::NativeScene;
use penombre_scene::readers::{MeshFormat, unpack};
use penombre_scene::{Diagnostics, FileId, SceneDescription, json, toml};
use std::path::Path;

/// Reads a mesh; `folder` is where it looks for files that it names.
pub fn mesh(folder: &Path, format: MeshFormat, data: &[u8]) {
    drop(read_in(folder, format, data));
}

/// Reads a material library, for which there must be room in the folder, by way of a mesh that uses what most of them
/// have.
pub fn mtl(folder: &Path, data: &[u8]) {
    const MESH: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\nusemtl n\nf 3 2 1\n";
    std::fs::write(folder.join("a.mtl"), data).expect("a library");
    let read = read_in(folder, MeshFormat::Obj, MESH);
    // A library is no reason to refuse a mesh, unless it names a file that must not be read.
    let outside = read.out.iter().any(|d| d.code == "asset::outside");
    assert_eq!(read.file.is_none(), outside, "{:?}", read.messages());
}

/// Unpacks.
pub fn gzip(data: &[u8]) {
    drop(unpack(data));
}

/// Reads a scene in TOML.
pub fn toml(data: &[u8]) {
    native(data, toml::read_toml, toml::write_toml);
}

/// Reads a scene in JSON.
pub fn json(data: &[u8]) {
    native(data, json::read_json, json::write_json);
}

type Read = fn(&str, FileId, &mut Diagnostics) -> NativeScene;

/// Reads a scene, and writes what was accepted: to read that gives the same.
fn native(data: &[u8], read: Read, write: fn(&SceneDescription) -> String) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let mut out = Diagnostics::default();
    let scene = read(text, FileId(0), &mut out);
    for d in out.iter() {
        let end = d.span.start as usize + d.span.len as usize;
        // A mark one byte long may stand at the end of the text.
        assert!(!d.help.is_empty() && end <= text.len() + 1, "{d:?}");
    }
    if out.has_errors() {
        return;
    }
    let (written, mut faults) = (write(&scene.description), Diagnostics::default());
    let again = read(&written, FileId(0), &mut faults);
    assert!(!faults.has_errors(), "{faults:?} in {written}");
    assert_eq!(write(&again.description), written);
}

#[cfg(test)]
mod replayed {
    use super::*;
    use penombre_lab::kept_corpus;

    fn replay(target: &str, check: impl Fn(&[u8])) {
        for (name, data) in kept_corpus(target) {
            // A failing test shows the last line.
            eprintln!("{target}/{name}");
            check(&data);
        }
    }

    #[test]
    fn kept_meshes() {
        let folder = tempfile::tempdir().unwrap();
        for (target, format) in [
            ("obj", MeshFormat::Obj),
            ("off", MeshFormat::Off),
            ("ply", MeshFormat::Ply),
            ("stl", MeshFormat::Stl),
        ] {
            replay(target, |data| mesh(folder.path(), format, data));
        }
    }

    #[test]
    fn kept_libraries() {
        let folder = tempfile::tempdir().unwrap();
        replay("mtl", |data| mtl(folder.path(), data));
    }

    #[test]
    fn kept_archives() {
        replay("gzip", gzip);
    }

    #[test]
    fn kept_scenes() {
        replay("toml", toml);
        replay("json", json);
    }
}
