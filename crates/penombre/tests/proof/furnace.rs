//! Scenes with closed forms.

use super::common::{Subject, block_means, by_size};
use penombre_image::Image;
use penombre_lab::Moments;
use std::f64::consts::{FRAC_1_PI, PI};
use std::path::Path;

/// Mean of each channel over a square.
fn mean(image: &Image, [x, y, edge]: [u32; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..edge * edge {
        let rgb = image.rgb(x + i % edge, y + i / edge);
        (0..3).for_each(|c| sum[c] += f64::from(rgb[c]) / f64::from(edge * edge));
    }
    sum
}

/// The six scenes of the folder within the tolerances of their table.
#[test]
fn furnaces_are_even() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/scenes/furnace");
    let table = std::fs::read_to_string(format!("{folder}/EXPECTED.tsv")).unwrap();
    let mut count = 0;
    for line in table.lines().filter(|l| !l.starts_with('#')) {
        let columns: Vec<&str> = line.split('\t').collect();
        let [file, _, square, value, allowed] = columns[..] else { panic!("{line}") };
        let square: Vec<u32> = square.split(' ').map(|n| n.parse().unwrap()).collect();
        let [value, allowed] = [value, allowed].map(|n| n.parse::<f64>().unwrap());
        let image = Subject::file(&Path::new(folder).join(file), None).render();
        let found = mean(&image, square.try_into().unwrap());
        println!("{file}: {found:?} for {value}");
        assert!(found.iter().all(|f| (f - value).abs() <= allowed), "{file}: {found:?} for {value}");
        count += 1;
    }
    assert_eq!(count, 6);
}

/// Inside anything closed that shines and is matt the light is emission / (1 - reflectance) everywhere.
#[test]
fn closed_rooms_fill_with_their_own_light() {
    let quads: String = (0..6)
        .map(|i| {
            let (axis, near) = (i / 2, i % 2 == 0);
            let corner: [f64; 3] = std::array::from_fn(|a| if a == axis && !near { 1.0 } else { -1.0 });
            let side =
                |k: usize| std::array::from_fn::<f64, 3, _>(|a| if a == (axis + k) % 3 { 2.0 } else { 0.0 });
            let sides = if near { [side(1), side(2)] } else { [side(2), side(1)] };
            format!(
                "[shape.q{i}]\ntype = \"quad\"\nmaterial = \"it\"\norigin = {corner:?}\nsides = {sides:?}\n"
            )
        })
        .collect();
    let tetrahedron = "[shape.t]\ntype = \"mesh\"\nmaterial = \"it\"\n\
        positions = [[2, 2, 2], [-2, -2, 2], [-2, 2, -2], [2, -2, -2]]\n\
        faces = [[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]]\ncrease_angle = 0\n";
    for room in [&quads, tetrahedron] {
        let image = Subject::new(&format!(
            "[render]\nintegrator = \"path\"\nsize = [16, 16]\nspp = {}\nmax_depth = 200\n\
             [camera.main]\ntype = \"perspective\"\nposition = [0.1, 0.05, 0]\ntarget = [0.3, 0.2, 1]\nfov = 90\n\
             [material.it]\ntype = \"diffuse\"\ncolor = [0.6, 0.6, 0.6]\nemission = [0.4, 0.4, 0.4]\n{room}",
            by_size(256, 4096)
        ))
        .render();
        let found = mean(&image, [0, 0, 16])[1];
        println!("{found}");
        assert!((found - 1.0).abs() < 0.005, "{found} in {room}");
    }
}

/// Irradiance of a point below the corner of a rectangle with sides a and b, in units of the height, per radiance
/// (\[Howell2010\], factor C-11).
fn below_corner(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let r = (1.0 + a * a).sqrt();
        a / r * f64::atan2(b, r)
    };
    0.5 * (part(a, b) + part(b, a))
}

