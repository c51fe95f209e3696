//! What every scattering model must keep, as one test.
//!
//! By chi², directions follow the density (α = 0.01 with Šidák over all models' checks); weights are f·cos/pdf; power
//! does not grow; f is reciprocal; nothing is ever NaN, infinite or negative.

use super::{Bsdf, BsdfSample, Scatter, Transport};
use penombre_lab::{DensityCheck, Moments, Pcg32, sidak};
use penombre_math::Vec3;

/// At least the number of all chi² tests of the room.
const TESTS: usize = 400;

/// True for the full-sized run, by `PENOMBRE_SLOW=1`.
pub fn is_slow() -> bool {
    std::env::var("PENOMBRE_SLOW").is_ok_and(|v| v == "1")
}

/// A model to check.
pub struct Case {
    pub name: String,
    pub bsdf: Bsdf,
    /// Least power of white light that must be scattered, from any direction.
    pub least_energy: f64,
    /// Largest error of `albedo`.
    pub albedo_error: f64,
    /// Samples for the energy.
    pub samples: u32,
}

impl Case {
    pub fn new(name: &str, bsdf: Bsdf) -> Self {
        let samples = if is_slow() { 200_000 } else { 10_000 };
        Self { name: name.to_owned(), bsdf, least_energy: 0.0, albedo_error: 1.0, samples }
    }
}

/// Directions from the normal to the horizon on both sides.
pub fn directions() -> Vec<Vec3> {
    let polar = |degrees: f32, phi: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    let above = [polar(0.0, 0.0), polar(45.0, 0.4), polar(80.0, 2.1), polar(89.5, 4.0)];
    above.into_iter().flat_map(|w| [w, Vec3::new(w.x, w.y, -w.z)]).collect()
}

fn random_direction(rng: &mut Pcg32) -> Vec3 {
    let normal = |rng: &mut Pcg32| rng.next_normal() as f32;
    Vec3::new(normal(rng), normal(rng), normal(rng)).normalize()
}

/// Random pairs of directions.
pub fn pairs(count: u32) -> impl Iterator<Item = (Vec3, Vec3)> {
    let mut rng = Pcg32::new(50);
    (0..count).map(move |_| (random_direction(&mut rng), random_direction(&mut rng)))
}

fn numbers(rng: &mut Pcg32) -> [f32; 3] {
    [rng.next_f32(), rng.next_f32(), rng.next_f32()]
}

/// All checks of a model that is not delta only.
pub fn check_scatter(case: &Case) {
    for (i, wo) in directions().into_iter().enumerate() {
        // 89.5° needs the fine bins: most of refraction then lies beside an edge of the density.
        if is_slow() || [0, 3, 4, 5].contains(&i) {
            check_density(case, wo, 100 + i as u64);
        }
    }
    check_weights(case);
    check_energy(case);
    check_reciprocity(case);
}

fn check_density(case: &Case, wo: Vec3, seed: u64) {
    let (samples, theta_bins) = if is_slow() { (1_000_000, 80) } else { (100_000, 40) };
    let check = DensityCheck { samples, theta_bins, phi_bins: 2 * theta_bins, seed };
    let mode = Transport::Radiance;
    let report = check.run(
        |rng| case.bsdf.sample(wo, numbers(rng), mode).filter(|s| !s.is_delta).map(|s| s.wi.to_array()),
        |wi| case.bsdf.eval(wo, Vec3::from(wi), mode).pdf,
    );
    assert!(report.passes(sidak(0.01, TESTS)), "{} from {wo}: {report}", case.name);
    assert!(report.integral < 1.002, "{} from {wo}: {report}", case.name);
    if is_slow() {
        let p = report.shape.p_value;
        println!("{} from {wo}: p = {p:.3}, integral of pdf {:.4}", case.name, report.integral);
    }
}

fn check_weights(case: &Case) {
    let mut rng = Pcg32::new(51);
    for wo in directions() {
        for mode in [Transport::Radiance, Transport::Importance] {
            for _ in 0..1000 {
                let Some(s) = case.bsdf.sample(wo, numbers(&mut rng), mode) else { continue };
                assert!(s.is_delta || s.is_transmission == (s.wi.z * wo.z < 0.0), "{} {wo} {s:?}", case.name);
                let eval = case.bsdf.eval(wo, s.wi, mode);
                let (got, value) = (s.weight * s.pdf, eval.f_cos);
                let off = (got - value).to_rgb().into_iter().fold(0.0f32, |m, v| m.max(v.abs()));
                assert!(off <= 2e-3 * value.max_component(), "{} {wo} {s:?} {eval:?}", case.name);
                assert!((s.pdf - eval.pdf).abs() <= 2e-3 * s.pdf, "{} {wo} {s:?} {eval:?}", case.name);
            }
        }
    }
}

