//! From linear light to display values.

use crate::image::Image;
use penombre_math::color::srgb_encode;
use penombre_math::float;
use std::fmt;
use std::str::FromStr;

/// How linear light becomes the values of an 8-bit file. Both curves cut at 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ToneCurve {
    /// The linear value itself, as the course program writes it.
    Raw,
    /// The sRGB transfer curve (IEC 61966-2-1): what screens expect.
    #[default]
    Srgb,
}

impl ToneCurve {
    /// The names of all curves, as [`FromStr`] takes them.
    pub const NAMES: &'static [&'static str] = &["raw", "srgb"];

    /// Display value, 0 to 1, of a linear one. NaN gives 0.
    #[must_use]
    pub fn apply(self, linear: f32) -> f32 {
        let cut = unit(linear);
        match self {
            Self::Raw => cut,
            Self::Srgb => srgb_encode(cut).min(1.0),
        }
    }
}

/// The value cut to 0…1; NaN gives 0 (`clamp` would keep it).
pub(crate) fn unit(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES[*self as usize])
    }
}

impl FromStr for ToneCurve {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name {
            "raw" => Ok(Self::Raw),
            "srgb" => Ok(Self::Srgb),
            _ => Err(UnknownName { found: name.to_owned(), expected: Self::NAMES }),
        }
    }
}

/// A name that is none of a closed list.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found \"{found}\", expected one of {}", expected.join(", "))]
pub struct UnknownName {
    /// The name given.
    pub found: String,
    /// The names there are.
    pub expected: &'static [&'static str],
}

/// 8-bit red, green and blue of all pixels, top row first: `round(255 · curve(2^exposure · c))`, limited to 0…255;
/// NaN gives 0. `exposure` is in stops (EV).
#[must_use]
pub fn quantise(image: &Image, tone: ToneCurve, exposure: f32) -> Vec<u8> {
    let gain = float::exp2(exposure);
    let quantiser = Quantiser::new(tone);
    image.rgb_pixels().flatten().map(|c| quantiser.byte(gain * c)).collect()
}

/// The same with a fourth byte, 255, behind each pixel: what graphics cards take.
#[must_use]
pub fn quantise_rgba(image: &Image, tone: ToneCurve, exposure: f32) -> Vec<u8> {
    let gain = float::exp2(exposure);
    let quantiser = Quantiser::new(tone);
    let pixel = |rgb: [f32; 3]| {
        let [r, g, b] = rgb.map(|c| quantiser.byte(gain * c));
        [r, g, b, 255]
    };
    image.rgb_pixels().flat_map(pixel).collect()
}

/// A curve as the values at which the next byte begins: the bytes of the formula without its power function.
struct Quantiser {
    /// The smallest value of each byte.
    first: [f32; 256],
    /// Byte at the beginning of each cell of values.
    cells: Vec<u8>,
}

impl Quantiser {
    /// Bits of a value that do not tell its cell: 128 cells for each power of two.
    const CELL_BITS: u32 = 16;
    /// Values below this one, 2⁻¹⁶, are all in the first cell.
    const LOWEST: u32 = 0x3780_0000;

    fn new(tone: ToneCurve) -> Self {
        let byte = |c: f32| (255.0 * tone.apply(c)).round() as u8;
        let mut first = [0.0; 256];
        for (code, first) in first.iter_mut().enumerate().skip(1) {
            // Bits of floats from 0 to 1 are in the order of the floats.
            let (mut below, mut at) = (0, 1f32.to_bits());
            while at - below > 1 {
                let middle = below.midpoint(at);
                if usize::from(byte(f32::from_bits(middle))) < code { below = middle } else { at = middle }
            }
            *first = f32::from_bits(at);
        }
        let begins = (Self::LOWEST..1f32.to_bits()).step_by(1 << Self::CELL_BITS);
        let mut cells: Vec<u8> = begins.map(|bits| byte(f32::from_bits(bits))).collect();
        cells[0] = 0;
        Self { first, cells }
    }

    fn byte(&self, value: f32) -> u8 {
        // Also NaN, which is not above 0.
        let positive = value > 0.0;
        if !positive {
            return 0;
        }
        if value >= 1.0 {
            return 255;
        }
        let cell = value.to_bits().saturating_sub(Self::LOWEST) >> Self::CELL_BITS;
        let mut byte = self.cells[cell as usize];
        while byte < 255 && value >= self.first[usize::from(byte) + 1] {
            byte += 1;
        }
        byte
    }
}

#[cfg(test)]
mod tests {
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
        for tone in [ToneCurve::Raw, ToneCurve::Srgb] {
            let formula = |c: f32| (255.0 * tone.apply(c)).round() as u8;
            let quantiser = Quantiser::new(tone);
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
        for name in ToneCurve::NAMES {
            assert_eq!(name.parse::<ToneCurve>().unwrap().to_string(), *name);
        }
        let message = "SRGB".parse::<ToneCurve>().unwrap_err().to_string();
        assert!(message.contains("SRGB") && message.contains("raw, srgb"), "{message}");
    }
}
