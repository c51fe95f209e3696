//! More meshes for tests.

use super::meshes::{Mesh, in_cube};
use penombre_lab::Pcg32;
use penombre_math::Vec3;

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
