//! Light by way of glass and mirror balls: with and without the search for it the images converge to the same.

use super::common::{Subject, by_size};
use penombre_lab::sidak;

const CAMERA: &str =
    "[camera.main]\ntype = \"perspective\"\nposition = [0, 2.2, 3]\ntarget = [0, 0.3, 0]\nfov = 45\n";
const FLOOR: &str = "[material.floor]\ntype = \"diffuse\"\ncolor = [0.7, 0.6, 0.5]\n\
    [shape.floor]\ntype = \"quad\"\norigin = [-3, 0, 3]\nsides = [[6, 0, 0], [0, 0, -6]]\nmaterial = \"floor\"\n";
const QUAD: &str = "[light.lamp]\ntype = \"quad\"\norigin = [-1, 2.2, -1]\nsides = [[1.6, 0, 0], [0, 0, 1.6]]\n\
    radiance = [4, 4, 4]\n";

fn ball(name: &str, at: [f64; 3], radius: f64, material: &str) -> String {
    format!(
        "[material.{name}]\n{material}\n[shape.{name}]\ntype = \"sphere\"\ncenter = {at:?}\nradius = {radius:?}\n\
         material = \"{name}\"\n"
    )
}

fn glass(ior: f64) -> String {
    format!("type = \"glass\"\nior = {ior:?}")
}

fn mirror() -> String {
    "type = \"mirror\"\nreflectance = [0.9, 0.8, 0.7]".to_owned()
}

const UP: [f64; 3] = [0.0, 0.8, 0.0];
const ON_FLOOR: [f64; 3] = [0.0, 0.5, 0.0];

fn scene(parts: &[&str]) -> Subject {
    let parts = parts.concat();
    let camera = if parts.contains("[camera") { "" } else { CAMERA };
    Subject::new(&format!("[render]\nintegrator = \"path\"\nsize = [32, 32]\nmax_depth = 9\n{camera}{parts}"))
}

