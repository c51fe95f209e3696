use super::*;

/// The definition of IEC 61966-2-1 in double precision with the system's power function.
fn decode_exact(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn encode_exact(v: f64) -> f64 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn eight_bit_codes_are_correctly_rounded_and_return() {
    for code in 0..=255u8 {
        let linear = srgb_decode_u8(code);
        assert_eq!(linear, decode_exact(f64::from(code) / 255.0) as f32, "code {code}");
        assert_eq!(srgb_encode_u8(linear), code);
        let encoded = srgb_encode(linear);
        assert!((encoded * 255.0 - f32::from(code)).abs() < 1e-4, "code {code}");
    }
    assert_eq!((srgb_decode_u8(0), srgb_decode_u8(255)), (0.0, 1.0));
}

#[test]
fn both_curves_are_accurate_and_rising() {
    let mut last = (f32::NEG_INFINITY, f32::NEG_INFINITY, 0);
    for i in 0..200_000 {
        // From −0.1 to 3.9, fine near the joint.
        let x = if i % 2 == 0 { i as f32 * 2e-5 - 0.1 } else { last.0.max(0.0) + 1e-9 };
        let close = |found: f32, exact: f64| {
            (f64::from(found) - exact).abs() <= 1.001 * f64::from(f32::EPSILON) / 2.0 * exact.abs()
        };
        assert!(close(srgb_decode(x), decode_exact(f64::from(x))), "decode {x}");
        assert!(close(srgb_encode(x), encode_exact(f64::from(x))), "encode {x}");
        if x > last.0 {
            let code = srgb_encode_u8(x);
            assert!(srgb_encode(x) >= last.1 && code >= last.2, "rising at {x}");
            assert_eq!(code, (encode_exact(f64::from(x)) * 255.0).round() as u8, "code of {x}");
            last = (x, srgb_encode(x), code);
        }
    }
}

#[test]
fn curves_outside_the_unit_range() {
    assert!(srgb_decode(f32::NAN).is_nan() && srgb_encode(f32::NAN).is_nan());
    assert_eq!((srgb_encode_u8(f32::NAN), srgb_encode_u8(-1.0), srgb_encode_u8(f32::INFINITY)), (0, 0, 255));
    assert_eq!((srgb_encode(f32::INFINITY), srgb_decode(f32::INFINITY)), (f32::INFINITY, f32::INFINITY));
    assert_eq!((srgb_encode(-0.5), srgb_decode(-0.5)), (-6.46, (-0.5f64 / 12.92) as f32));
    assert!(srgb_encode(f32::NEG_INFINITY) == f32::NEG_INFINITY && srgb_decode(f32::MAX) == f32::INFINITY);
}

#[test]
fn luminance_of_white_is_one() {
    assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-7);
    assert_eq!(luminance([0.0, 2.0, 0.0]), 2.0 * 0.7152);
    assert!((LUMINANCE.iter().sum::<f32>() - 1.0).abs() < 1e-7);
}
