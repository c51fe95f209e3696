//! Irradiance of lights with radiance 1 in closed form.

use super::*;
use penombre_lab::Moments;
use penombre_math::Spectrum;
use std::f64::consts::PI;

/// Irradiance, by sampling, of a surface at the reference point with that normal.
fn irradiance(sampler: &dyn DirectionSampler, normal: Vec3, seed: u64) -> Moments {
    let mut rng = Pcg32::new(seed);
    let one = |_| {
        let s = sampler.sample(uniform(&mut rng));
        f64::from(s.wi.dot(normal).max(0.0)) / f64::from(s.pdf)
    };
    (0..samples()).map(one).collect()
}

fn agrees(name: &str, found: &Moments, expected: f64) {
    let deviation = found.variance_of_mean().sqrt();
    eprintln!("{name}: {:.6} ± {deviation:.6}, expected {expected:.6}", found.mean());
    assert!(
        (found.mean() - expected).abs() <= 4.0 * deviation + 1e-6 * expected,
        "{name}: {found:?}, {expected}"
    );
}

/// Irradiance of a surface under the corner of a parallel rectangle of a × b at distance h: π times the form
/// factor of the textbooks \[Howell2010\].
fn under_a_corner(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    0.5 * (x / p * (y / p).atan() + y / q * (x / q).atan())
}

/// Lambert's formula: the irradiance of a polygon that lies above the horizon, by its edges.
fn of_polygon(corners: &[DVec3], normal: DVec3) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let across = a.cross(b);
        across.length().atan2(a.dot(b)) * across.normalize().dot(normal)
    };
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn a_rectangle_above_gives_the_irradiance_of_the_form_factor() {
    for (i, h) in [1e-3f32, 0.1, 1.0, 5.0, 100.0, 3000.0].into_iter().enumerate() {
        // Over the middle, four corners; beside it, a large corner less a small one.
        let quad = |x, y| {
            SphericalQuad::new(Vec3::ZERO, Vec3::new(x, y, h), [Vec3::X * 2.0, Vec3::Y * 3.0]).unwrap()
        };
        let height = f64::from(h);
        let over = irradiance(&quad(-1.0, -1.5), Vec3::Z, i as u64);
        agrees("over the middle", &over, 4.0 * under_a_corner(1.0, 1.5, height));
        let beside = irradiance(&quad(1.0, 0.0), Vec3::Z, 100 + i as u64);
        agrees("beside", &beside, under_a_corner(3.0, 3.0, height) - under_a_corner(1.0, 3.0, height));
    }
}

#[test]
fn polygons_give_the_irradiance_of_lamberts_formula() {
    let normal = Vec3::new(0.2, -0.1, 1.0).normalize();
    for (i, size) in [0.02f32, 0.3, 2.0].into_iter().enumerate() {
        let origin = Vec3::new(0.1, -0.2, 1.0);
        let (a, b) = (Vec3::new(size, 0.2 * size, 0.1 * size), Vec3::new(-0.3 * size, size, 0.0));
        let quad = SphericalQuad::new(Vec3::ZERO, origin, [a, b]).unwrap();
        let corners = [origin, origin + a, origin + a + b, origin + b].map(|c| c.as_dvec3());
        agrees("quad", &irradiance(&quad, normal, i as u64), of_polygon(&corners, normal.as_dvec3()));
        let corners = [origin, origin + a, origin + b];
        let triangle = SphericalTriangle::new(Vec3::ZERO, corners).unwrap();
        let expected = of_polygon(&corners.map(|c| c.as_dvec3()), normal.as_dvec3());
        agrees("triangle", &irradiance(&triangle, normal, 10 + i as u64), expected);
    }
}

#[test]
fn disks_and_spheres_give_the_irradiance_of_the_form_factor() {
    for (i, (h, beside)) in [(1.0f32, 0.0f32), (0.01, 0.5), (1.0, 3.0), (200.0, 50.0)].into_iter().enumerate()
    {
        let center = Vec3::new(beside, 0.0, h);
        let disk = SphericalDisk::new(Vec3::ZERO, center, -Vec3::Z, 1.5).unwrap();
        // A parallel disk from beside its axis \[Howell2010\].
        let (h, d, r) = (f64::from(h), f64::from(beside), 1.5f64);
        let sum = h * h + d * d + r * r;
        let expected = PI / 2.0 * (1.0 - (sum - 2.0 * r * r) / (sum * sum - 4.0 * r * r * d * d).sqrt());
        agrees("disk", &irradiance(&disk, Vec3::Z, i as u64), expected);
        // A sphere above the horizon: π·(r/d)²·cos.
        let radius = 0.9 * h;
        let sphere = SphericalCap::new(Vec3::ZERO, center, radius as f32).unwrap();
        let square = h * h + d * d;
        let expected = PI * radius * radius / square * (h / square.sqrt());
        agrees("sphere", &irradiance(&sphere, Vec3::Z, 10 + i as u64), expected);
    }
}

#[test]
fn a_constant_environment_gives_pi() {
    let environment = Environment::constant(Spectrum::WHITE);
    let mut rng = Pcg32::new(1);
    let one = |_| {
        let s = environment.sample(uniform(&mut rng));
        f64::from(s.wi.z.max(0.0) * s.radiance[1] / s.pdf)
    };
    let found: Moments = (0..samples()).map(one).collect();
    agrees("environment", &found, PI);
}
