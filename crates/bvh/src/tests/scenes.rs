//! Adversarial scenes and rays.

use super::bodies;
use super::cornell::cornell;
use super::meshes::{self, Mesh, direction, in_cube};
use super::users::{Balls, Boxes};
use super::{Disk, Geometry, Instance, Quad, Ray, Sphere, build};
use penombre_lab::Pcg32;
use penombre_math::{Bounds3, DAffine3, DMat3, DVec3, Transform, Vec3};
use std::sync::Arc;

pub struct Scene {
    pub name: &'static str,
    pub geometries: Vec<Geometry>,
    /// Points worth aiming at: vertices, corners, poles.
    pub points: Vec<Vec3>,
}

fn of_mesh(name: &'static str, mesh: &Mesh) -> Scene {
    Scene { name, geometries: vec![mesh.geometry()], points: mesh.positions.clone() }
}

pub fn all(rng: &mut Pcg32) -> Vec<Scene> {
    let small = |_: &mut Pcg32| Vec3::splat(0.2);
    let mut scenes = vec![
        of_mesh("icosphere", &meshes::icosphere(2)),
        of_mesh("torus", &bodies::torus(3)),
        of_mesh("cube", &bodies::cube()),
        of_mesh("soup", &bodies::soup(rng, 300, small)),
        of_mesh("thin soup", &bodies::soup(rng, 300, |rng| stretched(direction(rng)))),
        of_mesh("grid along its plane", &bodies::grid(8)),
        of_mesh("far grid", &bodies::grid(8).map(|p| p + Vec3::new(1e6, 3e5, -2e6))),
        of_mesh("huge", &bodies::soup(rng, 200, small).map(|p| p * 1e30)),
        of_mesh("tiny", &bodies::soup(rng, 200, small).map(|p| p * 1e-30)),
        of_mesh("subnormal", &bodies::soup(rng, 100, small).map(|p| p * 1e-38)),
        of_mesh("squashed", &meshes::icosphere(2).map(|p| p * Vec3::new(1.0, 1e-6, 1.0))),
        of_mesh("integers", &bodies::soup(rng, 200, small).map(|p| (p * 4.0).round())),
    ];
    scenes.extend([
        all_sizes(rng),
        coincident(rng),
        mixed(rng),
        touching(),
        instances(rng),
        sheared_instances(rng),
        users(rng),
    ]);
    scenes
}

/// Long in the main direction of `v`, about 10⁻⁵ across.
fn stretched(v: Vec3) -> Vec3 {
    let square = v * v;
    square * square * square * square * 2.0 + 1e-5
}

/// Triangles from 10⁻²⁰ to 10²⁰ together.
fn all_sizes(rng: &mut Pcg32) -> Scene {
    let mut mesh = bodies::soup(rng, 200, |_| Vec3::splat(0.5));
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        let size = (0..(i / 3) % 41).fold(1e-20, |s, _| s * 10.0);
        *p *= size;
    }
    of_mesh("all sizes", &mesh)
}

/// Hundreds of equal triangles, in two meshes, and their mirrored twins.
fn coincident(rng: &mut Pcg32) -> Scene {
    let one = bodies::soup(rng, 3, |_| Vec3::splat(1.0));
    let mut many = one.clone();
    for i in 0..600 {
        let [a, b, c] = one.indices[i % 3];
        many.indices.push(if i % 2 == 0 { [a, b, c] } else { [c, b, a] });
    }
    Scene { name: "coincident", geometries: vec![many.geometry(), many.geometry()], points: one.positions }
}

fn mixed(rng: &mut Pcg32) -> Scene {
    let mesh = bodies::soup(rng, 60, |_| Vec3::splat(0.4));
    let mut points = mesh.positions.clone();
    let (mut spheres, mut quads, mut disks) = (vec![], vec![], vec![]);
    for i in 0..40 {
        let center = in_cube(rng) * 2.0;
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][i % 3];
        let radius = 0.05 + 0.3 * rng.next_f32();
        spheres.push(Sphere { center, radius });
        points.extend([center, center + axis * radius, center - axis * radius]);
        // Every other one lies along the axes.
        let sides = if i % 2 == 0 {
            [axis, [Vec3::Y, Vec3::Z, Vec3::X][i % 3]]
        } else {
            [direction(rng), direction(rng)]
        };
        let origin = in_cube(rng);
        quads.push(Quad { origin, sides });
        points.extend([origin, origin + sides[0], origin + sides[1], origin + sides[0] + sides[1]]);
        let normal = if i % 2 == 0 { axis } else { direction(rng) * 3.0 };
        disks.push(Disk { center: -center, normal, radius });
        points.push(-center);
    }
    let lists = [Geometry::Disks(disks), Geometry::Quads(quads), Geometry::Spheres(spheres)];
    let geometries = lists.into_iter().chain([mesh.geometry()]).collect();
    Scene { name: "mixed", geometries, points }
}

