//! Primitives by callback. That trees of them equal exhaustive search is tested with all scenes.

use super::meshes::{Mesh, direction, in_cube};
use super::{Geometry, Hit, Instance, Ray, Sphere, bodies, build};
use crate::{Bvh, UserHit, UserPrimitives};
use penombre_lab::Pcg32;
use penombre_math::{Bounds3, DAffine3, DVec3, Transform, Vec3};
use std::sync::Arc;

/// Spheres by the textbook formula in double precision.
#[derive(Debug)]
pub struct Balls(pub Vec<Sphere>);

/// What the textbook formula needs.
const MARGIN: f32 = 1e-6;

/// The first of some distances that lies in the ray's range.
fn first_in_range(ray: &Ray, distances: [f64; 2]) -> Option<UserHit> {
    let t = distances.map(|t| t as f32).into_iter().find(|&t| ray.t_min < t && t < ray.t_max)?;
    Some(UserHit { t, u: 0.25, v: -7.0 })
}

impl UserPrimitives for Balls {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: usize) -> Option<Bounds3> {
        let Sphere { center, radius } = self.0[index];
        let radius = Vec3::splat(radius + MARGIN);
        Some(Bounds3 { min: center - radius, max: center + radius })
    }

    fn intersect(&self, index: usize, ray: &Ray) -> Option<UserHit> {
        let Sphere { center, radius } = self.0[index];
        let (from, dir) = (ray.origin.as_dvec3() - center.as_dvec3(), ray.dir.as_dvec3());
        let (a, b) = (dir.length_squared(), from.dot(dir));
        let root = (b * b - a * (from.length_squared() - f64::from(radius).powi(2))).sqrt();
        first_in_range(ray, [(-b - root) / a, (-b + root) / a])
    }
}

/// Hollow boxes along the axes.
#[derive(Debug)]
pub struct Boxes(pub Vec<Bounds3>);

impl UserPrimitives for Boxes {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: usize) -> Option<Bounds3> {
        Some(self.0[index])
    }

    fn intersect(&self, index: usize, ray: &Ray) -> Option<UserHit> {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (from, dir) = (f64::from(ray.origin[axis]), f64::from(ray.dir[axis]));
            let [min, max] = [self.0[index].min, self.0[index].max].map(|p| f64::from(p[axis]));
            if dir == 0.0 {
                if from < min || from > max {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min - from) / dir, (max - from) / dir);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        if enter > leave {
            return None;
        }
        first_in_range(ray, [enter, leave])
    }
}

fn user(list: impl UserPrimitives + 'static) -> Geometry {
    Geometry::User(Arc::new(list))
}

/// Rays of unit length from and to anywhere near the origin.
fn rays(rng: &mut Pcg32, count: usize) -> Vec<Ray> {
    (0..count).map(|_| Ray::new(in_cube(rng) * 3.0, direction(rng), 0.0, f32::INFINITY)).collect()
}

/// Two hierarchies of the same surfaces find nearly the same, but for a few rays that graze one.
fn check_alike(ours: &Bvh, theirs: &Bvh, rays: &[Ray], same: impl Fn(&Hit, &Hit) -> bool) {
    let mut truth = vec![Hit::MISS; rays.len()];
    theirs.closest_batch(rays, &mut truth);
    let found = truth.iter().filter(|hit| hit.is_hit()).count();
    assert!(found > rays.len() / 10 && found < rays.len(), "{found} hits test nothing");
    for ours in ours.on_all_kernels() {
        let (mut hits, mut blocked) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        ours.closest_batch(rays, &mut hits);
        ours.occluded_batch(rays, &mut blocked);
        let mut others = 0;
        for (i, (hit, truth)) in hits.iter().zip(&truth).enumerate() {
            assert_eq!((blocked[i], ours.closest(&rays[i])), (hit.is_hit(), *hit));
            let near = hit.t == truth.t || (hit.t - truth.t).abs() < 1e-4;
            others += usize::from(!near || !same(hit, truth));
        }
        assert!(others * 1000 < rays.len(), "{others} of {} rays differ", rays.len());
    }
}

fn many_balls(rng: &mut Pcg32) -> Vec<Sphere> {
    (0..300).map(|_| Sphere { center: in_cube(rng) * 3.0, radius: 0.02 + 0.2 * rng.next_f32() }).collect()
}

