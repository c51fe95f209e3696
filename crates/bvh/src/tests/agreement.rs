//! The tree answers as a loop over all primitives does, on every instruction set, bit for bit.

use super::{Hit, Ray, build, exhaustive, scenes};
use crate::{BuildOptions, Bvh};
use penombre_lab::Pcg32;
use penombre_math::Vec3;

const RAYS: usize = 12_000;

fn bits(hit: &Hit) -> [u32; 6] {
    [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geometry, hit.prim, hit.instance]
}

fn check(name: &str, bvh: &Bvh, rays: &[Ray], truth: &[Hit]) {
    let mut hits = vec![Hit::MISS; rays.len()];
    let mut blocked = vec![false; rays.len()];
    bvh.closest_batch(rays, &mut hits);
    bvh.occluded_batch(rays, &mut blocked);
    for (i, ray) in rays.iter().enumerate() {
        assert_eq!(bits(&truth[i]), bits(&hits[i]), "{name}: {ray:?}: {:?}, not {:?}", hits[i], truth[i]);
        assert_eq!(truth[i].is_hit(), blocked[i], "{name}: occluded: {ray:?}");
    }
}

#[test]
fn tree_equals_exhaustive_search() {
    let mut rng = Pcg32::new(2013);
    for scene in scenes::all(&mut rng) {
        let bvh = build(scene.geometries.clone());
        let rays: Vec<Ray> = (0..RAYS).map(|_| scenes::ray(&mut rng, &bvh.bounds(), &scene.points)).collect();
        let truth: Vec<Hit> = rays.iter().map(|ray| exhaustive(&bvh, ray)).collect();
        let found = truth.iter().filter(|h| h.is_hit()).count();
        assert!(found > RAYS / 50 && found < RAYS, "{}: {found} hits test nothing", scene.name);
        check(scene.name, &bvh, &rays, &truth);
        for bvh in bvh.on_all_kernels() {
            check(scene.name, &bvh, &rays, &truth);
            check(scene.name, &bvh.through_nodes(), &rays, &truth);
        }
        let mut options = BuildOptions::default();
        (options.bins, options.max_leaf) = (5, 1);
        let other = Bvh::build(scene.geometries, &options).expect("valid");
        check(scene.name, &other, &rays, &truth);
    }
}

/// Rooms and heaps of a few simple primitives, some of them twice, for rays of which some are bad.
#[test]
fn few_primitives_equal_exhaustive_search() {
    let mut rng = Pcg32::new(16);
    for i in 0..60 {
        let scene = scenes::few(&mut rng, i % 17);
        let bvh = build(scene.geometries);
        assert!(bvh.tree.few, "{i}: this tests the way without a tree");
        // No multiple of the rays tested at once, so that some are left over.
        let mut rays: Vec<Ray> =
            (0..1003).map(|_| scenes::ray(&mut rng, &bvh.bounds(), &scene.points)).collect();
        for ray in rays.iter_mut().step_by(7) {
            match rng.below(4) {
                0 => ray.dir = Vec3::ZERO,
                1 => ray.origin.y = f32::NAN,
                2 => ray.t_max = ray.t_min,
                _ => ray.dir.x = f32::INFINITY,
            }
        }
        let truth: Vec<Hit> = rays.iter().map(|ray| exhaustive(&bvh, ray)).collect();
        let found = truth.iter().filter(|h| h.is_hit()).count();
        assert!(i % 17 == 0 || found > 50, "{i}: {found} hits test nothing");
        check(scene.name, &bvh, &rays, &truth);
        for bvh in bvh.on_all_kernels() {
            check(scene.name, &bvh, &rays, &truth);
            check(scene.name, &bvh.through_nodes(), &rays, &truth);
        }
    }
}

#[test]
fn boxes_of_instances_hide_nothing() {
    let mut rng = Pcg32::new(31);
    for i in 0..400 {
        let (size, away, offset) =
            [(1.0, 0.5, 3.0), (1.0, 1.0, 1e3), (1e-3, 1e-4, 1e-3), (0.1, 1e4, 1.0)][i % 4];
        let scene = scenes::one_instance(&mut rng, size, away, offset);
        let bvh = build(scene.geometries);
        let rays: Vec<Ray> = (0..500).map(|_| scenes::ray(&mut rng, &bvh.bounds(), &scene.points)).collect();
        let truth: Vec<Hit> = rays.iter().map(|ray| exhaustive(&bvh, ray)).collect();
        check(scene.name, &bvh, &rays, &truth);
    }
}

#[test]
fn single_calls_equal_batches() {
    let mut rng = Pcg32::new(77);
    for scene in scenes::all(&mut rng) {
        let bvh = build(scene.geometries);
        let rays: Vec<Ray> = (0..500).map(|_| scenes::ray(&mut rng, &bvh.bounds(), &scene.points)).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.closest_batch(&rays, &mut hits);
        for (ray, hit) in rays.iter().zip(&hits) {
            assert_eq!(bits(hit), bits(&bvh.closest(ray)), "{}: {ray:?}", scene.name);
            assert_eq!(hit.is_hit(), bvh.occluded(ray), "{}: {ray:?}", scene.name);
        }
    }
}

#[test]
fn same_tree_every_time() {
    let mut rng = Pcg32::new(5);
    for scene in scenes::all(&mut rng) {
        let (one, two) = (build(scene.geometries.clone()), build(scene.geometries));
        assert_eq!(one.stats(), two.stats());
        assert_eq!(format!("{:?}", one.tree.nodes), format!("{:?}", two.tree.nodes), "{}", scene.name);
    }
}
