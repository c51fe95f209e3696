//! Single primitives against closed forms.

use super::meshes::{direction, in_cube};
use super::{Disk, Geometry, Hit, Instance, Quad, Ray, Sphere, build};
use penombre_lab::Pcg32;
use penombre_math::{DAffine3, DVec3, Transform, Vec3};
use std::sync::Arc;

fn unit_ball() -> crate::Bvh {
    build(vec![Geometry::Spheres(vec![Sphere { center: Vec3::ZERO, radius: 1.0 }])])
}

/// The textbook quadratic in `f32`.
fn naive_sphere(ray: &Ray) -> f32 {
    let (a, b) = (ray.dir.length_squared(), ray.origin.dot(ray.dir));
    let c = ray.origin.length_squared() - 1.0;
    let d = b * b - a * c;
    if d < 0.0 { f32::INFINITY } else { (-b - d.sqrt()) / a }
}

/// Distance of the point at `t` from the unit sphere, in `f64` from the exact `f32` ray.
fn off_sphere(ray: &Ray, t: f32) -> f64 {
    ((ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(t)).length() - 1.0).abs()
}

#[test]
fn spheres_from_afar() {
    let bvh = unit_ball();
    let mut rng = Pcg32::new(10);
    for distance in [2.0, 1e2, 1e4, 1e6] {
        let (mut ours, mut naive) = (0f64, 0f64);
        for _ in 0..5000 {
            let origin = direction(&mut rng) * distance;
            let ray = Ray::new(origin, direction(&mut rng) * 0.9 - origin, 0.0, f32::INFINITY);
            let hit = bvh.closest(&ray);
            assert!(hit.is_hit(), "{ray:?}");
            ours = ours.max(off_sphere(&ray, hit.t));
            naive = naive.max(off_sphere(&ray, naive_sphere(&ray)));
        }
        // Half a unit in the last place of t, times the length of the direction.
        let bound = f64::from(distance) * 1.1 * 2f64.powi(-24);
        assert!(ours < bound, "{distance}: {ours:e}");
        assert!(distance < 1e4 || naive > 1e-1, "the naive formula is bad from {distance}: {naive:e}");
    }
}

#[test]
fn sphere_from_inside_and_in_ranges() {
    let bvh = unit_ball();
    let along = |t_min, t_max| bvh.closest(&Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, t_min, t_max)).t;
    assert_eq!(along(0.0, 10.0), 2.0);
    assert_eq!(along(2.0, 10.0), 4.0, "ranges are open at their start");
    assert_eq!(along(2.5, 4.0), f32::INFINITY, "and at their end");
    assert_eq!(along(-1.0, 2.0), f32::INFINITY);
    let inside = bvh.closest(&Ray::new(Vec3::ZERO, Vec3::new(0.0, 0.5, 0.0), 0.0, 10.0));
    assert_eq!(inside.t, 2.0);
    assert_eq!(bvh.closest(&Ray::new(Vec3::ZERO, Vec3::Y, -10.0, 10.0)).t, -1.0);
}

#[test]
fn quad_coordinates() {
    let sides = [Vec3::new(2.0, 0.0, 0.5), Vec3::new(0.5, 1.0, 0.0)];
    let quad = Quad { origin: Vec3::new(1.0, -1.0, 3.0), sides };
    let bvh = build(vec![Geometry::Quads(vec![quad])]);
    let mut rng = Pcg32::new(11);
    for _ in 0..5000 {
        let (u, v) = (rng.next_f32() * 1.2 - 0.1, rng.next_f32() * 1.2 - 0.1);
        let aim = quad.origin + sides[0] * u + sides[1] * v;
        let origin = aim + direction(&mut rng) * 4.0;
        let grazing = (aim - origin).normalize().dot(sides[0].cross(sides[1]).normalize()).abs() < 0.1;
        let hit = bvh.closest(&Ray::new(origin, aim - origin, 0.0, 10.0));
        let out = u.min(v).min(1.0 - u).min(1.0 - v);
        if grazing || out.abs() < 1e-4 {
            continue;
        }
        assert_eq!(hit.is_hit(), out > 0.0);
        if hit.is_hit() {
            assert!((hit.t - 1.0).abs() < 1e-5 && (hit.u - u).abs() < 2e-5 && (hit.v - v).abs() < 2e-5);
        }
    }
}

