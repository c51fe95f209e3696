//! The size of an image from the beginning of its file, without decoding it: for estimates of memory.

use crate::codec;
use crate::format::Format;
use crate::io::MAX_PIXELS;
use std::path::Path;

/// Bytes of a file that [`probe`] wants to see: the size of a picture stands before its pixels, but behind what
/// cameras write into JPEG files.
pub const PROBE_BYTES: u64 = 1 << 18;

/// Pixels that a byte of a JPEG file holds, where no size is found: more than in any photograph worth looking at.
const JPEG_PIXELS_PER_BYTE: u64 = 16;

/// What a file says of its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Width in pixels.
    pub width: u64,
    /// Height in pixels.
    pub height: u64,
    /// Samples per pixel, at least as many as the decoded image has.
    pub channels: u32,
    /// Bytes of a sample of the decoded image: 1, 2 or 4.
    pub sample_bytes: u32,
    /// Bytes that decoding takes besides for each sample, at most.
    pub spare_bytes: u32,
}

impl ImageSize {
    /// Memory that the image takes, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.samples().saturating_mul(self.sample_bytes.into())
    }

    /// Memory that decoding takes besides, bytes.
    #[must_use]
    pub fn decoding_bytes(&self) -> u64 {
        self.samples().saturating_mul(self.spare_bytes.into())
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.pixels().saturating_mul(self.channels.into())
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.width.saturating_mul(self.height)
    }
}

/// The size of the image in a file of `length` bytes that begins with `head`, its first [`PROBE_BYTES`]. `name`: as for
/// [`decode`](crate::decode). `None` if [`decode`](crate::decode) will refuse the file before it takes memory for pixels:
/// it is no image, or one that so many bytes cannot hold.
#[must_use]
pub fn probe(head: &[u8], length: u64, name: &Path) -> Option<ImageSize> {
    let format = Format::of_file(head, name)?;
    let found = match format {
        Format::Png => png(head),
        Format::Jpeg => jpeg(head).or_else(|| unknown_jpeg(length)),
        Format::Ppm | Format::Pgm => netpbm(format, head),
        Format::Pfm => {
            let [width, height, _] = numbers(head.get(2..)?);
            sized(format, [width?, height?], if head[1] == b'F' { 3 } else { 1 }, 4)
        }
        Format::Exr => exr(head),
        Format::Hdr => hdr(head),
        Format::Tga => sized(format, [word(head, 12)?, word(head, 14)?], 4, 1),
        Format::Bmp => bmp(head),
        Format::Webp => webp(head),
        Format::Gif => sized(format, [word(head, 6)?, word(head, 8)?], 4, 1),
    };
    found.filter(|size| size.pixels() <= MAX_PIXELS.min(codec::most_pixels(format, length)))
}

/// Coefficients of all blocks of progressive JPEG files, a second picture of WebP and GIF; the rest is decoded where it
/// stays.
fn spare_bytes(format: Format) -> u32 {
    match format {
        Format::Jpeg => 2,
        Format::Webp | Format::Gif => 1,
        Format::Ppm
        | Format::Pgm
        | Format::Png
        | Format::Pfm
        | Format::Exr
        | Format::Hdr
        | Format::Tga
        | Format::Bmp => 0,
    }
}

fn sized(format: Format, [width, height]: [u64; 2], channels: u32, sample_bytes: u32) -> Option<ImageSize> {
    let size = ImageSize { width, height, channels, sample_bytes, spare_bytes: spare_bytes(format) };
    (width > 0 && height > 0).then_some(size)
}

/// Two bytes, the lower one first.
fn word(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?)))
}

/// Four bytes, the lowest first, with a sign.
fn signed(bytes: &[u8], at: usize) -> Option<i64> {
    Some(i64::from(i32::from_le_bytes(*bytes.get(at..)?.first_chunk()?)))
}

fn png(head: &[u8]) -> Option<ImageSize> {
    let side = |at: usize| Some(u64::from(u32::from_be_bytes(*head.get(at..)?.first_chunk()?)));
    // Kinds: 0 grey, 2 colour, 3 table, 4 grey and alpha, 6 colour and alpha; a separate chunk may add alpha.
    let channels = match *head.get(25)? {
        0 | 4 => 2,
        _ => 4,
    };
    let has_alpha = matches!(head[25], 4 | 6) || head.windows(4).any(|w| w == b"tRNS");
    let sample_bytes = if head[24] == 16 { 2 } else { 1 };
    sized(Format::Png, [side(16)?, side(20)?], channels - u32::from(!has_alpha), sample_bytes)
}

