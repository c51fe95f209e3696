//! The sRGB transfer curve and luminance.

use crate::float::pow_wide;

/// Weights of linear Rec. 709 red, green and blue in the relative luminance Y (ITU-R BT.709).
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Relative luminance Y of a linear Rec. 709 colour.
#[inline]
pub fn luminance(rgb: [f32; 3]) -> f32 {
    LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2]
}

/// Linear value of an sRGB-encoded one (IEC 61966-2-1), rounded once from double precision. Values above 1
/// follow the same curve, negative ones its linear part; NaN stays NaN.
#[inline]
pub const fn srgb_decode(encoded: f32) -> f32 {
    decode_wide(encoded as f64) as f32
}

/// sRGB-encoded value of a linear one (IEC 61966-2-1), rounded once from double precision. Values above 1
/// follow the same curve, negative ones its linear part; NaN stays NaN.
#[inline]
pub const fn srgb_encode(linear: f32) -> f32 {
    encode_wide(linear as f64) as f32
}

/// Linear value of an 8-bit sRGB code, correctly rounded.
#[inline]
pub const fn srgb_decode_u8(code: u8) -> f32 {
    DECODED[code as usize]
}

/// The nearest 8-bit sRGB code of a linear value; limited to 0…255, NaN gives 0.
#[inline]
pub const fn srgb_encode_u8(linear: f32) -> u8 {
    (encode_wide(linear as f64) * 255.0 + 0.5) as u8
}

/// Above every finite `f32`: infinity and NaN, which the power function does not take, are beyond.
const HUGE: f64 = 1e40;

#[inline]
const fn decode_wide(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else if encoded <= HUGE {
        pow_wide((encoded + 0.055) / 1.055, 2.4)
    } else {
        encoded
    }
}

#[inline]
const fn encode_wide(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else if linear <= HUGE {
        1.055 * pow_wide(linear, 1.0 / 2.4) - 0.055
    } else {
        linear
    }
}

static DECODED: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = decode_wide(code as f64 / 255.0) as f32;
        code += 1;
    }
    table
};

#[cfg(test)]
mod tests;
