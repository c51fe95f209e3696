//! What the tests of mesh readers share.

use penombre_scene::readers::{Folders, MeshFormat, MeshSource, read_mesh};
use penombre_scene::{Diagnostics, MeshFile, Severity, Sources};
use std::path::{Path, PathBuf};

/// What reading a text gives.
pub struct Read {
    pub file: Option<MeshFile>,
    pub sources: Sources,
    pub out: Diagnostics,
}

impl Read {
    /// The mesh file; fails the test with the messages if there is none.
    pub fn file(&self) -> &MeshFile {
        self.file.as_ref().unwrap_or_else(|| panic!("not read: {:#?}", self.messages()))
    }

    /// `severity code file:line:column message` of every fault.
    pub fn messages(&self) -> Vec<String> {
        self.out
            .iter()
            .map(|d| {
                let place = self
                    .sources
                    .locate(d.span)
                    .map_or(String::new(), |l| format!("{}:{}:{}", l.name, l.line, l.column));
                format!("{} {} {place} {}", d.severity.name(), d.code, d.message)
            })
            .collect()
    }

    /// The one fault there is, as [`Read::messages`] has it.
    pub fn only(&self) -> String {
        let messages = self.messages();
        assert_eq!(messages.len(), 1, "{messages:#?}");
        messages.into_iter().next().unwrap_or_default()
    }
}

/// Reads bytes as if they were the file `m.obj`, `m.off` and so on in a folder.
pub fn read_in(folder: &Path, format: MeshFormat, bytes: &[u8]) -> Read {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let folders = Folders { root: folder.to_owned(), asset_roots: Vec::new() };
    let name = match format {
        MeshFormat::Obj => "m.obj",
        MeshFormat::Off => "m.off",
        MeshFormat::Ply => "m.ply",
        MeshFormat::Stl => "m.stl",
    };
    let path = folder.join(name);
    let mut source = MeshSource {
        path: &path,
        name,
        prefix: "mesh",
        folders: &folders,
        sources: &mut sources,
        out: &mut out,
    };
    let file = read_mesh(format, bytes, &mut source);
    assert_eq!(file.is_none(), out.has_errors(), "a mesh and errors, or neither");
    assert_helpful(&out);
    if let Some(file) = &file {
        assert_sound(file);
    }
    Read { file, sources, out }
}

/// Every message must name a place and say what to do.
pub fn assert_helpful(out: &Diagnostics) {
    for d in out.iter() {
        assert!(d.span.is_some() && !d.help.is_empty(), "{d:?}");
    }
}

/// The invariants that the renderer relies on.
fn assert_sound(file: &MeshFile) {
    let m = &file.mesh;
    let triangles = m.indices.len();
    assert!(m.indices.iter().flatten().all(|i| (*i as usize) < m.positions.len()));
    let within = |i: &u32, n: usize| *i == u32::MAX || (*i as usize) < n;
    assert!(m.normal_indices.iter().flatten().all(|i| within(i, m.normals.len())));
    assert!(m.uv_indices.iter().flatten().all(|i| within(i, m.uvs.len())));
    for length in [m.normal_indices.len(), m.uv_indices.len(), m.slots.len(), m.face_colors.len()] {
        assert!(length == 0 || length == triangles);
    }
    let implied =
        |n: usize, own: usize| n == 0 || own > 0 || m.indices.iter().flatten().all(|i| (*i as usize) < n);
    assert!(implied(m.normals.len(), m.normal_indices.len()) && implied(m.uvs.len(), m.uv_indices.len()));
    assert!(m.colors.is_empty() || m.colors.len() == m.positions.len());
    assert!(m.colors.iter().chain(&m.face_colors).flatten().all(|c| (0.0..=1.0).contains(c)));
    assert!(m.positions.iter().all(|p| p.is_finite()) && m.uvs.iter().all(|p| p.is_finite()));
    assert!(m.normals.iter().all(|n| n.length() == 0.0 || (n.length() - 1.0).abs() < 1e-5));
    assert!(m.slots.iter().all(|s| (*s as usize) < file.materials.len()) && !file.materials.is_empty());
    let mut names: Vec<&str> = file.materials.iter().map(|n| n.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), file.materials.len());
}

/// The folder of the large test data, if it is there; says loudly if it is not.
pub fn test_data(part: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let root = std::env::var_os("PENOMBRE_TESTDATA").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let folder = root.join(part);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("NOT RUN: the test data {part} is not there; set PENOMBRE_TESTDATA to its folder");
    None
}

/// Number of errors, warnings and remarks.
pub fn counts(out: &Diagnostics) -> [usize; 3] {
    [Severity::Error, Severity::Warning, Severity::Advice].map(|s| out.count(s))
}
