//! Filtered answers are those of a loop over all hits, on every instruction set, bit for bit.

use super::{Geometry, Hit, Quad, Ray, Sphere, build, every_hit, scenes};
use crate::{Bvh, Filter, Instance, Masks};
use penombre_lab::Pcg32;
use penombre_math::{Transform, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const RAYS: usize = 400;

/// What decides among hits: distance, then ids.
fn order(hit: &Hit) -> (f32, u32, u32, u32) {
    (hit.t, hit.top_geometry(), hit.geometry, hit.prim)
}

fn bits(hit: &Hit) -> [u32; 6] {
    [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geometry, hit.prim, hit.instance]
}

/// The closest of all hits that count.
fn exhaustive_where(bvh: &Bvh, index: usize, ray: &Ray, filter: &dyn Filter) -> Hit {
    let mut best = Hit::MISS;
    every_hit(bvh, ray, &mut |hit| {
        if filter.accepts(index, ray, &hit) && (!best.is_hit() || order(&hit) < order(&best)) {
            best = hit;
        }
    });
    best
}

fn random_rays(rng: &mut Pcg32, bvh: &Bvh, points: &[Vec3], count: usize) -> Vec<Ray> {
    (0..count).map(|_| scenes::ray(rng, &bvh.bounds(), points)).collect()
}

/// Batches and single rays, on all kernels. Returns how many rays hit something else than without the filter.
fn check(name: &str, bvh: &Bvh, rays: &[Ray], filter: &dyn Filter) -> usize {
    let truth: Vec<Hit> =
        rays.iter().enumerate().map(|(i, ray)| exhaustive_where(bvh, i, ray, filter)).collect();
    for bvh in bvh.on_all_kernels() {
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut blocked = vec![false; rays.len()];
        bvh.closest_batch_where(rays, filter, &mut hits);
        bvh.occluded_batch_where(rays, filter, &mut blocked);
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(bits(&truth[i]), bits(&hits[i]), "{name}: {ray:?}: {:?}, not {:?}", hits[i], truth[i]);
            assert_eq!(truth[i].is_hit(), blocked[i], "{name}: occluded: {ray:?}");
            // A single ray stands at place 0: what was asked of place i is asked of it.
            let alone = |_: usize, ray: &Ray, hit: &Hit| filter.accepts(i, ray, hit);
            assert_eq!(bits(&truth[i]), bits(&bvh.closest_where(ray, &alone)), "{name}: alone: {ray:?}");
            assert_eq!(truth[i].is_hit(), bvh.occluded_where(ray, &alone), "{name}: occluded alone: {ray:?}");
        }
    }
    rays.iter().zip(&truth).filter(|(ray, hit)| bits(&bvh.closest(ray)) != bits(hit)).count()
}

#[test]
fn filtered_trees_equal_exhaustive_search() {
    let mut rng = Pcg32::new(300);
    for scene in scenes::all(&mut rng) {
        let bvh = build(scene.geometries.clone());
        let rays = random_rays(&mut rng, &bvh, &scene.points, RAYS);
        let parity = |_: usize, _: &Ray, hit: &Hit| hit.prim.is_multiple_of(2);
        let cut_out = |_: usize, _: &Ray, hit: &Hit| hit.u + hit.v > 0.5;
        let by_ray = |index: usize, ray: &Ray, hit: &Hit| {
            (hit.prim as usize + index).is_multiple_of(3) || ray.dir.x > 0.0
        };
        let by_distance = |_: usize, _: &Ray, hit: &Hit| hit.t.to_bits().is_multiple_of(3);
        let everything = |_: usize, _: &Ray, _: &Hit| true;
        let changed = check(scene.name, &bvh, &rays, &parity)
            + check(scene.name, &bvh, &rays, &cut_out)
            + check(scene.name, &bvh, &rays, &by_ray)
            + check(scene.name, &bvh, &rays, &by_distance);
        assert!(changed > 15, "{}: {changed} changes test nothing", scene.name);
        assert_eq!(check(scene.name, &bvh, &rays, &everything), 0, "{}", scene.name);
    }
}

