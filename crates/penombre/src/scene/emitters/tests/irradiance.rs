//! Irradiance in closed form.

use super::*;

/// Under the corner of a parallel rectangle of a × b at distance h, radiance 1 \[Howell2010\].
fn under_a_corner(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    0.5 * (x / p * (y / p).atan() + y / q * (x / q).atan())
}

/// A parallel disk of radius r at height h, d beside its axis, radiance 1 \[Howell2010\].
fn under_a_disk(h: f64, d: f64, r: f64) -> f64 {
    let sum = h * h + d * d + r * r;
    PI / 2.0 * (1.0 - (sum - 2.0 * r * r) / (sum * sum - 4.0 * r * r * d * d).sqrt())
}

const SAMPLES: u32 = 20_000;
const RADIANCE: [f64; 3] = [1.0, 2.0, 3.0];

/// A quad facing down, two units up.
fn quad(node: Node) -> Node {
    node.with("origin", [0.0, 0.0, 2.0]).with("sides", [[0.0, 3.0, 0.0], [1.5, 0.0, 0.0]])
}

fn disk(node: Node) -> Node {
    node.with("center", [0.8, 0.0, 1.5]).with("normal", [0.0, 0.0, -2.0]).with("radius", 0.7)
}

fn ball(node: Node) -> Node {
    node.with("center", [0.5, 0.4, 2.0]).with("radius", 0.6)
}

fn ball_above() -> f64 {
    let (x, y, z, r) = (0.5f64, 0.4f64, 2.0f64, 0.6f64);
    let d = (x * x + y * y + z * z).sqrt();
    PI * (r / d) * (r / d) * (z / d)
}

fn check(name: &str, nodes: impl IntoIterator<Item = Node>, expected: f64) {
    let scene = scene(nodes);
    agrees(name, &by_lights(&scene, Vec3::ZERO, Vec3::Z, SAMPLES), expected);
    agrees(&format!("{name} by rays"), &by_rays(&scene, Vec3::ZERO, Vec3::Z, 10 * SAMPLES), expected);
}

#[test]
fn surfaces_give_the_irradiance_of_the_form_factor() {
    let lit = |node: Node| node.with("radiance", RADIANCE);
    check("quad", [quad(lit(light("quad", "a")))], 2.0 * under_a_corner(1.5, 3.0, 2.0));
    check("disk", [disk(lit(light("disk", "a")))], 2.0 * under_a_disk(1.5, 0.8, 0.7));
    check("sphere", [ball(lit(light("sphere", "a")))], 2.0 * ball_above());
    let glow = || glow("glow", RADIANCE, false);
    check("quad shape", [glow(), quad(shape("quad", "a", "glow"))], 2.0 * under_a_corner(1.5, 3.0, 2.0));
    check("disk shape", [glow(), disk(shape("disk", "a", "glow"))], 2.0 * under_a_disk(1.5, 0.8, 0.7));
    check("sphere shape", [glow(), ball(shape("sphere", "a", "glow"))], 2.0 * ball_above());
    let mesh = shape("mesh", "a", "glow")
        .with("positions", [[0.0, 0.0, 2.0], [0.0, 3.0, 2.0], [1.5, 3.0, 2.0], [1.5, 0.0, 2.0]])
        .with("faces", vec![[0i64, 1, 2], [0, 2, 3]]);
    check("mesh", [glow(), mesh], 2.0 * under_a_corner(1.5, 3.0, 2.0));
}

