//! Tests of layers of a whole render.

use super::*;
use crate::film::{BACKGROUND_DEPTH, FilmLayer};
use penombre_image::{Layers, Samples};
use penombre_math::Vec3;
use penombre_scene::SceneDescription;

fn all() -> Vec<FilmLayer> {
    FilmLayer::NAMES.iter().filter_map(|name| FilmLayer::from_name(name)).collect()
}

fn layers(description: &SceneDescription, threads: usize, tile: u32, progressive: bool) -> (Layers, Plan) {
    let job = |p: &mut Plan| {
        p.job = Job { features: true, estimate: true, tile, progressive, ..p.job };
    };
    let mut p = plan(description);
    job(&mut p);
    let mut render = Render::new(p);
    render.run(threads, &Quiet);
    (render.layers(&all()), plan(description))
}

fn values(layers: &Layers, name: &str, [x, y]: [u32; 2]) -> Vec<f32> {
    let image = layers.get(name).unwrap().to_image(layers.width(), layers.height()).unwrap();
    image.pixel(x, y).to_vec()
}

#[test]
fn layers_have_the_same_bits_for_threads_tiles_and_single_samples() {
    let d = small("cornell", 24, 18);
    let (expected, _) = layers(&d, 1, 16, false);
    for (threads, tile, progressive) in [(2, 16, false), (3, 5, false), (2, 7, true)] {
        assert_eq!(layers(&d, threads, tile, progressive).0, expected);
    }
    let names: Vec<&str> = expected.layers().iter().map(|l| l.name()).collect();
    assert_eq!(names[1..], *FilmLayer::NAMES);
}

/// Through pixel centres, so that each feature is that of one ray, which the path inspector tells.
#[test]
fn features_are_those_of_the_first_surface() {
    let mut d = small("cornell", 32, 2);
    set(&mut d, Role::Render, "", "pixel_jitter", false);
    let (layers, plan) = layers(&d, 2, 16, false);
    let view = *plan.scene.cameras()[0].value.view();
    for pixel in [[16, 16], [3, 16], [16, 3], [10, 22], [22, 25], [0, 0]] {
        let path = record(&plan.scene, &*plan.integrator, &plan.job, pixel, 0);
        let at = path.vertices[0].surface.unwrap();
        let close = |name: &str, expected: &[f32]| {
            let found = values(&layers, name, pixel);
            let off = found.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-5);
            assert!(!off, "{name} {pixel:?}: {found:?} {expected:?}");
        };
        close("normal", &at.facing_normal().to_array());
        close("position", &at.p.to_array());
        close("uv", &at.uv.to_array());
        close("depth", &[(at.p - view.position).dot(view.forward)]);
        close("material-id", &[(at.material + 1) as f32]);
        close("object-id", &[(at.shape + 1) as f32]);
        close("samples", &[2.0]);
        let normal = Vec3::from_slice(&values(&layers, "normal", pixel));
        assert!(normal.dot(path.vertices[0].ray.dir) < 0.0 && (normal.length() - 1.0).abs() < 1e-5);
        let albedo = values(&layers, "albedo", pixel);
        assert!(albedo.iter().all(|v| (0.0..=1.0).contains(v)), "{albedo:?}");
    }
}

#[test]
fn nothing_is_far_black_and_number_0() {
    let (layers, _) = layers(&small("sphere", 16, 4), 1, 16, false);
    assert_eq!(values(&layers, "depth", [0, 0]), [BACKGROUND_DEPTH]);
    for (name, zeros) in [("normal", 3), ("albedo", 3), ("position", 3), ("object-id", 1), ("material-id", 1)]
    {
        assert_eq!(values(&layers, name, [0, 0]), vec![0.0; zeros], "{name}");
    }
    assert!(values(&layers, "depth", [8, 8])[0] < 100.0);
    let Some(Samples::U32(ids)) = layers.get("object-id").unwrap().channel("X") else { panic!("not whole") };
    assert_eq!(ids[8 * 16 + 8], 1);
}

/// The mean of the variance layer over penumbras is what the scatter over seeds is.
#[test]
fn the_variance_is_that_of_the_pixels_mean() {
    let d = small("cornell", 24, 16);
    let (mut claimed, mut moments) = (0.0, vec![penombre_lab::Moments::default(); 24 * 24]);
    let seeds = 24;
    for seed in 0..seeds {
        let mut p = plan(&d);
        p.job = Job { estimate: true, seed, ..p.job };
        let mut render = Render::new(p);
        render.run(2, &Quiet);
        let layers = render.layers(&[FilmLayer::Variance]);
        let variance = layers.get("variance").unwrap().to_image(24, 24).unwrap();
        claimed += variance.mean()[0] / f64::from(seeds as u32);
        let image = render.image();
        moments
            .iter_mut()
            .zip(image.to_data().chunks_exact(3))
            .for_each(|(m, rgb)| m.push(f64::from(rgb[0])));
    }
    let found = moments.iter().map(penombre_lab::Moments::variance).sum::<f64>() / f64::from(24 * 24);
    // 576 pixels, 23 degrees of freedom each: a few per cent of scatter.
    assert!((claimed / found - 1.0).abs() < 0.1, "{claimed} {found}");
}
