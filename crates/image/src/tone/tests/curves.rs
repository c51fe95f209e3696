//! The curves against their published formulas, written a second time in double precision with the system's functions.

use super::super::curves::agx_contrast;
use super::*;

/// Greys from far below black to far above white, each brighter by 1 in 1000.
fn greys() -> impl Iterator<Item = f32> {
    (0..27_000).map(|i| (1e-6 * 1.001f64.powi(i)) as f32)
}

/// Colours of all kinds, 0 to about 30.
fn colors() -> impl Iterator<Item = [f32; 3]> {
    let level = |i: usize| [0.0, 0.001, 0.02, 0.07, 0.18, 0.5, 0.77, 1.0, 4.0, 31.0][i];
    (0..1000).map(move |i| [level(i / 100), level(i / 10 % 10), level(i % 10)])
}

/// GLSL fills matrices column by column, as the source of AgX prints them.
fn by_columns(m: [f64; 9], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| m[row] * v[0] + m[row + 3] * v[1] + m[row + 6] * v[2])
}

fn agx(color: [f64; 3]) -> [f64; 3] {
    let inset = [
        0.842479062253094,
        0.0423282422610123,
        0.0423756549057051,
        0.0784335999999992,
        0.878468636469772,
        0.0784336,
        0.0792237451477643,
        0.0791661274605434,
        0.879142973793104,
    ];
    let outset = [
        1.19687900512017,
        -0.0528968517574562,
        -0.0529716355144438,
        -0.0980208811401368,
        1.15190312990417,
        -0.0980434501171241,
        -0.0990297440797205,
        -0.0989611768448433,
        1.15107367264116,
    ];
    let (low, high) = (-12.47393, 4.026069);
    let contrast = |x: f64| {
        15.5 * x.powi(6) - 40.14 * x.powi(5) + 31.96 * x.powi(4) - 6.868 * x.powi(3)
            + 0.4298 * x * x
            + 0.1191 * x
            - 0.00232
    };
    let encoded = by_columns(inset, color).map(|v| (v.log2().clamp(low, high) - low) / (high - low));
    by_columns(outset, encoded.map(contrast)).map(|v| v.max(0.0).powf(2.2))
}

fn aces(color: [f64; 3]) -> [f64; 3] {
    let to = [0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777];
    let from = [1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602];
    let fit = |v: f64| {
        let above = v * (v + 0.0245786) - 0.000090537;
        above / (v * (0.983729 * v + 0.4329510) + 0.238081)
    };
    by_columns(from, by_columns(to, color).map(fit))
}

/// As the sample code of the specification does it, which differs in form from its text.
fn pbr_neutral(color: [f64; 3]) -> [f64; 3] {
    let x = color.into_iter().fold(f64::MAX, f64::min);
    let shifted = color.map(|c| c - if x < 0.08 { x - 6.25 * x * x } else { 0.04 });
    let peak = shifted.into_iter().fold(0.0, f64::max);
    if peak < 0.76 {
        return shifted;
    }
    let new = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    let white = 1.0 - 1.0 / (0.15 * (peak - new) + 1.0);
    shifted.map(|c| c * new / peak * (1.0 - white) + new * white)
}