/// A matt floor under a rectangular lamp, below its middle and beside it, where its parts that reach too far are subtracted.
#[test]
fn a_quad_lights_by_its_closed_form() {
    let (radiance, albedo, height) = (5.0, 0.5, 0.8);
    for x in [0.0, 0.9] {
        let spp = by_size(256, 4096);
        let subject = Subject::new(&format!(
            "[render]\nintegrator = \"path\"\nsize = [8, 8]\nspp = {spp}\nmax_depth = 4\n\
             [camera.main]\ntype = \"perspective\"\nposition = [{x}, 0.1, 0]\ntarget = [{x}, 0, 0]\nup = [0, 0, 1]\nfov = 1\n\
             [material.it]\ntype = \"diffuse\"\ncolor = [{albedo}, {albedo}, {albedo}]\n\
             [shape.floor]\ntype = \"quad\"\norigin = [-9, 0, 9]\nsides = [[18, 0, 0], [0, 0, -18]]\nmaterial = \"it\"\n\
             [light.lamp]\ntype = \"quad\"\norigin = [-0.6, {height}, -0.4]\nsides = [[1.2, 0, 0], [0, 0, 0.8]]\n\
             radiance = [{radiance}, {radiance}, {radiance}]\n"
        ));
        let corner = |reach: f64| below_corner((reach / height).abs(), 0.4 / height) * reach.signum();
        let irradiance = radiance * 2.0 * (corner(0.6 - x) + corner(0.6 + x));
        let expected = albedo * FRAC_1_PI * irradiance;
        let found = block_means(&subject.render(), 8)[0][1];
        println!("beside by {x}: {found} for {expected}");
        assert!((found / expected - 1.0).abs() < 0.002, "{x}: {found} for {expected}");
    }
    // A plane of light gives π times its radiance.
    assert!((4.0 * below_corner(1e6, 1e6) - PI).abs() < 1e-5);
}

/// Materials that neither take nor give light vanish in a uniform white world, at any roughness: smooth ones entirely, rough
/// ones but for what the tables of lost energy leave out: under 0.2 % a bounce, but there are many within and between balls,
/// and most at grazing angles, which is what the lower half shows.
#[test]
fn white_materials_vanish_in_a_white_world() {
    let metal = "type = \"metal\"\nn = [1e-6, 1e-6, 1e-6]\nk = [9, 9, 9]";
    let smooth = |text: String| (text, [0.003, 0.003]);
    let rough = |text: String| (text, [0.006, 0.012]);
    let mut materials = vec![
        smooth("type = \"diffuse\"\ncolor = [1, 1, 1]".to_owned()),
        smooth("type = \"mirror\"\nreflectance = [1, 1, 1]".to_owned()),
    ];
    materials.extend([1.0, 1.0001, 0.6, 2.4].map(|ior| smooth(format!("type = \"glass\"\nior = {ior:?}"))));
    for alpha in [0.0, 1e-8, 0.01, 0.3, 1.0] {
        let text =
            [1.0, 1.33, 2.5].map(|ior| format!("type = \"rough_glass\"\nior = {ior:?}\nalpha = {alpha:e}"));
        let texts = text.into_iter().chain([format!("{metal}\nalpha = {alpha:e}")]);
        materials.extend(texts.map(|text| if alpha < 0.001 { smooth(text) } else { rough(text) }));
    }
    for (material, allowed) in materials {
        let found = world(&material, by_size(32, 1024)).map(|(mean, error)| (mean[1], error));
        println!("{}: {found:.4?}", material.replace('\n', ", "));
        for ((value, error), allowed) in found.into_iter().zip(allowed) {
            // 3.7 standard errors: a hundredth for all 104 bounds.
            let noise = 3.7 * error;
            assert!(value + noise > 1.0 - allowed && value - noise < 1.003, "{material}: {value} ± {error}");
        }
    }
}

/// A single ball of rough glass vanishes, in the whole and in rings down to its rim. Light that is caught behind the
/// critical angle meets the surface some 1/α² times before it gets out; roulette would leave it to a few very bright paths.
#[test]
fn rough_balls_vanish_in_a_white_world() {
    for (ior, alpha) in
        [(1.1, 0.02), (1.5, 0.005), (1.5, 0.02), (1.5, 0.1), (2.5, 0.02), (2.5, 0.1), (1.5, 0.5)]
    {
        let image = Subject::new(&format!(
            "[render]\nintegrator = \"path\"\nsize = [32, 32]\nspp = {}\nmax_depth = 4000\n\
             [integrator.path]\nroulette_depth = 4000\n\
             [camera.main]\ntype = \"perspective\"\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 24\n\
             [material.it]\ntype = \"rough_glass\"\nior = {ior:?}\nalpha = {alpha:?}\n\
             [shape.ball]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"it\"\n\
             [light.world]\ntype = \"environment\"\nradiance = [1, 1, 1]\n",
            by_size(128, 2048)
        ))
        .render();
        let radius = 16.0 * (0.2f64.asin().tan() / 12f64.to_radians().tan());
        for [from, to] in [[0.0, 1.0], [0.0, 0.3], [0.3, 0.6], [0.6, 0.8], [0.8, 0.9], [0.9, 1.0]] {
            let (mean, error) = ring(&image, from * radius, to * radius);
            println!("index {ior}, α {alpha}, {from} to {to}: {mean:.4} ± {error:.4}");
            // 3.7 standard errors: a hundredth for all 84 bounds.
            assert!((mean - 0.998).abs() < 0.003 + 3.7 * error, "{ior} {alpha} {from}: {mean} ± {error}");
            assert!(error < 0.01);
        }
    }
}

