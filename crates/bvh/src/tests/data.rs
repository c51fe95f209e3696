//! Bad data and large data.

use super::bodies;
use super::cornell::cornell;
use super::meshes::{Mesh, in_cube};
use super::{Disk, Geometry, Hit, Instance, Quad, Ray, Sphere, Triangles, build, exhaustive};
use crate::{BuildError, BuildOptions, Bvh};
use penombre_lab::Pcg32;
use penombre_math::{Bounds3, Transform, Vec3};
use std::sync::Arc;

const ODD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

#[test]
fn nothing_at_all() {
    let bvh = build(Vec::new());
    assert_eq!(bvh.bounds(), Bounds3::EMPTY);
    assert_eq!(bvh.closest(&Ray::new(Vec3::ZERO, Vec3::X, 0.0, 1.0)), Hit::MISS);
    let around =
        build(vec![Geometry::Instance(Instance { bvh: Arc::new(bvh), to_world: Transform::IDENTITY })]);
    assert!(!around.occluded(&Ray::new(Vec3::ZERO, Vec3::X, 0.0, 1.0)));
    assert_eq!(around.stats().skipped, 1);
}

/// 10 good primitives, and of every kind as many bad ones as named in the result.
fn with_bad_ones() -> (Vec<Geometry>, usize) {
    let mut mesh = bodies::cube();
    let (mut spheres, mut quads, mut disks) = (Vec::new(), Vec::new(), Vec::new());
    let n = mesh.positions.len() as u32;
    for (i, odd) in (0..).zip(ODD) {
        let bad = Vec3::new(0.0, odd, 0.0);
        mesh.positions.push(bad);
        mesh.indices.push([0, 1, n + i]);
        spheres.extend([Sphere { center: bad, radius: 1.0 }, Sphere { center: Vec3::ZERO, radius: odd }]);
        quads.push(Quad { origin: bad, sides: [Vec3::X, Vec3::Y] });
        quads.push(Quad { origin: Vec3::ZERO, sides: [Vec3::X, bad] });
        disks.push(Disk { center: bad, normal: Vec3::X, radius: 1.0 });
        disks.push(Disk { center: Vec3::ZERO, normal: bad, radius: 1.0 });
        disks.push(Disk { center: Vec3::ZERO, normal: Vec3::X, radius: odd });
    }
    mesh.indices.extend([[0, 0, 0], [0, 1, 1], [3, 1, 3]]);
    spheres.extend([0.0, -0.0, -1.0].map(|radius| Sphere { center: Vec3::ZERO, radius }));
    spheres.push(Sphere { center: Vec3::splat(3e38), radius: 3e38 });
    quads.push(Quad { origin: Vec3::ZERO, sides: [Vec3::X, Vec3::X * -2.0] });
    quads.push(Quad { origin: Vec3::ZERO, sides: [Vec3::ZERO, Vec3::X] });
    disks.push(Disk { center: Vec3::ZERO, normal: Vec3::ZERO, radius: 1.0 });
    disks.push(Disk { center: Vec3::ZERO, normal: Vec3::X, radius: -2.0 });
    let bad = 6 + spheres.len() + quads.len() + disks.len();
    (vec![Geometry::Spheres(spheres), Geometry::Quads(quads), Geometry::Disks(disks), mesh.geometry()], bad)
}

#[test]
fn bad_primitives_are_skipped_and_counted() {
    let (geometries, bad) = with_bad_ones();
    let bvh = build(geometries);
    assert_eq!(bvh.stats().skipped, bad);
    assert_eq!(bvh.stats().primitives.triangles, 12);
    assert_eq!(bvh.bounds(), Bounds3 { min: Vec3::splat(-1.0), max: Vec3::ONE });
    let mut rng = Pcg32::new(1);
    for _ in 0..2000 {
        let ray = Ray::new(in_cube(&mut rng) * 3.0, in_cube(&mut rng), 0.0, f32::INFINITY);
        let hit = bvh.closest(&ray);
        assert!(!hit.is_hit() || (hit.geometry == 3 && hit.prim < 12));
        assert_eq!(hit, exhaustive(&bvh, &ray));
    }
}

#[test]
fn bad_rays_hit_nothing() {
    let bvh = build(cornell());
    let good = Ray::new(Vec3::ZERO, Vec3::new(0.3, 1.0, 0.2), 0.0, f32::INFINITY);
    assert!(bvh.occluded(&good));
    let mut bad = vec![
        Ray { dir: Vec3::ZERO, ..good },
        Ray { dir: -Vec3::ZERO, ..good },
        Ray { t_min: f32::NAN, ..good },
        Ray { t_max: f32::NAN, ..good },
        Ray { t_max: 0.0, ..good },
        Ray { t_min: f32::INFINITY, ..good },
        Ray { t_max: -1.0, ..good },
    ];
    for odd in ODD {
        for axis in 0..3 {
            let mut ray = good;
            ray.origin[axis] = odd;
            bad.push(ray);
            ray = good;
            ray.dir[axis] = odd;
            bad.push(ray);
        }
    }
    for ray in bad {
        assert_eq!(bvh.closest(&ray), Hit::MISS, "{ray:?}");
        assert!(!bvh.occluded(&ray), "{ray:?}");
    }
}

