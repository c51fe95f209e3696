//! Shapes for tests and benches, made of nothing but roots and integers.

use super::{Geometry, Quad, Sphere, Triangles};
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
    let near = |mesh: &Mesh, i: usize, j: usize| (mesh.positions[i].distance(mesh.positions[j]) - 2.0).abs() < 0.1;
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

/// The cube from −1 to 1, 12 triangles.
pub fn cube() -> Mesh {
    let positions = (0..8).map(|i| Vec3::new(side(i & 1), side(i >> 1 & 1), side(i >> 2 & 1))).collect();
    let mut indices = Vec::new();
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for base in [0, 1 << axis] {
            indices.extend([[base, base + u, base + u + v], [base, base + u + v, base + v]]);
        }
    }
    Mesh { positions, indices }
}

fn side(bit: u32) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}

/// Points of the unit circle: those of a square's outline, normalised.
fn circle(quarter: u32) -> Vec<(f32, f32)> {
    let mut points = Vec::new();
    for turn in 0..4 {
        for i in 0..quarter {
            let (x, y) = (1.0, 2.0 * i as f32 / quarter as f32 - 1.0);
            let r = (x * x + y * y).sqrt();
            let (x, y) = (x / r, y / r);
            points.push([(x, y), (-y, x), (-x, -y), (y, -x)][turn]);
        }
    }
    points
}

/// A torus with radii 1 and 0.4, 32·`quarter`² triangles.
pub fn torus(quarter: u32) -> Mesh {
    let ring = circle(quarter);
    let n = ring.len() as u32;
    let mut mesh = Mesh::default();
    for &(cx, cy) in &ring {
        for &(px, py) in &ring {
            let r = 1.0 + 0.4 * px;
            mesh.positions.push(Vec3::new(cx * r, cy * r, 0.4 * py));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let at = |i: u32, j: u32| (i % n) * n + j % n;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.indices.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A flat grid of 2·n² triangles in the plane y = 0, from −1 to 1.
pub fn grid(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: u32| 2.0 * k as f32 / n as f32 - 1.0;
            mesh.positions.push(Vec3::new(at(i), 0.0, at(j)));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            mesh.indices.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    mesh
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

/// Triangles with corners `centre + size · random`, not connected.
pub fn soup(rng: &mut Pcg32, count: u32, size: impl Fn(&mut Pcg32) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let center = in_cube(rng);
        for _ in 0..3 {
            let p = center + in_cube(rng) * size(rng);
            mesh.positions.push(p);
        }
        mesh.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// The course's box: six walls of a room from −2 to 2 and two balls.
pub fn cornell() -> Vec<Geometry> {
    let wall = |x: f32, y: f32, z: f32, s: Vec3, t: Vec3| Quad { origin: Vec3::new(x, y, z), sides: [s, t] };
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z * 4.0);
    let walls = vec![
        wall(-2.0, -2.0, -2.0, z, y),
        wall(2.0, -2.0, -2.0, y, z),
        wall(-2.0, -2.0, -2.0, x, z),
        wall(-2.0, 2.0, -2.0, z, x),
        wall(-2.0, -2.0, -2.0, y, x),
        wall(-2.0, -2.0, 2.0, x, y),
    ];
    let balls = vec![
        Sphere { center: Vec3::new(-0.9, -1.2, -0.6), radius: 0.8 },
        Sphere { center: Vec3::new(0.9, -1.2, 0.4), radius: 0.8 },
    ];
    vec![Geometry::Quads(walls), Geometry::Spheres(balls)]
}
