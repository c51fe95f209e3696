//! Samples follow the densities.

use super::*;
use penombre_lab::{DensityCheck, sidak};

/// Draws from a sampler and compares with its density; every sample must agree with `pdf`, but for those whose
/// direction rounds to the other side of the rim.
fn check(name: &str, seed: u64, sampler: &dyn DirectionSampler) -> penombre_lab::DensityReport {
    let settings = DensityCheck { seed, samples: samples(), ..DensityCheck::default() };
    let mut at_rim = 0;
    let report = settings.run(
        |rng| {
            let s = sampler.sample(uniform(rng));
            let again = sampler.pdf(s.wi);
            let near = (again - s.pdf).abs() <= 1e-5 * s.pdf;
            assert!(near || again == 0.0, "{name}: {s:?}, pdf {again}");
            assert_eq!(sampler.pdf_of_hit(s.wi, s.distance), s.pdf, "{name}");
            at_rim += u32::from(again == 0.0);
            Some(s.wi.to_array())
        },
        |wi| sampler.pdf(Vec3::from(wi)),
    );
    assert!(f64::from(at_rim) <= 2e-4 * f64::from(samples()), "{name}: {at_rim} samples miss the shape");
    report
}

#[test]
fn directions_follow_the_density_of_every_shape() {
    let shapes = shapes();
    let alpha = sidak(ALPHA, shapes.len());
    for (i, (name, shape)) in shapes.iter().enumerate() {
        let report = check(name, i as u64, shape.sampler());
        eprintln!("{name}: {report}");
        assert!(report.passes(alpha), "{name}: {report}");
        assert!((report.integral - 1.0).abs() < 2e-3, "{name}: {report}");
    }
}

#[test]
fn points_lie_on_the_shape_in_the_direction_at_the_distance() {
    let point = turned(Vec3::new(0.3, -0.2, 0.1)).as_dvec3();
    let mut rng = Pcg32::new(2);
    for (name, shape) in shapes() {
        for _ in 0..2000 {
            let s = shape.sampler().sample(uniform(&mut rng));
            let to = s.point.as_dvec3() - point;
            let size = s.point.length().max(1.0);
            assert!((to.length() - f64::from(s.distance)).abs() < 4e-7 * f64::from(size), "{name}: {s:?}");
            let off = (to - s.wi.as_dvec3() * f64::from(s.distance)).length();
            assert!(off < 4e-7 * f64::from(size), "{name}: {s:?}");
            assert!((s.wi.length() - 1.0).abs() < 2e-7, "{name}: {s:?}");
        }
    }
}

#[test]
fn solid_angles_are_those_of_the_closed_forms() {
    // Three octants' corner; a face of a cube around the point; a cone of 60°; from inside.
    let octant = SphericalTriangle::new(Vec3::ZERO, [Vec3::X, Vec3::Y, Vec3::Z]).unwrap();
    let face =
        SphericalQuad::new(Vec3::ZERO, Vec3::new(-1.0, -1.0, 1.0), [Vec3::X * 2.0, Vec3::Y * 2.0]).unwrap();
    let cone = SphericalCap::new(Vec3::ZERO, Vec3::Z * 2.0, 3f32.sqrt()).unwrap();
    let inside = SphericalCap::new(Vec3::ZERO, Vec3::Z, 1.5).unwrap();
    let pi = std::f32::consts::PI;
    for (found, expected) in [
        (octant.solid_angle(), pi / 2.0),
        (face.solid_angle(), 4.0 * pi / 6.0),
        (cone.solid_angle(), pi),
        (inside.solid_angle(), 4.0 * pi),
    ] {
        assert!((found - expected).abs() < 3e-7 * expected, "{found} {expected}");
    }
    // A far sphere: π·(r/d)².
    for power in [3, 6, 12, 18] {
        let d = 10f32.powi(power);
        let far = SphericalCap::new(Vec3::ZERO, Vec3::X * d, 1.0).unwrap();
        assert!((far.solid_angle() * d / pi * d - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_light_shines_to_the_side_of_its_normal() {
    let sides = [Vec3::X, Vec3::Y];
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for (z, front) in [(1.0, true), (-1.0, false)] {
        let from = Vec3::new(0.3, 0.3, z);
        assert_eq!(SphericalQuad::new(from, Vec3::ZERO, sides).unwrap().is_in_front(), front);
        assert_eq!(SphericalTriangle::new(from, triangle).unwrap().is_in_front(), front);
        assert_eq!(SphericalDisk::new(from, Vec3::ZERO, Vec3::Z, 2.0).unwrap().is_in_front(), front);
    }
    assert!(SphericalCap::new(Vec3::ZERO, Vec3::ZERO, 1.0).unwrap().is_inside());
    assert!(!SphericalCap::new(Vec3::X * 2.0, Vec3::ZERO, 1.0).unwrap().is_inside());
}
