//! Truevision TGA \[TGA\]: colour tables, colour and grey, plain or run-length coded, in; plain colour out.

use super::{Result, Source, Transfer, coded, eight_bit, finish, keep_first};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use std::io::Write;

/// Bytes before the image's name.
const HEADER: usize = 18;

/// A packet of two bytes makes 128 pixels at best.
pub const PIXELS_PER_BYTE: u64 = 64;

/// Bit of the descriptor: the first column is the right one.
const FROM_RIGHT: u8 = 0x10;

/// Bit of the descriptor: the first row is the upper one.
const FROM_TOP: u8 = 0x20;

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let side = |n: u32| {
        u16::try_from(n).map(u16::to_le_bytes).map_err(|_| ImageErrorKind::NotWritable {
            format: Format::Tga,
            reason: format!("a side of {n} pixels is longer than 65535"),
        })
    };
    let (width, height) = (side(image.width())?, side(image.height())?);
    let (mut bytes, channels) = eight_bit(image, options);
    let alpha_bits = if channels == 4 { 8 } else { 0 };
    w.write_all(&[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0])?;
    w.write_all(&[width, height].concat())?;
    w.write_all(&[8 * channels, FROM_TOP | alpha_bits])?;
    for pixel in bytes.chunks_exact_mut(channels.into()) {
        pixel.swap(0, 2);
    }
    w.write_all(&bytes)?;
    Ok(())
}

/// Whether these first bytes of a file can be a TGA header: the format has no mark of its own.
pub fn is_plausible(bytes: &[u8]) -> bool {
    // A colour table comes with kinds 1 and 9; without one its fields are zero.
    let header: Option<&[u8; HEADER]> = bytes.first_chunk();
    header.is_some_and(|h| {
        let table = matches!(h[2], 1 | 9);
        let fields = if table { matches!(h[7], 15 | 16 | 24 | 32) } else { h[3..8] == [0; 5] };
        let sides = h[12..14] != [0; 2] && h[14..16] != [0; 2];
        let depth = if table { matches!(h[16], 8 | 16) } else { matches!(h[16], 8 | 15 | 16 | 24 | 32) };
        matches!(h[2], 1 | 2 | 3 | 9 | 10 | 11)
            && h[1] == u8::from(table)
            && fields
            && sides
            && depth
            && h[17] & 0xc0 == 0
    })
}

/// What the bits of a pixel, or of an entry of the colour table, are.
#[derive(Clone, Copy, PartialEq)]
enum Texel {
    Grey,
    GreyAlpha,
    /// Five bits each, and whether the sixteenth is alpha.
    Five(bool),
    Bgr,
    /// Four bytes, and whether the last is alpha.
    Four(bool),
}

impl Texel {
    fn of_color(bits: u8, alpha_bits: u8) -> Option<Self> {
        match bits {
            15 => Some(Self::Five(false)),
            16 => Some(Self::Five(alpha_bits > 0)),
            24 => Some(Self::Bgr),
            32 => Some(Self::Four(alpha_bits > 0)),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha | Self::Five(_) => 2,
            Self::Bgr => 3,
            Self::Four(_) => 4,
        }
    }

    fn channels(self) -> u32 {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha => 2,
            Self::Five(false) | Self::Bgr | Self::Four(false) => 3,
            Self::Five(true) | Self::Four(true) => 4,
        }
    }

    fn max(self) -> u16 {
        if matches!(self, Self::Five(_)) { 31 } else { 255 }
    }

    /// Red, green, blue and alpha (or grey and alpha) of so many bytes.
    fn codes(self, b: &[u8]) -> [u8; 4] {
        match self {
            Self::Grey => [b[0], 0, 0, 0],
            Self::GreyAlpha => [b[0], b[1], 0, 0],
            Self::Five(_) => {
                let word = u16::from_le_bytes([b[0], b[1]]);
                let five = |shift: u16| (word >> shift & 31) as u8;
                [five(10), five(5), five(0), if word >> 15 == 1 { 31 } else { 0 }]
            }
            Self::Bgr => [b[2], b[1], b[0], 255],
            Self::Four(_) => [b[2], b[1], b[0], b[3]],
        }
    }
}

/// What the header says.
struct Header {
    width: u32,
    height: u32,
    descriptor: u8,
    packed: bool,
    /// What one pixel is in the file: bytes, and their meaning unless they are an index.
    stored: usize,
    texel: Texel,
    /// The first index of the colour table, and its entries.
    table: Option<(usize, Vec<[u8; 4]>)>,
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let mut source = Source::new(Format::Tga, bytes);
    let header = read_header(&mut source)?;
    let (width, channels) = (header.width as usize, header.texel.channels());
    let count = width * header.height as usize;
    let mut pixels = read_pixels(&mut source, &header, count)?;
    if header.descriptor & FROM_RIGHT != 0 {
        pixels.chunks_exact_mut(width).for_each(<[_]>::reverse);
    }
    if header.descriptor & FROM_TOP == 0 {
        pixels.reverse();
        pixels.chunks_exact_mut(width).for_each(<[_]>::reverse);
    }
    let transfer = Transfer::of(space, Transfer::Srgb);
    let mut codes = pixels.into_flattened();
    keep_first(&mut codes, 4, channels as usize);
    let samples = coded(codes, header.texel.max(), transfer);
    let size = (header.width, header.height);
    Ok(finish(Format::Tga, size, channels, samples, transfer != Transfer::Linear))
}

