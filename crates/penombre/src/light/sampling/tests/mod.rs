//! Densities by χ², closed forms of solid angle and irradiance, accuracy of the maps, odd input.
//!
//! Significance is α = 0.01 over all the tests of a function, by Šidák. The normal run draws 10⁵ samples per
//! density; with `PENOMBRE_SLOW=1` it draws 10⁶.

mod accuracy;
mod chance;
mod density;
mod environment;
mod irradiance;
mod odd;

use super::*;
use penombre_lab::Pcg32;

const ALPHA: f64 = 0.01;

fn slow() -> bool {
    std::env::var_os("PENOMBRE_SLOW").is_some_and(|v| v == "1")
}

fn samples() -> u32 {
    if slow() { 1_000_000 } else { 100_000 }
}

fn uniform(rng: &mut Pcg32) -> Vec2 {
    Vec2::new(rng.next_f32(), rng.next_f32())
}

/// A unit vector, uniform.
fn any_direction(rng: &mut Pcg32) -> Vec3 {
    let z = 1.0 - 2.0 * rng.next_f64();
    let (s, c) = (std::f64::consts::TAU * rng.next_f64()).sin_cos();
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * c, across * s, z).as_vec3()
}

/// A turned frame, so that nothing lies along an axis.
fn turned(v: Vec3) -> Vec3 {
    let z = DVec3::new(0.36, -0.48, 0.8);
    let (x, y) = z.any_orthonormal_pair();
    let v = v.as_dvec3();
    (x * v.x + y * v.y + z * v.z).as_vec3()
}

/// Solid angle of a triangle of vectors, in double precision \[VanOosterom1983\].
fn triangle_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let det = a.dot((b - a).cross(c - a)).abs();
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    2.0 * det.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// Solid angle of a parallelogram.
fn quad_angle(corner: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let far = corner + a + b;
    triangle_angle([corner, corner + a, far]) + triangle_angle([corner, far, corner + b])
}

/// A rectangle, a skewed one, a triangle… of any kind, for tests of what all have in common.
enum Shape {
    Quad(SphericalQuad),
    Triangle(SphericalTriangle),
    Disk(SphericalDisk),
    Sphere(SphericalCap),
}

impl Shape {
    fn sampler(&self) -> &dyn DirectionSampler {
        match self {
            Self::Quad(s) => s,
            Self::Triangle(s) => s,
            Self::Disk(s) => s,
            Self::Sphere(s) => s,
        }
    }
}

/// Shapes near and far, large and small, in front and at the side, around and over the point, each with its name.
fn shapes() -> Vec<(&'static str, Shape)> {
    let point = turned(Vec3::new(0.3, -0.2, 0.1));
    let at = |v: [f32; 3]| point + turned(Vec3::from(v));
    let along = |v: [f32; 3]| turned(Vec3::from(v));
    let quad = |origin, a, b| {
        Shape::Quad(SphericalQuad::new(point, at(origin), [along(a), along(b)]).expect("it can be seen"))
    };
    let triangle = |a, b, c| {
        Shape::Triangle(SphericalTriangle::new(point, [at(a), at(b), at(c)]).expect("it can be seen"))
    };
    let disk = |center, normal: [f32; 3], radius| {
        let normal = along(normal).normalize();
        Shape::Disk(SphericalDisk::new(point, at(center), normal, radius).expect("it can be seen"))
    };
    let sphere =
        |center, radius| Shape::Sphere(SphericalCap::new(point, at(center), radius).expect("it can be seen"));
    vec![
        ("rectangle", quad([-0.5, -0.3, 1.0], [1.2, 0.0, 0.0], [0.0, 0.9, 0.0])),
        ("rectangle at the side", quad([1.0, 0.5, 0.6], [1.2, 0.0, 0.0], [0.0, 0.9, 0.0])),
        ("rectangle upright", quad([1.0, -2.5, -1.6], [0.0, 0.0, 2.2], [0.5, 4.9, 0.0])),
        ("rectangle all around", quad([-50.0, -30.0, -1.0], [80.0, 0.0, 0.0], [0.0, 70.0, 0.0])),
        ("rectangle close", quad([-0.5, -0.3, 1e-4], [1.2, 0.0, 0.0], [0.0, 0.9, 0.0])),
        ("rectangle over an edge", quad([0.0, -0.3, 0.01], [1.2, 0.0, 0.0], [0.0, 0.9, 0.0])),
        ("rectangle small", quad([-0.5, -0.3, 8.0], [0.6, 0.0, 0.0], [0.0, 0.45, 0.0])),
        ("rectangle far", quad([-0.5, -0.3, 20.0], [0.3, 0.0, 0.0], [0.0, 0.15, 0.0])),
        ("parallelogram", quad([-0.5, -0.3, 1.0], [1.2, 0.2, 0.1], [0.5, 0.9, 0.0])),
        ("parallelogram close", quad([-0.5, -0.6, -0.01], [1.2, 0.2, 0.0], [0.5, 1.9, 0.0])),
        ("parallelogram sharp", quad([0.5, 0.3, 1.0], [5.0, 0.2, 0.1], [5.0, 0.9, 0.0])),
        ("triangle", triangle([-0.5, -0.3, 1.0], [1.2, 0.2, 1.1], [0.5, 0.9, 0.7])),
        ("triangle all around", triangle([-50.0, -30.0, 1.0], [52.0, -30.0, 1.0], [0.5, 49.0, 1.1])),
        ("triangle at the side", triangle([0.5, 0.3, 0.1], [1.2, 0.2, 0.1], [0.5, 0.9, 0.07])),
        ("triangle of three octants", triangle([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])),
        ("triangle far", triangle([30.0, 0.0, 0.0], [30.0, 0.6, 0.0], [30.0, 0.0, 0.6])),
        ("disk ahead", disk([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 0.8)),
        ("disk at the side", disk([2.0, 0.5, 0.4], [0.3, 0.1, -1.0], 1.2)),
        ("disk edge-on", disk([2.0, 0.5, 0.05], [0.0, 0.0, -1.0], 1.2)),
        ("disk close", disk([0.3, 0.1, 0.02], [0.0, 0.0, 1.0], 0.8)),
        ("disk far", disk([9.0, 5.0, 14.0], [-0.3, 0.1, 1.0], 1.2)),
        ("sphere", sphere([1.0, -0.5, 0.7], 0.8)),
        ("sphere close", sphere([1.0, 0.0, 0.0], 0.9999)),
        ("sphere far", sphere([-10.0, 3.0, 5.0], 1.0)),
        ("sphere around the point", sphere([0.3, 0.1, 0.0], 2.0)),
    ]
}
