//! Light from infinity.

use super::*;
use penombre_image::Image;
use penombre_lab::{DensityCheck, Moments, sidak};
use penombre_math::Spectrum;
use std::f32::consts::PI;
use std::sync::Arc;

/// Dim sky, dark ground, a bright spot near the top and one at the seam.
fn sky(width: u32, height: u32) -> Arc<Image> {
    let mut rng = Pcg32::new(9);
    let mut image = Image::new(width, height, 3);
    for y in 0..height {
        for x in 0..width {
            let level = if y < height / 2 { 0.5 + rng.next_f32() } else { 0.05 };
            let sun = (y < 2 && x > width / 2) || (x == 0 && y == height / 3);
            let level = if sun { 60.0 } else { level };
            image.pixel_mut(x, y).copy_from_slice(&[level, 0.8 * level, 0.5 * level]);
        }
    }
    // A hole.
    (0..width / 3).for_each(|x| (height / 2..height).for_each(|y| image.pixel_mut(x, y).fill(0.0)));
    Arc::new(image)
}

fn of(image: Arc<Image>, sampling: EnvironmentSampling) -> Environment {
    Environment::new(image, sampling).expect("the image has pixels")
}

#[test]
fn directions_follow_the_density() {
    let (complete, compensated) = (EnvironmentSampling::Complete, EnvironmentSampling::Compensated);
    let cases = [
        ("constant", Environment::constant(Spectrum::splat(3.0))),
        ("complete", of(sky(32, 16), complete)),
        ("compensated", of(sky(32, 16), compensated)),
        ("odd size", of(sky(7, 13), compensated)),
        ("one row", of(sky(9, 1), complete)),
        ("one column", of(sky(1, 9), complete)),
    ];
    let alpha = sidak(ALPHA, cases.len());
    for (i, (name, environment)) in cases.iter().enumerate() {
        let mut at_border = 0;
        let check = DensityCheck { samples: samples(), seed: i as u64, ..DensityCheck::default() };
        let report = check.run(
            |rng| {
                let s = environment.sample(uniform(rng));
                at_border += u32::from(environment.pdf(s.wi) != s.pdf);
                let radiance = environment.radiance(s.wi);
                // The steepest slope is 60 per pixel. The direction of a pole itself does not tell φ.
                let close = (radiance - s.radiance).to_rgb().iter().all(|d| d.abs() < 1e-3);
                assert!(close || (s.wi.x == 0.0 && s.wi.z == 0.0), "{name}: {s:?}, {radiance:?}");
                Some(s.wi.to_array())
            },
            |wi| environment.pdf(Vec3::from(wi)),
        );
        eprintln!("{name}: {report}");
        assert!(report.passes(alpha), "{name}: {report}");
        assert!((report.integral - 1.0).abs() < 2e-3, "{name}: {report}");
        assert!(
            f64::from(at_border) < 2e-5 * f64::from(samples()) + 3.0,
            "{name}: {at_border} across a border"
        );
    }
}

#[test]
fn the_middle_is_minus_z_and_right_of_it_plus_x() {
    // 8 × 4: the pixel right of the middle and above it, and so on, has its centre at φ = π/8, θ = 3π/8.
    let mut image = Image::new(8, 4, 1);
    for (i, v) in image.data_mut().iter_mut().enumerate() {
        *v = i as f32;
    }
    let environment = of(Arc::new(image), EnvironmentSampling::Complete);
    let at = |phi: f32, theta: f32| {
        let wi = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        environment.radiance(wi)[0]
    };
    let eighth = PI / 8.0;
    for (phi, theta, pixel) in [
        (eighth, 3.0 * eighth, 12.0),       // ahead, a little right and up
        (-eighth, 3.0 * eighth, 11.0),      // a little left
        (3.0 * eighth, 5.0 * eighth, 21.0), // right, below the horizon
        (7.0 * eighth, eighth, 7.0),        // behind, high
        (-7.0 * eighth, 7.0 * eighth, 24.0),
    ] {
        assert!((at(phi, theta) - pixel).abs() < 1e-4, "{phi} {theta}: {}", at(phi, theta));
    }
    // Halfway between centres, over the seam, and straight up: the row is clamped, the seam is open.
    assert!((environment.radiance(-Vec3::Z)[0] - 15.5).abs() < 1e-4);
    assert!((environment.radiance(Vec3::X)[0] - 17.5).abs() < 1e-4);
    assert!((environment.radiance(Vec3::Z)[0] - (8.0 + 15.0 + 16.0 + 23.0) / 4.0).abs() < 1e-4);
    assert!(environment.radiance(Vec3::Y)[0] <= 7.0 && environment.radiance(-Vec3::Y)[0] >= 24.0);
}

