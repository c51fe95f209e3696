//! Triangles that stand for a shape in raster previews.

use super::ShapePoint;
use penombre_math::{Spectrum, Vec2, Vec3};

/// How finely a shape is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    /// About so many triangles for a shape that is curved; it has a least and a most number of its own.
    pub curved: usize,
    /// Most triangles of a mesh; of a larger one some are left out, evenly.
    pub most: usize,
}

impl Detail {
    /// As fine as it makes sense, and all of a mesh.
    pub const FULL: Self = Self { curved: usize::MAX, most: usize::MAX };
}

/// Triangles that look like a shape, in the space of its geometry. Every vertex has all attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Surface coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertex colours; white where the shape has none.
    pub colors: Vec<Spectrum>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
    /// Material slot of each triangle; empty: all slot 0.
    pub slots: Vec<u32>,
    /// Triangles of the shape that are not among them.
    pub left_out: usize,
}

impl Tessellation {
    /// A grid over the unit square of surface coordinates, `columns` × `rows` cells; `at` gives position and normal
    /// at (u, v).
    pub fn grid(columns: u32, rows: u32, at: impl Fn(Vec2) -> (Vec3, Vec3)) -> Self {
        let mut result = Self::default();
        for row in 0..=rows {
            for column in 0..=columns {
                let uv = Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32);
                let (p, n) = at(uv);
                result.push(p, n, uv, Spectrum::WHITE);
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = row * (columns + 1) + column;
                let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
                result.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        result
    }

    /// Adds a vertex and returns its index.
    pub fn push(&mut self, p: Vec3, n: Vec3, uv: Vec2, color: Spectrum) -> u32 {
        self.positions.push(p);
        self.normals.push(n);
        self.uvs.push(uv);
        self.colors.push(color);
        self.positions.len() as u32 - 1
    }
}

/// Collects the corners of a mesh, each vertex once as long as all its triangles see the same attributes there.
pub(super) struct Corners {
    pub result: Tessellation,
    /// The latest vertex at each position of the mesh, and for each vertex the one before it at the same position.
    latest: Vec<u32>,
    before: Vec<u32>,
}

/// No vertex.
const NONE: u32 = u32::MAX;

impl Corners {
    /// None yet, of a mesh with so many positions.
    pub fn new(positions: usize) -> Self {
        Self { result: Tessellation::default(), latest: vec![NONE; positions], before: Vec::new() }
    }

    /// The vertex at a position (its index in the mesh, and where it is) with the attributes of a point.
    pub fn vertex(&mut self, index: u32, position: Vec3, at: &ShapePoint) -> u32 {
        let mut known = self.latest[index as usize];
        while known != NONE {
            let i = known as usize;
            let r = &self.result;
            if (r.normals[i], r.uvs[i], r.colors[i]) == (at.ns, at.uv, at.color) {
                return known;
            }
            known = self.before[i];
        }
        let new = self.result.push(position, at.ns, at.uv, at.color);
        self.before.push(std::mem::replace(&mut self.latest[index as usize], new));
        new
    }
}
