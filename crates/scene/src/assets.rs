//! The files that a scene names, read once.
//!
//! [`Assets::load`] resolves every path, reads, decodes and hashes. After it no path is looked at again.
//!
//! Files are read, not mapped: a mapped file that becomes shorter, because another program writes it anew, ends the
//! process by a signal when its lost pages are touched. A mapping would save a quarter of the time that a large
//! binary mesh takes (`docs/benchmarks.md`), which is not worth that.

mod paths;
mod read;

use crate::description::{Node, NodeId, Role, SceneDescription, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::readers::{
    Folders, MeshFile, MeshFormat, MeshSource, MeshTexture, is_packed, read_mesh, unpack, without_gz,
};
use crate::span::{Sources, Span};
use penombre_image::{ColorSpace, Image, ImageErrorKind, decode};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(crate) use paths::UNREADABLE_HELP;
pub use paths::{PathFault, check_regular, resolve};
use read::read_file;

/// Most threads that decode images.
const MOST_THREADS: usize = 8;

/// The contents of the files that the nodes of a description name.
#[derive(Clone, Debug, Default)]
pub struct Assets {
    meshes: BTreeMap<NodeId, Arc<MeshFile>>,
    slots: BTreeMap<NodeId, Arc<[NodeId]>>,
    images: BTreeMap<NodeId, Arc<Image>>,
    hashes: BTreeMap<NodeId, [u8; 32]>,
    bytes: u64,
}

impl Assets {
    /// Reads every file that a shape (`file`: a mesh), a texture or a light (`file`: an image) names, each distinct
    /// file once; images in parallel.
    ///
    /// The materials and textures of mesh files are added to the description, unless every shape that names the
    /// file has a `material` of its own: names `SHAPE/MATERIAL`, after the first shape that names the file. A node
    /// of that role and name that the scene has already stands in for them.
    ///
    /// Names are relative to the folder of the file that the node's header stands in; for nodes without a place to
    /// the root folder. Faults go to `out`, with their places; what could not be read is absent.
    pub fn load(
        description: &mut SceneDescription,
        folders: &Folders,
        sources: &mut Sources,
        out: &mut Diagnostics,
    ) -> Self {
        let mut loader = Loader { description, folders, sources, out, assets: Self::default() };
        let meshes = loader.meshes();
        let images = loader.images(&meshes);
        loader.place_meshes(meshes, &images);
        loader.assets
    }

    /// The mesh file of a shape. The file's materials are named after the first shape that names it.
    pub fn mesh(&self, node: NodeId) -> Option<&Arc<MeshFile>> {
        self.meshes.get(&node)
    }

    /// The material nodes by slot of a shape whose mesh file brings its own. Empty if the node has a `material`.
    pub fn slot_materials(&self, node: NodeId) -> &[NodeId] {
        self.slots.get(&node).map_or(&[], |slots| slots)
    }

    /// The image of a texture or light.
    pub fn image(&self, node: NodeId) -> Option<&Arc<Image>> {
        self.images.get(&node)
    }

    /// Memory that the meshes and images take, bytes; files that several nodes name count once.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// BLAKE3 hashes of the contents of the files, by node, in the order of the nodes.
    pub fn content_hashes(&self) -> impl Iterator<Item = (NodeId, [u8; 32])> {
        self.hashes.iter().map(|(id, hash)| (*id, *hash))
    }
}

/// A mesh file and the shapes that name it.
struct MeshEntry {
    file: MeshFile,
    hash: [u8; 32],
    users: Vec<NodeId>,
}

/// Why there is no image, and what to do about it.
struct ImageFault {
    message: String,
    help: &'static str,
}

/// A decoded image with the hash of its file, or why there is none.
type ImageResult = Result<(Arc<Image>, [u8; 32]), ImageFault>;
/// An image file and what its numbers mean.
type ImageKey = (PathBuf, ColorSpace);
type Images = HashMap<ImageKey, ImageResult>;

struct Loader<'a> {
    description: &'a mut SceneDescription,
    folders: &'a Folders,
    sources: &'a mut Sources,
    out: &'a mut Diagnostics,
    assets: Assets,
}

