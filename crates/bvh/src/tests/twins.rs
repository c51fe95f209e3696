//! Triangles that lie upon each other are kept once, and nobody sees it.

use super::meshes::{Mesh, icosphere, in_cube};
use super::refits::check as check_moved;
use super::{Geometry, Hit, Ray, bodies, build};
use crate::lanes::Baseline;
use crate::prepared::PreparedRay;
use crate::primitive::{Key, TriangleBlock, has_area};
use crate::{BuildOptions, Bvh, Filter, Quality, RefitError};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::collections::HashSet;

/// Random triangles, each many times over with its corners in all orders, of one geometry or several.
fn heap(rng: &mut Pcg32, lists: usize) -> Vec<Mesh> {
    let soup = bodies::soup(rng, 40, |_| Vec3::splat(0.7));
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0], [0, 0, 1]];
    let mut mesh = || Mesh {
        positions: soup.positions.clone(),
        indices: (0..1500)
            .map(|_| {
                let triangle = soup.indices[rng.below(40) as usize];
                orders[rng.below(7) as usize].map(|corner: usize| triangle[corner])
            })
            .collect(),
    };
    (0..lists).map(|_| mesh()).collect()
}

fn geometries(meshes: &[Mesh]) -> Vec<Geometry> {
    meshes.iter().map(Mesh::geometry).collect()
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|i| mesh.positions[i as usize])
}

/// The closest hit of all triangles of the list that counts; no tree is asked.
fn truth(meshes: &[Mesh], extent: f32, ray: &Ray, filter: &dyn Filter) -> Hit {
    let prepared = PreparedRay::new(ray, extent).expect("a sane ray");
    let mut best = Hit::MISS;
    for (geometry, mesh) in (0..).zip(meshes) {
        for (prim, triangle) in (0..).zip(&mesh.indices) {
            let corners = corners(mesh, *triangle);
            let mut block = TriangleBlock::EMPTY;
            block.push(corners, 0);
            let meeting = block.meet::<Baseline>(0, &prepared).filter(|_| has_area(corners));
            let hit = meeting.map(|at| at.hit(Key { geometry, prim }, Hit::NO_INSTANCE));
            // The first of equals stays: they come in the order of their ids.
            if let Some(hit) = hit.filter(|hit| hit.t < best.t && filter.accepts(0, ray, hit)) {
                best = hit;
            }
        }
    }
    best
}

#[test]
fn answers_are_those_of_a_loop_over_all() {
    let mut rng = Pcg32::new(400);
    for lists in [1, 3] {
        let meshes = heap(&mut rng, lists);
        let mut changed = 0;
        for quality in [Quality::Fast, Quality::High] {
            let bvh = Bvh::build(geometries(&meshes), &BuildOptions::with_quality(quality)).expect("valid");
            assert!(bvh.tree.twins.len() > 1000 * lists);
            let kernels: Vec<Bvh> = bvh.on_all_kernels().collect();
            let mut ray = || Ray::new(in_cube(&mut rng) * 2.0, in_cube(&mut rng), 0.0, f32::INFINITY);
            let all = |_: usize, _: &Ray, _: &Hit| true;
            let some = |_: usize, _: &Ray, hit: &Hit| hit.prim % 97 == 3 || hit.prim > 1490;
            for ray in (0..300).map(|_| ray()) {
                let [whole, part] =
                    [&all as &dyn Filter, &some].map(|filter| truth(&meshes, bvh.tree.extent, &ray, filter));
                changed += usize::from(whole != part);
                for bvh in &kernels {
                    assert_eq!((bvh.closest(&ray), bvh.occluded(&ray)), (whole, whole.is_hit()), "{ray:?}");
                    assert_eq!(bvh.closest_where(&ray, &some), part, "{ray:?}");
                    assert_eq!(bvh.occluded_where(&ray, &some), part.is_hit(), "{ray:?}");
                    let mut hits = [Hit::MISS; 9];
                    bvh.closest_batch(&[ray; 9], &mut hits);
                    assert_eq!(hits, [whole; 9], "{ray:?}");
                    bvh.closest_batch_where(&[ray; 9], &some, &mut hits);
                    assert_eq!(hits, [part; 9], "{ray:?}");
                }
            }
        }
        assert!(changed > 50, "{changed} changes test nothing");
    }
}

