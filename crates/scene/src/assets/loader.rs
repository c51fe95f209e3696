//! From names to the contents of files: what is named, what of it is the same, and reading it on several threads.

use super::images::{ImageKey, ImageResult, Images};
use super::meshes::{MeshEntry, MeshRead, format_by_name};
use super::observe::{FileContent, FileRead, LoadEvent, LoadObserver};
use super::twins::first_alike;
use super::weigh::{decoding, image_file, mesh_file, mesh_weight};
use super::{AssetMemory, Assets, pool};
use crate::description::{Node, NodeId, Role, SceneDescription, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::readers::{Folders, MeshFile, MeshTexture, MeshWeight};
use crate::span::{Sources, Span};
use penombre_image::{Image, ImageSize};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// The folder to which the names of files in a node are relative.
pub(crate) fn base_folder(node: &Node, sources: &Sources, folders: &Folders) -> PathBuf {
    match sources.get(node.span.file).map(|f| &f.path) {
        Some(path) if !path.as_os_str().is_empty() => path.parent().unwrap_or(Path::new("")).to_owned(),
        _ => folders.root.clone(),
    }
}

pub(super) struct Loader<'a> {
    pub description: &'a mut SceneDescription,
    pub folders: &'a Folders,
    pub sources: &'a mut Sources,
    pub out: &'a mut Diagnostics,
    pub observer: &'a dyn LoadObserver,
    pub assets: &'a mut Assets,
}

/// A node and the image that it names.
type ImageUse = (NodeId, ImageKey, Span);

/// The mesh files that shapes name, and the faults of those names: before each file those of the shapes up to it.
#[derive(Default)]
struct NamedMeshes {
    entries: Vec<(Diagnostics, MeshEntry)>,
    /// Behind the last file.
    rest: Diagnostics,
}

/// A mesh that was read, the hash of its file and the shapes that name it.
type PlacedMesh = (MeshFile, [u8; 32], Vec<NodeId>);

/// Files that are to be decoded at the same time.
struct Batch<'a> {
    meshes: Vec<&'a MeshEntry>,
    /// With their lengths in bytes.
    images: Vec<(ImageKey, u64)>,
    /// What lights name.
    lights: &'a [ImageKey],
}

/// What one of them holds, before it is decoded.
enum Weight {
    Mesh(MeshWeight),
    Image(Option<ImageSize>),
}

/// What came of them.
struct Decoded {
    meshes: Vec<MeshRead>,
    images: Vec<ImageResult>,
}

/// What came of one.
enum Read {
    Mesh(MeshRead),
    Image(ImageResult),
}

