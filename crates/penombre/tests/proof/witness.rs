//! Caustics of point lights against rays that are traced the other way: from the light, evenly, in double precision.

use super::common::{Subject, by_size};
use penombre_math::DVec3;
use std::f64::consts::{PI, TAU};

const LIGHT: DVec3 = DVec3::new(-0.8, 2.0, 0.4);
const CENTER: DVec3 = DVec3::new(0.0, 0.8, 0.0);
const RADIUS: f64 = 0.5;
const INTENSITY: f64 = 5.0;
const ALBEDO: f64 = 0.6;
/// What is seen of the floor: the middle of a square, and its size.
const MIDDLE: [f64; 2] = [0.6, -0.3];
const SIZE: f64 = 1.6;
/// Blocks with a larger relative standard error are not compared.
const STEADY: f64 = 0.02;
/// By how much the grid of rays may be off: the ball's shadow has a sharp edge.
const GRID: f64 = 3e-3;
/// Blocks along an edge.
const BLOCKS: usize = 4;

/// The ball reflects nothing, and paths end at the light behind it: what is left are direct light and light straight through.
fn scene(ior: f64, lamp: &str) -> Subject {
    let [x, z] = MIDDLE;
    Subject::new(&format!(
        "[render]\nintegrator = \"path\"\nsize = [32, 32]\nmax_depth = 4\n\
         [camera.main]\ntype = \"orthographic\"\nposition = [{x}, 0.2, {z}]\ntarget = [{x}, 0, {z}]\nup = [0, 0, -1]\nheight = {SIZE}\n\
         [material.floor]\ntype = \"diffuse\"\ncolor = [{ALBEDO}, {ALBEDO}, {ALBEDO}]\n\
         [shape.floor]\ntype = \"quad\"\norigin = [-3, 0, 3]\nsides = [[6, 0, 0], [0, 0, -6]]\nmaterial = \"floor\"\n\
         [material.ball]\ntype = \"glass\"\nior = {ior:?}\nreflect = [0, 0, 0]\n\
         [shape.ball]\ntype = \"sphere\"\ncenter = [0, 0.8, 0]\nradius = 0.5\nmaterial = \"ball\"\n{lamp}"
    ))
}

fn point() -> String {
    format!(
        "[light.lamp]\ntype = \"point\"\nposition = [-0.8, 2, 0.4]\nintensity = [{INTENSITY}, {INTENSITY}, {INTENSITY}]\n"
    )
}

/// A ball in the point's place, of the same intensity.
fn tiny(radius: f64) -> String {
    let l = INTENSITY / (PI * radius * radius);
    format!(
        "[light.lamp]\ntype = \"sphere\"\ncenter = [-0.8, 2, 0.4]\nradius = {radius}\nradiance = [{l}, {l}, {l}]\n"
    )
}

/// Refraction at a boundary whose unit normal `n` faces the ray; `eta` is the index behind over that before. The direction
/// behind and the share that passes, of unpolarised light \[PBRT4\].
fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<(DVec3, f64)> {
    let cos = -d.dot(n);
    let square = 1.0 - (1.0 - cos * cos) / (eta * eta);
    let cos_t = (square > 0.0).then(|| square.sqrt())?;
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let across = (cos - eta * cos_t) / (cos + eta * cos_t);
    Some((d / eta + n * (cos / eta - cos_t), 1.0 - 0.5 * (parallel * parallel + across * across)))
}

/// A ray from the light through the ball: where it leaves, in which direction, and the share that passes both boundaries.
fn pass(d: DVec3, ior: f64) -> Option<(DVec3, DVec3, f64)> {
    let to = LIGHT - CENTER;
    let b = to.dot(d);
    let square = b * b - to.length_squared() + RADIUS * RADIUS;
    let n = (square > 0.0).then(|| (to - d * (b + square.sqrt())) / RADIUS)?;
    let (inside, first) = refract(d, n, ior)?;
    let m = n - inside * (2.0 * n.dot(inside));
    let (out, second) = refract(inside, -m, 1.0 / ior)?;
    Some((CENTER + m * RADIUS, out, first * second))
}

