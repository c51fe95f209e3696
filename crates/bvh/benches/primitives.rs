//! Rays per second on one thread where there are no triangles: the course's box of parallelograms and spheres.
//! `cargo bench -p penombre-bvh --bench primitives`. Triangles have a bench of their own, `kernels`.
//!
//! Primary rays come from a camera in pixel order; shadow rays go from what they hit to random points of a
//! small light. Figures are the best of several passes over the same rays.
#![allow(clippy::print_stdout, reason = "a bench talks to a person")]

use penombre_bvh::{BuildError, BuildOptions, Bvh, Geometry, Hit, Quad, Ray, Sphere};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::hint::black_box;
use std::time::Instant;

#[path = "../src/tests/cornell.rs"]
mod cornell;

const SIDE: usize = 256;
const PASSES: usize = 40;
const EYE: Vec3 = Vec3::new(0.0, 0.0, 1.9);
const LIGHT: Vec3 = Vec3::new(0.0, 1.5, 0.0);

fn main() -> Result<(), BuildError> {
    let bvh = Bvh::build(cornell::cornell(), &BuildOptions::default())?;
    let primary = camera();
    let mut hits = vec![Hit::MISS; primary.len()];
    let closest = best_of(|| bvh.closest_batch(black_box(&primary), &mut hits));
    let shadow = shadow(&primary, &hits);
    let mut blocked = vec![false; shadow.len()];
    let any = best_of(|| bvh.occluded_batch(black_box(&shadow), &mut blocked));
    let share = blocked.iter().filter(|&&b| b).count() as f64 / blocked.len().max(1) as f64;
    println!("cornell box, 8 primitives: {:?}", bvh.stats());
    println!("  primary {}", speed(closest, primary.len()));
    println!("  shadow  {}  ({:.0} % blocked)", speed(any, shadow.len()), 100.0 * share);
    Ok(())
}

fn camera() -> Vec<Ray> {
    let at = |i: usize| (i as f32 + 0.5) / SIDE as f32 - 0.5;
    let pixels = (0..SIDE * SIDE).map(|i| Vec3::new(at(i % SIDE), -at(i / SIDE), -1.0));
    pixels.map(|dir| Ray::new(EYE, dir, 0.0, f32::INFINITY)).collect()
}

fn shadow(primary: &[Ray], hits: &[Hit]) -> Vec<Ray> {
    let mut rng = Pcg32::new(7);
    let mut offset = || (rng.next_f32() * 2.0 - 1.0) * 0.3;
    let hit = primary.iter().zip(hits).filter(|(_, hit)| hit.is_hit());
    let ray = |(ray, hit): (&Ray, &Hit)| {
        let from = ray.at(hit.t);
        let target = LIGHT + Vec3::new(offset(), offset(), offset());
        Ray::new(from, target - from, 1e-4, 0.9999)
    };
    hit.map(ray).collect()
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
