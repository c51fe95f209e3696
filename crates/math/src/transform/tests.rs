use super::*;
use crate::hash::{combine, unit_f32};
use glam::DQuat;

/// A number in [−1, 1) of a trial.
fn number(trial: u32, index: u32) -> f64 {
    f64::from(unit_f32(combine(trial, index))) * 2.0 - 1.0
}

fn vector(trial: u32, index: u32) -> DVec3 {
    DVec3::new(number(trial, index), number(trial, index + 1), number(trial, index + 2))
}

/// A rotation, an uneven scaling (mirroring for some trials) and a translation.
fn random_map(trial: u32) -> DAffine3 {
    let (q, w) = (vector(trial, 0), number(trial, 3));
    let rotation = DQuat::from_xyzw(q.x, q.y, q.z, w).normalize();
    let scale = vector(trial, 4);
    let scale = scale + scale.signum() * 0.1;
    DAffine3::from_scale_rotation_translation(scale, rotation, vector(trial, 7) * 10.0)
}

#[test]
fn the_inverse_brings_points_back() {
    for trial in 0..2000 {
        let t = Transform::new(random_map(trial)).expect("invertible");
        let p = vector(trial, 20).as_vec3();
        assert!((t.inverse().point(t.point(p)) - p).length() < 1e-4, "trial {trial}");
        assert!((t.inverse().vector(t.vector(p)) - p).length() < 1e-5, "trial {trial}");
        assert_eq!(t.inverse().inverse(), t);
    }
}

#[test]
fn normals_stay_normal() {
    for trial in 0..2000 {
        let t = Transform::new(random_map(trial)).expect("invertible");
        let (u, v) = (vector(trial, 20).as_vec3(), vector(trial, 23).as_vec3());
        let image = t.normal(u.cross(v)).normalize();
        assert!(image.dot(t.vector(u).normalize()).abs() < 1e-4, "trial {trial}");
        assert!(image.dot(t.vector(v).normalize()).abs() < 1e-4, "trial {trial}");
        // The normal keeps its side.
        let outward = u.cross(v);
        assert!(t.normal(outward).dot(t.vector(outward)) > 0.0, "trial {trial}");
    }
}

#[test]
fn handedness_is_the_sign_of_the_determinant() {
    let scaled = |x: f64, y: f64, z: f64| {
        Transform::new(DAffine3::from_scale(DVec3::new(x, y, z))).expect("invertible").flips_handedness()
    };
    assert!(!scaled(1.0, 2.0, 3.0) && !scaled(-1.0, -1.0, 1.0));
    assert!(scaled(-1.0, 1.0, 1.0) && scaled(-1.0, -1.0, -1.0));
    // The determinants over- and underflow an f32.
    assert!(scaled(-1e20, 1e20, 1e20) && scaled(-1e-20, 1e-20, 1e-20));
}

#[test]
fn singular_and_extreme_maps_are_refused() {
    let scale = |x: f64, y: f64, z: f64| Transform::new(DAffine3::from_scale(DVec3::new(x, y, z)));
    assert_eq!(scale(1.0, 0.0, 1.0), None);
    assert_eq!(scale(1.0, f64::NAN, 1.0), None);
    assert_eq!(scale(1.0, f64::INFINITY, 1.0), None);
    assert_eq!(scale(1e39, 1.0, 1.0), None);
    assert_eq!(scale(1e-39, 1e-39, 1e-39), None, "the inverse overflows");
    assert_eq!(Transform::translation(DVec3::splat(1e39)), None);
    // Singular only after rounding: the second column is the first but for 10⁻⁹.
    let close = DMat3::from_cols(DVec3::ONE, DVec3::new(1.0, 1.0, 1.0 + 1e-9), DVec3::Z + DVec3::X);
    assert_eq!(Transform::new(DAffine3::from_mat3(close)), None);
}

#[test]
fn identity_moves_nothing() {
    assert!(Transform::default().is_identity());
    assert!(Transform::translation(DVec3::ZERO).expect("invertible").is_identity());
    assert!(!Transform::translation(DVec3::X).expect("invertible").is_identity());
    let b = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };
    assert_eq!(Transform::IDENTITY.bounds(&b), b);
}

#[test]
fn the_error_bound_holds_and_is_not_lavish() {
    let mut largest = 0.0f64;
    for trial in 0..20_000 {
        let t = Transform::new(random_map(trial)).expect("invertible");
        let p = vector(trial, 20).as_vec3();
        let (image, bound) = t.point_with_error(p, Vec3::ZERO);
        let m = t.forward.matrix3.to_cols_array().map(f64::from);
        let exact = DMat3::from_cols_array(&m) * p.as_dvec3() + Vec3::from(t.forward.translation).as_dvec3();
        let ratio = ((image.as_dvec3() - exact).abs() / bound.as_dvec3()).max_element();
        assert!(ratio <= 1.0, "trial {trial}: {ratio}");
        largest = largest.max(ratio);
        let error = Vec3::new(1e-3, 2e-3, 0.0);
        let (_, with_error) = t.point_with_error(p, error);
        let displaced = t.vector(error).abs();
        assert!((with_error - bound).cmpge(displaced * 0.999).all(), "trial {trial}");
    }
    assert!(largest > 0.3, "a bound never nearly reached is too large: {largest}");
}

#[test]
fn boxes_hold_the_images_of_their_points() {
    for trial in 0..2000 {
        let t = Transform::new(random_map(trial)).expect("invertible");
        let b = Bounds3::of_points([vector(trial, 20).as_vec3(), vector(trial, 23).as_vec3()]);
        let image = t.bounds(&b);
        for k in 0..20 {
            let weights = (vector(trial, 30 + 3 * k) * 0.5 + 0.5).as_vec3();
            let p = (b.min + (b.max - b.min) * weights).clamp(b.min, b.max);
            let q = t.point(p);
            assert!(image.min.cmple(q).all() && q.cmple(image.max).all(), "trial {trial}");
        }
        let tight = Bounds3::of_points(b.corners().map(|c| t.point(c)));
        assert!((image.size() - tight.size()).max_element() < 1e-4);
    }
    assert_eq!(Transform::translation(DVec3::X).expect("invertible").bounds(&Bounds3::EMPTY), Bounds3::EMPTY);
}