#[test]
fn few_primitives_are_filtered_too() {
    let mut rng = Pcg32::new(301);
    let mut changed = 0;
    for i in 0..34 {
        let scene = scenes::few(&mut rng, i % 17);
        let bvh = build(scene.geometries);
        assert!(bvh.tree.few, "{i}: this tests what has a way without a tree");
        let rays = random_rays(&mut rng, &bvh, &scene.points, 203);
        changed +=
            check(scene.name, &bvh, &rays, &|_: usize, _: &Ray, hit: &Hit| hit.t.to_bits().is_multiple_of(3));
        changed += check(scene.name, &bvh, &rays, &|i: usize, _: &Ray, hit: &Hit| hit.prim as usize == i % 2);
    }
    assert!(changed > 1000, "{changed} changes test nothing");
}

#[test]
fn nothing_is_hit_if_everything_is_refused() {
    let mut rng = Pcg32::new(302);
    for scene in scenes::all(&mut rng) {
        let bvh = build(scene.geometries.clone());
        let rays = random_rays(&mut rng, &bvh, &scene.points, 200);
        let nothing = |_: usize, _: &Ray, _: &Hit| false;
        let mut hits = vec![Hit { prim: 1, ..Hit::MISS }; rays.len()];
        bvh.closest_batch_where(&rays, &nothing, &mut hits);
        assert!(hits.iter().all(|hit| *hit == Hit::MISS), "{}", scene.name);
        check(scene.name, &bvh, &rays, &nothing);
    }
}

/// Only one primitive of the scene is left: the answer is that of a hierarchy of it alone.
#[test]
fn one_of_many_is_hit_as_if_it_were_alone() {
    let mut rng = Pcg32::new(303);
    let spheres: Vec<Sphere> = (0..200)
        .map(|_| Sphere { center: super::meshes::in_cube(&mut rng), radius: 0.3 + 0.2 * rng.next_f32() })
        .collect();
    let bvh = build(vec![Geometry::Spheres(spheres.clone())]);
    let points: Vec<Vec3> = spheres.iter().map(|s| s.center).collect();
    let rays = random_rays(&mut rng, &bvh, &points, 2000);
    for only in [0, 77, 199] {
        let alone = build(vec![Geometry::Spheres(vec![spheres[only as usize]])]);
        let filter = |_: usize, _: &Ray, hit: &Hit| hit.prim == only;
        assert!(check("one of many", &bvh, &rays, &filter) > 100);
        let mut found = 0;
        for ray in &rays {
            let (hit, truth) = (bvh.closest_where(ray, &filter), alone.closest(ray));
            assert_eq!((hit.t, hit.is_hit()), (truth.t, truth.is_hit()));
            found += usize::from(hit.is_hit());
        }
        assert!(found > 50, "{found} hits test nothing");
    }
}

/// The filter is given complete hits and the ray as it was in the world, and only hits that would win.
#[test]
fn filters_are_told_what_was_promised() {
    let mut rng = Pcg32::new(304);
    for scene in scenes::all(&mut rng) {
        let bvh = build(scene.geometries.clone());
        let rays = random_rays(&mut rng, &bvh, &scene.points, 200);
        let asked = AtomicUsize::new(0);
        let filter = |index: usize, ray: &Ray, hit: &Hit| {
            asked.fetch_add(1, Ordering::Relaxed);
            assert!(std::ptr::eq(ray, &rays[index]), "{}: another ray", scene.name);
            let mut exists = false;
            every_hit(&bvh, ray, &mut |other| exists |= bits(&other) == bits(hit));
            assert!(exists, "{}: {hit:?} of {ray:?} is none", scene.name);
            hit.prim % 2 == 1
        };
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.closest_batch_where(&rays, &filter, &mut hits);
        bvh.occluded_batch_where(&rays, &filter, &mut vec![false; rays.len()]);
        assert!(asked.into_inner() > 20, "{}: nothing was asked", scene.name);
    }
}

/// Surfaces in a row are visited in order: those behind the first one that counts are not asked about.
#[test]
fn filters_are_not_asked_about_what_lies_behind() {
    let wall = |z: f32| Quad { origin: Vec3::new(-1.0, -1.0, z), sides: [Vec3::X * 2.0, Vec3::Y * 2.0] };
    let bvh = build(vec![Geometry::Quads((0..1000).map(|z| wall(z as f32)).collect())]);
    let asked = AtomicUsize::new(0);
    let filter = |_: usize, _: &Ray, hit: &Hit| {
        asked.fetch_add(1, Ordering::Relaxed);
        hit.prim >= 3
    };
    let ray = Ray::new(Vec3::new(0.1, 0.2, -1.0), Vec3::Z, 0.0, f32::INFINITY);
    assert_eq!(bvh.closest_where(&ray, &filter).prim, 3);
    // Leaves of one node go nearest first.
    assert_eq!(asked.into_inner(), 4);
}

