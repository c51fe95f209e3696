//! Mesh files.

use super::UNREADABLE_HELP;
use super::read::read_file;
use super::twins::Candidate;
use crate::description::NodeId;
use crate::diagnostic::Diagnostics;
use crate::readers::{Folders, MeshFile, MeshFormat, MeshSource, is_packed, read_mesh, unpack, without_gz};
use crate::span::{Sources, Span};
use std::path::{Path, PathBuf};

/// A mesh file and the shapes that name it.
pub(super) struct MeshEntry {
    pub path: PathBuf,
    /// How messages call it.
    pub name: String,
    /// The format by its name, or by that of a link to it, and whether it is packed.
    pub format: Option<(MeshFormat, bool)>,
    /// Length, bytes.
    pub length: u64,
    /// Where the scene names it.
    pub span: Span,
    /// Name of the first shape that does.
    pub shape: String,
    /// All shapes that do.
    pub users: Vec<NodeId>,
}

/// What came of a mesh file.
pub(super) struct MeshRead {
    /// The mesh and the hash of its file.
    pub found: Option<(MeshFile, [u8; 32])>,
    /// Texts and faults, to be joined with those of the scene.
    pub sources: Sources,
    pub out: Diagnostics,
}

/// The format that a name says, and whether the file is packed.
pub(super) fn format_by_name(path: &Path) -> Option<(MeshFormat, bool)> {
    MeshFormat::of_path(path).map(|format| (format, without_gz(path) != path))
}

/// What two files must share for their meshes to be the same: libraries of OBJ files are looked for in their folder.
type MeshKind<'a> = (&'static str, bool, Option<&'a Path>);

impl MeshEntry {
    pub fn candidate(&self) -> Candidate<'_, MeshKind<'_>> {
        let (name, packed) = self.format.map_or(("", false), |(format, packed)| (format.name(), packed));
        let folder = self.path.parent().filter(|_| name == MeshFormat::Obj.name());
        Candidate { path: &self.path, length: self.length, kind: (name, packed, folder) }
    }

    /// Reads it. The texts are numbered as a branch of `sources`.
    pub fn read(&self, folders: &Folders, sources: &Sources) -> MeshRead {
        let mut read = MeshRead { found: None, sources: sources.branch(), out: Diagnostics::default() };
        read.found = self.mesh(folders, &mut read.sources, &mut read.out);
        read
    }

    fn mesh(
        &self,
        folders: &Folders,
        sources: &mut Sources,
        out: &mut Diagnostics,
    ) -> Option<(MeshFile, [u8; 32])> {
        let Some((format, gz)) = self.format else {
            let endings = MeshFormat::ENDINGS;
            let message = format!("found `{}`, expected a mesh: a name that ends in {endings}", self.name);
            out.error("asset::mesh-format", self.span, message).help =
                "write it as PLY or OBJ in the program that made it".to_owned();
            return None;
        };
        let bytes = self.contents(gz, out)?;
        let format = self.format_of(format, &bytes, out);
        let mut source =
            MeshSource { path: &self.path, name: &self.name, prefix: &self.shape, folders, sources, out };
        let (file, hash) = std::thread::scope(|scope| {
            let hash = scope.spawn(|| *blake3::hash(&bytes).as_bytes());
            let file = read_mesh(format, &bytes, &mut source);
            (file, hash.join().expect("hashing does not panic"))
        });
        Some((file?, hash))
    }

    /// The bytes of the file, unpacked. `gz`: its name says that they are packed.
    fn contents(&self, gz: bool, out: &mut Diagnostics) -> Option<Vec<u8>> {
        let name = &self.name;
        let bytes = match read_file(&self.path) {
            Ok(bytes) => bytes,
            Err(e) => {
                let message = format!("`{name}` cannot be read: {e}");
                out.error("asset::unreadable", self.span, message).help = UNREADABLE_HELP.to_owned();
                return None;
            }
        };
        match (gz, is_packed(&bytes)) {
            (true, true) => {}
            (false, false) => return Some(bytes),
            (false, true) => {
                let message = format!("`{name}`: byte 0: found gzip data, expected a name that ends in .gz");
                out.error("asset::gzip", self.span, message).help =
                    "unpack it, or give it a name that ends in .gz".to_owned();
                return None;
            }
            (true, false) => {
                let message = format!("`{name}` is not compressed with gzip, although its name says so");
                out.warning("asset::gzip", self.span, message).help = "remove .gz from its name".to_owned();
                return Some(bytes);
            }
        }
        match unpack(&bytes) {
            Ok(bytes) => Some(bytes),
            Err(fault) => {
                out.error("asset::gzip", self.span, format!("`{name}`: {fault}")).help =
                    fault.help().to_owned();
                None
            }
        }
    }

    /// The format of a file whose name says one of them, perhaps the wrong one.
    fn format_of(&self, said: MeshFormat, bytes: &[u8], out: &mut Diagnostics) -> MeshFormat {
        match MeshFormat::of_content(bytes) {
            Some(found) if found != said => {
                let [found_name, said] = [found, said].map(MeshFormat::name);
                let name = &self.name;
                let message = format!(
                    "`{name}` is a {found_name} file and read as such, although its name says {said}"
                );
                out.warning("asset::mesh-content", self.span, message).help =
                    "give it a name that says what it is".to_owned();
                found
            }
            _ => said,
        }
    }
}

impl MeshRead {
    /// The same mesh for another file of the same bytes; `None` if there is something to say about it, or it brings
    /// materials, for these have names of their own.
    pub fn shared(&self, own: &MeshEntry, other: &MeshEntry, sources: &Sources) -> Option<Self> {
        let (file, hash) = self.found.as_ref().filter(|_| self.out.is_empty())?;
        let file = file.shared(&own.shape, &other.shape)?;
        Some(Self { found: Some((file, *hash)), sources: sources.branch(), out: Diagnostics::default() })
    }

    /// Joins its texts and faults with those of the scene.
    pub fn join(self, sources: &mut Sources, out: &mut Diagnostics) -> Option<(MeshFile, [u8; 32])> {
        let Self { mut found, sources: own, out: mut faults } = self;
        let moved = sources.append(own);
        faults.for_each_span(|span| moved.apply(span));
        out.extend(faults);
        for texture in found.iter_mut().flat_map(|(file, _)| &mut file.textures) {
            texture.node.params.iter_mut().for_each(|p| moved.apply(&mut p.value.span));
        }
        found
    }
}
