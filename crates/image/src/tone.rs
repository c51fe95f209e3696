//! From linear light to display values.

mod curves;
#[cfg(test)]
mod tests;

use crate::image::Image;
use penombre_math::color::srgb_encode;
use penombre_math::float;
use std::fmt;
use std::str::FromStr;

/// How linear light becomes the values of an 8-bit file: a curve from the colours of the scene to those of a display,
/// then the transfer curve of sRGB, which all but [`Raw`](Self::Raw) have.
///
/// Colours are linear Rec. 709. Where a middle grey of 0.18 goes, as light of the display and as a byte:
///
/// | `raw` | `srgb` | `agx` | `aces` | `pbr-neutral` | `filmic` |
/// |---|---|---|---|---|---|
/// | 0.18, 46 | 0.18, 118 | 0.214, 128 | 0.106, 91 | 0.14, 105 | 0.128, 100 |
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ToneCurve {
    /// The linear value itself, cut at 0 and 1, as the course program writes it.
    Raw,
    /// The value cut at 0 and 1, then the sRGB transfer curve (IEC 61966-2-1): what screens expect.
    #[default]
    Srgb,
    /// The base look of AgX \[SobotkaAgX\] in its polynomial form \[WrenschAgX\]: 16.5 stops, white at 16.3,
    /// bright colours fade towards white.
    Agx,
    /// The look of ACES as fitted by Hill \[HillACES\]: contrasty; without any exposure of its own.
    Aces,
    /// Khronos PBR Neutral \[KhronosNeutral2024\]: base colours from 0.08 to 0.8 keep their hue and saturation, only
    /// highlights are compressed.
    PbrNeutral,
    /// The filmic curve of Uncharted 2 \[Hable2010\]: soft toe and shoulder, white at 5.6.
    Filmic,
}

impl ToneCurve {
    /// The names of all curves, as [`FromStr`] takes them.
    pub const NAMES: &'static [&'static str] = &["raw", "srgb", "agx", "aces", "pbr-neutral", "filmic"];

    /// All curves, in the order of [`NAMES`](Self::NAMES).
    pub const ALL: &'static [Self] =
        &[Self::Raw, Self::Srgb, Self::Agx, Self::Aces, Self::PbrNeutral, Self::Filmic];

    /// The light, 0 to 1, that a display shall show for a colour of the scene. Negative components and NaN count as 0,
    /// infinite ones as the largest number.
    #[must_use]
    pub fn light(self, scene: [f32; 3]) -> [f32; 3] {
        self.curve(scene).map(self.lamp())
    }

    /// Display values, 0 to 1, of a colour of the scene: its [`light`](Self::light), with the transfer curve of sRGB
    /// unless the curve is [`Raw`](Self::Raw).
    #[must_use]
    pub fn apply(self, scene: [f32; 3]) -> [f32; 3] {
        self.curve(scene).map(self.transfer())
    }

    /// What the formula gives for a colour: light, or with AgX values for a display that [`lamp`](Self::lamp) describes.
    fn curve(self, scene: [f32; 3]) -> [f32; 3] {
        let formula = match self {
            Self::Raw | Self::Srgb => return scene.map(unit),
            Self::Agx => curves::agx,
            Self::Aces => curves::aces,
            Self::PbrNeutral => curves::pbr_neutral,
            Self::Filmic => curves::filmic,
        };
        formula(scene.map(|c| if c > 0.0 { f64::from(c.min(f32::MAX)) } else { 0.0 })).map(|c| unit(c as f32))
    }

    /// From what the formula gives, 0 to 1, to light.
    fn lamp(self) -> fn(f32) -> f32 {
        match self {
            Self::Agx => curves::agx_lamp,
            _ => |value| value,
        }
    }

    /// From what the formula gives to the value in the file.
    fn transfer(self) -> fn(f32) -> f32 {
        match self {
            Self::Raw => unit,
            Self::Agx => |value| srgb(curves::agx_lamp(unit(value))),
            _ => srgb,
        }
    }
}

/// The value cut to 0…1; NaN gives 0 (`clamp` would keep it).
pub(crate) fn unit(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The sRGB value, 0 to 1, of a linear one, cut to 0…1; NaN gives 0.
pub(crate) fn srgb(linear: f32) -> f32 {
    srgb_encode(unit(linear)).min(1.0)
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES[*self as usize])
    }
}

impl FromStr for ToneCurve {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let place = Self::NAMES.iter().position(|n| *n == name);
        place
            .map(|i| Self::ALL[i])
            .ok_or_else(|| UnknownName { found: name.to_owned(), expected: Self::NAMES })
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

/// 8-bit red, green and blue of all pixels, top row first: `round(255 · curve(2^exposure · rgb))`, limited to 0…255;
/// NaN gives 0. `exposure` is in stops (EV).
#[must_use]
pub fn quantise(image: &Image, tone: ToneCurve, exposure: f32) -> Vec<u8> {
    pixels(image, tone, exposure, |rgb| rgb).into_flattened()
}

/// The same with a fourth byte, 255, behind each pixel: what graphics cards take.
#[must_use]
pub fn quantise_rgba(image: &Image, tone: ToneCurve, exposure: f32) -> Vec<u8> {
    pixels(image, tone, exposure, |[r, g, b]| [r, g, b, 255]).into_flattened()
}

/// What `pixel` makes of the bytes of each pixel.
fn pixels<T>(image: &Image, tone: ToneCurve, exposure: f32, pixel: impl Fn([u8; 3]) -> T) -> Vec<T> {
    let display = Display::new(tone, exposure);
    let mut pixels = Vec::with_capacity(image.pixel_count());
    image.each_rgb(0..image.pixel_count(), |rgb| pixels.push(pixel(display.bytes(rgb))));
    pixels
}

/// From colours of the scene to bytes.
pub(crate) struct Display {
    tone: ToneCurve,
    gain: f32,
    quantiser: Quantiser,
}

impl Display {
    /// `exposure` is in stops (EV).
    pub fn new(tone: ToneCurve, exposure: f32) -> Self {
        Self { tone, gain: float::exp2(exposure), quantiser: Quantiser::new(tone.transfer()) }
    }

    /// `round(255 · curve(2^exposure · rgb))`, limited to 0…255; NaN gives 0.
    #[inline]
    pub fn bytes(&self, rgb: [f32; 3]) -> [u8; 3] {
        let scaled = [self.gain * rgb[0], self.gain * rgb[1], self.gain * rgb[2]];
        let [r, g, b] = match self.tone {
            // The quantiser cuts as these do.
            ToneCurve::Raw | ToneCurve::Srgb => scaled,
            tone => tone.curve(scaled),
        };
        [self.quantiser.byte(r), self.quantiser.byte(g), self.quantiser.byte(b)]
    }
}

/// A transfer curve as the values at which the next byte begins: the bytes of the formula without its power function.
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

    fn new(transfer: fn(f32) -> f32) -> Self {
        let byte = |c: f32| (255.0 * transfer(c)).round() as u8;
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

    #[inline]
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