fn read_header(source: &mut Source<'_>) -> Result<Header> {
    let h = source.take(HEADER, "the header")?;
    let word = |at: usize| u16::from_le_bytes([h[at], h[at + 1]]);
    let (kind, bits, descriptor) = (h[2], h[16], h[17]);
    let at = |at: usize| source.placed(at);
    if !matches!(kind, 1 | 2 | 3 | 9 | 10 | 11) {
        return Err(at(2).unsupported(format!("kind {kind}"), "kind 1, 2, 3, 9, 10 or 11"));
    }
    if descriptor & 0xc0 != 0 {
        return Err(at(17).unsupported("interleaved rows", "rows in order"));
    }
    let alpha_bits = descriptor & 15;
    let (texel, depths) = match kind & 3 {
        1 if matches!(bits, 8 | 16) => (Texel::of_color(h[7], alpha_bits), "a colour table"),
        1 => (None, "indices of 8 or 16 bits"),
        2 => (Texel::of_color(bits, alpha_bits), "15, 16, 24 or 32 bits"),
        _ => match (bits, alpha_bits) {
            (8, _) => (Some(Texel::Grey), ""),
            (16, 8) => (Some(Texel::GreyAlpha), ""),
            _ => (None, "grey of 8 bits, or 16 with alpha"),
        },
    };
    let Some(texel) = texel else {
        let found = format!("{bits} bits for a pixel and {} for an entry of the table", h[7]);
        return Err(at(16).unsupported(found, depths));
    };
    let packed = kind > 8;
    let ratio = if packed { PIXELS_PER_BYTE } else { 1 };
    let (width, height) = at(12).check_size(word(12).into(), word(14).into(), ratio)?;
    source.take(h[0].into(), "the name of the image")?;
    let table = read_table(source, h, kind & 3 == 1, alpha_bits)?;
    let stored = if table.is_some() { usize::from(bits / 8) } else { texel.bytes() };
    Ok(Header { width, height, descriptor, packed, stored, texel, table })
}

/// The colour table, if the pixels need it; else it is skipped.
fn read_table(
    source: &mut Source<'_>,
    h: &[u8],
    needed: bool,
    alpha_bits: u8,
) -> Result<Option<(usize, Vec<[u8; 4]>)>> {
    if h[1] == 0 && !needed {
        return Ok(None);
    }
    let word = |at: usize| usize::from(u16::from_le_bytes([h[at], h[at + 1]]));
    let place = source.placed(1);
    if h[1] != 1 {
        return Err(place.fault(format!("a colour table of kind {}", h[1]), "kind 1"));
    }
    let (first, length) = (word(3), word(5));
    let Some(texel) = Texel::of_color(h[7], alpha_bits) else {
        let place = source.placed(7);
        return Err(place.fault(format!("table entries of {} bits", h[7]), "15, 16, 24 or 32"));
    };
    let entries = source.take(length * texel.bytes(), "the colour table")?;
    let entries = entries.chunks_exact(texel.bytes()).map(|e| texel.codes(e)).collect();
    Ok(needed.then_some((first, entries)))
}

/// All pixels in the order of the file.
fn read_pixels(source: &mut Source<'_>, header: &Header, count: usize) -> Result<Vec<[u8; 4]>> {
    let size = header.stored;
    let mut pixels = Vec::new();
    if !header.packed {
        let start = source.at;
        for (i, stored) in source.take(count * size, "pixels")?.chunks_exact(size).enumerate() {
            let place = source.placed(start + i * size);
            pixels.push(pixel(&place, header, stored)?);
        }
        return Ok(pixels);
    }
    while pixels.len() < count {
        let place = source.placed(source.at);
        let code = source.take(1, "a packet of pixels")?[0];
        let length = usize::from(code & 0x7f) + 1;
        let left = count - pixels.len();
        if length > left {
            let found = format!("a packet of {length} pixels");
            return Err(place.fault(found, format!("at most {left}, the rest of the picture")));
        }
        if code & 0x80 != 0 {
            let one = pixel(&place, header, source.take(size, "a pixel")?)?;
            pixels.resize(pixels.len() + length, one);
        } else {
            for stored in source.take(length * size, "a packet of pixels")?.chunks_exact(size) {
                pixels.push(pixel(&place, header, stored)?);
            }
        }
    }
    Ok(pixels)
}

/// The colour that the bytes of a pixel stand for.
fn pixel(place: &Source<'_>, header: &Header, stored: &[u8]) -> Result<[u8; 4]> {
    let Some((first, entries)) = &header.table else { return Ok(header.texel.codes(stored)) };
    let index = stored.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
    index.checked_sub(*first).and_then(|i| entries.get(i)).copied().ok_or_else(|| {
        let last = first + entries.len();
        place.fault(format!("colour {index}"), format!("colours {first} to below {last} of the table"))
    })
}
