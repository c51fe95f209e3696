//! Emitters against closed forms, densities by χ², and hits against samples.
//!
//! Significance is α = 0.01 over all the tests of a function, by Šidák; means are compared within 4 standard deviations.

mod densities;
mod irradiance;
mod kinds;
mod speed;

use super::NO_EMITTER;
use crate::scene::{Scene, SurfacePoint};
use penombre_bvh::Ray;
use penombre_lab::{Moments, Pcg32};
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::{Assets, Diagnostics, Node, Role, SceneDescription, Value};
use std::f64::consts::PI;
use std::sync::Arc;

/// Builds a scene of these nodes whose lights are surfaces.
fn scene(nodes: impl IntoIterator<Item = Node>) -> Arc<Scene> {
    let mut d = SceneDescription::default();
    nodes.into_iter().for_each(|node| _ = d.add(node));
    let mut out = Diagnostics::default();
    let scene = Scene::build(&d, &Assets::default(), (1.0, true), &mut out);
    assert!(!out.has_errors(), "{out:?}");
    scene.unwrap()
}

fn light(type_name: &str, name: &str) -> Node {
    Node::new(Role::Light, type_name, name)
}

fn shape(type_name: &str, name: &str, material: &str) -> Node {
    Node::new(Role::Shape, type_name, name).with("material", material)
}

/// A material of that radiance.
fn glow(name: &str, radiance: [f64; 3], two_sided: bool) -> Node {
    Node::new(Role::Material, "emissive", name).with("radiance", radiance).with("two_sided", two_sided)
}

/// A material that varies: a chessboard of that radiance and black.
fn checks() -> [Node; 2] {
    let texture = Node::new(Role::Texture, "checker", "checks")
        .with("scale", [3.0, 2.0])
        .with("a", [4.0, 2.0, 1.0])
        .with("b", [0.0; 3]);
    let source = Value::from([("texture", "checks".into())]);
    [texture, Node::new(Role::Material, "emissive", "checks").with("radiance", source)]
}

fn uniform(rng: &mut Pcg32) -> Vec2 {
    Vec2::new(rng.next_f32(), rng.next_f32())
}

/// A unit vector, uniform.
fn any_direction(rng: &mut Pcg32) -> Vec3 {
    let z = 1.0 - 2.0 * rng.next_f64();
    let (s, c) = (std::f64::consts::TAU * rng.next_f64()).sin_cos();
    let across = (1.0 - z * z).sqrt();
    Vec3::new((across * c) as f32, (across * s) as f32, z as f32)
}

fn green(color: Spectrum) -> f64 {
    f64::from(color.to_rgb()[1])
}

/// Irradiance in the green of a surface at `p` with that normal, by samples of the lights, nothing in the way.
fn by_lights(scene: &Scene, p: Vec3, normal: Vec3, count: u32) -> Moments {
    let mut rng = Pcg32::new(7);
    let one = |_| {
        let sample = scene.sample_light(p, rng.next_f32(), uniform(&mut rng));
        sample.map_or(0.0, |s| green(s.radiance) * f64::from(s.wi.dot(normal).max(0.0)) / f64::from(s.pdf))
    };
    (0..count).map(one).collect()
}

/// What a ray meets that shines.
fn seen(scene: &Scene, from: Vec3, dir: Vec3) -> Option<SurfacePoint> {
    let ray = Ray::new(from, dir, 0.0, f32::INFINITY);
    scene.surface(&ray, &scene.closest(&ray))
}

/// The same irradiance by directions uniform over the hemisphere of `axis`, and what they meet.
fn by_rays(scene: &Scene, p: Vec3, normal: Vec3, count: u32) -> Moments {
    let mut rng = Pcg32::new(8);
    let one = |_| {
        let wi = any_direction(&mut rng);
        let cos = f64::from(wi.dot(normal).max(0.0));
        if cos == 0.0 {
            return 0.0;
        }
        let radiance = match seen(scene, p, wi) {
            Some(at) => green(scene.emitted(&at)),
            None => scene.escaped(wi).map(|e| green(e.radiance)).sum(),
        };
        radiance * cos * 4.0 * PI
    };
    (0..count).map(one).collect()
}

fn agrees(name: &str, found: &Moments, expected: f64) {
    let deviation = found.variance_of_mean().sqrt();
    eprintln!("{name}: {:.6} ± {deviation:.6}, expected {expected:.6}", found.mean());
    let tolerance = 4.0 * deviation + 3e-6 * expected;
    assert!((found.mean() - expected).abs() <= tolerance, "{name}: {found:?}, {expected}");
}