/// Names and scenes.
fn subjects() -> Vec<(&'static str, Subject)> {
    let glass_ball = |at| ball("ball", at, 0.5, &glass(1.5));
    let floor = |material: &str| FLOOR.replace("type = \"diffuse\"\ncolor = [0.7, 0.6, 0.5]", material);
    let disk = "[light.lamp]\ntype = \"disk\"\ncenter = [0.8, 2.2, 0.3]\nnormal = [-0.4, -1, 0]\nradius = 0.8\nradiance = [6, 6, 6]\n";
    let bulb =
        "[light.lamp]\ntype = \"sphere\"\ncenter = [-1.1, 1.7, 0.2]\nradius = 0.6\nradiance = [5, 5, 5]\n";
    let both = QUAD.replace("[4, 4, 4]", "[4, 4, 4]\ntwo_sided = true");
    let triangle = "[material.glow]\ntype = \"emissive\"\nradiance = [30, 25, 20]\n[shape.lamp]\ntype = \"mesh\"\n\
        positions = [[-1.4, 1.9, -0.9], [0.4, 1.9, -0.9], [0.2, 2.1, 0.7], [-1.2, 2.2, 0.6]]\nfaces = [[0, 1, 2], [0, 2, 3]]\nmaterial = \"glow\"\n"
        .replace("radiance = [30, 25, 20]", "radiance = [30, 25, 20]\ntwo_sided = true");
    let wall = "[shape.wall]\ntype = \"quad\"\norigin = [-0.2, 0, 0.75]\nsides = [[1, 0, 0], [0, 0.9, 0]]\nmaterial = \"floor\"\n";
    let inside = "[camera.main]\ntype = \"perspective\"\nposition = [0.2, 0.7, 0.1]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov = 70\n";
    let metal = |alpha: f64| format!("type = \"metal\"\nmetal = \"gold\"\nalpha = {alpha}");
    vec![
        ("glass, quad", scene(&[FLOOR, QUAD, &glass_ball(UP)])),
        ("water, quad", scene(&[FLOOR, QUAD, &ball("ball", UP, 0.5, &glass(1.33))])),
        ("bubble, quad", scene(&[FLOOR, QUAD, &ball("ball", UP, 0.5, &glass(0.7))])),
        ("diamond, quad", scene(&[FLOOR, QUAD, &ball("ball", UP, 0.5, &glass(2.4))])),
        ("mirror, quad", scene(&[FLOOR, QUAD, &ball("ball", UP, 0.5, &mirror())])),
        ("polished metal, quad", scene(&[FLOOR, QUAD, &ball("ball", UP, 0.5, &metal(0.0))])),
        ("glass, two-sided quad", scene(&[FLOOR, &both, &glass_ball(ON_FLOOR)])),
        ("glass, disk", scene(&[FLOOR, disk, &glass_ball(UP)])),
        ("mirror, disk", scene(&[FLOOR, disk, &ball("ball", UP, 0.5, &mirror())])),
        ("glass, sphere", scene(&[FLOOR, bulb, &glass_ball(UP)])),
        ("mirror, sphere", scene(&[FLOOR, bulb, &ball("ball", UP, 0.5, &mirror())])),
        ("bubble, sphere", scene(&[FLOOR, bulb, &ball("ball", UP, 0.5, &glass(0.7))])),
        ("glass, mesh", scene(&[FLOOR, &triangle, &glass_ball(UP)])),
        ("mirror, mesh", scene(&[FLOOR, &triangle, &ball("ball", UP, 0.5, &mirror())])),
        ("touching, glass", scene(&[FLOOR, QUAD, &glass_ball(ON_FLOOR)])),
        ("touching, mirror", scene(&[FLOOR, QUAD, &ball("ball", ON_FLOOR, 0.5, &mirror())])),
        ("sunk in the floor, glass", scene(&[FLOOR, QUAD, &glass_ball([0.0, 0.3, 0.0])])),
        ("camera within", scene(&[FLOOR, QUAD, &glass_ball(UP), inside])),
        ("partly hidden", scene(&[FLOOR, QUAD, &glass_ball(ON_FLOOR), wall])),
        (
            "a matt ball within",
            scene(&[
                FLOOR,
                QUAD,
                &glass_ball(UP),
                &ball("core", [0.1, 0.85, 0.0], 0.2, "type = \"diffuse\""),
            ]),
        ),
        (
            "a glass shell",
            scene(&[FLOOR, QUAD, &glass_ball(UP), &ball("core", [0.0, 0.8, 0.0], 0.4, &glass(0.6667))]),
        ),
        (
            "two balls",
            scene(&[
                FLOOR,
                QUAD,
                &ball("ball", [-0.5, 0.5, 0.2], 0.45, &glass(1.5)),
                &ball("other", [0.5, 0.6, -0.1], 0.4, &mirror()),
            ]),
        ),
        (
            "phong floor",
            scene(&[
                &floor(
                    "type = \"phong\"\ndiffuse = [0.4, 0.4, 0.4]\nspecular = [0.5, 0.5, 0.5]\nshininess = 30",
                ),
                QUAD,
                &glass_ball(UP),
            ]),
        ),
        ("rough metal floor", scene(&[&floor(&metal(0.3)), QUAD, &glass_ball(UP)])),
        ("rough metal floor, mirror", scene(&[&floor(&metal(0.3)), QUAD, &ball("ball", UP, 0.5, &mirror())])),
        (
            "tinted glass",
            scene(&[
                FLOOR,
                QUAD,
                &ball(
                    "ball",
                    UP,
                    0.5,
                    "type = \"glass\"\nior = 1.5\ntransmit = [0.5, 0.8, 0.9]\nreflect = [0.9, 0.8, 0.5]",
                ),
            ]),
        ),
        (
            "light within",
            scene(&[
                FLOOR,
                "[light.lamp]\ntype = \"sphere\"\ncenter = [0.1, 0.8, 0.1]\nradius = 0.15\nradiance = [20, 20, 20]\n",
                &glass_ball(UP),
            ]),
        ),
        (
            "light half within",
            scene(&[
                FLOOR,
                "[light.lamp]\ntype = \"sphere\"\ncenter = [0.3, 1.2, 0.1]\nradius = 0.2\nradiance = [20, 20, 20]\n",
                &glass_ball(UP),
            ]),
        ),
        (
            "two glass balls in a row",
            scene(&[
                FLOOR,
                QUAD,
                &ball("ball", [0.0, 0.45, 0.3], 0.4, &glass(1.5)),
                &ball("other", [-0.3, 1.3, -0.1], 0.35, &glass(1.5)),
            ]),
        ),
        (
            "mirror floor, glass",
            scene(&[
                &floor("type = \"mirror\"\nreflectance = [0.9, 0.9, 0.9]"),
                QUAD,
                &glass_ball(UP),
                "[shape.wall]\ntype = \"quad\"\norigin = [-2, 0, -1.2]\nsides = [[4, 0, 0], [0, 2, 0]]\nmaterial = \"wall\"\n[material.wall]\ntype = \"diffuse\"\n",
            ]),
        ),
        ("large glass ball", scene(&[FLOOR, QUAD, &ball("ball", [0.0, 0.9, 0.0], 0.9, &glass(1.5))])),
        ("small mirror ball", scene(&[FLOOR, QUAD, &ball("ball", [0.0, 0.2, 1.0], 0.1, &mirror())])),
        ("two lamps", scene(&[FLOOR, QUAD, &bulb.replace("lamp", "bulb"), &glass_ball(UP)])),
    ]
}

