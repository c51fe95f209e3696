//! Triangles of OBJ and OFF files. Whatever else they hold is passed over: the renderer's own readers live in a crate
//! that this one must not import.

use crate::meshes::Mesh;
use penombre_math::Vec3;
use std::path::{Path, PathBuf};

/// A mesh's name: its file's, without folder and ending.
pub fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Reads a mesh by its file's ending.
pub fn read(path: &Path) -> Result<Mesh, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let text = String::from_utf8_lossy(&bytes);
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let mesh = match ending.as_str() {
        "obj" => obj(&text),
        "off" => off(&text),
        _ => return Err(format!("{}: neither .obj nor .off", path.display())),
    };
    let mesh = mesh.filter(|m| !m.indices.is_empty() && m.has_valid_indices());
    mesh.ok_or_else(|| format!("{}: no triangles that could be read", path.display()))
}

/// A file of the workspace, or of the big test data beside it.
pub fn workspace(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// A file of the big test corpora: below `$PENOMBRE_TESTDATA`, else below `shared` beside the workspace.
pub fn test_data(path: &str) -> PathBuf {
    let named = std::env::var_os("PENOMBRE_TESTDATA").map(PathBuf::from);
    named.unwrap_or_else(|| workspace("../shared")).join(path)
}

fn obj(text: &str) -> Option<Mesh> {
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh.positions.push(point(&mut words)?),
            Some("f") => {
                let known = mesh.positions.len();
                let corners: Option<Vec<u32>> = words.map(|w| corner(w, known)).collect();
                mesh.fan(&corners?);
            }
            _ => {}
        }
    }
    Some(mesh)
}

/// A vertex number of OBJ: counted from 1, or back from −1.
fn corner(word: &str, known: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 { number.checked_add_unsigned(known as u64)? } else { number - 1 };
    u32::try_from(index).ok()
}

fn off(text: &str) -> Option<Mesh> {
    let lines = text.lines().map(|l| l.split('#').next().unwrap_or_default());
    let mut words = lines.flat_map(str::split_whitespace).skip_while(|w| *w == "OFF");
    let mut count = || words.next()?.parse::<usize>().ok();
    let (vertices, faces, _) = (count()?, count()?, count()?);
    let mut mesh = Mesh::default();
    for _ in 0..vertices {
        mesh.positions.push(point(&mut words)?);
    }
    for _ in 0..faces {
        let corners: usize = words.next()?.parse().ok()?;
        let corners: Option<Vec<u32>> = (0..corners).map(|_| words.next()?.parse().ok()).collect();
        mesh.fan(&corners?);
    }
    Some(mesh)
}

fn point<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let mut number = || words.next()?.parse::<f32>().ok();
    Some(Vec3::new(number()?, number()?, number()?))
}