fn jpeg(head: &[u8]) -> Option<ImageSize> {
    let at = codec::jpeg::first_segment(head, codec::jpeg::is_frame)?;
    let side = |at: usize| Some(u64::from(u16::from_be_bytes(*head.get(at..)?.first_chunk()?)));
    let channels = if *head.get(at + 9)? == 1 { 1 } else { 3 };
    sized(Format::Jpeg, [side(at + 7)?, side(at + 5)?], channels, 1)
}

/// The frame lies behind what was looked at.
fn unknown_jpeg(length: u64) -> Option<ImageSize> {
    let pixels = length.saturating_mul(JPEG_PIXELS_PER_BYTE).min(MAX_PIXELS);
    sized(Format::Jpeg, [pixels, 1], 3, 1)
}

/// Width, height and the largest value as text; of bitmaps there is no largest value.
fn netpbm(format: Format, head: &[u8]) -> Option<ImageSize> {
    let [width, height, max] = numbers(head.get(2..)?);
    let is_wide = !matches!(head[1], b'1' | b'4') && max.is_none_or(|max| max > 255);
    let channels = if format == Format::Ppm { 3 } else { 1 };
    sized(format, [width?, height?], channels, if is_wide { 2 } else { 1 })
}

/// The next three whole numbers, behind blanks and comments.
fn numbers(mut bytes: &[u8]) -> [Option<u64>; 3] {
    std::array::from_fn(|_| {
        loop {
            bytes = bytes.trim_ascii_start();
            if bytes.first() != Some(&b'#') {
                break;
            }
            bytes = &bytes[bytes.iter().position(|b| *b == b'\n' || *b == b'\r')?..];
        }
        let end = bytes.iter().position(|b| !b.is_ascii_digit())?;
        let (number, rest) = bytes.split_at(end);
        bytes = rest;
        std::str::from_utf8(number).ok()?.parse().ok()
    })
}

fn exr(head: &[u8]) -> Option<ImageSize> {
    let behind = |mark: &[u8]| head.windows(mark.len()).position(|w| w == mark).map(|at| at + mark.len());
    let window = behind(b"dataWindow\0box2i\0")? + 4;
    let corner = |i: usize| signed(head, window + 4 * i);
    let sides = [corner(2)? - corner(0)? + 1, corner(3)? - corner(1)? + 1].map(|n| u64::try_from(n).ok());
    // A name, a zero and 16 bytes for each channel; of several layers one is decoded.
    let mut list = head.get(behind(b"channels\0chlist\0")? + 4..)?;
    let mut channels = 0;
    while channels < 4 && *list.first()? != 0 {
        list = list.get(list.iter().position(|b| *b == 0)? + 17..)?;
        channels += 1;
    }
    sized(Format::Exr, [sides[0]?, sides[1]?], channels.max(1), 4)
}

fn hdr(head: &[u8]) -> Option<ImageSize> {
    let line = head.split(|b| *b == b'\n').skip_while(|line| !line.trim_ascii().is_empty()).nth(1)?;
    let words: Vec<&str> = std::str::from_utf8(line).ok()?.split_whitespace().collect();
    let [first, a, _, b] = words[..] else { return None };
    let (width, height) = if first.ends_with('X') { (a, b) } else { (b, a) };
    sized(Format::Hdr, [width.parse().ok()?, height.parse().ok()?], 3, 4)
}

fn bmp(head: &[u8]) -> Option<ImageSize> {
    let ([width, height], _) = codec::packed::bmp_size(head).ok()?;
    sized(Format::Bmp, [width, height], 4, 1)
}

fn webp(head: &[u8]) -> Option<ImageSize> {
    let [width, height] = codec::packed::webp_size(head)?.map(u64::from);
    sized(Format::Webp, [width, height], if &head[12..16] == b"VP8 " { 3 } else { 4 }, 1)
}
