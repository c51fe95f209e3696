//! Readers of mesh files.
//!
//! They take bytes, report every fault with line and column, and stop after 20 errors. What a file says in vain
//! (a two-corner face, a missing library) is a warning; what would be guessed at is an error.

mod colors;
mod encoding;
mod faults;
mod gzip;
mod lexer;
mod looks;
mod map;
mod materials;
mod mtl;
mod obj;
mod off;
mod ply;
mod polygon;
mod smoothing;
mod soup;
mod stl;
mod weigh;

use crate::assets::{PathFault, resolve};
use crate::description::{Node, Value};
use crate::diagnostic::Diagnostics;
use crate::mesh::TriangleMesh;
use crate::span::Sources;
pub(crate) use encoding::by_mark as wide_encoding;
use faults::Faults;
pub use gzip::{GzipFault, is_packed, unpack, without_gz};
use std::path::{Path, PathBuf};
use std::sync::Arc;
pub use weigh::{MeshWeight, weigh};

/// A mesh file: its triangles and what they are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The triangles; files of the same bytes share them.
    pub mesh: Arc<TriangleMesh>,
    /// The material nodes by slot; never empty. Behind them those that `mix` materials are made of. Their names begin
    /// with [`MeshSource::prefix`].
    pub materials: Vec<Node>,
    /// The images that they use.
    pub textures: Vec<MeshTexture>,
}

/// An image that a material of a mesh file uses.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshTexture {
    /// The texture node, type `image`; has the name of its material, and behind a slash that of its use if it is not
    /// the diffuse colour. Its `file` is relative to the scene's folder, or absolute if it lies below an asset root.
    pub node: Node,
    /// The file.
    pub path: PathBuf,
    /// Where it is used: indices into [`MeshFile::materials`] and names of parameters.
    pub uses: Vec<(usize, &'static str)>,
    /// What messages call it: `colour`, `opacity`.
    pub what: &'static str,
    /// What is used if the file cannot be decoded.
    pub plain: Value,
}

/// The folders below which files may be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Folders {
    /// The folder of the main scene file.
    pub root: PathBuf,
    /// Further folders (`--asset-root`).
    pub asset_roots: Vec<PathBuf>,
}

impl Folders {
    /// Finds a file that another file in the folder `base` names: see [`resolve`].
    ///
    /// # Errors
    /// As [`resolve`].
    pub fn resolve(&self, base: &Path, name: &str) -> Result<PathBuf, PathFault> {
        resolve(&self.root, &self.asset_roots, base, name)
    }

    /// How scenes and messages call a file that [`Folders::resolve`] found: relative to the scene's folder if it
    /// lies there, with forward slashes.
    pub fn name_of(&self, path: &Path) -> String {
        let root = if self.root.as_os_str().is_empty() { Path::new(".") } else { &self.root };
        let relative = root.canonicalize().ok().and_then(|r| path.strip_prefix(r).ok().map(Path::to_owned));
        match relative {
            Some(p) => p.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"),
            None => path.to_string_lossy().into_owned(),
        }
    }
}

/// Where a mesh file comes from, and where its faults go.
pub struct MeshSource<'a> {
    /// The file; its libraries are looked for in its folder.
    pub path: &'a Path,
    /// How messages call it.
    pub name: &'a str,
    /// What the names of its materials begin with, before a slash: the name of the shape.
    pub prefix: &'a str,
    /// What may be read.
    pub folders: &'a Folders,
    /// Gets excerpts around faults.
    pub sources: &'a mut Sources,
    /// Gets the faults.
    pub out: &'a mut Diagnostics,
}

/// The formats of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Geomview's Object File Format.
    Off,
    /// Wavefront's object file.
    Obj,
    /// The polygon file format of Stanford.
    Ply,
    /// The format of stereolithography.
    Stl,
}

impl MeshFormat {
    /// How the names of mesh files end, for messages.
    pub const ENDINGS: &str = ".obj, .off, .ply or .stl (or one of these and .gz)";

    /// The format by the ending of a file's name, in upper or lower case; `.gz` may follow it.
    pub fn of_path(path: &Path) -> Option<Self> {
        let inner = without_gz(path);
        match inner.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "off" => Some(Self::Off),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }

