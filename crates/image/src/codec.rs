//! One module per file format, and what they share: a cursor over bytes with places for messages, size checks,
//! and tables from integers to linear light.

pub mod exr;
pub mod hdr;
pub mod jpeg;
pub mod packed;
pub mod palette;
pub mod pfm;
pub mod png;
pub mod pnm;
pub mod tga;

use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::{Codes, Image, Pixel, Storage, Tables};
use crate::io::{ColorSpace, Decoded, MAX_PIXELS, WriteOptions};
use crate::tone::{Display, unit};
use penombre_math::color::srgb_decode;
use std::sync::Arc;

pub type Result<T> = std::result::Result<T, ImageErrorKind>;

/// A place in the bytes of a file.
pub struct Source<'a> {
    pub format: Format,
    pub bytes: &'a [u8],
    pub at: usize,
}

impl<'a> Source<'a> {
    pub fn new(format: Format, bytes: &'a [u8]) -> Self {
        Self { format, bytes, at: 0 }
    }

    /// Another place in the same file.
    pub fn placed(&self, at: usize) -> Self {
        Self { format: self.format, bytes: self.bytes, at }
    }

    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at.min(self.bytes.len())..]
    }

    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    pub fn byte(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.at += 1;
        Some(byte)
    }

    /// The next `count` bytes, or an error that says how many there are.
    pub fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8]> {
        let rest = self.rest();
        if rest.len() < count {
            let found = format!("{} more bytes before the end of the file", rest.len());
            return Err(self.fault(found, format!("{count} bytes of {what}")));
        }
        self.at += count;
        Ok(&rest[..count])
    }

    /// The next line without its line feed; `None` at the end of the file. Lines over `limit` bytes are cut there.
    pub fn line(&mut self, limit: usize) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().take(limit).position(|b| *b == b'\n');
        let line = &rest[..length.unwrap_or(rest.len().min(limit))];
        self.at += line.len() + usize::from(length.is_some());
        Some(line)
    }

    /// A fault at the present place.
    pub fn fault(&self, found: impl Into<String>, expected: impl Into<String>) -> ImageErrorKind {
        ImageErrorKind::Malformed {
            format: self.format,
            offset: self.at as u64,
            found: found.into(),
            expected: expected.into(),
        }
    }

    pub fn unsupported(&self, found: impl Into<String>, expected: impl Into<String>) -> ImageErrorKind {
        ImageErrorKind::Unsupported {
            format: self.format,
            offset: self.at as u64,
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// Refuses sizes of zero, sizes beyond [`MAX_PIXELS`], more pixels than the file can hold at `pixels_per_byte`, the
    /// best that any encoder of the format can do, and huge pictures of which it says next to nothing.
    pub fn check_size(&self, width: u64, height: u64, pixels_per_byte: u64) -> Result<(u32, u32)> {
        if width == 0 || height == 0 {
            return Err(self.fault(format!("a size of {width} × {height} pixels"), "at least one pixel"));
        }
        let bytes = self.bytes.len() as u64;
        let limit = sensible_pixels(self.format, bytes).min(bytes.saturating_mul(pixels_per_byte));
        let side = |n: u64| u32::try_from(n).ok();
        match (width.checked_mul(height), side(width), side(height)) {
            (Some(pixels), Some(w), Some(h)) if pixels <= limit => Ok((w, h)),
            _ => {
                let (format, offset) = (self.format, self.at as u64);
                Err(ImageErrorKind::TooLarge { format, offset, width, height, bytes, limit })
            }
        }
    }
}

/// Most pixels of a file of that many bytes. Small files that unpack to gigabytes are made to do harm. Pictures that keep
/// the numbers of their files may have 8192² pixels, which covers masks of one colour. Those that become floats may
/// have 4096², and 8192² where one value takes a byte before it is packed as well as can be. More is taken only from files
/// that say something of it.
fn sensible_pixels(format: Format, bytes: u64) -> u64 {
    let becomes_floats = matches!(format, Format::Exr | Format::Hdr | Format::Pfm);
    let empty = if becomes_floats { bytes.saturating_mul(1100).clamp(1 << 24, 1 << 26) } else { 1 << 26 };
    bytes.saturating_mul(32).clamp(empty, MAX_PIXELS)
}

/// Most pixels that so many bytes of a format can hold: what [`Source::check_size`] lets pass, or more.
pub fn most_pixels(format: Format, bytes: u64) -> u64 {
    let per_byte = match format {
        Format::Png => png::PIXELS_PER_BYTE,
        Format::Jpeg => jpeg::PIXELS_PER_BYTE,
        Format::Ppm | Format::Pfm => 1,
        Format::Pgm => 8,
        Format::Exr => exr::PIXELS_PER_BYTE,
        Format::Hdr => hdr::PIXELS_PER_BYTE,
        Format::Tga => tga::PIXELS_PER_BYTE,
        Format::Bmp => packed::BMP_PIXELS_PER_BYTE,
        Format::Gif => packed::GIF_PIXELS_PER_BYTE,
        Format::Webp => packed::WEBP_PIXELS_PER_BYTE,
    };
    let always = if matches!(format, Format::Bmp | Format::Gif | Format::Webp) { packed::SMALL } else { 0 };
    bytes.saturating_mul(per_byte).max(always).min(sensible_pixels(format, bytes))
}

/// What was expected where a text of a decoding library contains the first word of a pair: the second one.
pub fn expected<'w>(pairs: &[(&str, &'w str)], text: &str) -> Option<&'w str> {
    pairs.iter().find(|(part, _)| text.contains(part)).map(|(_, expected)| *expected)
}

