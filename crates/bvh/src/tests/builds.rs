//! What builds promise: the same tree on any number of threads, and trees for all kinds of data.

use super::meshes::{Mesh, in_cube};
use super::{Geometry, Hit, Ray, Sphere, exhaustive, scenes};
use crate::{BuildOptions, Bvh, Quality};
use penombre_lab::Pcg32;
use penombre_math::Vec3;

const QUALITIES: [Quality; 2] = [Quality::Fast, Quality::High];

/// Small triangles, some long ones and a few without area, all over a cube.
fn heap(count: usize, rng: &mut Pcg32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let (at, size) = (in_cube(rng), if i % 50 == 0 { 0.7 } else { 0.02 });
        let first = mesh.positions.len() as u32;
        let along = if i % 97 == 0 { Vec3::ZERO } else { in_cube(rng) * size };
        mesh.positions.extend([at, at + along, at + in_cube(rng) * 0.01]);
        mesh.indices.push([first, first + 1, first + 2]);
    }
    mesh
}

fn text(bvh: &Bvh) -> String {
    let tree = &bvh.tree;
    format!("{:?} {:?} {:?} {:?}", bvh.stats(), tree.nodes, tree.blocks, tree.spheres)
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let mut rng = Pcg32::new(40);
    let spheres = |rng: &mut Pcg32| Sphere { center: in_cube(rng), radius: 0.01 };
    let spheres = (0..3000).map(|_| spheres(&mut rng)).collect();
    // More than what one thread builds alone.
    let geometries = vec![heap(60_000, &mut rng).geometry(), Geometry::Spheres(spheres)];
    for quality in QUALITIES {
        let options = BuildOptions::with_quality(quality);
        let build = |threads| Bvh::build_on(geometries.clone(), &options, threads).expect("valid");
        let one = text(&build(1));
        for threads in [2, 3, 7] {
            assert!(one == text(&build(threads)), "{quality:?}: {threads} threads");
        }
    }
}

/// Rays through the middle of the triangles find what a loop over all finds.
#[test]
fn both_qualities_find_the_same_hits() {
    let mut rng = Pcg32::new(41);
    let mesh = heap(30_000, &mut rng);
    let trees = QUALITIES.map(|quality| {
        Bvh::build(vec![mesh.geometry()], &BuildOptions::with_quality(quality)).expect("valid")
    });
    for _ in 0..150 {
        let ray = Ray::new(in_cube(&mut rng) * 2.0, in_cube(&mut rng), 0.0, f32::INFINITY);
        let truth = exhaustive(&trees[0], &ray);
        for tree in &trees {
            assert_eq!(tree.closest(&ray), truth, "{ray:?}");
            assert_eq!(tree.occluded(&ray), truth.is_hit(), "{ray:?}");
        }
    }
    assert_eq!(trees[0].stats().primitives, trees[1].stats().primitives);
    assert_eq!(trees[0].stats().skipped, trees[1].stats().skipped);
}

#[test]
fn all_scenes_are_the_same_in_both_qualities() {
    let mut rng = Pcg32::new(42);
    for scene in scenes::all(&mut rng) {
        let build = |quality| {
            Bvh::build(scene.geometries.clone(), &BuildOptions::with_quality(quality)).expect("valid")
        };
        let (fast, high) = (build(Quality::Fast), build(Quality::High));
        let rays: Vec<Ray> =
            (0..3000).map(|_| scenes::ray(&mut rng, &fast.bounds(), &scene.points)).collect();
        let mut hits = [vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]];
        fast.closest_batch(&rays, &mut hits[0]);
        high.closest_batch(&rays, &mut hits[1]);
        assert!(hits[0] == hits[1], "{}", scene.name);
    }
}

/// A fan of triangles that all share one corner, and as many that are all the same.
#[test]
fn large_heaps_at_one_point_are_built() {
    let mut mesh = Mesh { positions: vec![Vec3::ZERO], indices: Vec::new() };
    let mut rng = Pcg32::new(43);
    for _ in 0..30_000u32 {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([in_cube(&mut rng), in_cube(&mut rng)]);
        mesh.indices.extend([[0, first, first + 1], [0, 1, 2]]);
    }
    for quality in QUALITIES {
        let bvh = Bvh::build(vec![mesh.geometry()], &BuildOptions::with_quality(quality)).expect("valid");
        assert_eq!(bvh.stats().primitives.triangles + bvh.stats().skipped, mesh.indices.len());
        assert!(bvh.stats().depth < 60, "{:?}", bvh.stats());
        for _ in 0..20 {
            let ray = Ray::new(in_cube(&mut rng), in_cube(&mut rng), 0.0, f32::INFINITY);
            assert_eq!(bvh.closest(&ray), exhaustive(&bvh, &ray));
        }
    }
}

#[test]
fn coordinates_near_the_limit_of_numbers_are_built() {
    let mut rng = Pcg32::new(44);
    for size in [1e19, 1e38, 3e38, 1e-38] {
        let mut mesh = heap(500, &mut rng);
        let scale = |p: &mut Vec3| *p = p.clamp(Vec3::splat(-1.0), Vec3::ONE) * size;
        mesh.positions.iter_mut().for_each(scale);
        for quality in QUALITIES {
            let bvh = Bvh::build(vec![mesh.geometry()], &BuildOptions::with_quality(quality)).expect("valid");
            for _ in 0..200 {
                let ray = Ray::new(in_cube(&mut rng) * size, in_cube(&mut rng), 0.0, f32::INFINITY);
                assert_eq!(bvh.closest(&ray), exhaustive(&bvh, &ray), "{size}: {ray:?}");
            }
        }
    }
}
