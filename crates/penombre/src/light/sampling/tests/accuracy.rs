//! The maps against closed forms in double precision, from the tiny to the huge and the grazing.

use super::super::{rectangle::Rectangle, triangle::TriangleMap};
use super::*;

/// Errors of a map: of its solid angle, relative, and of the share of it that `u.x` cuts off, absolute.
#[derive(Debug)]
struct Errors {
    solid_angle: f64,
    share: f64,
}

fn grid() -> impl Iterator<Item = DVec2> {
    let (columns, rows) = (32, 7);
    (0..columns * rows).map(move |i| {
        DVec2::new(f64::from(i % columns) + 0.5, f64::from(i / columns) + 0.5)
            / DVec2::new(f64::from(columns), f64::from(rows))
    })
}

fn of_rectangle(corner: DVec3, sides: [DVec3; 2]) -> Option<Errors> {
    let map = Rectangle::new(corner, sides.map(DVec3::length))?;
    let whole = quad_angle(corner, sides);
    let left_of = |x: f64| quad_angle(corner, [DVec3::X * (x - corner.x), sides[1]]);
    let share = grid().map(|u| (left_of(map.point(u).x) / whole - u.x).abs());
    Some(Errors { solid_angle: (map.solid_angle / whole - 1.0).abs(), share: share.fold(0.0, f64::max) })
}

fn of_triangle(corners: [DVec3; 3]) -> Errors {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let map = TriangleMap::new(corners, a.dot(normal).abs());
    let whole = triangle_angle(corners);
    let share = grid().map(|u| {
        // Through the point from B on to the side AC.
        let direction = map.direction(u);
        let through = direction * (a.dot(normal) / direction.dot(normal)) - b;
        let along = c - a;
        let cut = a + along * ((b - a).cross(through).dot(normal) / along.cross(through).dot(normal));
        (triangle_angle([a, b, cut]) / whole - u.x).abs()
    });
    Errors { solid_angle: (map.solid_angle / whole - 1.0).abs(), share: share.fold(0.0, f64::max) }
}

fn judge(name: &str, size: f64, errors: &Errors) {
    // A few roundings of f32: of the angle, of its sine and cosine.
    let good = errors.solid_angle < 1.2e-7 && errors.share < 2.5e-7;
    assert!(good, "{name} at {size:e}: {errors:?}");
}

#[test]
fn maps_of_rectangles_are_as_accurate_as_f32() {
    let sides = [DVec3::X, DVec3::Y * 0.7];
    for k in 0..10 {
        let large = 10f64.powi(k);
        let good = |name, corner: DVec3, sides: [DVec3; 2]| {
            judge(name, large, &of_rectangle(corner, sides).expect("not grazing"));
        };
        good("ahead", DVec3::new(-0.3, -0.2, large), sides);
        good("over it", DVec3::new(-0.5, -0.3, 1.0 / large), sides);
        good("wide", DVec3::new(1.0, 1.0, 1.0), sides.map(|s| s * large));
        good("wide over it", DVec3::new(-0.4 * large, -0.3 * large, 1.0), sides.map(|s| s * large));
        if k <= 4 {
            // Rectangles smaller than 1/64 of the distance are sampled by area.
            good("away", DVec3::new(0.3, 0.2, 0.8) * large, sides);
            good("beside", DVec3::new(1.0, 0.5, 1.0 / large), sides);
            good("beside one side", DVec3::new(-0.5, 1.0, 1.0 / large), sides);
        } else {
            assert!(of_rectangle(DVec3::new(1.0, 0.5, 0.9 / large), sides).is_none(), "grazing");
        }
        if k <= 7 {
            good("narrow", DVec3::ONE, [DVec3::X / large, DVec3::Y]);
            good("low", DVec3::ONE, [DVec3::X, DVec3::Y / large]);
        }
    }
}

#[test]
fn maps_of_triangles_are_as_accurate_as_f32() {
    let spread = |corner: DVec3, size: f64| {
        [corner, corner + DVec3::new(1.0, 0.1, 0.0) * size, corner + DVec3::new(0.3, 0.8, 0.0) * size]
    };
    for k in 0..10 {
        let large = 10f64.powi(k);
        let good = |name, corners| judge(name, large, &of_triangle(corners));
        good("ahead", spread(DVec3::new(-0.3, -0.2, large), 1.0));
        good("away", spread(DVec3::new(0.3, 0.2, 0.8) * large.min(1e8), 1.0));
        good("over it", spread(DVec3::new(-0.4, -0.3, 1.0 / large), 1.0));
        good("beside", spread(DVec3::new(1.0, 1.0, 1.0 / large), 1.0));
        good("wide", spread(DVec3::ONE, large));
        good("wide over it", spread(DVec3::new(-0.4 * large, -0.3 * large, 1.0), large));
    }
}

/// For samples of all kinds, the mean of 1/pdf is the solid angle: within 4 standard deviations, or of the
/// rounding where the density is even.
#[test]
fn densities_have_the_inverse_of_the_solid_angle_in_the_mean() {
    let mut rng = Pcg32::new(4);
    for k in -6..=6 {
        for (from, height) in [(-0.3, 1.0), (2.0, 1.0), (2.0, 1e-3), (-0.3, 1e-4), (30.0, 10.0), (5e3, 2e3)] {
            let scale = 10f32.powi(k);
            let origin = Vec3::new(from, 0.4, height) * scale;
            for b in [Vec3::Y, Vec3::new(0.4, 1.0, 0.0)] {
                let sides = [Vec3::X * scale, b * scale];
                let quad = SphericalQuad::new(Vec3::ZERO, origin, sides).unwrap();
                let expected = quad_angle(origin.as_dvec3(), sides.map(|s| s.as_dvec3()));
                assert!((f64::from(quad.solid_angle()) / expected - 1.0).abs() < 1e-3);
                mean_matches(&quad, expected, &mut rng);
                let corners = [origin, origin + sides[0], origin + sides[1]];
                let triangle = SphericalTriangle::new(Vec3::ZERO, corners).unwrap();
                let expected = triangle_angle(corners.map(|c| c.as_dvec3()));
                mean_matches(&triangle, expected, &mut rng);
            }
        }
    }
}

fn mean_matches(sampler: &dyn DirectionSampler, expected: f64, rng: &mut Pcg32) {
    let mut moments = penombre_lab::Moments::default();
    (0..2000).for_each(|_| moments.push(1.0 / f64::from(sampler.sample(uniform(rng)).pdf)));
    let tolerance = 4.0 * moments.variance_of_mean().sqrt() + 4e-7 * expected;
    assert!((moments.mean() - expected).abs() <= tolerance, "{moments:?}, not {expected:e}");
}