#[test]
fn lights_without_extent_give_the_irradiance_of_their_formula() {
    let at = [1.0, 2.0, 3.0];
    let (square, cos) = (14.0f64, 3.0 / 14f64.sqrt());
    let point = light("point", "a").with("position", at).with("intensity", RADIANCE);
    let one = |node: Node| by_lights(&scene([node]), Vec3::ZERO, Vec3::Z, 2);
    agrees("point", &one(point), 2.0 / square * cos);
    let spot = || light("spot", "a").with("position", at).with("intensity", RADIANCE);
    agrees("spot", &one(spot().with("target", [0.0, 0.0, 0.1])), 2.0 / square * cos);
    // In the middle of the rim in cosine the strength is a half. The axis leans by that angle.
    let degrees = |d: f64| d.to_radians();
    let middle = ((degrees(20.0).cos() + degrees(40.0).cos()) / 2.0).acos();
    let (s, c) = middle.sin_cos();
    let below = light("spot", "a")
        .with("position", [0.0, 0.0, 2.0])
        .with("direction", [3.0 * s, 0.0, -3.0 * c])
        .with("angle", 40.0)
        .with("blend", 20.0)
        .with("intensity", RADIANCE);
    let found = one(below);
    assert!((found.mean() - 2.0 / 4.0 * 0.5).abs() < 1e-5, "{found:?}");
    assert_eq!(one(spot().with("direction", [1.0, 0.0, 0.0])).mean(), 0.0, "outside the cone");
    let sun = light("sun", "a").with("direction", [0.0, -3.0, -4.0]).with("irradiance", RADIANCE);
    agrees("sun", &one(sun), 2.0 * 0.8);
}

#[test]
fn one_sided_surfaces_are_dark_from_behind() {
    let behind = Vec3::new(0.5, 0.2, 5.0);
    let wi = (Vec3::new(0.7, 0.1, 2.0) - behind).normalize();
    let glow = |two_sided| glow("glow", RADIANCE, two_sided);
    let lamps = |two_sided: bool| -> [Vec<Node>; 4] {
        [
            vec![quad(light("quad", "a")).with("two_sided", two_sided)],
            vec![disk(light("disk", "a")).with("two_sided", two_sided)],
            vec![glow(two_sided), quad(shape("quad", "a", "glow"))],
            vec![glow(two_sided), disk(shape("disk", "a", "glow"))],
        ]
    };
    for two_sided in [false, true] {
        for (i, nodes) in lamps(two_sided).into_iter().enumerate() {
            let scene = scene(nodes);
            let sample = scene.sample_light(behind, 0.5, Vec2::splat(0.5));
            let at = seen(&scene, behind, wi).unwrap();
            assert_ne!(at.emitter, NO_EMITTER);
            let pdf = scene.light_pdf(&at, behind, wi, at.t);
            assert_eq!(
                (sample.is_some(), !scene.emitted(&at).is_black(), pdf > 0.0),
                (two_sided, two_sided, two_sided),
                "{i}"
            );
        }
    }
    // Within a ball only one that shines to both sides is bright, from everywhere.
    let center = Vec3::new(0.5, 0.4, 2.1);
    for (nodes, bright) in [
        (vec![ball(light("sphere", "a"))], false),
        (vec![glow(false), ball(shape("sphere", "a", "glow"))], false),
        (vec![glow(true), ball(shape("sphere", "a", "glow"))], true),
    ] {
        let scene = scene(nodes);
        let found = by_lights(&scene, center, Vec3::Z, SAMPLES);
        agrees("inside", &found, if bright { 2.0 * PI } else { 0.0 });
    }
}

