mod curves;

use super::*;

fn one(value: f32, tone: ToneCurve, exposure: f32) -> u8 {
    let image = Image::from_data(1, 1, 1, vec![value]).unwrap();
    let bytes = quantise(&image, tone, exposure);
    assert_eq!([bytes[0]; 3], bytes[..]);
    bytes[0]
}

#[test]
fn raw_rounds_and_cuts() {
    let cases = [
        (f32::NAN, 0),
        (f32::NEG_INFINITY, 0),
        (-0.5, 0),
        (0.0, 0),
        (0.4999 / 255.0, 0),
        (0.5001 / 255.0, 1),
        (0.5, 128),
        (254.4 / 255.0, 254),
        (1.0, 255),
        (7.0, 255),
        (f32::INFINITY, 255),
    ];
    for (value, byte) in cases {
        assert_eq!(one(value, ToneCurve::Raw, 0.0), byte, "{value}");
    }
    // Every byte comes back from its own value.
    for byte in 0..=255u8 {
        assert_eq!(one(f32::from(byte) / 255.0, ToneCurve::Raw, 0.0), byte);
    }
}

#[test]
fn srgb_values_are_those_of_the_standard() {
    // Linear 18 % grey is 0.4614 in sRGB, 50 % is 0.7354; the linear toe has slope 12.92.
    let cases =
        [(0.18, 118), (0.5, 188), (0.001, 3), (0.0, 0), (1.0, 255), (2.0, 255), (-1.0, 0), (f32::NAN, 0)];
    for (value, byte) in cases {
        assert_eq!(one(value, ToneCurve::Srgb, 0.0), byte, "{value}");
    }
    for byte in 0..=255u8 {
        let linear = penombre_math::color::srgb_decode_u8(byte);
        assert_eq!(one(linear, ToneCurve::Srgb, 0.0), byte);
    }
}

/// The table gives the formula's bytes, next to every step and everywhere else.
#[test]
fn bytes_are_those_of_the_formula() {
    for tone in [ToneCurve::Raw, ToneCurve::Srgb, ToneCurve::Agx] {
        let formula = |v: f32| (255.0 * tone.transfer()(v)).round() as u8;
        let quantiser = Quantiser::new(tone.transfer());
        let steps = quantiser.first[1..].iter().flat_map(|f| (0..7).map(|i| f.to_bits() + i - 3));
        let spread = (0..0x4000_0000).step_by(4099);
        for value in steps.chain(spread).map(f32::from_bits) {
            assert_eq!(quantiser.byte(value), formula(value), "{tone} {value:e}");
        }
    }
}

#[test]
fn four_bytes_are_three_and_an_opaque_one() {
    let image = Image::from_data(2, 1, 3, vec![0.1, 0.2, 0.3, 4.0, -5.0, f32::NAN]).unwrap();
    let three = quantise(&image, ToneCurve::Srgb, 0.5);
    let four = quantise_rgba(&image, ToneCurve::Srgb, 0.5);
    assert_eq!(four, [&three[..3], &[255], &three[3..], &[255]].concat());
}

#[test]
fn exposure_is_in_stops() {
    assert_eq!(one(0.25, ToneCurve::Raw, 1.0), one(0.5, ToneCurve::Raw, 0.0));
    assert_eq!(one(0.25, ToneCurve::Srgb, -2.0), one(0.0625, ToneCurve::Srgb, 0.0));
}

#[test]
fn names_go_both_ways() {
    assert_eq!(ToneCurve::NAMES.len(), ToneCurve::ALL.len());
    for (name, tone) in ToneCurve::NAMES.iter().zip(ToneCurve::ALL) {
        assert_eq!(name.parse::<ToneCurve>().unwrap(), *tone);
        assert_eq!(tone.to_string(), *name);
    }
    let message = "SRGB".parse::<ToneCurve>().unwrap_err().to_string();
    assert!(message.contains("SRGB") && message.contains("raw, srgb"), "{message}");
}