impl Loader<'_> {
    /// The nodes of a role that name a file, with the name and its place.
    fn named(&self, role: Role) -> Vec<(NodeId, String, Span)> {
        let file = |node: &Node| match node.param("file").map(|p| &p.value) {
            Some(v) => match &v.kind {
                ValueKind::String(name) => Some((name.clone(), v.span)),
                _ => None,
            },
            None => None,
        };
        let nodes = self.description.of_role(role);
        nodes.filter_map(|(id, node)| file(node).map(|(name, span)| (id, name, span))).collect()
    }

    /// Finds a file that a node names; `None` after a fault.
    fn find(&mut self, id: NodeId, name: &str, span: Span) -> Option<PathBuf> {
        let base = base_folder(self.description.node(id), self.sources, self.folders);
        match self.folders.resolve(&base, name) {
            Ok(path) => Some(path),
            Err(fault) => {
                self.out.error(fault.code(), span, fault.to_string()).help = fault.help();
                None
            }
        }
    }

    /// Reads the mesh files.
    fn meshes(&mut self) -> Vec<MeshEntry> {
        let mut entries: Vec<MeshEntry> = Vec::new();
        let mut index_of: HashMap<PathBuf, Option<usize>> = HashMap::new();
        for (id, name, span) in self.named(Role::Shape) {
            let Some(path) = self.find(id, &name, span) else { continue };
            if let Some(known) = index_of.get(&path) {
                if let Some(index) = known {
                    entries[*index].users.push(id);
                }
                continue;
            }
            let entry = self.mesh(id, &name, &path, span);
            index_of.insert(path, entry.is_some().then_some(entries.len()));
            entries.extend(entry);
        }
        entries
    }

    /// Reads a mesh file that the scene calls `said`, perhaps a link to the file.
    fn mesh(&mut self, id: NodeId, said: &str, path: &Path, span: Span) -> Option<MeshEntry> {
        let name = self.folders.name_of(path);
        let by_name =
            |path: &Path| MeshFormat::of_path(path).map(|format| (format, without_gz(path) != path));
        let Some((format, gz)) = by_name(path).or_else(|| by_name(Path::new(said))) else {
            let endings = MeshFormat::ENDINGS;
            let message = format!("found `{name}`, expected a mesh: a name that ends in {endings}");
            self.out.error("asset::mesh-format", span, message).help =
                "write it as PLY or OBJ in the program that made it".to_owned();
            return None;
        };
        let bytes = self.contents(&name, path, gz, span)?;
        let format = self.format_of(&name, format, &bytes, span);
        let prefix = self.description.node(id).name.clone();
        let (folders, sources, out) = (self.folders, &mut *self.sources, &mut *self.out);
        let mut source = MeshSource { path, name: &name, prefix: &prefix, folders, sources, out };
        let (file, hash) = std::thread::scope(|scope| {
            let hash = scope.spawn(|| *blake3::hash(&bytes).as_bytes());
            let file = read_mesh(format, &bytes, &mut source);
            (file, hash.join().expect("hashing does not panic"))
        });
        Some(MeshEntry { file: file?, hash, users: vec![id] })
    }

    /// The bytes of a mesh file, unpacked. `gz`: its name says that they are packed.
    fn contents(&mut self, name: &str, path: &Path, gz: bool, span: Span) -> Option<Vec<u8>> {
        let bytes = match read_file(path) {
            Ok(bytes) => bytes,
            Err(e) => {
                self.out.error("asset::unreadable", span, format!("`{name}` cannot be read: {e}")).help =
                    UNREADABLE_HELP.to_owned();
                return None;
            }
        };
        match (gz, is_packed(&bytes)) {
            (true, true) => {}
            (false, false) => return Some(bytes),
            (false, true) => {
                let message = format!("`{name}`: byte 0: found gzip data, expected a name that ends in .gz");
                self.out.error("asset::gzip", span, message).help =
                    "unpack it, or give it a name that ends in .gz".to_owned();
                return None;
            }
            (true, false) => {
                let message = format!("`{name}` is not compressed with gzip, although its name says so");
                self.out.warning("asset::gzip", span, message).help = "remove .gz from its name".to_owned();
                return Some(bytes);
            }
        }
        match unpack(&bytes) {
            Ok(bytes) => Some(bytes),
            Err(fault) => {
                self.out.error("asset::gzip", span, format!("`{name}`: {fault}")).help =
                    fault.help().to_owned();
                None
            }
        }
    }

    /// The format of a mesh file whose name says one of them, perhaps the wrong one.
    fn format_of(&mut self, name: &str, said: MeshFormat, bytes: &[u8], span: Span) -> MeshFormat {
        match MeshFormat::of_content(bytes) {
            Some(found) if found != said => {
                let [found_name, said] = [found, said].map(MeshFormat::name);
                let message = format!(
                    "`{name}` is a {found_name} file and read as such, although its name says {said}"
                );
                self.out.warning("asset::mesh-content", span, message).help =
                    "give it a name that says what it is".to_owned();
                found
            }
            _ => said,
        }
    }

    /// Decodes all images: those of nodes and those of mesh files. Faults of nodes are reported here.
    fn images(&mut self, meshes: &[MeshEntry]) -> Images {
        let mut nodes = Vec::new();
        for role in [Role::Texture, Role::Light] {
            for (id, name, span) in self.named(role) {
                let space = color_space(self.description.node(id));
                nodes.extend(self.find(id, &name, span).map(|path| (id, (path, space), span)));
            }
        }
        let of_meshes = meshes.iter().flat_map(|m| &m.file.textures).map(image_key);
        let mut keys: Vec<ImageKey> = nodes.iter().map(|(_, key, _)| key.clone()).chain(of_meshes).collect();
        keys.sort_by(|a, b| (&a.0, a.1 as u8).cmp(&(&b.0, b.1 as u8)));
        keys.dedup();
        let images: Images = keys.iter().cloned().zip(decode_all(&keys, self.folders)).collect();
        for (image, _) in images.values().flatten() {
            self.assets.bytes +=
                u64::from(image.width()) * u64::from(image.height()) * u64::from(image.channels()) * 4;
        }
        for (id, key, span) in nodes {
            match &images[&key] {
                Ok((image, hash)) => self.place_image(id, image, *hash),
                Err(fault) => {
                    self.out.error("asset::image", span, fault.message.clone()).help = fault.help.to_owned();
                }
            }
        }
        images
    }

    fn place_image(&mut self, id: NodeId, image: &Arc<Image>, hash: [u8; 32]) {
        self.assets.images.insert(id, image.clone());
        self.assets.hashes.insert(id, hash);
    }

    fn place_meshes(&mut self, meshes: Vec<MeshEntry>, images: &Images) {
        for MeshEntry { mut file, hash, users } in meshes {
            let has_own = |id: &NodeId| self.description.node(*id).param("material").is_some();
            let users_of_slots: Vec<NodeId> = users.iter().filter(|id| !has_own(id)).copied().collect();
            if !users_of_slots.is_empty() {
                let textures = std::mem::take(&mut file.textures);
                file.textures = textures
                    .into_iter()
                    .filter(|t| self.place_texture(t, &mut file.materials, images))
                    .collect();
                let slots: Arc<[NodeId]> = file.materials.iter().map(|m| self.add_or_find(m)).collect();
                self.assets.slots.extend(users_of_slots.into_iter().map(|id| (id, slots.clone())));
            }
            self.assets.bytes += mesh_bytes(&file);
            let file = Arc::new(file);
            for id in users {
                self.assets.meshes.insert(id, file.clone());
                self.assets.hashes.insert(id, hash);
            }
        }
    }

    /// Adds the texture of a mesh file. If it has no image, its materials get their plain values, and the answer is
    /// false.
    fn place_texture(&mut self, texture: &MeshTexture, materials: &mut [Node], images: &Images) -> bool {
        match &images[&image_key(texture)] {
            Ok((image, hash)) => {
                let id = self.add_or_find(&texture.node);
                // A node that the scene has itself has its image already, or the fault was reported.
                if !self.assets.images.contains_key(&id) && self.description.node(id) == &texture.node {
                    self.place_image(id, image, *hash);
                }
                true
            }
            Err(fault) => {
                let span = texture.node.param("file").map_or(Span::NONE, |p| p.value.span);
                let message = format!("{}: the plain {} is used", fault.message, texture.what);
                self.out.warning("mtl::image", span, message).help = fault.help.to_owned();
                for (material, name) in &texture.uses {
                    materials[*material].set(name, texture.plain.clone());
                }
                false
            }
        }
    }

    /// The node of that role and name, added if there is none.
    fn add_or_find(&mut self, node: &Node) -> NodeId {
        let known = self.description.find(node.role, &node.name);
        known.unwrap_or_else(|| self.description.add(node.clone()))
    }
}

