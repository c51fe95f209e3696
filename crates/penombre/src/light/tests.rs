//! Lights in the `classic` integrator, and the environment's place in the world.

use super::environment::EnvironmentLight;
use super::sampling::EnvironmentSampling;
use super::*;
use crate::Plan;
use crate::render::record;
use crate::testing::{plan, set, small};
use penombre_image::Image;
use penombre_lab::{DensityCheck, Moments, Pcg32};
use penombre_math::DMat3;
use penombre_scene::{Node, Role, SceneDescription};
use std::f64::consts::PI;
use std::sync::Arc;

/// A floor at y = 0 seen from above, lit by one light.
fn floor(light: Node) -> SceneDescription {
    let mut d = SceneDescription::default();
    d.add(Node::new(Role::Render, "render", "").with("size", [1i64, 1]).with("spp", 1i64));
    set(&mut d, Role::Render, "", "pixel_jitter", false);
    set(&mut d, Role::Render, "", "integrator", "classic");
    d.add(Node::new(Role::Integrator, "classic", "classic").with("phase", 2i64));
    d.add(Node::new(Role::Camera, "perspective", "main").with("position", [0.0, 2.0, 2.0]));
    d.add(Node::new(Role::Material, "phong", "white").with("diffuse", [1.0; 3]).with("specular", [0.0; 3]));
    let floor = Node::new(Role::Shape, "quad", "floor").with("material", "white");
    d.add(floor.with("origin", [-9.0, 0.0, -9.0]).with("sides", [[0.0, 0.0, 18.0], [18.0, 0.0, 0.0]]));
    d.add(light);
    d
}

fn seen(plan: &Plan) -> f32 {
    record(&plan.scene, &*plan.integrator, &plan.job, [0, 0], 0).radiance.to_rgb()[0]
}

fn classic(light: Node) -> f32 {
    seen(&plan(&floor(light)))
}

#[test]
fn every_light_does_its_part_in_classic() {
    let light = |kind: &str| Node::new(Role::Light, kind, "lamp").with("color", [0.5; 3]);
    let spot = || light("spot").with("position", [0.0, 3.0, 4.0]);
    let near = |found: f32, expected: f32| assert!((found - expected).abs() < 2e-3, "{found} {expected}");
    near(classic(spot().with("target", [0.0; 3])), 0.5 * 0.6);
    assert_eq!(classic(spot().with("target", [9.0, 0.0, 4.0])), 0.0);
    near(classic(light("distant").with("direction", [0.0, -3.0, 4.0])), 0.5 * 0.6);
    assert_eq!(classic(light("distant").with("direction", [0.0, 3.0, 4.0])), 0.0);
    let disk = light("disk").with("center", [0.0, 3.0, 4.0]).with("normal", [0.0, 1.0, 0.0]);
    near(classic(disk.with("radius", 0.2).with("shadow_samples", 4i64)), 0.5 * 0.6);
    near(classic(light("sphere").with("center", [0.0, 3.0, 4.0]).with("radius", 0.2)), 0.5 * 0.6);
    assert_eq!(classic(Node::new(Role::Light, "environment", "sky")), 0.0);
}

/// Shadow rays against parallel light leave no gap and meet no neighbour.
#[test]
fn parallel_light_casts_hard_shadows_in_classic() {
    let sun =
        || Node::new(Role::Light, "sun", "sun").with("direction", [-1.0, -1.0, 0.5]).with("color", [1.0; 3]);
    for (x, y, z) in [(1.0, 1.0, -0.5), (1000.0, 1000.0, -500.0), (1e5, 1e5, -5e4)] {
        for (aside, hidden) in [(0.0, true), (0.2, false)] {
            let mut d = floor(sun());
            let ball = Node::new(Role::Shape, "sphere", "ball").with("radius", 0.1);
            d.add(ball.with("center", [x, y, z + aside]));
            let dark = seen(&plan(&d)) == 0.0;
            assert_eq!(dark, hidden, "{x} {aside}");
        }
    }
}

/// Points of round lights are even over their area.
#[test]
fn points_of_round_lights_are_even() {
    let d = small("cornell", 8, 1);
    let assets = penombre_scene::Assets::default();
    let mut out = penombre_scene::Diagnostics::default();
    let mut context =
        Context { description: &d, assets: &assets, out: &mut out, node: penombre_scene::NodeId(0) };
    let disk =
        Node::new(Role::Light, "disk", "a").with("center", [1.0, 2.0, 3.0]).with("normal", [1.0, 1.0, 0.0]);
    let disk = AnyLight::build(&disk.with("radius", 2.0), &mut context).unwrap();
    let ball = Node::new(Role::Light, "sphere", "b").with("center", [1.0, 2.0, 3.0]).with("radius", 2.0);
    let ball = AnyLight::build(&ball, &mut context).unwrap();
    let center = Vec3::new(1.0, 2.0, 3.0);
    let (mut rng, mut squares, mut heights) = (Pcg32::new(1), Moments::default(), Moments::default());
    for _ in 0..20_000 {
        let u = Vec2::new(rng.next_f32(), rng.next_f32());
        let p = disk.sample_point(u) - center;
        assert!(p.dot(Vec3::new(1.0, 1.0, 0.0)).abs() < 1e-5);
        squares.push(f64::from(p.length_squared()));
        let p = ball.sample_point(u) - center;
        assert!((p.length() - 2.0).abs() < 1e-5);
        heights.push(f64::from(p.z * p.z));
    }
    // r² is uniform in 0..4, z uniform in −2..2.
    for (found, expected) in [(squares, 2.0), (heights, 4.0 / 3.0)] {
        assert!(
            (found.mean() - expected).abs() < 4.0 * found.variance_of_mean().sqrt(),
            "{found:?} {expected}"
        );
    }
}

