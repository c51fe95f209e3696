//! Rays per second on one thread: `cargo bench -p penombre-bvh`.
//!
//! Primary rays come from a camera in pixel order; shadow rays go from what they hit to random points of a
//! small light. Figures are the best of several passes over the same rays.
#![allow(clippy::print_stdout)]

use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Quad, Ray, Sphere, Triangles};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::hint::black_box;
use std::time::Instant;

#[path = "../src/tests/meshes.rs"]
mod meshes;

const SIDE: usize = 256;
const PASSES: usize = 40;

struct View {
    name: &'static str,
    geometries: Vec<Geometry>,
    eye: Vec3,
    light: Vec3,
}

fn main() {
    let bumpy = meshes::icosphere(8);
    let mut rng = Pcg32::new(1);
    let waves: Vec<Vec3> = (0..8).map(|_| meshes::direction(&mut rng)).collect();
    let bumpy = bumpy.map(|p| {
        let wobble: f32 = waves.iter().map(|w| (w.dot(p) * 5.0).fract().abs()).sum();
        p * (1.0 + 0.02 * wobble)
    });
    let outside = Vec3::new(0.0, 0.3, 3.0);
    let light = Vec3::new(1.5, 3.0, 2.0);
    let views = [
        View {
            name: "cornell box (8 primitives)",
            geometries: meshes::cornell(),
            eye: Vec3::new(0.0, 0.0, 1.9),
            light: Vec3::new(0.0, 1.5, 0.0),
        },
        View {
            name: "icosphere (82k triangles)",
            geometries: vec![meshes::icosphere(6).geometry()],
            eye: outside,
            light,
        },
        View { name: "displaced sphere (1.3M)", geometries: vec![bumpy.geometry()], eye: outside, light },
    ];
    println!("{:28} {:>9} {:>26} {:>26}", "", "build", "primary", "shadow");
    for view in views {
        run(view);
    }
}

fn run(view: View) {
    let start = Instant::now();
    let Ok(bvh) = Bvh::build(view.geometries, &BuildOptions::default()) else { return };
    let build = start.elapsed().as_secs_f64();
    let primary = camera(view.eye);
    let mut hits = vec![Hit::MISS; primary.len()];
    let closest = best_of(|| bvh.closest_batch(black_box(&primary), &mut hits));
    let mut rng = Pcg32::new(7);
    let mut shadow = Vec::new();
    for (ray, hit) in primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let target = view.light + meshes::in_cube(&mut rng) * 0.3;
        let from = ray.at(hit.t);
        shadow.push(Ray::new(from, target - from, 1e-4, 0.9999));
    }
    let mut blocked = vec![false; shadow.len()];
    let any = best_of(|| bvh.occluded_batch(black_box(&shadow), &mut blocked));
    let share = blocked.iter().filter(|&&b| b).count() as f64 / blocked.len().max(1) as f64;
    println!(
        "{:28} {:7.2} s {} {}  ({:.0} % blocked)",
        view.name,
        build,
        speed(closest, primary.len()),
        speed(any, shadow.len()),
        100.0 * share
    );
    println!("    {:?}", bvh.stats());
}

fn camera(eye: Vec3) -> Vec<Ray> {
    let mut rays = Vec::new();
    for y in 0..SIDE {
        for x in 0..SIDE {
            let at = |i: usize| (i as f32 + 0.5) / SIDE as f32 - 0.5;
            let dir = Vec3::new(at(x), -at(y), -1.0);
            rays.push(Ray::new(eye, dir, 0.0, f32::INFINITY));
        }
    }
    rays
}

fn best_of(mut pass: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..PASSES {
        let start = Instant::now();
        pass();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

fn speed(seconds: f64, rays: usize) -> String {
    let per_ray = seconds / rays.max(1) as f64;
    format!("{:8.2} Mrays/s {:6.1} ns", 1e-6 / per_ray, 1e9 * per_ray)
}