impl Loader<'_> {
    /// Reads all that the nodes name.
    pub fn load(mut self) {
        let named = self.named_meshes();
        let mut image_faults = Diagnostics::default();
        let uses = self.named_images(&mut image_faults);
        let meshes = named.entries.iter().map(|(_, entry)| entry).collect();
        let keys = uses.iter().map(|(_, key, _)| key.clone());
        let is_light = |id: NodeId| self.description.node(id).role == Role::Light;
        let lights: Vec<ImageKey> =
            uses.iter().filter(|(id, ..)| is_light(*id)).map(|(_, key, _)| key.clone()).collect();
        let batch = Batch { meshes, images: distinct(keys, &Images::new()), lights: &lights };
        let forbidden = self.observer.approve(self.description, &|| batch.memory());
        let decoded = if forbidden.is_none() { self.decode(&batch) } else { Decoded::nothing() };
        let Decoded { meshes, images } = decoded;
        let mut images: Images = batch.images.into_iter().map(|(key, _)| key).zip(images).collect();
        let meshes = self.join(named, meshes);
        self.out.extend(image_faults);
        if let Some(fault) = forbidden {
            return self.out.push(fault);
        }
        if self.decode_textures(&meshes, &mut images, &lights) {
            self.place_images(&uses, &images);
            self.place_meshes(meshes, &images);
        }
    }

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
    fn find(&self, id: NodeId, name: &str, span: Span, out: &mut Diagnostics) -> Option<PathBuf> {
        let base = base_folder(self.description.node(id), self.sources, self.folders);
        match self.folders.resolve(&base, name) {
            Ok(path) => Some(path),
            Err(fault) => {
                out.error(fault.code(), span, fault.to_string()).help = fault.help();
                None
            }
        }
    }

    /// The mesh files, each once.
    fn named_meshes(&self) -> NamedMeshes {
        let mut named = NamedMeshes::default();
        let mut index_of: HashMap<PathBuf, usize> = HashMap::new();
        for (id, said, span) in self.named(Role::Shape) {
            let Some(path) = self.find(id, &said, span, &mut named.rest) else { continue };
            if let Some(index) = index_of.get(&path) {
                named.entries[*index].1.users.push(id);
                continue;
            }
            index_of.insert(path.clone(), named.entries.len());
            let entry = MeshEntry {
                name: self.folders.name_of(&path),
                // The scene may name a link to the file.
                format: format_by_name(&path).or_else(|| format_by_name(Path::new(&said))),
                length: length(&path),
                span,
                shape: self.description.node(id).name.clone(),
                users: vec![id],
                path,
            };
            named.entries.push((std::mem::take(&mut named.rest), entry));
        }
        named
    }

    /// The images that textures and lights name.
    fn named_images(&self, out: &mut Diagnostics) -> Vec<ImageUse> {
        let mut uses = Vec::new();
        for (id, name, span) in [Role::Texture, Role::Light].into_iter().flat_map(|role| self.named(role)) {
            if let Some(path) = self.find(id, &name, span, out) {
                uses.push((id, ImageKey::of_node(self.description.node(id), path), span));
            }
        }
        uses
    }

    /// Decodes files, those of the same bytes once.
    fn decode(&self, batch: &Batch<'_>) -> Decoded {
        let (files, bytes) = batch.size();
        if files > 0 {
            self.observer.on(LoadEvent::Found { files, bytes });
        }
        let mesh_twins = first_alike(&batch.meshes.iter().map(|m| m.candidate()).collect::<Vec<_>>());
        let images = batch.images.iter().map(|(key, length)| key.candidate(*length));
        let image_twins = first_alike(&images.collect::<Vec<_>>());
        let behind = image_twins.into_iter().map(|first| first + batch.meshes.len());
        let first: Vec<usize> = mesh_twins.into_iter().chain(behind).collect();
        let mut reads: Vec<Option<Read>> = Vec::new();
        reads.resize_with(files, || None);
        let alone = (0..files).filter(|i| first[*i] == *i).collect::<Vec<_>>();
        self.read_all(batch, &alone, &mut reads);
        // A copy about which there is something to say is read for itself.
        for copy in (0..files).filter(|i| first[*i] != *i) {
            let original = reads[first[copy]].as_ref();
            reads[copy] = original.and_then(|read| self.share(batch, read, [first[copy], copy]));
        }
        let rest = (0..files).filter(|i| reads[*i].is_none()).collect::<Vec<_>>();
        self.read_all(batch, &rest, &mut reads);
        Decoded::of(reads)
    }

    /// Reads some files of a batch on several threads.
    fn read_all(&self, batch: &Batch<'_>, wanted: &[usize], reads: &mut [Option<Read>]) {
        let weights: Vec<u64> = wanted.iter().map(|i| batch.length(*i)).collect();
        let sources = &*self.sources;
        let (folders, observer) = (self.folders, self.observer);
        let done = pool::each(&weights, |i| batch.read(wanted[i], folders, sources, observer));
        for (i, read) in wanted.iter().zip(done) {
            reads[*i] = Some(read);
        }
    }

    /// What was read of the first of two files of the same bytes, for the other one; `None` if it must be read itself.
    fn share(&self, batch: &Batch<'_>, read: &Read, [first, copy]: [usize; 2]) -> Option<Read> {
        let shared = match read {
            Read::Mesh(mesh) => {
                Read::Mesh(mesh.shared(batch.meshes[first], batch.meshes[copy], self.sources)?)
            }
            Read::Image(image) => Read::Image(Ok(image.as_ref().ok()?.clone())),
        };
        let name = batch.name(copy, self.folders);
        let (bytes, content, time) = (batch.length(copy), FileContent::Copy, std::time::Duration::ZERO);
        self.observer.on(LoadEvent::Read(FileRead { name: &name, bytes, content, time }));
        Some(shared)
    }

    /// Joins what was read with the scene's texts and faults, in the order of the nodes.
    fn join(&mut self, named: NamedMeshes, reads: Vec<MeshRead>) -> Vec<PlacedMesh> {
        let mut placed = Vec::new();
        let mut reads = reads.into_iter();
        for (faults, entry) in named.entries {
            self.out.extend(faults);
            let found = reads.next().and_then(|read| read.join(self.sources, self.out));
            placed.extend(found.map(|(file, hash)| (file, hash, entry.users)));
        }
        self.out.extend(named.rest);
        placed
    }

    /// Decodes the images that the materials of meshes name and that are not there yet. False if that was forbidden.
    fn decode_textures(&mut self, meshes: &[PlacedMesh], images: &mut Images, lights: &[ImageKey]) -> bool {
        self.assets.memory = memory_of(meshes, images, lights);
        let textures = meshes.iter().flat_map(|(file, ..)| &file.textures).map(ImageKey::of_texture);
        let batch = Batch { meshes: Vec::new(), images: distinct(textures, images), lights: &[] };
        if batch.images.is_empty() {
            return true;
        }
        let known = self.assets.memory;
        let memory = || {
            let more = batch.memory();
            AssetMemory { images: known.images.saturating_add(more.images), decoding: more.decoding, ..known }
        };
        if let Some(fault) = self.observer.approve(self.description, &memory) {
            self.out.push(fault);
            return false;
        }
        let decoded = self.decode(&batch).images;
        images.extend(batch.images.into_iter().map(|(key, _)| key).zip(decoded));
        self.assets.memory = memory_of(meshes, images, lights);
        true
    }

    /// Gives the images to the nodes that name them.
    fn place_images(&mut self, uses: &[ImageUse], images: &Images) {
        for (id, key, span) in uses {
            match &images[key] {
                Ok((image, hash)) => self.place_image(*id, image, *hash),
                Err(fault) => {
                    self.out.error("asset::image", *span, fault.message.clone()).help = fault.help.to_owned();
                }
            }
        }
    }

    fn place_image(&mut self, id: NodeId, image: &Arc<Image>, hash: [u8; 32]) {
        self.assets.images.insert(id, image.clone());
        self.assets.hashes.insert(id, hash);
    }

    fn place_meshes(&mut self, meshes: Vec<PlacedMesh>, images: &Images) {
        for (mut file, hash, users) in meshes {
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
        match &images[&ImageKey::of_texture(texture)] {
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

impl Batch<'_> {
    /// Number of files, and their bytes.
    fn size(&self) -> (usize, u64) {
        let files = self.meshes.len() + self.images.len();
        (files, (0..files).fold(0, |sum: u64, i| sum.saturating_add(self.length(i))))
    }

    /// Length of a file, bytes. Images come behind meshes.
    fn length(&self, index: usize) -> u64 {
        match index.checked_sub(self.meshes.len()) {
            None => self.meshes[index].length,
            Some(image) => self.images[image].1,
        }
    }

    /// How messages call a file.
    fn name(&self, index: usize, folders: &Folders) -> String {
        match index.checked_sub(self.meshes.len()) {
            None => self.meshes[index].name.clone(),
            Some(image) => folders.name_of(&self.images[image].0.path),
        }
    }

    /// The memory that the files will take.
    fn memory(&self) -> AssetMemory {
        let weights: Vec<u64> = (0..self.size().0).map(|i| self.length(i)).collect();
        let weighed = pool::each(&weights, |i| match i.checked_sub(self.meshes.len()) {
            None => {
                let mesh = self.meshes[i];
                let found = mesh.format.map(|(format, _)| mesh_file(&mesh.path, format, mesh.length));
                let (weight, decoding) = found.unwrap_or_default();
                (Weight::Mesh(weight), decoding)
            }
            Some(image) => {
                let (size, decoding) = image_file(&self.images[image].0.path, weights[i]);
                (Weight::Image(size), decoding)
            }
        });
        let mut memory = AssetMemory::default();
        for (i, (weight, _)) in weighed.iter().enumerate() {
            match weight {
                Weight::Mesh(mesh) => memory.add_mesh(mesh, false, self.meshes[i].users.len()),
                Weight::Image(size) => {
                    let key = &self.images[i - self.meshes.len()].0;
                    let lights = self.lights.iter().filter(|light| *light == key).count() as u64;
                    let (bytes, pixels) = size.map_or((0, 0), |size| (size.bytes(), size.pixels()));
                    memory.images = memory.images.saturating_add(bytes);
                    memory.lights = memory.lights.saturating_add(pixels.saturating_mul(lights));
                }
            }
        }
        memory.decoding = decoding(weighed.into_iter().map(|(_, decoding)| decoding).collect());
        memory
    }

    /// Reads one file and tells it.
    fn read(&self, index: usize, folders: &Folders, sources: &Sources, observer: &dyn LoadObserver) -> Read {
        let begin = Instant::now();
        let name = self.name(index, folders);
        let (read, content) = match index.checked_sub(self.meshes.len()) {
            None => {
                let read = self.meshes[index].read(folders, sources);
                let triangles = read.found.as_ref().map(|(file, _)| file.mesh.indices.len());
                let content = triangles.map(|triangles| FileContent::Mesh { triangles });
                (Read::Mesh(read), content)
            }
            Some(image) => {
                let read = self.images[image].0.read(&name);
                let size = read.as_ref().ok().map(|(image, _)| [image.width(), image.height()]);
                let content = size.map(|size| FileContent::Image { size });
                (Read::Image(read), content)
            }
        };
        let content = content.unwrap_or(FileContent::Fault);
        let (bytes, time) = (self.length(index), begin.elapsed());
        observer.on(LoadEvent::Read(FileRead { name: &name, bytes, content, time }));
        read
    }
}

impl Decoded {
    fn nothing() -> Self {
        Self { meshes: Vec::new(), images: Vec::new() }
    }

    fn of(reads: Vec<Option<Read>>) -> Self {
        let mut decoded = Self::nothing();
        for read in reads.into_iter().flatten() {
            match read {
                Read::Mesh(mesh) => decoded.meshes.push(mesh),
                Read::Image(image) => decoded.images.push(image),
            }
        }
        decoded
    }
}

/// Images that are not there yet, each once, with their lengths.
fn distinct(keys: impl Iterator<Item = ImageKey>, known: &Images) -> Vec<(ImageKey, u64)> {
    let mut seen = HashSet::new();
    let new = keys.filter(|key| !known.contains_key(key) && seen.insert(key.clone()));
    let new: Vec<ImageKey> = new.collect();
    let lengths: Vec<u64> = new.iter().map(|key| length(&key.path)).collect();
    new.into_iter().zip(lengths).collect()
}

fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |m| m.len())
}

/// The memory that meshes and images take; what several files share counts once.
fn memory_of(meshes: &[PlacedMesh], images: &Images, lights: &[ImageKey]) -> AssetMemory {
    let mut memory = AssetMemory::default();
    let mut seen = HashSet::new();
    for (file, _, users) in meshes {
        let is_shared = !seen.insert(Arc::as_ptr(&file.mesh));
        memory.add_mesh(&mesh_weight(&file.mesh), is_shared, users.len());
    }
    let mut seen = HashSet::new();
    for (image, _) in images.values().flatten() {
        if seen.insert(Arc::as_ptr(image)) {
            memory.images += image.bytes();
        }
    }
    let of_lights = lights.iter().filter_map(|key| images.get(key)?.as_ref().ok());
    memory.lights = of_lights.map(|(image, _)| image.pixel_count() as u64).sum();
    memory
}
