//! Closed meshes, and where one is inside them.

use crate::meshes::{Mesh, icosphere, in_cube};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use penombre_math::hash::{combine, unit_f32};

/// A closed mesh that every ray from some points must hit.
pub struct Body {
    pub name: &'static str,
    pub mesh: Mesh,
    inside: Box<dyn Fn(&mut Pcg32) -> Vec3 + Sync>,
}

impl Body {
    /// A mesh with a box around a centre that lies in its inside.
    fn around(name: &'static str, mesh: Mesh, centre: Vec3, half: Vec3) -> Self {
        Self { name, mesh, inside: Box::new(move |rng| centre + in_cube(rng) * half) }
    }

    /// A point inside.
    pub fn inside(&self, rng: &mut Pcg32) -> Vec3 {
        (self.inside)(rng)
    }
}

/// All of them: convex and not, of triangles that are regular, thin, stretched, far from the origin of coordinates.
pub fn all() -> Vec<Body> {
    let (centre, far) = (Vec3::ZERO, Vec3::new(900.0, -700.0, 1100.0));
    let flat = Vec3::new(1.0, 0.01, 100.0);
    vec![
        Body::around("sphere, 20 triangles", icosphere(0), centre, Vec3::splat(0.4)),
        Body::around("sphere, 82 k", icosphere(6), centre, Vec3::splat(0.5)),
        Body::around("stretched sphere, 20 k", icosphere(5).map(|p| p * flat), centre, flat * 0.5),
        Body::around("sphere far away, 5 k", icosphere(4).map(|p| p + far), far, Vec3::splat(0.4)),
        Body::around("displaced sphere, 82 k", icosphere(6).map(displaced), centre, Vec3::splat(0.1)),
        Body::around("spiked sphere, 20 k", icosphere(5).map(spiked), centre, Vec3::splat(0.05)),
        Body::around("box of slivers, 8 k", prism(&square(500), Cap::Middle), centre, Vec3::splat(0.9)),
        Body::around("drum of slivers, 8 k", prism(&circle(500), Cap::Rim), centre, Vec3::splat(0.6)),
        Body { name: "torus, 33 k", mesh: torus(32), inside: Box::new(in_tube) },
    ]
}

/// Soft hills: a star around the origin.
fn displaced(p: Vec3) -> Vec3 {
    let wave = |x: f32| x * (1.0 - x.abs());
    p * (0.7 + 0.3 * wave(p.x) + 0.6 * wave(p.y) * wave(p.z))
}

/// Each vertex at a radius of its own from 0.2 to 1.
fn spiked(p: Vec3) -> Vec3 {
    let bits = combine(combine(p.x.to_bits(), p.y.to_bits()), p.z.to_bits());
    p * (0.2 + 0.8 * unit_f32(bits))
}

/// The outline of the square from −1 to 1, 4·`quarter` points.
fn square(quarter: u32) -> Vec<(f32, f32)> {
    let mut points = Vec::new();
    for turn in 0..4 {
        for i in 0..quarter {
            let y = 2.0 * i as f32 / quarter as f32 - 1.0;
            points.push([(1.0, y), (-y, 1.0), (-1.0, -y), (y, -1.0)][turn]);
        }
    }
    points
}

/// 4·`quarter` points of the unit circle.
fn circle(quarter: u32) -> Vec<(f32, f32)> {
    let on_circle = |(x, y): (f32, f32)| {
        let radius = (x * x + y * y).sqrt();
        (x / radius, y / radius)
    };
    square(quarter).into_iter().map(on_circle).collect()
}

/// How the ends of a prism are cut into triangles.
#[derive(Clone, Copy, PartialEq)]
enum Cap {
    /// Around a point in the middle.
    Middle,
    /// Around a point of the outline, no two sides of which lie on one line.
    Rim,
}

/// A prism from z = −1 to 1 with sides of two long triangles each.
fn prism(outline: &[(f32, f32)], cap: Cap) -> Mesh {
    let mut mesh = Mesh::default();
    let n = outline.len() as u32;
    for z in [-1.0, 1.0] {
        mesh.positions.extend(outline.iter().map(|&(x, y)| Vec3::new(x, y, z)));
    }
    for i in 0..n {
        let (a, b) = (i, (i + 1) % n);
        mesh.indices.extend([[a, b, b + n], [a, b + n, a + n]]);
    }
    for (first, z) in [(0, -1.0), (n, 1.0)] {
        if cap == Cap::Middle {
            mesh.positions.push(Vec3::new(0.0, 0.0, z));
            let middle = mesh.positions.len() as u32 - 1;
            mesh.indices.extend((0..n).map(|i| [middle, first + i, first + (i + 1) % n]));
        } else {
            mesh.indices.extend((1..n - 1).map(|i| [first, first + i, first + i + 1]));
        }
    }
    mesh
}

/// The torus of radii 1 and 0.4, 32·`quarter`² triangles.
fn torus(quarter: u32) -> Mesh {
    let ring = circle(quarter);
    let n = ring.len() as u32;
    let mut mesh = Mesh::default();
    for &(cx, cy) in &ring {
        let point = |&(px, py): &(f32, f32)| Vec3::new(cx, cy, 0.0) * (1.0 + 0.4 * px) + Vec3::Z * (0.4 * py);
        mesh.positions.extend(ring.iter().map(point));
    }
    for i in 0..n * n {
        let at = |row: u32, column: u32| (i / n + row) % n * n + (i % n + column) % n;
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        mesh.indices.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// Near the circle in the middle of the torus' tube.
fn in_tube(rng: &mut Pcg32) -> Vec3 {
    let around = (in_cube(rng) * Vec3::new(1.0, 1.0, 0.0)).normalize_or(Vec3::X);
    around + in_cube(rng) * 0.15
}