/// A sun of a few pixels right of the middle of a dim sky.
fn sky() -> Arc<Image> {
    let mut image = Image::new(16, 8, 3);
    for (i, rgb) in image.data_mut().chunks_exact_mut(3).enumerate() {
        let (x, y) = (i % 16, i / 16);
        let v = if x == 11 && y == 3 { 50.0 } else { 0.1 + 0.05 * y as f32 };
        rgb.copy_from_slice(&[v, 0.5 * v, 0.25 * v]);
    }
    Arc::new(image)
}

fn environment(image: Arc<Image>, to_world: DMat3) -> EnvironmentLight {
    EnvironmentLight::of_image(image, Spectrum::rgb(2.0, 1.0, 1.0), to_world).unwrap()
}

#[test]
fn turned_environments_agree_with_their_samples() {
    let (sin, cos) = 0.7f64.sin_cos();
    let about_x = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, cos, sin, 0.0, -sin, cos]);
    let mirror = DMat3::from_diagonal(penombre_math::DVec3::new(-1.0, 1.0, 1.0));
    for turn in [DMat3::IDENTITY, about_x, about_x * mirror] {
        let light = environment(sky(), turn);
        let settings = DensityCheck { seed: 3, samples: 100_000, ..DensityCheck::default() };
        let report = settings.run(
            |rng| {
                let u = Vec2::new(rng.next_f32(), rng.next_f32());
                let s = light.sample_towards(Vec3::ZERO, u).unwrap();
                let e = light.escaped(s.wi).unwrap();
                let grain = 2e-5 * e.radiance.max_component() + 1e-3 * s.radiance.max_component();
                assert!((e.radiance - s.radiance).to_rgb().iter().all(|d| d.abs() <= grain), "{s:?} {e:?}");
                Some(s.wi.to_array())
            },
            |wi| light.escaped(Vec3::from(wi)).unwrap().pdf,
        );
        assert!(report.passes(penombre_lab::sidak(0.01, 3)), "{report}");
    }
}

/// Samples of the light and uniform directions together, weighted by the balance heuristic, give the mean; the mean of a
/// white furnace needs the light's samples alone.
#[test]
fn samples_of_environments_give_their_integral() {
    let uniform = 1.0 / (4.0 * PI);
    let light = environment(sky(), DMat3::IDENTITY);
    let mut rng = Pcg32::new(2);
    let (mut found, mut expected) = (Moments::default(), Moments::default());
    for _ in 0..100_000 {
        let s = light.sample_towards(Vec3::ZERO, Vec2::new(rng.next_f32(), rng.next_f32())).unwrap();
        let z = 1.0 - 2.0 * rng.next_f64();
        let (sin, cos) = (2.0 * PI * rng.next_f64()).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let e = light.escaped(Vec3::new((across * cos) as f32, z as f32, (across * sin) as f32)).unwrap();
        let radiance = |s: Spectrum| f64::from(s.to_rgb()[0]);
        found.push(
            radiance(s.radiance) / (f64::from(s.pdf) + uniform)
                + radiance(e.radiance) / (f64::from(e.pdf) + uniform),
        );
        expected.push(radiance(e.radiance) / uniform);
    }
    let deviation = (found.variance_of_mean() + expected.variance_of_mean()).sqrt();
    let off = (found.mean() - expected.mean()).abs();
    assert!(off < 4.0 * deviation, "{found:?} {expected:?}");
    assert!(found.variance() < 0.05 * expected.variance(), "{found:?} {expected:?}");
    let mut white = Image::new(4, 2, 3);
    white.data_mut().fill(3.0);
    let furnace = environment(Arc::new(white), DMat3::IDENTITY);
    for _ in 0..1000 {
        let s = furnace.sample_towards(Vec3::ZERO, Vec2::new(rng.next_f32(), rng.next_f32())).unwrap();
        let estimate = f64::from(s.radiance.to_rgb()[1] / s.pdf);
        assert!((estimate - 12.0 * PI).abs() < 1e-4, "{estimate}");
    }
    assert_eq!(EnvironmentSampling::default(), EnvironmentSampling::Compensated);
}

/// By `rotate`, the middle of the image goes from −z to −x, counter-clockwise from above.
#[test]
fn rotation_is_counter_clockwise_from_above() {
    let dark = Node::new(Role::Light, "envmap", "sky");
    assert_eq!(classic(dark.with("rotate", 90.0)), 0.0);
    let turn = environment::turn(90.0);
    assert!((turn * penombre_math::DVec3::NEG_Z - penombre_math::DVec3::NEG_X).length() < 1e-12);
}