fn filmic(color: [f64; 3]) -> [f64; 3] {
    let curve = |x: f64| (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
    color.map(|c| curve(2.0 * c) / curve(11.2))
}

fn formula(tone: ToneCurve) -> fn([f64; 3]) -> [f64; 3] {
    match tone {
        ToneCurve::Agx => agx,
        ToneCurve::Aces => aces,
        ToneCurve::PbrNeutral => pbr_neutral,
        ToneCurve::Filmic => filmic,
        _ => |c| c,
    }
}

#[test]
fn curves_are_their_published_formulas() {
    for tone in ToneCurve::ALL {
        for color in colors() {
            let expected = formula(*tone)(color.map(f64::from)).map(|c| c.clamp(0.0, 1.0));
            let encoded = |l: f64| {
                if l <= 0.0031308 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
            };
            for (i, (light, value)) in tone.light(color).into_iter().zip(tone.apply(color)).enumerate() {
                let e = expected[i];
                assert!((f64::from(light) - e).abs() < 2e-7, "{tone} {color:?}: {light} {e}");
                let e = if *tone == ToneCurve::Raw { e } else { encoded(e) };
                assert!((f64::from(value) - e).abs() < 2e-6, "{tone} {color:?}: {value} {e}");
            }
        }
    }
}

/// Bytes of a middle grey, of white, of a warm surface, and of two bright colours, computed apart from this crate.
#[test]
fn test_values() {
    let colors = [[0.18; 3], [1.0; 3], [0.5, 0.2, 0.05], [4.0, 0.5, 0.02], [0.0, 0.0, 3.0]];
    let cases = [
        (
            ToneCurve::Agx,
            [[128, 128, 128], [202, 202, 202], [180, 135, 82], [250, 184, 129], [132, 132, 244]],
        ),
        (ToneCurve::Aces, [[91, 91, 91], [206, 206, 206], [163, 100, 41], [255, 186, 84], [65, 3, 245]]),
        (
            ToneCurve::PbrNeutral,
            [[105, 105, 105], [240, 240, 240], [182, 113, 34], [253, 167, 150], [131, 131, 252]],
        ),
        (ToneCurve::Filmic, [[100, 100, 100], [186, 186, 186], [150, 105, 55], [246, 150, 33], [0, 0, 236]]),
    ];
    for (tone, expected) in cases {
        let image = Image::from_data(5, 1, 3, colors.concat()).unwrap();
        assert_eq!(quantise(&image, tone, 0.0), expected.concat(), "{tone}");
    }
}

#[test]
fn black_is_black_and_greys_rise_to_white() {
    for tone in ToneCurve::ALL {
        assert_eq!(tone.light([0.0; 3]), [0.0; 3], "{tone}");
        let mut before = [0.0; 3];
        for grey in greys() {
            let light = tone.light([grey; 3]);
            assert!((0..3).all(|i| light[i] >= before[i]), "{tone} {grey}: {light:?} after {before:?}");
            before = light;
        }
        assert!(before.iter().all(|c| (0.995..=1.0).contains(c)), "{tone}: {before:?}");
        let image = Image::from_data(1, 1, 1, vec![1e6]).unwrap();
        assert_eq!(quantise(&image, *tone, 0.0), [255; 3], "{tone}");
    }
}

/// Exactly, where the curve has no matrix; as well as the sources' digits allow, where it has.
#[test]
fn greys_stay_grey() {
    for tone in ToneCurve::ALL {
        let spread = match tone {
            ToneCurve::Agx => 1e-3,
            ToneCurve::Aces => 2e-5,
            _ => 0.0,
        };
        for grey in greys() {
            let [r, g, b] = tone.light([grey; 3]);
            let found = r.max(g).max(b) - r.min(g).min(b);
            assert!(found <= spread, "{tone} {grey}: {r} {g} {b}");
        }
    }
}

#[test]
fn every_number_gives_light_from_0_to_1() {
    let odd = [
        f32::NAN,
        f32::NEG_INFINITY,
        f32::MIN,
        -1.0,
        -0.0,
        0.0,
        1e-45,
        f32::MIN_POSITIVE,
        0.5,
        1e20,
        f32::MAX,
        f32::INFINITY,
    ];
    for tone in ToneCurve::ALL {
        for i in 0..odd.len().pow(3) {
            let color = [odd[i % 12], odd[i / 12 % 12], odd[i / 144]];
            let light = tone.light(color);
            assert!(light.iter().all(|c| (0.0..=1.0).contains(c)), "{tone} {color:?}: {light:?}");
            // What is not above 0 is the same as 0, infinity the same as the largest number.
            let tame = color.map(|c| if c > 0.0 { c.min(f32::MAX) } else { 0.0 });
            assert_eq!(light, tone.light(tame), "{tone} {color:?}");
        }
        for (value, byte) in [(f32::NAN, 0), (-1.0, 0), (f32::NEG_INFINITY, 0), (f32::INFINITY, 255)] {
            let image = Image::from_data(1, 1, 3, vec![value; 3]).unwrap();
            assert_eq!(quantise(&image, *tone, 0.0), [byte; 3], "{tone} {value}");
        }
    }
}

#[test]
fn bytes_are_those_of_the_values() {
    let data = colors().flatten().collect();
    let image = Image::from_data(1000, 1, 3, data).unwrap();
    for tone in ToneCurve::ALL {
        let expected: Vec<u8> =
            colors().flat_map(|c| tone.apply(c)).map(|v| (255.0 * v).round() as u8).collect();
        assert_eq!(quantise(&image, *tone, 0.0), expected, "{tone}");
    }
}

/// The sigmoid of the AgX repository (slope 2 at middle grey, powers 3 and 3.25, 0.18 becomes 0.5): the polynomial
/// stays within 0.006 of it.
#[test]
fn agx_is_near_its_original() {
    let middle = 10.0 / 16.5;
    let original = |x: f64| {
        let (a, b) = if x < middle { (59.507875, 3.0) } else { (69.86278913545539, 3.25) };
        0.5 + 2.0 * (x - middle) / (1.0 + a * (x - middle).abs().powf(b)).powf(1.0 / b)
    };
    assert!(original(0.0).abs() < 1e-6 && (original(1.0) - 1.0).abs() < 1e-6);
    for i in 0..=1000 {
        let x = f64::from(i) / 1000.0;
        assert!((agx_contrast(x) - original(x)).abs() < 0.006, "{x}");
        assert!(i == 0 || agx_contrast(x) > agx_contrast(x - 0.001), "{x}");
    }
}

/// The guarantees that the specification states.
#[test]
fn pbr_neutral_keeps_base_colors_and_hues() {
    let tone = ToneCurve::PbrNeutral;
    for color in [[0.08, 0.3, 0.8], [0.8, 0.8, 0.8], [0.1, 0.08, 0.5], [0.08; 3]] {
        for (light, scene) in tone.light(color).into_iter().zip(color) {
            assert!((light - (scene - 0.04)).abs() < 1e-7, "{color:?}: {light}");
        }
    }
    for color in colors() {
        // The same angle around the white axis: the differences of the components keep their ratios.
        let [r, g, b] = color.map(f64::from);
        let [x, y, z] = tone.light(color).map(f64::from);
        let turn = (r - g) * (y - z) - (g - b) * (x - y);
        assert!(turn.abs() < 1e-6 * (1.0 + r.max(g).max(b)), "{color:?}: {turn:e}");
    }
}

/// ACES shows a middle grey at a tenth of its white; Hill's matrices keep white white.
#[test]
fn aces_has_its_middle_grey() {
    let [r, g, b] = ToneCurve::Aces.light([0.18; 3]);
    assert!([r, g, b].iter().all(|c| (c - 0.1).abs() < 0.01), "{r} {g} {b}");
}

#[test]
fn filmic_reaches_white_at_its_white_point() {
    assert_eq!(ToneCurve::Filmic.light([5.6; 3]), [1.0; 3]);
    assert!(ToneCurve::Filmic.light([5.5; 3])[0] < 0.999);
}