#[test]
fn balls_by_callback_are_hit_as_spheres_are() {
    let mut rng = Pcg32::new(320);
    let balls = many_balls(&mut rng);
    let theirs = build(vec![Geometry::Spheres(Vec::new()), Geometry::Spheres(balls.clone())]);
    let ours = build(vec![user(Balls(Vec::new())), user(Balls(balls))]);
    check_alike(&ours, &theirs, &rays(&mut rng, 20_000), |ours, theirs| {
        let coordinates = if ours.is_hit() { (0.25, -7.0) } else { (0.0, 0.0) };
        (ours.u, ours.v) == coordinates && (ours.geometry, ours.prim) == (theirs.geometry, theirs.prim)
    });
    assert_eq!((ours.stats().primitives.users, ours.stats().skipped), (300, 0));
}

#[test]
fn boxes_by_callback_are_hit_as_meshes_are() {
    let mut rng = Pcg32::new(321);
    let places: Vec<(Vec3, Vec3)> =
        (0..100).map(|_| (in_cube(&mut rng) * 3.0, in_cube(&mut rng).abs() * 0.4 + 0.01)).collect();
    let meshes: Vec<Mesh> = places.iter().map(|&(at, half)| bodies::cube().map(|p| at + p * half)).collect();
    let theirs = build(meshes.iter().map(Mesh::geometry).collect());
    let boxes = meshes.iter().map(|mesh| Bounds3::of_points(mesh.positions.iter().copied())).collect();
    let ours = build(vec![user(Boxes(boxes))]);
    check_alike(&ours, &theirs, &rays(&mut rng, 20_000), |ours, theirs| ours.prim == theirs.geometry);
}

#[test]
fn instanced_callbacks_are_asked_in_their_own_space() {
    let mut rng = Pcg32::new(322);
    let balls = many_balls(&mut rng);
    let nested =
        [Geometry::Spheres(balls.clone()), user(Balls(balls))].map(|list| Arc::new(build(vec![list])));
    let maps = [0; 5].map(|_| {
        let size = in_cube(&mut rng).as_dvec3() * 0.4 + DVec3::splat(0.6);
        let by = in_cube(&mut rng).as_dvec3() * 2.0;
        Transform::new(DAffine3::from_translation(by) * DAffine3::from_scale(size)).expect("not singular")
    });
    let [theirs, ours] = nested.map(|bvh| {
        let place = |&to_world| Geometry::Instance(Instance { bvh: Arc::clone(&bvh), to_world });
        build(maps.iter().map(place).collect())
    });
    check_alike(&ours, &theirs, &rays(&mut rng, 10_000), |ours, theirs| {
        (ours.instance, ours.geometry, ours.prim) == (theirs.instance, theirs.geometry, theirs.prim)
    });
}

/// Says of three primitives what it is told to.
#[derive(Clone, Debug)]
struct Says {
    bounds: [Option<Bounds3>; 3],
    hits: [Option<UserHit>; 3],
}

impl UserPrimitives for Says {
    fn len(&self) -> usize {
        3
    }

    fn bounds(&self, index: usize) -> Option<Bounds3> {
        self.bounds[index]
    }

    fn intersect(&self, index: usize, _ray: &Ray) -> Option<UserHit> {
        self.hits[index]
    }
}

const CUBE: Bounds3 = Bounds3 { min: Vec3::NEG_ONE, max: Vec3::ONE };

fn at(t: f32) -> Option<UserHit> {
    Some(UserHit { t, u: 0.0, v: 0.0 })
}

/// The prim hit by a ray from −3 to +3 with a range from 1 to 5, the same however it is asked.
fn prim_hit(says: &Says) -> u32 {
    let ray = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 1.0, 5.0);
    let bvh = build(vec![user(says.clone())]);
    let hit = bvh.closest(&ray);
    for bvh in bvh.on_all_kernels() {
        let mut hits = [Hit::MISS; 9];
        bvh.closest_batch(&[ray; 9], &mut hits);
        assert_eq!((hits, bvh.closest(&ray)), ([hit; 9], hit));
        assert_eq!(bvh.occluded(&ray), hit.is_hit());
        assert_eq!(bvh.closest_where(&ray, &|_: usize, _: &Ray, _: &Hit| true), hit);
    }
    hit.prim
}