#[test]
fn errors_name_their_place() {
    let mesh =
        |index| Triangles { positions: Arc::from([Vec3::X]), indices: Arc::from([[0, 0, 0], [0, index, 0]]) };
    let geometries = |index| vec![Geometry::Quads(Vec::new()), Geometry::Triangles(mesh(index))];
    let options = BuildOptions::default();
    assert!(Bvh::build(geometries(0), &options).is_ok());
    let error = Bvh::build(geometries(1), &options).expect_err("out of range");
    assert_eq!(error, BuildError::IndexOutOfRange { geometry: 1, triangle: 1, index: 1, vertices: 1 });
    assert!(error.to_string().contains("triangle 1 refers to vertex 1"));

    let place = |bvh| Geometry::Instance(Instance { bvh: Arc::new(bvh), to_world: Transform::IDENTITY });
    let inner = build(cornell());
    let middle = build(vec![place(inner)]);
    let error = Bvh::build(vec![place(middle)], &options).expect_err("three levels");
    assert_eq!(error, BuildError::NestedInstances { geometry: 0 });
}

#[test]
fn too_many_primitives_are_refused_before_anything_is_built() {
    // 513 times the same 2²⁰ indices.
    let positions: Arc<[Vec3]> = Arc::from([Vec3::X]);
    let indices: Arc<[[u32; 3]]> = Arc::from(vec![[0; 3]; 1 << 20]);
    let mesh = Geometry::Triangles(Triangles { positions, indices });
    let error = Bvh::build(vec![mesh; 513], &BuildOptions::default()).expect_err("too many");
    assert_eq!(error, BuildError::TooManyPrimitives { found: 513 << 20, limit: 1 << 29 });
}

#[test]
fn thousands_of_equal_primitives() {
    let mut mesh = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], indices: vec![[0, 1, 2]; 20_000] };
    mesh.indices[0] = [0, 0, 0];
    let spheres = vec![Sphere { center: Vec3::new(0.2, 0.2, -5.0), radius: 1.0 }; 5000];
    let bvh = build(vec![mesh.geometry(), Geometry::Spheres(spheres)]);
    assert!(bvh.stats().depth < 12, "{:?}", bvh.stats());
    let hit = bvh.closest(&Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z, 0.0, 10.0));
    assert_eq!((hit.geometry, hit.prim, hit.t), (0, 1, 1.0));
    let hit = bvh.closest(&Ray::new(Vec3::new(0.2, 0.2, -1.0), -Vec3::Z, 0.0, 10.0));
    assert_eq!((hit.geometry, hit.prim, hit.t), (1, 0, 3.0));
}

/// Each triangle is a hundredth smaller than the last: splits by area want a list, not a tree.
#[test]
fn shrinking_primitives_do_not_deepen_the_tree_without_end() {
    let mut mesh = Mesh::default();
    let mut size = 1e37f32;
    while size > 1e-37 {
        let i = mesh.positions.len() as u32;
        mesh.positions.extend([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * size));
        mesh.indices.push([i, i + 1, i + 2]);
        size *= 0.99;
    }
    let bvh = build(vec![mesh.geometry()]);
    assert!(bvh.stats().depth < 96, "{:?}", bvh.stats());
    let mut rng = Pcg32::new(9);
    for _ in 0..300 {
        let aim = mesh.positions[rng.below(mesh.positions.len() as u32) as usize] * 0.3;
        let ray = Ray::new(Vec3::ZERO, aim + Vec3::splat(aim.max_element() * 0.1), 0.0, f32::INFINITY);
        assert_eq!(bvh.closest(&ray), exhaustive(&bvh, &ray), "{ray:?}");
        assert!(bvh.closest(&ray).is_hit());
    }
}

#[test]
fn stats_of_a_small_scene() {
    let bvh = build(cornell());
    let stats = bvh.stats();
    assert_eq!((stats.nodes, stats.leaves, stats.depth), (1, 8, 1));
    assert_eq!((stats.primitives.quads, stats.primitives.spheres), (6, 2));
    // Half areas: the room 3·16, six walls of 16, two boxes of 3·1.6² around the balls.
    let expected = 1.0 + (6.0 * 16.0 + 2.0 * 3.0 * 1.6 * 1.6) / 48.0;
    assert!((stats.sah_cost - expected).abs() < 1e-5, "{} {expected}", stats.sah_cost);
    assert!(stats.bytes > 256 && stats.bytes < 4096);
}