/// The block of a point of the floor.
fn block(x: f64, z: f64) -> Option<usize> {
    let cell = |at: f64| {
        let share = at / SIZE + 0.5;
        (0.0..1.0).contains(&share).then_some((share * BLOCKS as f64) as usize)
    };
    Some(cell(z - MIDDLE[1])? * BLOCKS + cell(x - MIDDLE[0])?)
}

/// Mean radiance of the floor in each block.
fn traced(ior: f64) -> [f64; BLOCKS * BLOCKS] {
    let mut flux = [0.0; BLOCKS * BLOCKS];
    let n = 2000;
    // Through the ball, evenly over the cone that it fills.
    let axis = (CENTER - LIGHT).normalize();
    let (a, b) = axis.any_orthonormal_pair();
    let sine = RADIUS / CENTER.distance(LIGHT);
    let cap = 1.0 - (1.0 - sine * sine).sqrt();
    for i in 0..n * n {
        let less = cap * ((i % n) as f64 + 0.5) / n as f64;
        let (s, c) = (TAU * ((i / n) as f64 + 0.5) / n as f64).sin_cos();
        let across = (less * (2.0 - less)).sqrt();
        let d = a * (across * c) + b * (across * s) + axis * (1.0 - less);
        let Some((p, out, share)) = pass(d, ior).filter(|(_, out, _)| out.y < 0.0) else { continue };
        let at = p - out * (p.y / out.y);
        if let Some(block) = block(at.x, at.z) {
            flux[block] += share * INTENSITY * TAU * cap / (n * n) as f64;
        }
    }
    // Past the ball, evenly over the floor.
    let m = 1600;
    let cell = SIZE / m as f64;
    for i in 0..m * m {
        let place = |k: usize, middle: f64| (k as f64 + 0.5) * cell - 0.5 * SIZE + middle;
        let at = DVec3::new(place(i % m, MIDDLE[0]), 0.0, place(i / m, MIDDLE[1]));
        let to = at - LIGHT;
        let d = to.normalize();
        if (CENTER - LIGHT).cross(d).length() > RADIUS {
            flux[block(at.x, at.z).unwrap()] += INTENSITY * -d.y / to.length_squared() * cell * cell;
        }
    }
    let area = (SIZE / BLOCKS as f64).powi(2);
    flux.map(|f| f / area * ALBEDO / PI)
}

/// A point, and tiny balls of the same intensity in its place.
#[test]
fn caustics_of_points_and_tiny_balls_are_those_of_traced_light() {
    let spp = by_size(16, 1024);
    let lamps = [("point", point()), ("1 mm", tiny(0.001)), ("4 mm", tiny(0.004)), ("16 mm", tiny(0.016))];
    let mut wrong = 0;
    for ior in [1.5, 1.33, 0.7] {
        let expected = traced(ior);
        let mean = expected.iter().sum::<f64>() / expected.len() as f64;
        for (name, lamp) in &lamps {
            let found = scene(ior, lamp).with("render", "spp", spp).blocks(8, 8);
            let (mut worst, mut tests) = (0.0f64, 0);
            for (block, expected) in found.list.iter().zip(&expected).filter(|(_, e)| **e > 0.1 * mean) {
                // A focus is bright in few samples, whose scatter tells nothing.
                let error = block[1].variance_of_mean().sqrt() / expected;
                if error > STEADY {
                    continue;
                }
                tests += 1;
                let off = block[1].mean() / expected - 1.0;
                wrong += u32::from(off.abs() > GRID + 5.0 * error);
                worst = if off.abs() > worst.abs() { off } else { worst };
            }
            let whole = found.whole.mean() / mean - 1.0;
            println!(
                "{ior}, {name}: whole {:+.3} ± {:.3} %, worst of {tests} {:+.2} %",
                100.0 * whole,
                100.0 * found.whole.variance_of_mean().sqrt() / mean,
                100.0 * worst
            );
            wrong += u32::from(tests < 3);
        }
    }
    assert_eq!(wrong, 0);
}
