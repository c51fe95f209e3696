//! How long a sample takes, told and not judged: `cargo test -p penombre --release --lib -- --nocapture speed_of_samples`.

use super::*;
use crate::testing::builtin;

/// Half an edge of the box of the points from which lights are seen, metres.
const HALF: f32 = 1.8;
const ROUNDS: usize = 50;

/// Nanoseconds per call for random points of a box, the best of several rounds.
fn time(name: &str, mut call: impl FnMut(Vec3, f32, Vec2) -> f32) {
    let mut rng = Pcg32::new(1);
    let mut next = || rng.next_f32();
    let inputs: Vec<(Vec3, f32, Vec2)> = (0..4096)
        .map(|_| {
            let p = Vec3::new(next(), next(), next()) * (2.0 * HALF) - Vec3::splat(HALF);
            (p, next(), Vec2::new(next(), next()))
        })
        .collect();
    let round = |call: &mut dyn FnMut(Vec3, f32, Vec2) -> f32| {
        let begin = std::time::Instant::now();
        let sum: f32 = inputs.iter().map(|(p, choice, u)| call(*p, *choice, *u)).sum();
        std::hint::black_box(sum);
        begin.elapsed().as_secs_f64() * 1e9 / inputs.len() as f64
    };
    let best = (0..ROUNDS).map(|_| round(&mut call)).fold(f64::INFINITY, f64::min);
    eprintln!("{name}: {best:.1} ns");
}

#[test]
fn speed_of_samples() {
    let at = |name: &str, scene: &Scene| {
        time(name, |p, choice, u| scene.sample_light(p, choice, u).map_or(0.0, |s| s.pdf + s.wi.x));
        let hit = seen(scene, Vec3::new(0.1, 0.0, 0.2), Vec3::Y);
        hit.iter().for_each(|at| {
            time(&format!("{name}, density"), |p, _, _| scene.light_pdf(at, p, Vec3::Y, 1.0));
        });
    };
    let mut out = Diagnostics::default();
    let cornell = Scene::build(&builtin("cornell"), &Assets::default(), (1.0, true), &mut out).unwrap();
    at("quad of the box", &cornell);
    let disk = || light("disk", "a").with("center", [0.0, 1.9, 0.0]).with("normal", [0.0, -1.0, 0.0]);
    let ball = || light("sphere", "b").with("center", [0.0, 5.9, 0.0]).with("radius", 0.5);
    at("disk", &scene([disk()]));
    at("sphere", &scene([ball()]));
    at("one of two", &scene([disk(), ball()]));
    let mesh = shape("mesh", "a", "glow")
        .with("positions", [[0.0, 1.9, 0.0], [1.0, 1.9, 0.0], [1.0, 1.9, 1.0], [0.0, 1.9, 1.0]])
        .with("faces", vec![[0i64, 1, 2], [0, 2, 3]]);
    at("mesh", &scene([glow("glow", [1.0; 3], false), mesh]));
    let quad = shape("quad", "a", "checks").with("origin", [0.0, 1.9, 0.0]);
    let quad = quad.with("sides", [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    at("quad with a texture", &scene(checks().into_iter().chain([quad])));
}
