//! The files that a scene names, read once.
//!
//! [`Assets::load`] resolves every path, reads, decodes and hashes, meshes and images alike on all cores. After it no
//! path is looked at again. Files of the same bytes are decoded once. Messages come in the order of the nodes, whichever
//! thread was faster.
//!
//! Files are read, not mapped: a mapped file that becomes shorter, because another program writes it anew, ends the
//! process by a signal when its lost pages are touched. A mapping would save a quarter of the time that a large
//! binary mesh takes (`docs/benchmarks.md`), which is not worth that.

mod images;
mod loader;
mod meshes;
mod observe;
mod paths;
mod pool;
mod read;
mod twins;
mod weigh;

use crate::description::{NodeId, SceneDescription};
use crate::diagnostic::Diagnostics;
use crate::readers::{Folders, MeshFile};
use crate::span::Sources;
use loader::Loader;
pub(crate) use loader::base_folder;
use penombre_image::Image;
use std::collections::BTreeMap;
use std::sync::Arc;

pub use observe::{FileContent, FileRead, LoadEvent, LoadObserver};
pub(crate) use paths::UNREADABLE_HELP;
pub use paths::{PathFault, check_regular, resolve};
pub use weigh::AssetMemory;

/// The contents of the files that the nodes of a description name.
#[derive(Clone, Debug, Default)]
pub struct Assets {
    meshes: BTreeMap<NodeId, Arc<MeshFile>>,
    slots: BTreeMap<NodeId, Arc<[NodeId]>>,
    images: BTreeMap<NodeId, Arc<Image>>,
    hashes: BTreeMap<NodeId, [u8; 32]>,
    memory: AssetMemory,
}

impl Assets {
    /// Reads every file that a shape (`file`: a mesh), a texture or a light (`file`: an image) names, each distinct
    /// file once, in parallel.
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
        Self::load_observed(description, folders, sources, out, &())
    }

    /// The same; `observer` hears what happens, and may forbid to decode files when it knows how much memory they take.
    pub fn load_observed(
        description: &mut SceneDescription,
        folders: &Folders,
        sources: &mut Sources,
        out: &mut Diagnostics,
        observer: &dyn LoadObserver,
    ) -> Self {
        let mut assets = Self::default();
        Loader { description, folders, sources, out, observer, assets: &mut assets }.load();
        assets
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
        self.memory.meshes + self.memory.images
    }

    /// Memory that the files take, and the shapes that are built from them.
    pub fn memory(&self) -> AssetMemory {
        self.memory
    }

    /// BLAKE3 hashes of the contents of the files, by node, in the order of the nodes.
    pub fn content_hashes(&self) -> impl Iterator<Item = (NodeId, [u8; 32])> {
        self.hashes.iter().map(|(id, hash)| (*id, *hash))
    }
}

#[cfg(test)]
mod tests;