/// Surfaces that touch and coincide: equal distances abound.
fn touching() -> Scene {
    let quad = Quad { origin: Vec3::splat(-1.0), sides: [Vec3::X * 2.0, Vec3::Y * 2.0] };
    let disk = Disk { center: Vec3::new(0.0, 0.0, -1.0), normal: Vec3::Z, radius: 1.0 };
    let sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };
    let mut geometries = cornell();
    geometries.extend([
        bodies::cube().geometry(),
        Geometry::Spheres(vec![sphere; 3]),
        Geometry::Disks(vec![disk, disk]),
        Geometry::Quads(vec![quad, quad]),
    ]);
    let mut points = bodies::cube().positions;
    points.extend(points.clone().into_iter().map(|p| p * 2.0));
    points.extend([Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::ZERO]);
    Scene { name: "touching", geometries, points }
}

fn placed(rng: &mut Pcg32, linear: DAffine3) -> Transform {
    let by = in_cube(rng).as_dvec3() * 3.0;
    Transform::new(DAffine3::from_translation(by) * linear).expect("not singular")
}

fn instances_of(rng: &mut Pcg32, name: &'static str, linear: impl Fn(&mut Pcg32) -> DAffine3) -> Scene {
    let ball = meshes::icosphere(1);
    let meshes = [ball.clone(), bodies::cube(), bodies::grid(2)];
    let nested: Vec<_> = meshes.iter().map(|m| Arc::new(build(vec![m.geometry()]))).collect();
    let others = Arc::new(build(mixed(rng).geometries));
    let mut geometries = vec![ball.geometry()];
    let mut points = ball.positions.clone();
    for i in 0..12 {
        let map = linear(rng);
        let to_world = if i % 4 == 0 { placed(rng, DAffine3::IDENTITY) } else { placed(rng, map) };
        geometries.push(Geometry::Instance(Instance { bvh: Arc::clone(&nested[i % 3]), to_world }));
        points.extend(meshes[i % 3].positions.iter().map(|&p| to_world.point(p)));
    }
    let map = linear(rng);
    let to_world = placed(rng, map);
    // Twice at the same place, so that ids decide.
    for _ in 0..2 {
        geometries.push(Geometry::Instance(Instance { bvh: Arc::clone(&others), to_world }));
    }
    Scene { name, geometries, points }
}

fn instances(rng: &mut Pcg32) -> Scene {
    instances_of(rng, "instances", |rng| {
        let x = direction(rng).as_dvec3();
        let y = x.cross(direction(rng).as_dvec3()).normalize();
        let size = f64::from(rng.next_f32()) + 0.1;
        DAffine3::from_mat3(DMat3::from_cols(x, y, x.cross(y)) * size)
    })
}

fn sheared_instances(rng: &mut Pcg32) -> Scene {
    instances_of(rng, "sheared instances", |rng| {
        let column = |rng: &mut Pcg32| in_cube(rng).as_dvec3();
        let (x, y, z) = (column(rng), column(rng), column(rng) * 1e-3);
        DAffine3::from_mat3(DMat3::from_cols(x, y + DVec3::X * 1e-4, z + DVec3::Z * 1e-4))
    })
}

/// Primitives by callback among others, in the world and in instances.
fn users(rng: &mut Pcg32) -> Scene {
    let sphere = |rng: &mut Pcg32| Sphere { center: in_cube(rng) * 2.0, radius: 0.05 + 0.3 * rng.next_f32() };
    let balls: Vec<Sphere> = (0..40).map(|_| sphere(rng)).collect();
    let mut boxes: Vec<Bounds3> = (0..60)
        .map(|_| (in_cube(rng), in_cube(rng)))
        .map(|(a, b)| Bounds3 { min: a.min(a + b * 0.3), max: a.max(a + b * 0.3) })
        .collect();
    boxes.extend(boxes.clone().iter().take(5));
    let mut points: Vec<Vec3> = boxes.iter().flat_map(Bounds3::corners).collect();
    points.extend(balls.iter().map(|ball| ball.center));
    let lists = || {
        vec![
            Geometry::User(Arc::new(Boxes(boxes.clone()))),
            Geometry::User(Arc::new(Balls(Vec::new()))),
            Geometry::User(Arc::new(Balls(balls.clone()))),
        ]
    };
    let nested = Arc::new(build(lists()));
    let mut geometries = lists();
    geometries.push(meshes::icosphere(1).geometry());
    for _ in 0..3 {
        let linear = DMat3::from_diagonal(in_cube(rng).as_dvec3() + DVec3::splat(1.5));
        let to_world = placed(rng, DAffine3::from_mat3(linear));
        geometries.push(Geometry::Instance(Instance { bvh: Arc::clone(&nested), to_world }));
        points.extend(balls.iter().map(|ball| to_world.point(ball.center)));
    }
    Scene { name: "users", geometries, points }
}