/// Mean and standard error of the pixels at distances from the middle of 32 × 32.
fn ring(image: &Image, from: f64, to: f64) -> (f64, f64) {
    let distance = |x: u32, y: u32| (f64::from(x) - 15.5).hypot(f64::from(y) - 15.5);
    let pixels = (0..1024).map(|i| (i % 32, i / 32)).filter(|&(x, y)| (from..to).contains(&distance(x, y)));
    mean_and_error(pixels.map(|(x, y)| f64::from(image.rgb(x, y)[1])))
}

/// Mean of numbers and its standard error.
fn mean_and_error(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let mut moments = Moments::default();
    numbers.for_each(|v| moments.push(v));
    (moments.mean(), moments.variance_of_mean().sqrt())
}

/// A ball on a huge one, seen at a grazing angle, of a material in a uniform white world: the means of the whole picture and
/// of its lower half, with standard errors.
fn world(material: &str, spp: i64) -> [([f64; 3], f64); 2] {
    let subject = Subject::new(&format!(
        "[render]\nintegrator = \"path\"\nsize = [32, 32]\nspp = {spp}\nmax_depth = 4000\n\
         [integrator.path]\nroulette_depth = 4000\n\
         [camera.main]\ntype = \"perspective\"\nposition = [0, -0.9, 5]\ntarget = [0, -0.5, 0]\nfov = 25\n\
         [material.it]\n{material}\n\
         [shape.ball]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"it\"\n\
         [shape.floor]\ntype = \"sphere\"\ncenter = [0, -51.01, 0]\nradius = 50\nmaterial = \"it\"\n\
         [light.world]\ntype = \"environment\"\nradiance = [1, 1, 1]\n"
    ));
    let image = subject.render();
    [[0, 0, 32], [8, 16, 16]].map(|square| {
        let [x, y, edge] = square;
        let pixels = (0..edge * edge).map(|i| f64::from(image.rgb(x + i % edge, y + i / edge)[1]));
        (mean(&image, square), mean_and_error(pixels).1)
    })
}

/// A mix of black and white under a white world sends back the share of white, for each path chooses one of both.
#[test]
fn mixes_send_back_the_shares_of_their_parts() {
    let ball = |amount: &str, nested: &str| {
        format!(
            "[render]\nintegrator = \"path\"\nsize = [16, 16]\nspp = 1024\n\
             [camera.main]\ntype = \"perspective\"\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 15\n\
             [material.black]\ntype = \"diffuse\"\ncolor = [0, 0, 0]\n\
             [material.white]\ntype = \"diffuse\"\ncolor = [1, 1, 1]\n\
             [material.half]\ntype = \"mix\"\na = \"black\"\nb = \"white\"\namount = 0.5\n\
             [material.it]\ntype = \"mix\"\na = \"{nested}\"\nb = \"white\"\namount = {amount}\n\
             [shape.ball]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"it\"\n\
             [light.world]\ntype = \"environment\"\nradiance = [1, 1, 1]\n"
        )
    };
    for (amount, nested, expected) in [("0.25", "black", 0.25), ("0.75", "black", 0.75), ("0.2", "half", 0.6)]
    {
        let image = Subject::new(&ball(amount, nested)).render();
        // 65 536 choices: five standard errors are 0.01.
        let found = mean(&image, [4, 4, 8])[1];
        assert!((found - expected).abs() < 0.01, "{amount} of {nested}: {found} for {expected}");
    }
}