#[test]
fn quad_corners_are_inclusive() {
    let quad = Quad { origin: Vec3::ZERO, sides: [Vec3::X, Vec3::Y] };
    let bvh = build(vec![Geometry::Quads(vec![quad])]);
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let hit = bvh.closest(&Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z, 0.0, 2.0));
        assert_eq!((hit.t, hit.u, hit.v), (1.0, x, y));
    }
    for (x, y) in [(-1e-6, 0.5), (1.000_001, 0.5), (0.5, -1e-6), (0.5, 1.000_001)] {
        assert!(!bvh.closest(&Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z, 0.0, 2.0)).is_hit());
    }
}

#[test]
fn disks() {
    let disk = Disk { center: Vec3::new(0.0, 2.0, 0.0), normal: Vec3::new(0.0, 7.0, 0.0), radius: 0.5 };
    let bvh = build(vec![Geometry::Disks(vec![disk])]);
    let mut rng = Pcg32::new(12);
    for _ in 0..5000 {
        let aim = disk.center + in_cube(&mut rng) * Vec3::new(1.0, 0.0, 1.0);
        let r = aim.distance(disk.center);
        let origin = aim + Vec3::new(0.3, 1.0, -0.2);
        let hit = bvh.closest(&Ray::new(origin, aim - origin, 0.0, 2.0));
        if (r - 0.5).abs() > 1e-5 {
            assert_eq!(hit.is_hit(), r < 0.5, "{aim}");
        }
        assert!(!hit.is_hit() || ((hit.t - 1.0).abs() < 1e-6 && hit.u == 0.0 && hit.v == 0.0));
    }
}

#[test]
fn triangle_barycentrics_and_distance() {
    let mut rng = Pcg32::new(13);
    for _ in 0..2000 {
        let mesh = super::bodies::soup(&mut rng, 1, |_| Vec3::splat(1.0));
        let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[i]);
        let (mut u, mut v) = (rng.next_f32(), rng.next_f32());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let aim = a + (b - a) * u + (c - a) * v;
        let origin = aim + direction(&mut rng) * 2.0;
        let dir = aim - origin;
        let normal = (b - a).cross(c - a);
        let sliver = normal.length() < 0.2 || normal.normalize().dot(dir.normalize()).abs() < 0.1;
        if sliver || u.min(v).min(1.0 - u - v) < 1e-3 {
            continue;
        }
        let hit = build(vec![mesh.geometry()]).closest(&Ray::new(origin, dir, 0.0, 2.0));
        assert!(hit.is_hit());
        assert!(
            (hit.t - 1.0).abs() < 2e-5 && (hit.u - u).abs() < 1e-4 && (hit.v - v).abs() < 1e-4,
            "{hit:?}"
        );
    }
}

#[test]
fn instances_keep_distances_and_tell_ids() {
    let nested = Arc::new(build(vec![
        Geometry::Quads(Vec::new()),
        Geometry::Spheres(vec![
            Sphere { center: Vec3::splat(50.0), radius: 1.0 },
            Sphere { center: Vec3::ZERO, radius: 1.0 },
        ]),
    ]));
    let at = |x: f64| {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, 2.0, 2.0),
            Default::default(),
            DVec3::new(x, 0.0, 0.0),
        );
        let to_world = Transform::new(map).expect("not singular");
        Geometry::Instance(Instance { bvh: Arc::clone(&nested), to_world })
    };
    let bvh = build(vec![Geometry::Spheres(Vec::new()), at(0.0), at(10.0)]);
    let hit = bvh.closest(&Ray::new(Vec3::new(10.0, 0.0, 8.0), Vec3::new(0.0, 0.0, -3.0), 0.0, 10.0));
    assert_eq!(hit, Hit { t: 2.0, u: 0.0, v: 0.0, geometry: 1, prim: 1, instance: 2 });
    let hit = bvh.closest(&Ray::new(Vec3::new(20.0, 0.0, 0.0), -Vec3::X, 12.5, 100.0));
    assert_eq!((hit.t, hit.instance), (18.0, 1));
    assert_eq!(bvh.stats().primitives.instances, 2);
    assert!(bvh.stats().bytes < 2 * nested.stats().bytes + 2000, "nested trees count once");
}