#[test]
fn estimates_are_those_of_a_plain_average() {
    // Weighted samples against uniform directions, both of the whole sphere and of a lobe around +y.
    let environment = of(sky(32, 16), EnvironmentSampling::Complete);
    let lobe = |wi: Vec3| f64::from(wi.y.max(0.0));
    let mut rng = Pcg32::new(3);
    let (mut by_light, mut by_lobe, mut plain) = (Moments::default(), Moments::default(), Moments::default());
    let mut plain_lobe = Moments::default();
    for _ in 0..samples() {
        let s = environment.sample(uniform(&mut rng));
        let weight = f64::from(s.radiance[0] / s.pdf);
        by_light.push(weight);
        by_lobe.push(weight * lobe(s.wi));
        let wi = any_direction(&mut rng);
        let value = f64::from(environment.radiance(wi)[0] * 4.0 * PI);
        plain.push(value);
        plain_lobe.push(value * lobe(wi));
    }
    for (a, b) in [(&by_light, &plain), (&by_lobe, &plain_lobe)] {
        let test = penombre_lab::welch_t_test(a, b);
        assert!(test.p_value > ALPHA / 2.0, "{test:?}: {a:?} {b:?}");
        assert!(a.variance() < 0.1 * b.variance(), "sampling by luminance pays: {a:?} {b:?}");
    }
    let mean = f64::from(environment.mean_radiance()[0] * 4.0 * PI);
    assert!((by_light.mean() / mean - 1.0).abs() < 0.05, "{by_light:?}, {mean}");
}

#[test]
fn nothing_that_shines_is_left_out_and_compensation_leaves_out_what_is_dim() {
    let complete = of(sky(32, 16), EnvironmentSampling::Complete);
    let compensated = of(sky(32, 16), EnvironmentSampling::Compensated);
    let mean = complete.mean_radiance().luminance();
    let mut rng = Pcg32::new(8);
    let mut left_out = 0;
    for _ in 0..20_000 {
        let wi = any_direction(&mut rng);
        let radiance = complete.radiance(wi).luminance();
        assert!(radiance == 0.0 || complete.pdf(wi) > 0.0, "{wi}");
        // Beside a bright pixel the mean of a cell is above the value.
        if compensated.pdf(wi) == 0.0 {
            left_out += 1;
            assert!(radiance < 8.0 * mean, "{wi}: {radiance}, mean {mean}");
        }
    }
    assert!(left_out > 10_000, "{left_out}");
}

#[test]
fn even_and_black_images_fall_back() {
    let flat = |v: f32| Arc::new(Image::from_data(5, 4, 1, vec![v; 20]).unwrap());
    let mut rng = Pcg32::new(8);
    for value in [0.0, 0.1, 1e30] {
        let environment = of(flat(value), EnvironmentSampling::Compensated);
        for _ in 0..1000 {
            let wi = any_direction(&mut rng);
            // A cell's share is a whole number of 2⁻²⁴.
            assert!((environment.pdf(wi) * 4.0 * PI - 1.0).abs() < 1e-4 || value == 0.0, "{value}");
            assert!(environment.pdf(wi) > 0.0 && environment.sample(uniform(&mut rng)).pdf > 0.0);
        }
        assert!((environment.mean_radiance()[0] - value).abs() <= 1e-6 * value);
    }
    assert!(Environment::new(Arc::new(Image::new(0, 4, 3)), EnvironmentSampling::Complete).is_none());
}

#[test]
fn odd_pixels_and_directions_are_sound() {
    let odd = [f32::NAN, -1.0, f32::INFINITY, f32::MAX, 1e-45, 0.0, 1.0, -f32::INFINITY];
    for sampling in [EnvironmentSampling::Complete, EnvironmentSampling::Compensated] {
        let environment = of(Arc::new(Image::from_data(4, 2, 1, odd.to_vec()).unwrap()), sampling);
        let mut rng = Pcg32::new(1);
        let last = 1.0f32.next_down();
        let rim = [Vec2::ZERO, Vec2::ONE, Vec2::splat(last), Vec2::new(0.0, last), Vec2::NAN, -Vec2::ONE];
        for u in rim.into_iter().chain((0..1000).map(|_| uniform(&mut rng))) {
            let s = environment.sample(u);
            assert!(
                s.wi.is_finite() && s.radiance.is_finite() && s.pdf.is_finite() && s.pdf > 0.0,
                "{u}: {s:?}"
            );
        }
        for wi in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::NAN, Vec3::ZERO] {
            let (radiance, pdf) = (environment.radiance(wi), environment.pdf(wi));
            assert!(radiance.is_finite() && pdf.is_finite() && pdf >= 0.0, "{wi}: {radiance:?} {pdf}");
        }
        assert!(environment.mean_radiance().is_finite());
    }
}
