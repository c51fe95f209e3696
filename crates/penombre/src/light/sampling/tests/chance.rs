//! The choice of a light, powers, and lights without extent.

use super::punctual::{PunctualSample, SpotCone};
use super::*;
use penombre_lab::{Moments, chi_square};
use std::f32::consts::PI;

#[test]
fn lights_are_chosen_by_power() {
    let powers = [3.0, 0.0, 1.0, 1e-20, 6.0];
    let choice = LightChoice::new(&powers).unwrap();
    assert_eq!(choice.lights(), 5);
    let mut rng = Pcg32::new(1);
    let (mut counts, mut reused) = ([0.0; 5], [0.0; 10]);
    for _ in 0..samples() {
        let s = choice.sample(rng.next_f32());
        assert_eq!(s.probability, choice.probability(s.index));
        counts[s.index] += 1.0;
        reused[(s.remapped * 10.0) as usize] += 1.0;
    }
    let n = f64::from(samples());
    let alpha = penombre_lab::sidak(ALPHA, 2);
    let shares = chi_square(&counts, &[0.3 * n, 0.0, 0.1 * n, 0.0, 0.6 * n]);
    let even = penombre_lab::chi_square_uniform(&reused);
    assert!(shares.p_value > alpha && even.p_value > alpha, "{shares:?} {even:?}");
    assert_eq!(choice.probability(1), 0.0);
    assert!(choice.probability(3) > 0.0, "dim lights are not forgotten");
    assert_eq!(choice.probability(5), 0.0);
}

#[test]
fn odd_powers_leave_every_light_that_may_shine_a_chance() {
    let choice = LightChoice::new(&[f32::NAN, f32::INFINITY, 1.0, f32::MIN_POSITIVE, -1.0]).unwrap();
    for (i, shines) in [true, true, true, true, false].into_iter().enumerate() {
        assert_eq!(choice.probability(i) > 0.0, shines, "light {i}");
    }
    assert!((choice.probability(0) - 0.5).abs() < 1e-6);
    let dark = LightChoice::new(&[0.0; 4]).unwrap();
    assert!((dark.probability(2) - 0.25).abs() < 1e-6, "some light is chosen");
    assert_eq!(LightChoice::new(&[]), None);
}

#[test]
fn powers_are_integrals_of_the_intensity() {
    // Of a sphere: radiance × area × π; the sum of its intensity π·r²·L over all directions.
    let sphere = power::of_sphere(2.0, 0.5);
    assert!((sphere - power::of_surface(2.0, 4.0 * PI * 0.25, false)).abs() < 1e-5 * sphere);
    assert!((sphere - power::of_point(2.0 * PI * 0.25)).abs() < 1e-5 * sphere);
    assert!((power::of_surface(3.0, 2.0, true) - 12.0 * PI).abs() < 1e-5);
    assert!((power::of_directional(3.0, 2.0) - 12.0 * PI).abs() < 1e-5);
    // An environment crosses each of the 4π directions' disks of the scene.
    let one = power::of_directional(1.0, 2.0);
    assert!((power::of_environment(3.0, 2.0) - 3.0 * 4.0 * PI * one).abs() < 1e-2);
    // A cone as wide as the sphere is a point.
    let all = SpotCone::new(Vec3::Z, 180.0, 180.0);
    assert!((power::of_spot(5.0, &all) - power::of_point(5.0)).abs() < 1e-4);
    let half = SpotCone::new(Vec3::Z, 90.0, 90.0);
    assert!((power::of_spot(5.0, &half) * 2.0 - power::of_point(5.0)).abs() < 1e-4);
}

#[test]
fn powers_stay_in_the_range_of_f32() {
    for (found, expected) in [
        (power::of_environment(1.0, 1e30), f32::MAX),
        (power::of_sphere(1e-5, 1e-30), f32::MIN_POSITIVE),
        (power::of_sphere(0.0, 1e30), 0.0),
        (power::of_surface(1.0, 0.0, true), 0.0),
        (power::of_point(-1.0), 0.0),
    ] {
        assert_eq!(found, expected);
    }
}

#[test]
fn spots_fall_off_between_their_cones() {
    let spot = SpotCone::new(Vec3::Y, 20.0, 35.0);
    let at = |degrees: f32| {
        let (s, c) = degrees.to_radians().sin_cos();
        spot.share(Vec3::new(s, c, 0.0))
    };
    assert_eq!([at(0.0), at(19.9), at(35.1), at(180.0)], [1.0, 1.0, 0.0, 0.0]);
    let middle = (20f32.to_radians().cos() / 2.0 + 35f32.to_radians().cos() / 2.0).acos().to_degrees();
    assert!((at(middle) - 0.5).abs() < 1e-4);
    assert!(at(22.0) > at(30.0) && at(30.0) > at(34.0) && at(34.0) > 0.0);
    // Its integral, by uniform directions.
    let mut rng = Pcg32::new(4);
    let found: Moments =
        (0..samples()).map(|_| f64::from(spot.share(any_direction(&mut rng)) * 2.0)).collect();
    let off = (found.mean() - f64::from(spot.mean_share())).abs();
    assert!(off < 4.0 * found.variance_of_mean().sqrt(), "{found:?}, {}", spot.mean_share());
    // No ring, no cone, and cones the wrong way round.
    let sharp = SpotCone::new(Vec3::Y, 30.0, 30.0);
    assert_eq!((sharp.share(Vec3::Y), sharp.share(Vec3::X)), (1.0, 0.0));
    assert_eq!(SpotCone::new(Vec3::Y, 50.0, 30.0), sharp);
    assert_eq!(SpotCone::new(Vec3::Y, 0.0, 0.0).share(Vec3::X), 0.0);
    assert_eq!(spot.share(Vec3::NAN), 0.0);
}

#[test]
fn points_weaken_with_the_square_of_the_distance() {
    let s = punctual::towards_point(Vec3::ONE, Vec3::new(1.0, 1.0, 5.0)).unwrap();
    assert_eq!(s, PunctualSample { wi: Vec3::Z, distance: 4.0, falloff: 1.0 / 16.0 });
    assert_eq!(punctual::towards_point(Vec3::ONE, Vec3::ONE), None);
    assert_eq!(punctual::towards_point(Vec3::ZERO, Vec3::X * 1e-30), None);
    assert_eq!(punctual::towards_point(Vec3::ZERO, Vec3::X * 1e30), None);
    assert_eq!(punctual::towards_point(Vec3::ZERO, Vec3::NAN), None);
    let sun = punctual::against(-Vec3::Y);
    assert_eq!((sun.wi, sun.falloff, sun.distance), (Vec3::Y, 1.0, f32::INFINITY));
}
