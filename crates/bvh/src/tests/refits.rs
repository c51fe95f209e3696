//! Hierarchies that moved answer as new ones do.

use super::meshes::{Mesh, in_cube};
use super::{Disk, Geometry, Hit, Instance, Quad, Ray, Sphere, Triangles, build, exhaustive};
use crate::{BuildOptions, Bvh, Quality, RefitError};
use penombre_lab::Pcg32;
use penombre_math::{Transform, Vec3};
use std::sync::Arc;

/// Small and long triangles.
fn heap(count: usize, rng: &mut Pcg32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count as u32 {
        let (at, size) = (in_cube(rng), if i % 20 == 0 { 1.0 } else { 0.05 });
        mesh.positions.extend([at, at + in_cube(rng) * size, at + in_cube(rng) * 0.03]);
        mesh.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

fn moved(mesh: &Mesh, rng: &mut Pcg32, by: f32) -> Mesh {
    mesh.clone().map(|p| Vec3::new(p.y + 0.5 * p.x, -p.x, 1.5 * p.z + 3.0) + in_cube(rng) * by)
}

/// Both find the same along random rays, on all processors.
pub fn check(old: &Bvh, new: &Bvh, rng: &mut Pcg32) {
    assert_eq!(old.bounds(), new.bounds());
    assert_eq!(old.stats().primitives, new.stats().primitives);
    assert_eq!(old.stats().skipped, new.stats().skipped);
    let centre = new.bounds().center();
    let size = new.bounds().size();
    let point = |rng: &mut Pcg32| centre + in_cube(rng) * size;
    let rays: Vec<Ray> = (0..2000)
        .map(|_| (point(rng), point(rng)))
        .map(|(from, to)| Ray::new(from, to - from, 0.0, f32::INFINITY))
        .collect();
    let mut expected = vec![Hit::MISS; rays.len()];
    new.closest_batch(&rays, &mut expected);
    let found = expected.iter().filter(|h| h.is_hit()).count();
    assert!(found > 40, "{found} hits test nothing");
    for old in old.on_all_kernels() {
        let mut hits = vec![Hit::MISS; rays.len()];
        old.closest_batch(&rays, &mut hits);
        assert_eq!(hits, expected);
        assert!(rays.iter().zip(&hits).all(|(ray, hit)| old.occluded(ray) == hit.is_hit()));
    }
    for (ray, hit) in rays.iter().zip(&expected).take(50) {
        assert_eq!(exhaustive(new, ray), *hit);
    }
}

#[test]
fn moved_meshes_answer_as_new_ones() {
    let mut rng = Pcg32::new(60);
    let mesh = heap(20_000, &mut rng);
    for quality in [Quality::Fast, Quality::High] {
        let options = BuildOptions::with_quality(quality);
        let mut bvh = Bvh::build(vec![mesh.geometry()], &options).expect("valid");
        for by in [0.0, 0.01, 3.0] {
            let mesh = moved(&mesh, &mut rng, by);
            bvh.refit(vec![mesh.geometry()]).expect("the same triangles");
            check(&bvh, &build(vec![mesh.geometry()]), &mut rng);
        }
    }
}

/// A refit to the same positions costs rays what the build did; disorder costs more.
#[test]
fn the_cost_tells_how_good_a_moved_tree_is() {
    let mut rng = Pcg32::new(61);
    let mesh = heap(5000, &mut rng);
    let options = BuildOptions::with_quality(Quality::Fast);
    let mut bvh = Bvh::build(vec![mesh.geometry()], &options).expect("valid");
    let built = bvh.stats();
    bvh.refit(vec![mesh.geometry()]).expect("the same triangles");
    assert!((bvh.stats().sah_cost / built.sah_cost - 1.0).abs() < 1e-3, "{:?} {built:?}", bvh.stats());
    assert_eq!((bvh.stats().nodes, bvh.stats().leaves), (built.nodes, built.leaves));
    bvh.refit(vec![moved(&mesh, &mut rng, 2.0).geometry()]).expect("the same triangles");
    assert!(bvh.stats().sah_cost > 2.0 * built.sah_cost);
}

/// Every seventh triangle, all of a region, or all but one become degenerate or not finite, and whole again.
#[test]
fn triangles_vanish_and_come_back() {
    let mut rng = Pcg32::new(62);
    let whole = heap(4000, &mut rng);
    let mut bvh = build(vec![whole.geometry()]);
    let gone = |test: &dyn Fn(usize) -> bool, value: Option<f32>| {
        let mut mesh = whole.clone();
        for i in (0..4000).filter(|&i| test(i)) {
            mesh.positions[3 * i] = value.map_or(mesh.positions[3 * i + 1], Vec3::splat);
        }
        mesh
    };
    let right = |i: usize| whole.positions[3 * i].x > 0.0;
    let changes = [
        gone(&|i| i % 7 == 0, None),
        whole.clone(),
        gone(&right, Some(f32::NAN)),
        gone(&|i| i % 3 == 0, Some(f32::INFINITY)),
        whole.clone(),
    ];
    for mesh in changes {
        bvh.refit(vec![mesh.geometry()]).expect("only what was there");
        check(&bvh, &build(vec![mesh.geometry()]), &mut rng);
    }
    let nothing = gone(&|_| true, None);
    bvh.refit(vec![nothing.geometry()]).expect("triangles may vanish");
    assert!(bvh.bounds().is_empty());
    assert_eq!(bvh.stats().skipped, 4000);
    assert_eq!(bvh.closest(&Ray::new(Vec3::splat(2.0), Vec3::NEG_ONE, 0.0, f32::INFINITY)), Hit::MISS);
    bvh.refit(vec![whole.geometry()]).expect("only what was there");
    check(&bvh, &build(vec![whole.geometry()]), &mut rng);
}

/// All kinds of primitives, shifted.
fn mixture(shift: Vec3, nested: &Arc<Bvh>) -> Vec<Geometry> {
    let mut rng = Pcg32::new(63);
    let mut at = || in_cube(&mut rng) + shift;
    let spheres = (0..40).map(|_| Sphere { center: at(), radius: 0.1 }).collect();
    let quads = (0..40).map(|_| Quad { origin: at(), sides: [at() * 0.2, at() * 0.2] }).collect();
    let disks = (0..40).map(|_| Disk { center: at(), normal: at(), radius: 0.1 }).collect();
    let to_world = Transform::translation(at().as_dvec3()).expect("a finite way");
    let mesh = heap(500, &mut rng).map(|p| p + shift);
    vec![
        Geometry::Spheres(spheres),
        mesh.geometry(),
        Geometry::Quads(quads),
        Geometry::Disks(disks),
        Geometry::Instance(Instance { bvh: Arc::clone(nested), to_world }),
    ]
}

#[test]
fn all_kinds_of_primitives_move() {
    let nested = Arc::new(build(vec![heap(100, &mut Pcg32::new(64)).geometry()]));
    let mut bvh = build(mixture(Vec3::ZERO, &nested));
    for shift in [Vec3::new(5.0, 0.1, -3.0), Vec3::new(-400.0, 2.0, 0.0)] {
        bvh.refit(mixture(shift, &nested)).expect("the same primitives");
        check(&bvh, &build(mixture(shift, &nested)), &mut Pcg32::new(65));
    }
}

#[test]
fn errors_leave_the_hierarchy_alone() {
    let mut rng = Pcg32::new(66);
    let mesh = heap(300, &mut rng);
    let sphere = |radius| Geometry::Spheres(vec![Sphere { center: Vec3::ZERO, radius }; 3]);
    let mut broken = mesh.clone();
    broken.positions[8] = broken.positions[7];
    let geometries = vec![broken.geometry(), sphere(0.5)];
    let mut bvh = build(geometries.clone());
    let expect = |bvh: &mut Bvh, geometries, error| assert_eq!(bvh.refit(geometries), Err(error));
    let appeared = RefitError::Appeared { geometry: 0, primitive: 2 };
    expect(&mut bvh, vec![mesh.geometry(), sphere(0.5)], appeared);
    let vanished = RefitError::Vanished { geometry: 1, primitive: 0 };
    expect(&mut bvh, vec![broken.geometry(), sphere(-1.0)], vanished);
    expect(&mut bvh, vec![broken.geometry()], RefitError::Different { geometry: 1 });
    let other = vec![sphere(0.5), broken.geometry()];
    expect(&mut bvh, other, RefitError::Different { geometry: 0 });
    let short = Triangles { positions: Arc::from([Vec3::X]), indices: Arc::from(&*broken.indices) };
    let refused = bvh.refit(vec![Geometry::Triangles(short), sphere(0.5)]);
    assert!(matches!(refused, Err(RefitError::Build(_))), "{refused:?}");
    check(&bvh, &build(geometries), &mut rng);
}
