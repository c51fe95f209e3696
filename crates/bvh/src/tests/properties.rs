//! Properties over random geometry that shrinks to small counterexamples.

use super::{Disk, Geometry, Quad, Ray, Sphere, Triangles, build, exhaustive};
use penombre_math::Vec3;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use std::sync::Arc;

/// Coordinates on a coarse grid (for coincidences), anywhere, and every bit pattern there is.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (-4i8..=4).prop_map(f32::from),
        4 => -1f32..1f32,
        1 => any::<u32>().prop_map(f32::from_bits),
    ]
}

fn vector() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from_array)
}

fn mesh() -> impl Strategy<Value = Geometry> {
    let indices = prop::collection::vec([0u32..12, 0..12, 0..12], 0..40);
    (prop::collection::vec(vector(), 12), indices).prop_map(|(positions, indices)| {
        Geometry::Triangles(Triangles { positions: Arc::from(positions), indices: Arc::from(indices) })
    })
}

fn others() -> impl Strategy<Value = Vec<Geometry>> {
    let sphere = (vector(), number()).prop_map(|(center, radius)| Sphere { center, radius });
    let quad = (vector(), [vector(), vector()]).prop_map(|(origin, sides)| Quad { origin, sides });
    let disk =
        (vector(), vector(), number()).prop_map(|(center, normal, radius)| Disk { center, normal, radius });
    (
        prop::collection::vec(sphere, 0..8),
        prop::collection::vec(quad, 0..8),
        prop::collection::vec(disk, 0..8),
    )
        .prop_map(|(s, q, d)| vec![Geometry::Spheres(s), Geometry::Quads(q), Geometry::Disks(d)])
}

fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let ray = (vector(), vector(), number(), number())
        .prop_map(|(origin, dir, a, b)| Ray::new(origin, dir, a.min(0.0), b.abs() * 10.0));
    prop::collection::vec(ray, 60)
}

proptest! {
    #![proptest_config(Config {
        cases: 400,
        rng_seed: RngSeed::Fixed(20_261_122),
        failure_persistence: None,
        ..Config::default()
    })]

    #[test]
    fn meshes_agree_with_exhaustive_search(mesh in mesh(), rays in rays()) {
        let bvh = build(vec![mesh]);
        for ray in rays {
            let truth = exhaustive(&bvh, &ray);
            prop_assert_eq!(bvh.closest(&ray), truth);
            prop_assert_eq!(bvh.occluded(&ray), truth.is_hit());
        }
    }

    #[test]
    fn anything_agrees_with_exhaustive_search(mesh in mesh(), others in others(), rays in rays()) {
        let mut geometries = others;
        geometries.push(mesh);
        let bvh = build(geometries);
        for ray in rays {
            let truth = exhaustive(&bvh, &ray);
            prop_assert_eq!(bvh.closest(&ray), truth);
            prop_assert_eq!(bvh.occluded(&ray), truth.is_hit());
        }
    }
}