/// The folder to which the names of files in a node are relative.
pub(crate) fn base_folder(node: &Node, sources: &Sources, folders: &Folders) -> PathBuf {
    match sources.get(node.span.file).map(|f| &f.path) {
        Some(path) if !path.as_os_str().is_empty() => path.parent().unwrap_or(Path::new("")).to_owned(),
        _ => folders.root.clone(),
    }
}

/// What a node says about the numbers of its image.
fn color_space(node: &Node) -> ColorSpace {
    match node.param("encoding").map(|p| &p.value.kind) {
        Some(ValueKind::String(word)) if word == "linear" => ColorSpace::Linear,
        Some(ValueKind::String(word)) if word == "srgb" => ColorSpace::Srgb,
        _ => ColorSpace::Auto,
    }
}

fn image_key(texture: &MeshTexture) -> ImageKey {
    (texture.path.clone(), color_space(&texture.node))
}

/// Reads and decodes images on several threads; the results are in the order of the keys.
fn decode_all(keys: &[ImageKey], folders: &Folders) -> Vec<ImageResult> {
    let threads =
        std::thread::available_parallelism().map_or(1, |n| n.get()).min(MOST_THREADS).min(keys.len());
    let next = AtomicUsize::new(0);
    let work = || {
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < keys.len());
        std::iter::from_fn(take).map(|i| (i, decode_one(&keys[i], folders))).collect::<Vec<_>>()
    };
    let mut results: Vec<(usize, ImageResult)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|w| w.join().expect("decoding does not panic")).collect()
    });
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

