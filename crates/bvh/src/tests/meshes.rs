//! Shapes and directions for tests and benches, made of nothing but roots and integers.

use super::{Geometry, Triangles};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// An indexed mesh.
#[derive(Clone, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub indices: Vec<[u32; 3]>,
}

impl Mesh {
    pub fn geometry(&self) -> Geometry {
        Geometry::Triangles(Triangles {
            positions: Arc::from(&*self.positions),
            indices: Arc::from(&*self.indices),
        })
    }

    pub fn map(mut self, f: impl FnMut(Vec3) -> Vec3) -> Self {
        self.positions = self.positions.into_iter().map(f).collect();
        self
    }
}

/// 20·4^level triangles on the unit sphere.
pub fn icosphere(level: u32) -> Mesh {
    let g = (1.0 + 5f32.sqrt()) / 2.0;
    let mut mesh = Mesh::default();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        mesh.positions.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    // Faces join the triples of mutual neighbours, which lie 2 apart.
    let near =
        |mesh: &Mesh, i: usize, j: usize| (mesh.positions[i].distance(mesh.positions[j]) - 2.0).abs() < 0.1;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(&mesh, i, j) && near(&mesh, j, k) && near(&mesh, i, k) {
                    mesh.indices.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    mesh = mesh.map(Vec3::normalize);
    for _ in 0..level {
        mesh = subdivided(&mesh).map(Vec3::normalize);
    }
    mesh
}

fn subdivided(mesh: &Mesh) -> Mesh {
    let mut fine = Mesh { positions: mesh.positions.clone(), indices: Vec::new() };
    let mut middles = HashMap::new();
    for &[a, b, c] in &mesh.indices {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                fine.positions.push((mesh.positions[i as usize] + mesh.positions[j as usize]) * 0.5);
                fine.positions.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        fine.indices.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    fine
}

/// Uniform in the cube from −1 to 1.
pub fn in_cube(rng: &mut Pcg32) -> Vec3 {
    Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
}

/// Roughly uniform directions of unit length.
pub fn direction(rng: &mut Pcg32) -> Vec3 {
    loop {
        let v = in_cube(rng);
        let square = v.length_squared();
        if (1e-4..=1.0).contains(&square) {
            return v / square.sqrt();
        }
    }
}
