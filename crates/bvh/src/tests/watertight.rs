//! No ray leaves a closed surface unseen.

use super::bodies;
use super::meshes::{self, Mesh, direction, in_cube};
use super::{Bvh, Geometry, Hit, Quad, Ray, build};
use penombre_lab::Pcg32;
use penombre_math::Vec3;

const BATCH: usize = 4096;

/// Points on vertices, edges and faces, more of the former.
fn target(rng: &mut Pcg32, mesh: &Mesh) -> Vec3 {
    let triangle = mesh.indices[rng.below(mesh.indices.len() as u32) as usize];
    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
    match rng.below(4) {
        0 => a,
        1 => a + (b - a) * rng.next_f32(),
        2 => (a + b) * 0.5,
        _ => {
            let share = rng.next_f32();
            a + (b - a) * share + (c - a) * ((1.0 - share) * rng.next_f32())
        }
    }
}

/// Traces `batches` of rays that must all hit; returns how many did not.
fn leaks(bvh: &Bvh, batches: usize, mut ray: impl FnMut() -> Ray) -> usize {
    let mut hits = vec![Hit::MISS; BATCH];
    let mut misses = 0;
    for _ in 0..batches {
        let rays: Vec<Ray> = (0..BATCH).map(|_| ray()).collect();
        bvh.closest_batch(&rays, &mut hits);
        misses += hits.iter().filter(|h| !h.is_hit()).count();
    }
    misses
}

/// From inside a body that is seen whole from around the origin.
fn from_inside(name: &str, mesh: &Mesh, room: f32, batches: usize) {
    let bvh = build(vec![mesh.geometry()]);
    let mut rng = Pcg32::new(1);
    let ray = || {
        let origin = in_cube(&mut rng) * room;
        let aimed = target(&mut rng, mesh) - origin;
        let dir = if rng.below(8) == 0 { direction(&mut rng) } else { aimed };
        Ray::new(origin, dir, 0.0, f32::INFINITY)
    };
    assert_eq!(leaks(&bvh, batches, ray), 0, "{name} leaks");
}

/// From outside, aimed at points just inside the hull of a convex body.
fn from_outside(name: &str, mesh: &Mesh, distance: f32, batches: usize) {
    let bvh = build(vec![mesh.geometry()]);
    let mut rng = Pcg32::new(2);
    let ray = || {
        let origin = direction(&mut rng) * distance;
        let aim = target(&mut rng, mesh) * 0.999;
        Ray::new(origin, aim - origin, 0.0, f32::INFINITY)
    };
    assert_eq!(leaks(&bvh, batches, ray), 0, "{name} leaks");
}

#[test]
fn closed_convex_meshes() {
    let stretched = meshes::icosphere(4).map(|p| p * Vec3::new(1.0, 0.01, 100.0));
    let shifted = meshes::icosphere(4);
    from_inside("icosphere", &meshes::icosphere(4), 0.5, 450);
    from_inside("stretched", &stretched, 0.004, 300);
    from_inside("cube", &bodies::cube(), 0.9, 450);
    from_outside("icosphere", &shifted, 3.0, 400);
    from_outside("distant icosphere", &shifted, 100.0, 200);
    from_outside("cube", &bodies::cube(), 4.0, 400);
}

#[test]
fn torus_is_crossed_an_even_number_of_times() {
    let mesh = bodies::torus(16);
    let bvh = build(vec![mesh.geometry()]);
    let mut rng = Pcg32::new(3);
    // From the tube's core circle every ray must leave through the wall.
    let ray = || {
        let d = direction(&mut rng) * Vec3::new(1.0, 1.0, 0.0);
        let origin = d.normalize_or(Vec3::X);
        let dir = if rng.below(4) == 0 { direction(&mut rng) } else { target(&mut rng, &mesh) - origin };
        Ray::new(origin, dir, 0.0, f32::INFINITY)
    };
    assert_eq!(leaks(&bvh, 300, ray), 0);
}

/// A room of parallelograms from its middle, aimed at its edges and corners.
fn room(corner: Vec3, sides: [Vec3; 3], batches: usize) {
    let mut quads = Vec::new();
    for axis in 0..3 {
        let (s, t) = (sides[(axis + 1) % 3], sides[(axis + 2) % 3]);
        quads.push(Quad { origin: corner, sides: [s, t] });
        quads.push(Quad { origin: corner + sides[axis], sides: [t, s] });
    }
    let bvh = build(vec![Geometry::Quads(quads)]);
    let mut rng = Pcg32::new(4);
    let mut ray = || {
        let mut at = || [0.0, 1.0, rng.next_f32(), 0.5][rng.below(4) as usize];
        let aim = corner + sides[0] * at() + sides[1] * at() + sides[2] * at();
        let mut inner = || 0.1 + 0.8 * rng.next_f32();
        let origin = corner + sides[0] * inner() + sides[1] * inner() + sides[2] * inner();
        let dir = if aim == origin { Vec3::X } else { aim - origin };
        Ray::new(origin, dir, 0.0, f32::INFINITY)
    };
    assert_eq!(leaks(&bvh, batches, &mut ray), 0, "{corner}");
    assert_eq!(leaks(&bvh.through_nodes(), batches / 4, &mut ray), 0, "{corner}, through nodes");
}

#[test]
fn rooms_of_quads() {
    room(Vec3::splat(-2.0), [Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z * 4.0], 150);
    room(Vec3::new(0.1, -0.3, 0.7), [Vec3::X * 0.3, Vec3::Y * 1.7, Vec3::Z * 33.3], 100);
    // Corners that sums of rounded sides reach exactly, along no axis.
    let sides = [Vec3::new(3.0, 1.0, -1.0), Vec3::new(-1.0, 4.0, 0.5), Vec3::new(0.25, -1.0, 5.0)];
    room(Vec3::new(1.0, 2.0, -3.0), sides, 100);
}
