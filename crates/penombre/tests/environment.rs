//! An environment whose image comes from a file.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre::Scene;
use penombre_math::{Vec2, Vec3};
use penombre_scene::load::{LoadOptions, load};

#[test]
fn the_image_of_a_file_stands_as_turned() {
    let mut loaded = load("tests/data/sky.toml", &LoadOptions::default());
    let (description, assets) = (&loaded.description, &loaded.assets);
    let scene = Scene::build(description, assets, (1.0, true), &mut loaded.diagnostics).unwrap();
    assert_eq!(loaded.diagnostics.iter().count(), 0, "{:?}", loaded.diagnostics);
    // The white pixel is right of the middle, above the horizon: a turn of 90° takes (⅛π, ⅛π up) from −z to −x.
    let up = 22.5f64.to_radians();
    let white = Vec3::new(-(up.cos() * up.cos()) as f32, up.sin() as f32, -(up.cos() * up.sin()) as f32);
    let seen = scene.escaped(white).next().unwrap();
    assert!((seen.radiance.to_rgb()[0] - 2.0).abs() < 1e-3, "{seen:?}");
    assert!(seen.pdf > 0.1);
    let opposite = scene.escaped(-white).next().unwrap();
    assert_eq!(opposite.pdf, 0.0, "what lies below the mean is not sampled");
    assert!(opposite.radiance.to_rgb()[0] > 0.0);
    let sample = scene.sample_light(Vec3::ZERO, 0.5, Vec2::splat(0.5)).unwrap();
    assert!(sample.wi.dot(white) > 0.9 && sample.distance == f32::INFINITY, "{sample:?}");
    let again = scene.escaped(sample.wi).next().unwrap();
    assert!((again.pdf - sample.pdf).abs() < 1e-4 * sample.pdf);
}