/// Room for the samples of an image that has passed [`Source::check_size`].
pub fn room(width: u32, height: u32, channels: u32) -> Result<Vec<f32>> {
    let mut samples = Vec::new();
    let length = width as usize * height as usize * channels as usize;
    match samples.try_reserve_exact(length) {
        Ok(()) => Ok(samples),
        Err(_) => Err(ImageErrorKind::OutOfMemory { width: width.into(), height: height.into() }),
    }
}

/// Zeros for all samples of an image that has passed [`Source::check_size`]. Memory that is never written to is never
/// really taken, so a file that is cut off early costs little.
pub fn zeroed<T: Clone + Default>(width: u32, height: u32, channels: u32) -> Result<Vec<T>> {
    let length = width as usize * height as usize * channels as usize;
    // Only a trial: it can fail where `vec!` would end the program.
    match Vec::<T>::new().try_reserve_exact(length) {
        Ok(()) => Ok(vec![T::default(); length]),
        Err(_) => Err(ImageErrorKind::OutOfMemory { width: width.into(), height: height.into() }),
    }
}

/// Display values of an image in bytes, row by row, and how many for each pixel: red, green and blue, and alpha if there
/// is any.
pub fn eight_bit_rows(image: &Image, options: &WriteOptions) -> (impl ExactSizeIterator<Item = Vec<u8>>, u8) {
    let display = Display::new(options.tone, options.exposure);
    let channels = if image.channels().is_multiple_of(2) { 4 } else { 3 };
    ((0..image.height()).map(move |y| row_bytes(image, y, &display)), channels)
}

fn row_bytes(image: &Image, y: u32, display: &Display) -> Vec<u8> {
    let width = image.width() as usize;
    if !image.channels().is_multiple_of(2) {
        let (start, mut colors) = (y as usize * width, Vec::with_capacity(width));
        image.each_rgb(start..start + width, |rgb| colors.push(display.bytes(rgb)));
        return colors.into_flattened();
    }
    let bytes = |pixel: Pixel| {
        let [r, g, b] = display.bytes(pixel.rgb());
        [r, g, b, (255.0 * unit(pixel.alpha().unwrap_or(1.0))).round() as u8]
    };
    (0..image.width()).map(|x| bytes(image.pixel(x, y))).collect::<Vec<_>>().into_flattened()
}

/// The same for the whole image.
pub fn eight_bit(image: &Image, options: &WriteOptions) -> (Vec<u8>, u8) {
    let (rows, channels) = eight_bit_rows(image, options);
    (rows.collect::<Vec<_>>().concat(), channels)
}