/// Appearances under maps shine as what they look like.
#[test]
fn moved_shapes_shine_where_they_are() {
    let step = |name: &str, value: Value| Value::from([(name, value)]);
    let turn = || Value::from([("rotate", [1.0, 0.3, 0.0].into()), ("angle", 35.0.into())]);
    let similar = vec![step("scale", 1.3.into()), turn(), step("translate", [0.3, 0.2, 1.0].into())];
    let mirrored =
        vec![step("scale", [1.0, 1.0, -1.0].into()), turn(), step("translate", [0.0, 0.2, 4.0].into())];
    let bent = vec![step("scale", [1.5, 0.6, 1.0].into()), turn(), step("translate", [0.0, 0.2, 1.5].into())];
    let mesh = |node: Node| {
        node.with("positions", [[0.0, 0.0, 2.0], [0.0, 3.0, 2.0], [1.5, 3.0, 2.5], [1.5, 0.0, 2.0]])
            .with("faces", vec![[0i64, 1, 2], [0, 2, 3]])
    };
    let mut compared = 0;
    for (i, steps) in [similar, mirrored, bent].into_iter().enumerate() {
        let of = |kind| shape(kind, "a", "glow");
        for node in [quad(of("quad")), disk(of("disk")), ball(of("sphere")), mesh(of("mesh"))] {
            let kind = node.type_name.clone();
            let sampled = i < 2 || ["quad", "mesh"].contains(&kind.as_str());
            let instance = || {
                Node::new(Role::Instance, "instance", "b").with("of", "a").with("transform", steps.clone())
            };
            // The shape itself is out of the way, far below and facing down.
            let away = vec![step("translate", [0.0, 0.0, -500.0].into())];
            let own = node.clone().with("transform", steps.clone());
            let undo = vec![step("translate", [0.0, 0.0, 500.0].into())];
            let back: Vec<Value> = undo.into_iter().chain(steps.clone()).collect();
            let far = node.with("transform", away);
            let placed = instance().with("transform", back);
            for nodes in [vec![own], vec![far, placed]] {
                let scene = scene(std::iter::once(glow("glow", RADIANCE, true)).chain(nodes));
                let expected = by_rays(&scene, Vec3::ZERO, Vec3::Z, 10 * SAMPLES);
                let found = by_lights(&scene, Vec3::ZERO, Vec3::Z, SAMPLES);
                assert!(expected.mean() > 0.05, "{kind} {i}: nothing to see");
                if !sampled {
                    // Only what stands far below is sampled, and that lies under the horizon.
                    assert_eq!(found.mean(), 0.0, "{kind} {i}");
                    continue;
                }
                let deviation = (expected.variance_of_mean() + found.variance_of_mean()).sqrt();
                let off = (found.mean() - expected.mean()).abs();
                assert!(
                    off < 4.0 * deviation,
                    "{kind} {i}: {} {} ± {deviation}",
                    found.mean(),
                    expected.mean()
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 20);
}

/// Radiance that varies over a surface is that of the place.
#[test]
fn textured_surfaces_shine_in_their_pattern() {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mesh = shape("mesh", "a", "checks")
        .with("positions", [[0.0, 0.0, 2.0], [0.0, 3.0, 2.0], [1.5, 3.0, 2.0], [1.5, 0.0, 2.0]])
        .with("uvs", uvs)
        .with("faces", vec![[0i64, 1, 2], [0, 2, 3]]);
    let of = |kind| shape(kind, "a", "checks");
    for node in [quad(of("quad")), disk(of("disk")), ball(of("sphere")), mesh] {
        let kind = node.type_name.clone();
        let scene = scene(checks().into_iter().chain([node]));
        let found = by_lights(&scene, Vec3::ZERO, Vec3::Z, SAMPLES);
        let expected = by_rays(&scene, Vec3::ZERO, Vec3::Z, 20 * SAMPLES);
        let deviation = (expected.variance_of_mean() + found.variance_of_mean()).sqrt();
        eprintln!("{kind}: {:.5} {:.5} ± {deviation:.5}", found.mean(), expected.mean());
        assert!((found.mean() - expected.mean()).abs() < 4.0 * deviation, "{kind}");
        // A sample knows what a ray towards it sees.
        let mut rng = Pcg32::new(3);
        let mut same = 0;
        for _ in 0..1000 {
            let Some(s) = scene.sample_light(Vec3::ZERO, 0.5, uniform(&mut rng)) else { continue };
            let at = seen(&scene, Vec3::ZERO, s.point).unwrap();
            same += i32::from(scene.emitted(&at) == s.radiance) - i32::from(scene.emitted(&at) != s.radiance);
        }
        assert!(same > 300, "{kind}: {same}");
    }
}