#[test]
fn refused_spheres_are_hit_from_within() {
    let bvh = build(vec![Geometry::Spheres(vec![Sphere { center: Vec3::ZERO, radius: 1.0 }])]);
    let ray = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 0.0, 10.0);
    let inner = |_: usize, ray: &Ray, hit: &Hit| ray.at(hit.t).z > 0.0;
    assert_eq!(bvh.closest_where(&ray, &inner).t, 4.0);
    assert!(bvh.occluded_where(&ray, &inner));
    assert!(!bvh.occluded_where(&Ray { t_max: 3.0, ..ray }, &inner));
}

#[test]
fn masks_choose_by_the_topmost_geometry() {
    let ball = |x: f32| Geometry::Spheres(vec![Sphere { center: Vec3::X * x, radius: 1.0 }]);
    let nested = Arc::new(build(vec![ball(0.0), ball(3.0)]));
    let to_world = Transform::translation(Vec3::new(10.0, 0.0, 0.0).as_dvec3()).expect("finite");
    let bvh = build(vec![ball(5.0), Geometry::Instance(Instance { bvh: nested, to_world }), ball(20.0)]);
    let ray = Ray::new(Vec3::ZERO, Vec3::X, 0.0, f32::INFINITY);
    for bvh in bvh.on_all_kernels() {
        let see = |geometries: &[u32], rays: &[u32]| {
            let masks = Masks { geometries, rays };
            let (mut hits, mut blocked) = ([Hit::MISS; 3], [false; 3]);
            bvh.closest_batch_where(&[ray; 3], &masks, &mut hits);
            bvh.occluded_batch_where(&[ray; 3], &masks, &mut blocked);
            assert_eq!(hits.map(|hit| hit.is_hit()), blocked);
            assert_eq!(bvh.closest_where(&ray, &masks), hits[0], "one ray stands at place 0");
            hits.map(|hit| hit.t)
        };
        let miss = f32::INFINITY;
        assert_eq!(see(&[1, 2, 4], &[1, 2, 4]), [4.0, 9.0, 19.0]);
        assert_eq!(see(&[1, 2, 4], &[6, 12, 8]), [9.0, 19.0, miss]);
        assert_eq!(see(&[0, 0, 0], &[u32::MAX, 1]), [miss; 3], "a mask without bits hides from all");
        assert_eq!(see(&[8], &[1, 8]), [9.0, 4.0, 4.0], "what is not listed has all bits");
        assert_eq!(see(&[], &[0, 1]), [miss, 4.0, 4.0]);
        assert_eq!(see(&[1, 2, 4, 8], &[4, 4, 4, 1]), [19.0; 3], "more than needed harm nobody");
        assert_eq!(see(&[], &[]), [4.0; 3]);
    }
}

#[test]
fn masks_equal_exhaustive_search() {
    let mut rng = Pcg32::new(305);
    for scene in scenes::all(&mut rng).into_iter().filter(|scene| scene.geometries.len() > 1) {
        let bvh = build(scene.geometries.clone());
        let rays = random_rays(&mut rng, &bvh, &scene.points, 300);
        let geometries: Vec<u32> = scene.geometries.iter().map(|_| 1 << rng.below(3)).collect();
        let of_rays: Vec<u32> = rays.iter().map(|_| rng.below(8)).collect();
        let changed = check(scene.name, &bvh, &rays, &Masks { geometries: &geometries, rays: &of_rays });
        assert!(changed > 20, "{}: {changed} changes test nothing", scene.name);
    }
}

#[test]
fn rays_that_hit_nothing_ask_nobody() {
    let nobody = |_: usize, _: &Ray, _: &Hit| -> bool { unreachable!("there is nothing to ask about") };
    let rays = [Ray::new(Vec3::ZERO, Vec3::X, 0.0, 9.0), Ray::new(Vec3::ZERO, Vec3::ZERO, 0.0, 9.0)];
    let mut hits = [Hit::MISS; 2];
    for bvh in build(Vec::new()).on_all_kernels() {
        bvh.closest_batch_where(&rays, &nobody, &mut hits);
        bvh.closest_batch_where(&[], &nobody, &mut []);
        assert_eq!(hits, [Hit::MISS; 2]);
    }
}