/// The samples as an image; the caller has made them fit.
pub fn finish(
    format: Format,
    size: (u32, u32),
    channels: u32,
    samples: impl Into<Storage>,
    was_srgb: bool,
) -> Decoded {
    let image = Image::from_storage(size.0, size.1, channels, samples.into())
        .expect("the decoder has made as many samples as the size says");
    Decoded { image, was_srgb, format, metadata: Vec::new() }
}

/// How the colour samples of a file become linear. Alpha is always linear.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Transfer {
    Linear,
    Srgb,
    /// Power law: linear = encoded ^ exponent.
    Power(f32),
}

impl Transfer {
    /// The transfer of a format whose own one is `auto`.
    pub fn of(space: ColorSpace, auto: Self) -> Self {
        match space {
            ColorSpace::Auto => auto,
            ColorSpace::Linear => Self::Linear,
            ColorSpace::Srgb => Self::Srgb,
        }
    }

    pub fn apply(self, encoded: f32) -> f32 {
        match self {
            Self::Linear => encoded,
            Self::Srgb => srgb_decode(encoded),
            Self::Power(exponent) => penombre_math::float::pow(encoded, exponent),
        }
    }

    /// Linear values of the integers 0 to `max`.
    pub fn table(self, max: u16) -> Vec<f32> {
        (0..=max).map(|code| self.apply(f32::from(code) / f32::from(max))).collect()
    }

    /// Makes float samples linear in place.
    pub fn apply_to_colors(self, samples: &mut [f32], channels: u32) {
        if self == Self::Linear {
            return;
        }
        let colors = if channels >= 3 { 3 } else { 1 };
        for pixel in samples.chunks_exact_mut(channels as usize) {
            for sample in &mut pixel[..colors] {
                *sample = self.apply(*sample);
            }
        }
    }
}

/// The numbers of a file, 0 to `max`, as samples: of one byte, or of two with the high one first if `max` is above 255.
pub fn coded(bytes: Vec<u8>, max: u16, transfer: Transfer) -> Codes {
    if max > 255 {
        Codes::Wide { bytes, tables: tables(max, transfer) }
    } else {
        Codes::Narrow { bytes, tables: tables(max, transfer) }
    }
}

fn tables<const N: usize>(max: u16, transfer: Transfer) -> Tables<N> {
    // There are no numbers above `max`.
    let table = |transfer: Transfer| {
        let mut values = transfer.table(max);
        values.resize(N, 0.0);
        Arc::from(<Box<[f32; N]>>::try_from(values).expect("of that length"))
    };
    let alpha: Arc<[f32; N]> = table(Transfer::Linear);
    Tables { color: if transfer == Transfer::Linear { alpha.clone() } else { table(transfer) }, alpha }
}

/// Keeps the first `kept` bytes of each pixel of `stored` bytes.
pub fn keep_first(bytes: &mut Vec<u8>, stored: usize, kept: usize) {
    let pixels = bytes.len() / stored;
    for i in 0..pixels {
        bytes.copy_within(i * stored..i * stored + kept, i * kept);
    }
    bytes.truncate(pixels * kept);
    bytes.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_files_do_not_become_gigabytes() {
        let check = |format, side: u64, length: usize| {
            let bytes = vec![0; length];
            Source::new(format, &bytes).check_size(side, side, png::PIXELS_PER_BYTE).is_ok()
        };
        // Pictures of one colour, as large as they are in practice: 1 bit, a byte and three bytes for a pixel.
        let png = |side, length| check(Format::Png, side, length);
        assert!(png(4096, 2_200) && png(8192, 8_500) && png(8192, 66_000) && png(8192, 211_851));
        assert!(!png(16_000, 31_500) && !png(16_000, 775_221));
        assert!(png(16_000, 8_000_000) && !png(16_400, 500_000_000));
        let exr = |side, length| check(Format::Exr, side, length);
        assert!(exr(4096, 2_200) && exr(8192, 66_000) && !exr(8192, 8_500) && !exr(16_000, 775_221));
    }
}
