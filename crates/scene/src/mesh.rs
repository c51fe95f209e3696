//! Triangle meshes as readers deliver them.

use penombre_math::{Bounds3, Vec2, Vec3};

/// Triangles with shared positions and optional attributes. Attributes have index lists of their own where a
/// format (OBJ) indexes them apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Three position indices per triangle, each below `positions.len()`.
    pub indices: Vec<[u32; 3]>,
    /// Unit vertex normals; empty if the file has none.
    pub normals: Vec<Vec3>,
    /// Normal indices per triangle; empty: as `indices`. A corner without a normal has `u32::MAX`.
    pub normal_indices: Vec<[u32; 3]>,
    /// Texture coordinates, v upwards (v = 0 at the bottom of the image); empty if the file has none.
    pub uvs: Vec<Vec2>,
    /// UV indices per triangle; empty: as `indices`. A corner without coordinates has `u32::MAX`.
    pub uv_indices: Vec<[u32; 3]>,
    /// Linear Rec. 709 colour per position; empty if the file has none.
    pub colors: Vec<[f32; 3]>,
    /// Linear Rec. 709 colour per triangle (OFF face colours); empty if the file has none.
    pub face_colors: Vec<[f32; 3]>,
    /// Material slot per triangle, index into the file's list of materials; empty: all slot 0.
    pub slots: Vec<u32>,
}

impl TriangleMesh {
    /// The box of the positions that triangles use; positions that are not finite are passed over.
    pub fn bounds(&self) -> Bounds3 {
        let corners = self.indices.iter().flatten().map(|i| self.positions[*i as usize]);
        Bounds3::of_points(corners.filter(|p| p.is_finite()))
    }
}