#[test]
fn the_search_changes_the_noise_only() {
    let subjects = subjects();
    let (spp, seeds) = by_size((4, 5), (256, 16));
    let mut wrong = 0;
    for (name, subject) in &subjects {
        let subject = subject.with("render", "spp", spp);
        let found = subject.blocks(8, seeds);
        let plain = subject.with("path", "caustics", false).blocks(8, seeds);
        let d = found.difference(&plain);
        let alpha = sidak(0.01, d.tests * subjects.len());
        let ratio = found.whole.variance_of_mean() / plain.whole.variance_of_mean();
        println!(
            "{name}: whole {:+.3} % (p {:.1e}), worst block {} {:+.1} % (p {:.1e}); variance {ratio:.3}",
            100.0 * d.whole_relative,
            d.whole.p_value,
            d.block,
            100.0 * d.worst_relative,
            d.worst.p_value
        );
        // The few samples of the normal run say nothing of single blocks: some miss what rare paths bring.
        let p_value = by_size(d.whole.p_value, d.p_value());
        wrong += u32::from(p_value < alpha);
    }
    assert!(wrong == 0, "{wrong} scenes differ");
}

/// Points give what a tiny ball of the same intensity gives, π·r²·L, by way of glass and mirrors too.
#[test]
fn point_lights_are_tiny_balls() {
    // It sees the floor only: in the ball there is an image of the tiny one, and none of the point.
    let beside = "[camera.main]\ntype = \"perspective\"\nposition = [1.5, 1.2, 1.5]\ntarget = [0.9, 0, 0.3]\nfov = 20\n";
    let subject = |lamp: &str, material: &str, spp: i64| {
        scene(&[FLOOR, lamp, &ball("ball", UP, 0.5, material), beside])
            .with("render", "spp", spp)
            .blocks(8, 6)
    };
    let radius = 0.004;
    let radiance = 5.0 / (std::f64::consts::PI * radius * radius);
    let point = "[light.lamp]\ntype = \"point\"\nposition = [-0.8, 2, 0.4]\nintensity = [5, 5, 5]\n";
    let tiny = format!(
        "[light.lamp]\ntype = \"sphere\"\ncenter = [-0.8, 2, 0.4]\nradius = {radius}\nradiance = [{radiance}, {radiance}, {radiance}]\n"
    );
    for material in [glass(1.5), glass(0.7), mirror()] {
        let spp = by_size(8, 1024);
        let d = subject(point, &material, spp).difference(&subject(&tiny, &material, spp));
        println!(
            "{}: whole {:+.3} %, worst block {} {:+.2} % (p {:.1e})",
            material.replace('\n', ", "),
            100.0 * d.whole_relative,
            d.block,
            100.0 * d.worst_relative,
            d.p_value()
        );
        assert!(d.p_value() > sidak(0.01, 3 * d.tests), "{material}: {d:?}");
        assert!(d.whole_relative.abs() < by_size(0.03, 0.003), "{material}: {d:?}");
    }
}
