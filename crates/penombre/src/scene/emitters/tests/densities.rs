//! Samples of many emitters together follow the densities, and hits know those of samples.

use super::*;
use penombre_lab::DensityCheck;

/// Around the origin, none behind another: every kind of emitter with an extent, and a lamp that shines away.
fn many() -> Arc<Scene> {
    let checks = checks();
    let faces = vec![[0i64, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
    let tetrahedron = [[-3.0, -2.0, 0.0], [-2.0, -3.0, 0.3], [-2.0, -2.2, 1.5], [-3.5, -3.5, 1.0]];
    let up = Value::from([("translate", [0.0, 0.0, 6.5].into())]);
    let nodes = [
        light("quad", "quad")
            .with("origin", [-0.5, -0.5, 2.0])
            .with("sides", [[0.0, 1.2, 0.0], [1.0, 0.0, 0.0]])
            .with("radiance", [2.0, 2.0, 2.0]),
        light("disk", "disk")
            .with("center", [2.0, 0.0, 0.2])
            .with("normal", [-1.0, 0.2, 0.1])
            .with("radius", 0.7)
            .with("two_sided", true),
        light("sphere", "ball").with("center", [0.0, 2.0, -0.3]).with("radius", 0.5),
        light("disk", "away")
            .with("center", [0.0, -2.0, 0.0])
            .with("normal", [0.0, -1.0, 0.0])
            .with("radius", 0.7),
        glow("glow", [3.0, 1.0, 1.0], false),
        shape("mesh", "body", "glow").with("positions", tetrahedron).with("faces", faces),
        shape("sphere", "far", "glow").with("center", [1.0, 1.0, -9.0]).with("radius", 0.5),
        Node::new(Role::Instance, "instance", "b").with("of", "far").with("transform", vec![up]),
        shape("quad", "pattern", "checks")
            .with("origin", [-3.0, 1.0, -1.0])
            .with("sides", [[0.5, 1.0, 0.0], [0.0, 0.2, 1.5]]),
    ];
    scene(checks.into_iter().chain(nodes))
}

/// Sum over all emitters of the density of a direction, whether or not they hide each other.
fn density(scene: &Scene, from: Vec3, wi: Vec3) -> f32 {
    let mut ray = Ray::new(from, wi, 0.0, f32::INFINITY);
    let mut sum = 0.0;
    while let Some(at) = scene.surface(&ray, &scene.closest(&ray)) {
        if !scene.emitted(&at).is_black() {
            sum += scene.light_pdf(&at, from, wi, at.t);
        }
        ray.t_min = at.t * (1.0 + 1e-4);
    }
    sum
}

#[test]
fn directions_follow_the_sum_of_the_densities() {
    let scene = many();
    let settings = DensityCheck { seed: 5, samples: 300_000, ..DensityCheck::default() };
    let report = settings.run(
        |rng| {
            let sample = scene.sample_light(Vec3::ZERO, rng.next_f32(), uniform(rng))?;
            Some(sample.wi.to_array())
        },
        |wi| density(&scene, Vec3::ZERO, Vec3::from(wi)),
    );
    eprintln!("{report}");
    assert!(report.passes(0.01), "{report}");
    assert!(report.integral > 0.6 && report.integral < 0.95, "some look away: {}", report.integral);
}

#[test]
fn hits_have_the_density_and_radiance_of_samples() {
    let scene = many();
    let mut rng = Pcg32::new(9);
    let (mut checked, mut emitters) = (0, [0; 16]);
    for _ in 0..20_000 {
        let from = any_direction(&mut rng) * 0.3;
        let Some(s) = scene.sample_light(from, rng.next_f32(), uniform(&mut rng)) else { continue };
        let Some(at) = seen(&scene, from, s.wi) else { continue };
        // At an edge the direction, rounded, may meet the triangle beyond it.
        if at.p.distance(s.point) > 2e-6 * s.distance {
            continue;
        }
        let pdf = scene.light_pdf(&at, from, s.wi, at.t);
        assert!((pdf - s.pdf).abs() <= 2e-5 * s.pdf, "{s:?} {at:?} {pdf}");
        let rim = at.uv * Vec2::new(3.0, 2.0);
        let near_rim = (rim - rim.round()).abs().min_element() < 1e-3;
        assert!(scene.emitted(&at) == s.radiance || near_rim, "{s:?} {at:?}");
        emitters[at.emitter as usize] += 1;
        checked += 1;
    }
    assert!(checked > 10_000, "{checked}");
    // Quad, disk and ball; not the lamp that shines away; mesh, ball, pattern and the instance.
    let seen: Vec<bool> = emitters[..8].iter().map(|n| *n > 20).collect();
    assert_eq!(seen, [true, true, true, false, true, true, true, true], "{emitters:?}");
}

#[test]
fn surfaces_that_do_not_shine_have_no_emitter() {
    let scene = scene([
        Node::new(Role::Material, "diffuse", "white"),
        glow("black", [0.0; 3], true),
        shape("sphere", "a", "white").with("center", [0.0, 0.0, 3.0]),
        shape("sphere", "b", "black").with("center", [0.0, 3.0, 0.0]),
        light("point", "lamp").with("position", [3.0, 0.0, 0.0]),
    ]);
    for dir in [Vec3::Z, Vec3::Y] {
        let at = seen(&scene, Vec3::ZERO, dir).unwrap();
        assert_eq!(at.emitter, NO_EMITTER);
        assert_eq!(scene.light_pdf(&at, Vec3::ZERO, dir, at.t), 0.0);
        assert!(scene.emitted(&at).is_black());
    }
}
