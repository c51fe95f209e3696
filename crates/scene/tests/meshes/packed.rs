//! Mesh files that are packed with gzip, and those whose names lie.

use crate::common::counts;
use flate2::Compression;
use flate2::write::GzEncoder;
use penombre_scene::load::{LoadOptions, Loaded, load};
use penombre_scene::{Role, TriangleMesh};
use std::io::Write;
use std::path::Path;

const OFF: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn packed(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

/// Writes a file and loads it as the command does.
fn loaded(folder: &Path, name: &str, bytes: &[u8]) -> Loaded {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    load(path.to_str().unwrap(), &LoadOptions::default())
}

fn mesh(loaded: &Loaded) -> TriangleMesh {
    let (id, _) = loaded.description.of_role(Role::Shape).next().unwrap();
    (*loaded.assets.mesh(id).unwrap().mesh).clone()
}

fn messages(loaded: &Loaded) -> Vec<String> {
    loaded.diagnostics.iter().map(|d| format!("{} {} {}", d.severity.name(), d.code, d.message)).collect()
}

#[test]
fn packed_meshes_are_those_that_were_packed() {
    let folder = tempfile::tempdir().unwrap();
    let plain = loaded(folder.path(), "a.off", OFF.as_bytes());
    for (name, text) in [("a.off.gz", OFF), ("a.ply.gz", PLY), ("a.OFF.GZ", OFF)] {
        let read = loaded(folder.path(), name, &packed(text));
        assert_eq!(counts(&read.diagnostics), [0; 3], "{:?}", messages(&read));
        assert_eq!((mesh(&read), read.name.as_str(), read.bare_mesh), (mesh(&plain), "a", true));
        if text == OFF {
            let hashes = |l: &Loaded| l.assets.content_hashes().next().unwrap().1;
            assert_eq!(hashes(&read), hashes(&plain), "the hash is that of the content");
        }
    }
}

#[test]
fn damaged_packs_are_told_with_their_byte() {
    let folder = tempfile::tempdir().unwrap();
    let whole = packed(PLY);
    let cut = loaded(folder.path(), "cut.ply.gz", &whole[..whole.len() - 9]);
    let at = whole.len() - 9;
    assert_eq!(
        messages(&cut),
        [format!("error asset::gzip `cut.ply.gz`: byte {at}: found the end of the gzip data, expected more")]
    );
    let mut changed = whole.clone();
    let last = changed.len() - 6;
    changed[last] ^= 1;
    let bad = messages(&loaded(folder.path(), "bad.ply.gz", &changed));
    assert!(bad[0].starts_with("error asset::gzip `bad.ply.gz`: about byte "), "{bad:?}");
    let garbage = loaded(folder.path(), "long.ply.gz", &[&whole[..], b"more than that"].concat());
    assert_eq!(
        messages(&garbage),
        [format!(
            "error asset::gzip `long.ply.gz`: byte {}: found bytes that are no gzip data behind those that are, expected the end of the file",
            whole.len()
        )]
    );
    let padded = loaded(folder.path(), "padded.ply.gz", &[&whole[..], &[0; 1000]].concat());
    assert_eq!((mesh(&padded).indices.len(), messages(&padded).len()), (1, 0));
    let mut bomb = GzEncoder::new(Vec::new(), Compression::fast());
    (0..20).for_each(|_| bomb.write_all(&[b' '; 1 << 20]).unwrap());
    let bomb = loaded(folder.path(), "bomb.obj.gz", &bomb.finish().unwrap());
    assert!(messages(&bomb)[0].starts_with(
        "error asset::gzip `bomb.obj.gz`: byte 0: found gzip data that unpack to more than 16777216"
    ));
}

#[test]
fn names_that_lie() {
    let folder = tempfile::tempdir().unwrap();
    let read = loaded(folder.path(), "a.obj", PLY.as_bytes());
    assert_eq!(mesh(&read).indices, [[0, 1, 2]]);
    assert_eq!(
        messages(&read),
        ["warning asset::mesh-content `a.obj` is a PLY file and read as such, although its name says OBJ"]
    );
    let read = loaded(folder.path(), "b.ply.gz", PLY.as_bytes());
    assert_eq!(mesh(&read).indices, [[0, 1, 2]]);
    assert_eq!(
        messages(&read),
        ["warning asset::gzip `b.ply.gz` is not compressed with gzip, although its name says so"]
    );
    let read = loaded(folder.path(), "c.ply", &packed(PLY));
    assert!(messages(&read)[0].starts_with("error load::kind"), "{:?}", messages(&read));
    std::fs::write(
        folder.path().join("s.toml"),
        "penombre = 1\n[shape.m]\ntype = \"mesh\"\nfile = \"c.ply\"\n",
    )
    .unwrap();
    let read = load(folder.path().join("s.toml").to_str().unwrap(), &LoadOptions::default());
    assert_eq!(
        messages(&read)[0],
        "error asset::gzip `c.ply`: byte 0: found gzip data, expected a name that ends in .gz"
    );
}