    /// The format by the first bytes of a file, where they are certain.
    pub fn of_content(bytes: &[u8]) -> Option<Self> {
        ply::has_magic(bytes).then_some(Self::Ply)
    }

    /// The name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "OFF",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        }
    }
}

/// Reads a mesh file of a known format. Faults go to the source; `None` after errors.
pub fn read_mesh(format: MeshFormat, bytes: &[u8], source: &mut MeshSource<'_>) -> Option<MeshFile> {
    match format {
        MeshFormat::Off => read_off(bytes, source),
        MeshFormat::Obj => read_obj(bytes, source),
        MeshFormat::Ply => read_ply(bytes, source),
        MeshFormat::Stl => read_stl(bytes, source),
    }
}

/// Reads an OFF file \[Geomview\]: prefixes `ST`, `C`, `N`; polygons; colours of vertices and faces. Faults go to
/// the source; `None` after errors.
pub fn read_off(bytes: &[u8], source: &mut MeshSource<'_>) -> Option<MeshFile> {
    let mut faults = Faults::new(bytes, source.path, source.name, source.sources, source.out);
    let mesh = off::parse(bytes, &mut faults)?;
    tell_empty(&mesh, "a triangle is a line such as `3 0 1 2`", &mut faults);
    Some(plain(mesh, source.prefix))
}

/// Reads a PLY file \[Turk1994\], text or binary: positions, normals, texture coordinates and colours of vertices;
/// polygons, their colours, and strips of triangles. Faults go to the source; `None` after errors.
pub fn read_ply(bytes: &[u8], source: &mut MeshSource<'_>) -> Option<MeshFile> {
    let mut faults = Faults::new(bytes, source.path, source.name, source.sources, source.out);
    let mesh = ply::parse(bytes, &mut faults)?;
    tell_empty(&mesh, "triangles are in the element `face`: points alone are not rendered", &mut faults);
    Some(plain(mesh, source.prefix))
}

/// Reads an STL file \[Burns1993\], text or binary, with the colours of binary ones. Corners at one position become
/// one vertex. Faults go to the source; `None` after errors.
pub fn read_stl(bytes: &[u8], source: &mut MeshSource<'_>) -> Option<MeshFile> {
    let mut faults = Faults::new(bytes, source.path, source.name, source.sources, source.out);
    let mesh = stl::parse(bytes, &mut faults)?;
    tell_empty(&mesh, "was the right part of the model exported?", &mut faults);
    Some(plain(mesh, source.prefix))
}

/// Reads an OBJ file \[WavefrontObj\] and its material libraries \[WavefrontMtl\]. Attribute indices are kept apart,
/// so positions and their indices are those of the same mesh in OFF. Faults go to the source; `None` after errors.
pub fn read_obj(bytes: &[u8], source: &mut MeshSource<'_>) -> Option<MeshFile> {
    let mut faults = Faults::new(bytes, source.path, source.name, source.sources, source.out);
    let file = obj::parse(bytes, &mut faults)?;
    let (mut materials, textures) =
        materials::of_obj(&file, source.path, source.prefix, source.folders, &mut faults)?;
    tell_empty(&file.mesh, "a triangle is a line such as `f 1 2 3`", &mut faults);
    if materials.is_empty() {
        materials.push(materials::plain(source.prefix));
    }
    Some(MeshFile { mesh: Arc::new(file.mesh), materials, textures })
}

/// A mesh with the material of files that name none.
fn plain(mesh: TriangleMesh, prefix: &str) -> MeshFile {
    MeshFile { mesh: Arc::new(mesh), materials: vec![materials::plain(prefix)], textures: Vec::new() }
}

impl MeshFile {
    /// The same triangles for another shape; `None` if the file brings materials of its own.
    pub(crate) fn shared(&self, own: &str, other: &str) -> Option<Self> {
        let is_plain = self.textures.is_empty() && self.materials == [materials::plain(own)];
        is_plain.then(|| Self {
            mesh: self.mesh.clone(),
            materials: vec![materials::plain(other)],
            textures: Vec::new(),
        })
    }
}

fn tell_empty(mesh: &TriangleMesh, help: &str, faults: &mut Faults<'_>) {
    if mesh.indices.is_empty() {
        let end = faults.end();
        let message = "there is no triangle in the file: nothing of it will be seen";
        faults.warning("mesh::empty", end, message, help);
    }
}
