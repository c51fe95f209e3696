//! Triangles that stand for a shape in raster previews.

use penombre_math::{Spectrum, Vec2, Vec3};

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