/// Metals, glossy and tinted ones at the ends of their ranges: never brighter than the world.
#[test]
fn nothing_outshines_a_white_world() {
    let mut materials = Vec::new();
    for alpha in [0.0, 1e-8, 0.02, 0.5, 1.0] {
        for more in ["", "compensate = false", "compensate = false\nmasking = \"separable\""] {
            materials.push(format!("type = \"metal\"\nmetal = \"silver\"\nalpha = {alpha:e}\n{more}"));
            materials.push(format!("type = \"rough_glass\"\nior = 1.5\nalpha = {alpha:e}\n{more}"));
        }
        materials.push(format!(
            "type = \"metal\"\nn = [0.01, 0.01, 0.01]\nk = [9, 9, 9]\nalpha = 1\nalpha_y = {alpha:e}"
        ));
    }
    for shininess in [0.0, 1.0, 1e4] {
        materials.push(format!(
            "type = \"phong\"\ndiffuse = [0.5, 0.5, 0.5]\nspecular = [0.5, 0.5, 0.5]\nshininess = {shininess:?}"
        ));
    }
    for material in materials {
        let found = world(&material, by_size(16, 512));
        println!("{}: {found:.4?}", material.replace('\n', ", "));
        let is_fair = |(mean, error): &([f64; 3], f64)| {
            mean.iter().all(|v| *v > 0.05 && *v - 4.0 * error < 1.003) // a hundredth for all 228 bounds
        };
        assert!(found.iter().all(is_fair), "{material}: {found:?}");
    }
}

/// The `classic` integrator's ambient light, which comes from everywhere, is that of a white world.
#[test]
fn ambient_light_is_even() {
    let text = "[render]\nintegrator = \"classic\"\nsize = [32, 32]\nspp = 4\n[integrator.classic]\nambient = [1, 1, 1]\n\
        [camera.main]\ntype = \"perspective\"\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 20\n\
        [material.it]\ntype = \"diffuse\"\ncolor = [1, 1, 1]\n\
        [shape.ball]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"it\"\n\
        [light.off]\ntype = \"point\"\nposition = [0, 9, 0]\ncolor = [0, 0, 0]\n"
        .replace("color = [1, 1, 1]", "color = [1, 1, 1]\nambient = [1, 1, 1]");
    assert_eq!(mean(&Subject::new(&text).render(), [12, 12, 8]), [1.0; 3]);
}

/// What shines through a sieve: half of a lamp that is half there, whether its light is sought or met.
#[test]
fn a_lamp_with_holes_gives_its_share() {
    let scene = |shape: &str, opacity: f64| {
        let text = format!(
            "[render]\nintegrator = \"path\"\nsize = [8, 8]\nspp = {}\nmax_depth = 3\n\
             [camera.main]\ntype = \"perspective\"\nposition = [0.2, 0.1, 0]\ntarget = [0.2, 0, 0]\nup = [0, 0, 1]\nfov = 1\n\
             [material.it]\ntype = \"diffuse\"\ncolor = [0.5, 0.5, 0.5]\n\
             [material.glow]\ntype = \"emissive\"\nradiance = [1, 1, 1]\nopacity = {opacity:?}\n\
             [shape.floor]\ntype = \"quad\"\norigin = [-9, 0, 9]\nsides = [[18, 0, 0], [0, 0, -18]]\nmaterial = \"it\"\n\
             [shape.lamp]\nmaterial = \"glow\"\n{shape}\n",
            by_size(512, 16384)
        );
        block_means(&Subject::new(&text).render(), 8)[0][1]
    };
    for shape in [
        "type = \"quad\"\norigin = [-0.6, 0.8, -0.4]\nsides = [[1.2, 0, 0], [0, 0, 0.8]]",
        "type = \"disk\"\ncenter = [0, 0.8, 0]\nnormal = [0, -1, 0]\nradius = 0.6",
        "type = \"sphere\"\ncenter = [0, 0.8, 0]\nradius = 0.4",
        "type = \"mesh\"\npositions = [[-0.6, 0.8, -0.4], [0.6, 0.8, -0.4], [0, 0.8, 0.7]]\nfaces = [[0, 1, 2]]",
    ] {
        let ratio = scene(shape, 0.3) / scene(shape, 1.0);
        println!("{ratio} of {shape:?}");
        assert!((ratio - 0.3).abs() < 0.003, "{ratio} of {shape}");
    }
}