fn decode_one((path, space): &ImageKey, folders: &Folders) -> ImageResult {
    let name = folders.name_of(path);
    let bytes = std::fs::read(path).map_err(|e| ImageFault {
        message: format!("`{name}` cannot be read: {e}"),
        help: UNREADABLE_HELP,
    })?;
    let decoded = decode(&bytes, Path::new(&name), *space)
        .map_err(|e| ImageFault { message: e.to_string(), help: image_help(&e.kind) })?;
    Ok((Arc::new(decoded.image), *blake3::hash(&bytes).as_bytes()))
}

/// What to do about an image that cannot be decoded.
fn image_help(kind: &ImageErrorKind) -> &'static str {
    match kind {
        ImageErrorKind::UnknownContent { .. } => {
            "what counts is the content and not the name: is this an image in one of these formats?"
        }
        ImageErrorKind::Malformed { .. } => "the file is damaged or was cut: save or copy it anew",
        ImageErrorKind::TooLarge { .. } | ImageErrorKind::OutOfMemory { .. } => {
            "make the image smaller; if it is not that large, the file is damaged"
        }
        _ => "save it as PNG, or as OpenEXR if it has more than 16 bits",
    }
}

fn mesh_bytes(file: &MeshFile) -> u64 {
    let m = &file.mesh;
    let triples = m.positions.len()
        + m.indices.len()
        + m.normals.len()
        + m.normal_indices.len()
        + m.uv_indices.len()
        + m.colors.len()
        + m.face_colors.len();
    (12 * triples + 8 * m.uvs.len() + 4 * m.slots.len()) as u64
}

#[cfg(test)]
mod tests;
