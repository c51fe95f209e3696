//! The enum over all models.

use super::check::pairs;
use super::*;

#[test]
fn a_bsdf_is_small() {
    let size = size_of::<Bsdf>();
    assert!(size <= 96, "{size} bytes");
}

#[test]
fn the_enum_is_its_model() {
    let lambert = Lambert::new(Spectrum::splat(0.5));
    let any = Bsdf::from(lambert);
    for (wo, wi) in pairs(100) {
        let mode = Transport::Radiance;
        assert_eq!(any.eval(wo, wi, mode), lambert.eval(wo, wi, mode));
        assert_eq!(any.sample(wo, [0.1, 0.7, 0.3], mode), lambert.sample(wo, [0.1, 0.7, 0.3], mode));
        assert_eq!(any.albedo(wo), lambert.albedo(wo));
    }
    assert!(!any.is_delta_only() && any.roughness() == 1.0);
}

/// The cosine-weighted directions of the disk's map: no density 0, all of length 1.
#[test]
fn cosine_directions_are_unit() {
    for u in [[0.0, 0.0], [0.5, 0.5], [1.0 - f32::EPSILON / 2.0, 0.0], [0.0, 0.3], [0.999, 0.999]] {
        let w = sampling::cosine_hemisphere(u);
        assert!((w.length() - 1.0).abs() < 1e-6 && w.z >= 1e-4, "{u:?}: {w}");
    }
}