/// One small body in a skew place, to be aimed at exactly: the box in the world and the surface in its own
/// space must not disagree. The body of about `size` lies `away` from the origin of its own space, which lies
/// `offset` from the world's.
pub fn one_instance(rng: &mut Pcg32, size: f32, away: f32, offset: f64) -> Scene {
    let [x, y, z] = [0; 3].map(|_| in_cube(rng).as_dvec3());
    let linear = DMat3::from_cols(x, y + DVec3::Y * 0.1, z * 0.1 + DVec3::Z * 0.1);
    let by = in_cube(rng).as_dvec3() * offset;
    let to_world = Transform::new(DAffine3 { matrix3: linear, translation: by }).expect("not singular");
    let mesh = if rng.below(2) == 0 { bodies::grid(1) } else { meshes::icosphere(0) };
    let shift = in_cube(rng) * away;
    let mesh = mesh.map(|p| p * size + shift);
    let points = mesh.positions.iter().map(|&p| to_world.point(p)).collect();
    let bvh = Arc::new(build(vec![mesh.geometry()]));
    Scene { name: "one instance", geometries: vec![Geometry::Instance(Instance { bvh, to_world })], points }
}

/// A ray that looks for trouble: from and to special points, along axes and planes, of odd lengths and
/// ranges.
pub fn ray(rng: &mut Pcg32, bounds: &Bounds3, points: &[Vec3]) -> Ray {
    let special = |rng: &mut Pcg32| points[rng.below(points.len() as u32) as usize];
    let somewhere = |rng: &mut Pcg32| bounds.center() + bounds.size() * in_cube(rng);
    let on_edge = |rng: &mut Pcg32| special(rng) * 0.5 + special(rng) * 0.5;
    let mut origin = match rng.below(8) {
        0 => special(rng),
        1 => special(rng) - somewhere(rng),
        2 => Vec3::new(special(rng).x, somewhere(rng).y, special(rng).z),
        3 => on_edge(rng),
        4 => bounds.center() + bounds.size() * in_cube(rng) * 1e3,
        _ => somewhere(rng),
    };
    let mut dir = match rng.below(8) {
        0 => [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z][rng.below(6) as usize],
        1 => (special(rng) - special(rng)) * Vec3::new(1.0, -0.0, 1.0),
        2 => {
            direction(rng) * [Vec3::new(1.0, 1e-13, 1e-7), Vec3::new(1e-4, 1e-11, 1.0)][rng.below(2) as usize]
        }
        3 => on_edge(rng) - origin,
        4 => direction(rng),
        _ => special(rng) - origin,
    };
    if rng.below(4) == 0 && dir != Vec3::ZERO {
        // Through a point, but for rounding, in whatever direction.
        let distance = bounds.size().max_element() * 3.0 * rng.next_f32();
        origin = special(rng) - dir / dir.abs().max_element() * distance;
    }
    dir *= match rng.below(8) {
        0 => 1e-12,
        1 => 1e12,
        2 => 1e-35,
        3 => 1e6,
        _ => 1.0,
    };
    let (t_min, t_max) = match rng.below(6) {
        0 => (-1.0, 0.5),
        1 => (0.0, 1.0),
        2 => (f32::NEG_INFINITY, f32::INFINITY),
        3 => (1e-4, 2.0),
        _ => (0.0, f32::INFINITY),
    };
    Ray::new(origin, dir, t_min, t_max)
}

/// `count` spheres, parallelograms and disks. Every fourth one lies where the one before does.
pub fn few(rng: &mut Pcg32, count: usize) -> Scene {
    let (mut spheres, mut quads, mut disks) = (Vec::new(), Vec::new(), Vec::new());
    let mut points = vec![Vec3::ZERO];
    let mut kind = 0;
    for i in 0..count {
        let center = in_cube(rng) * 2.0;
        points.push(center);
        if i % 4 != 3 || i == 0 {
            kind = rng.below(3);
        }
        let twice = i % 4 == 3;
        match kind {
            0 => {
                let new = Sphere { center, radius: 0.2 + rng.next_f32() };
                spheres.push(if twice { spheres[spheres.len() - 1] } else { new });
            }
            1 => {
                let new = Quad { origin: center, sides: [direction(rng), direction(rng) * 2.0] };
                quads.push(if twice { quads[quads.len() - 1] } else { new });
            }
            _ => {
                let new = Disk { center, normal: direction(rng), radius: 0.2 + rng.next_f32() };
                disks.push(if twice { disks[disks.len() - 1] } else { new });
            }
        }
    }
    let geometries = vec![Geometry::Disks(disks), Geometry::Spheres(spheres), Geometry::Quads(quads)];
    Scene { name: "few", geometries, points }
}