/// What is kept are the different ones, whatever mesh they come from; the figures are still those of all.
#[test]
fn each_triangle_is_kept_once() {
    let mut rng = Pcg32::new(401);
    let meshes = heap(&mut rng, 2);
    let all = meshes.iter().flat_map(|mesh| mesh.indices.iter().map(|t| corners(mesh, *t)));
    let whole: Vec<[Vec3; 3]> = all.filter(|corners| has_area(*corners)).collect();
    let different: HashSet<_> = whole.iter().map(|c| c.map(|p| p.to_array().map(f32::to_bits))).collect();
    let bvh = Bvh::build(geometries(&meshes), &BuildOptions::with_quality(Quality::Fast)).expect("valid");
    let kept: usize = bvh.tree.blocks.iter().map(TriangleBlock::len).sum();
    assert_eq!((kept, bvh.tree.twins.len()), (different.len(), whole.len() - different.len()));
    assert_eq!(bvh.stats().primitives.triangles, whole.len());
    assert_eq!(bvh.stats().skipped, 3000 - whole.len());
    assert!(bvh.tree.twins.is_sorted() && bvh.tree.twins.iter().all(|twin| twin.first < twin.number));
}

/// A ray tests one leaf, not twelve thousand.
#[test]
fn a_hundred_thousand_equal_triangles_are_one_leaf() {
    let mesh = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], indices: vec![[0, 1, 2]; 100_000] };
    let bvh = build(vec![mesh.geometry()]);
    let stats = bvh.stats();
    assert_eq!((stats.nodes, stats.leaves, stats.primitives.triangles), (1, 1, 100_000));
    let hit = bvh.closest(&Ray::new(Vec3::new(0.2, 0.3, 1.0), -Vec3::Z, 0.0, f32::INFINITY));
    assert_eq!((hit.prim, hit.t), (0, 1.0));
}

/// Several copies of everything, as careless exporters make them: the tree is that of one copy.
#[test]
fn copies_of_a_whole_mesh_cost_rays_nothing() {
    let one = icosphere(4);
    let mut copies = one.clone();
    for _ in 0..3 {
        copies.indices.extend_from_slice(&one.indices);
    }
    let [one, copies] = [one, copies].map(|mesh| build(vec![mesh.geometry()]).stats());
    assert_eq!((copies.nodes, copies.leaves), (one.nodes, one.leaves));
    assert_eq!(copies.primitives.triangles, 4 * one.primitives.triangles);
}

#[test]
fn few_are_not_looked_for() {
    let one = bodies::cube();
    let twice = Mesh { indices: [&*one.indices, &*one.indices].concat(), positions: one.positions };
    assert!(build(vec![twice.geometry()]).tree.twins.is_empty());
}

#[test]
fn twins_move_together() {
    let mut rng = Pcg32::new(402);
    let mut mesh = heap(&mut rng, 1).remove(0);
    let mut bvh = build(vec![mesh.geometry()]);
    for shift in [Vec3::splat(2.0), Vec3::new(-9.0, 0.0, 0.5)] {
        mesh = mesh.map(|p| Vec3::new(p.y, p.z, p.x) * 1.5 + shift);
        bvh.refit(vec![mesh.geometry()]).expect("all twins still are");
        check_moved(&bvh, &build(vec![mesh.geometry()]), &mut rng);
    }
    // All with a certain corner are gone for a while, the twins too.
    let mut gone = mesh.clone();
    gone.positions[0] = Vec3::NAN;
    for mesh in [&gone, &mesh] {
        bvh.refit(vec![mesh.geometry()]).expect("triangles may vanish");
        check_moved(&bvh, &build(vec![mesh.geometry()]), &mut rng);
    }
    // One gets a corner of its own.
    let apart = bvh.tree.twins[0].number as usize;
    let mut parted = mesh.clone();
    parted.indices[apart][0] = parted.positions.len() as u32;
    parted.positions.push(Vec3::ZERO);
    let error = RefitError::Parted { geometry: 0, primitive: apart };
    assert_eq!(bvh.refit(vec![parted.geometry()]), Err(error));
    check_moved(&bvh, &build(vec![mesh.geometry()]), &mut rng);
}