/// The scattered power is at most 1, at least what the case asks, and near `albedo`. Five deviations are granted: the
/// room makes some thousand of these tests, which by Šidák asks for 4.7 at α = 0.01.
pub fn check_energy(case: &Case) {
    let mut rng = Pcg32::new(52);
    for wo in
        directions().into_iter().chain([Vec3::new(0.9, 0.1, 0.3).normalize(), Vec3::new(0.8, 0.6, -0.01)])
    {
        let mut lanes = [Moments::default(); 3];
        for _ in 0..case.samples {
            let sample = case.bsdf.sample(wo, numbers(&mut rng), Transport::Importance);
            let weight = sample.map_or([0.0; 3], |s| s.weight.to_rgb());
            lanes.iter_mut().zip(weight).for_each(|(m, w)| m.push(f64::from(w)));
        }
        let albedo = case.bsdf.albedo(wo).to_rgb();
        for (m, albedo) in lanes.iter().zip(albedo) {
            let (mean, error) = (m.mean(), 5.0 * m.variance_of_mean().sqrt() + 1e-5);
            assert!(mean <= 1.0 + error, "{} from {wo}: {mean} ± {error}", case.name);
            assert!(mean + error >= case.least_energy, "{} from {wo}: {mean} ± {error}", case.name);
            let off = (mean - f64::from(albedo)).abs();
            assert!(
                off <= case.albedo_error + error,
                "{} from {wo}: {mean} ± {error}, albedo {albedo}",
                case.name
            );
        }
    }
}

/// What is carried from the camera along a pair of directions is what is carried back from the light.
fn check_reciprocity(case: &Case) {
    for (wo, wi) in pairs(5000) {
        let there = case.bsdf.eval(wo, wi, Transport::Radiance).f_cos / wi.z.abs();
        let back = case.bsdf.eval(wi, wo, Transport::Importance).f_cos / wo.z.abs();
        let off = (there - back).to_rgb().into_iter().fold(0.0f32, |m, v| m.max(v.abs()));
        assert!(off <= 1e-3 * back.max_component().max(1e-4), "{} {wo} {wi}: {there:?} {back:?}", case.name);
    }
}

/// Ten thousand random inputs, many of them odd (10⁵ in the full-sized run): all results are sound.
pub fn check_extremes(name: &str, bsdf: Bsdf) {
    let mut rng = Pcg32::new(53);
    let odd_z = [0.0f32, -0.0, 1e-30, -1e-30, 1e-10, 2e-10, -1e-7, 1e-5, -1e-3, 1.0, -1.0];
    for _ in 0..if is_slow() { 100_000 } else { 10_000 } {
        let mut direction = || {
            let w = random_direction(&mut rng);
            let odd = odd_z.get(rng.below(2 * odd_z.len() as u32) as usize);
            odd.map_or(w, |&z| {
                let side = w.truncate().normalize() * (1.0 - z * z).max(0.0).sqrt();
                Vec3::new(side.x, side.y, z)
            })
        };
        let (wo, wi) = (direction(), direction());
        let edge = |u: f32| {
            if u < 0.1 {
                0.0
            } else if u > 0.9 {
                1.0 - f32::EPSILON / 2.0
            } else {
                u
            }
        };
        let u = numbers(&mut rng).map(edge);
        for mode in [Transport::Radiance, Transport::Importance] {
            let towards = [wi, -wo, Vec3::new(-wo.x, -wo.y, wo.z), wo];
            for wi in towards {
                let eval = bsdf.eval(wo, wi, mode);
                let sound = eval.f_cos.is_finite() && eval.f_cos.to_rgb().iter().all(|v| *v >= 0.0);
                assert!(sound && eval.pdf >= 0.0 && eval.pdf.is_finite(), "{name} {wo} {wi}: {eval:?}");
            }
            let Some(s) = bsdf.sample(wo, u, mode) else { continue };
            assert!(is_sound(&s), "{name} {wo} {u:?}: {s:?}");
        }
        let albedo = bsdf.albedo(wo);
        assert!(
            albedo.is_finite() && albedo.to_rgb().iter().all(|v| (0.0..=1.001).contains(v)),
            "{name} {wo}"
        );
    }
}

fn is_sound(s: &BsdfSample) -> bool {
    let weight = s.weight.is_finite() && s.weight.to_rgb().iter().all(|v| *v >= 0.0);
    let pdf = s.pdf > 0.0 && s.pdf.is_finite() && (!s.is_delta || s.pdf <= 1.0);
    weight && pdf && (s.wi.length() - 1.0).abs() < 1e-4 && s.eta > 0.0 && s.eta.is_finite()
}
