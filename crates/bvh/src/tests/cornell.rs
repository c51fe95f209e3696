//! The course's box for tests and benches.

use super::{Geometry, Quad, Sphere};
use penombre_math::Vec3;

/// The course's box: six walls of a room from −2 to 2 and two balls.
pub fn cornell() -> Vec<Geometry> {
    let wall = |x: f32, y: f32, z: f32, s: Vec3, t: Vec3| Quad { origin: Vec3::new(x, y, z), sides: [s, t] };
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z * 4.0);
    let walls = vec![
        wall(-2.0, -2.0, -2.0, z, y),
        wall(2.0, -2.0, -2.0, y, z),
        wall(-2.0, -2.0, -2.0, x, z),
        wall(-2.0, 2.0, -2.0, z, x),
        wall(-2.0, -2.0, -2.0, y, x),
        wall(-2.0, -2.0, 2.0, x, y),
    ];
    let balls = vec![
        Sphere { center: Vec3::new(-0.9, -1.2, -0.6), radius: 0.8 },
        Sphere { center: Vec3::new(0.9, -1.2, 0.4), radius: 0.8 },
    ];
    vec![Geometry::Quads(walls), Geometry::Spheres(balls)]
}