#[test]
fn hits_out_of_range_or_not_numbers_are_ignored() {
    let with =
        |first: Option<UserHit>| prim_hit(&Says { bounds: [Some(CUBE); 3], hits: [first, None, at(3.5)] });
    assert_eq!(with(at(3.0)), 0);
    assert_eq!(with(at(3.5)), 0, "the smaller index among equals");
    assert_eq!(with(at(4.0)), 2);
    for t in [1.0, 0.5, -3.0, 5.0, 6.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(with(at(t)), 2, "{t}");
    }
    for (u, v) in [(f32::NAN, 0.0), (0.0, f32::NAN)] {
        assert_eq!(with(Some(UserHit { t: 3.0, u, v })), 2);
    }
}

#[test]
fn primitives_without_boxes_are_skipped_and_counted() {
    let hits = [at(2.5), at(3.0), at(3.5)];
    let with = |first: Option<Bounds3>| {
        let says = Says { bounds: [first, Some(CUBE), None], hits };
        let stats = build(vec![user(says.clone())]).stats();
        assert_eq!(stats.primitives.users + stats.skipped, 3);
        (prim_hit(&says), stats.skipped)
    };
    assert_eq!(with(Some(CUBE)), (0, 1));
    assert_eq!(with(None), (1, 2));
    assert_eq!(with(Some(Bounds3::EMPTY)), (1, 2));
    assert_eq!(with(Some(Bounds3 { min: CUBE.max, max: CUBE.min })), (1, 2), "inside out");
    for bad in [f32::NAN, f32::INFINITY] {
        assert_eq!(with(Some(Bounds3 { min: CUBE.min, max: Vec3::new(1.0, bad, 1.0) })), (1, 2), "{bad}");
        assert_eq!(with(Some(Bounds3 { min: Vec3::new(-bad, -1.0, -1.0), max: CUBE.max })), (1, 2), "{bad}");
    }
    let nothing = build(vec![user(Says { bounds: [None; 3], hits })]);
    assert_eq!((nothing.stats().skipped, nothing.bounds().is_empty()), (3, true));
    assert!(!nothing.closest(&Ray::new(Vec3::ZERO, Vec3::Z, 0.0, 9.0)).is_hit());
}

/// Of a box that is refused where the ray enters it, the far side may count.
#[test]
fn filters_see_the_far_side() {
    let bvh = build(vec![user(Boxes(vec![CUBE]))]);
    let ray = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 0.0, 10.0);
    let far = |_: usize, ray: &Ray, hit: &Hit| ray.at(hit.t).z > 0.0;
    assert_eq!((bvh.closest(&ray).t, bvh.closest_where(&ray, &far).t), (2.0, 4.0));
    assert!(bvh.occluded_where(&ray, &far) && !bvh.occluded_where(&Ray { t_max: 4.0, ..ray }, &far));
    let neither = |_: usize, _: &Ray, _: &Hit| false;
    assert!(!bvh.closest_where(&ray, &neither).is_hit() && !bvh.occluded_where(&ray, &neither));
}

#[test]
fn callbacks_move() {
    let mut rng = Pcg32::new(323);
    let balls = many_balls(&mut rng);
    let moved: Vec<Sphere> = balls
        .iter()
        .map(|b| Sphere { center: Vec3::splat(0.5) - b.center + 0.2 * in_cube(&mut rng), ..*b })
        .collect();
    let mut bvh = build(vec![user(Balls(balls.clone()))]);
    bvh.refit(vec![user(Balls(moved.clone()))]).expect("the same primitives");
    check_alike(&bvh, &build(vec![Geometry::Spheres(moved)]), &rays(&mut rng, 10_000), |ours, theirs| {
        ours.prim == theirs.prim
    });
    let gone = crate::RefitError::Vanished { geometry: 0, primitive: 1 };
    let says = |bounds| user(Says { bounds, hits: [None; 3] });
    let mut bvh = build(vec![says([Some(CUBE); 3])]);
    assert_eq!(bvh.refit(vec![says([Some(CUBE), None, Some(CUBE)])]), Err(gone));
    let other = Geometry::Spheres(balls[..3].to_vec());
    assert_eq!(bvh.refit(vec![other]), Err(crate::RefitError::Different { geometry: 0 }));
}
