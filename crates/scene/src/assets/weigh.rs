//! How much memory files will take, told from their length, their headers and some of their lines, without decoding
//! them; and how much they took.

use super::pool;
use crate::mesh::TriangleMesh;
use crate::readers::{MeshFormat, MeshWeight, weigh};
use penombre_image::{ImageSize, PROBE_BYTES, probe};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Memory that the files of a scene take, and what is built from them, bytes. Estimated before they are decoded, exact
/// after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssetMemory {
    /// Meshes as read, each file once.
    pub meshes: u64,
    /// Images, each file once for each meaning of its numbers.
    pub images: u64,
    /// Number of pixels of those of them that lights name, once for each light: tables are made of them.
    pub lights: u64,
    /// What decoding takes besides, on all threads together.
    pub decoding: u64,
    /// Copies of meshes that the shapes that name them make, with normals.
    pub shapes: u64,
    /// Number of their triangles.
    pub triangles: u64,
}

impl AssetMemory {
    /// Adds a mesh file, or one more of the files like it that share a mesh, that so many shapes name.
    pub(super) fn add_mesh(&mut self, mesh: &MeshWeight, is_shared: bool, users: usize) {
        let users = users as u64;
        self.meshes = self.meshes.saturating_add(if is_shared { 0 } else { mesh.bytes });
        self.shapes = self.shapes.saturating_add(mesh.shape_bytes().saturating_mul(users));
        self.triangles = self.triangles.saturating_add(mesh.triangles.saturating_mul(users));
    }
}

/// Decoded files: what a thread takes for the largest, for each thread.
pub(super) fn decoding(mut takes: Vec<u64>) -> u64 {
    takes.sort_unstable_by(|a, b| b.cmp(a));
    takes.iter().take(pool::threads(takes.len())).fold(0, |sum, n| sum.saturating_add(*n))
}

/// The mesh in a file, and what decoding takes besides.
pub(super) fn mesh_file(path: &Path, said: MeshFormat, length: u64) -> (MeshWeight, u64) {
    let weight = weigh(path, said, length).unwrap_or_default();
    (weight, weight.text_bytes.saturating_add(weight.bytes))
}

/// The image in a file, if there is any, and what decoding takes besides, bytes: the file, and what the format needs.
pub(super) fn image_file(path: &Path, length: u64) -> (Option<ImageSize>, u64) {
    let head = File::open(path).and_then(|file| {
        let mut head = Vec::new();
        file.take(PROBE_BYTES).read_to_end(&mut head).map(|_| head)
    });
    let size = head.ok().and_then(|head| probe(&head, length, path));
    (size, size.map_or(length, |size| length.saturating_add(size.decoding_bytes())))
}

/// Memory of a mesh, bytes.
pub(super) fn mesh_weight(m: &TriangleMesh) -> MeshWeight {
    let triples = m.positions.len()
        + m.indices.len()
        + m.normals.len()
        + m.normal_indices.len()
        + m.uv_indices.len()
        + m.colors.len()
        + m.face_colors.len();
    MeshWeight {
        positions: m.positions.len() as u64,
        triangles: m.indices.len() as u64,
        bytes: (12 * triples + 8 * m.uvs.len() + 4 * m.slots.len()) as u64,
        has_normals: !m.normals.is_empty(),
        text_bytes: 0,
    }
}
