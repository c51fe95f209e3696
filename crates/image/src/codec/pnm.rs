//! Netpbm \[Netpbm\]: P1 to P6 in, P5, P6 and the course program's P3 out.

use super::{Result, Source, Transfer, coded, finish};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use crate::tone::{quantise, unit};
use penombre_math::color::luminance;
use penombre_math::float;
use std::io::Write;

/// P6, or P3 as the course program writes it.
pub fn encode_ppm(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    if options.course_ppm {
        return encode_course(image, options.exposure, w);
    }
    write!(w, "P6\n{} {}\n255\n", image.width(), image.height())?;
    w.write_all(&quantise(image, options.tone, options.exposure))?;
    Ok(())
}

/// P5 of the luminance.
pub fn encode_pgm(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    write!(w, "P5\n{} {}\n255\n", image.width(), image.height())?;
    let grey = if image.channels() < 3 {
        image.clone()
    } else {
        let data = image.rgb_pixels().map(luminance).collect();
        Image::from_data(image.width(), image.height(), 1, data).expect("one sample for each pixel")
    };
    let bytes = quantise(&grey, options.tone, options.exposure);
    let bytes: Vec<u8> = bytes.into_iter().step_by(3).collect();
    w.write_all(&bytes)?;
    Ok(())
}

/// Header on three lines, then every value and a blank on one line, truncated to whole numbers.
fn encode_course(image: &Image, exposure: f32, w: &mut dyn Write) -> Result<()> {
    write!(w, "P3\n{} {}\n255\n", image.width(), image.height())?;
    let gain = float::exp2(exposure);
    let mut line = Vec::with_capacity(image.pixel_count() * 12 + 1);
    for value in image.rgb_pixels().flatten() {
        // The cast cuts the fraction off, as the course program's does.
        let byte = (255.0 * unit(gain * value)) as u8;
        write!(line, "{byte} ")?;
    }
    line.push(b'\n');
    w.write_all(&line)?;
    Ok(())
}

/// What the header says.
struct Header {
    /// The digit after the P.
    kind: u8,
    width: u32,
    height: u32,
    max: u16,
}

impl Header {
    fn channels(&self) -> u32 {
        if matches!(self.kind, b'3' | b'6') { 3 } else { 1 }
    }

    fn is_bitmap(&self) -> bool {
        matches!(self.kind, b'1' | b'4')
    }

    fn sample_bytes(&self) -> usize {
        if self.max > 255 { 2 } else { 1 }
    }

    fn sample_count(&self) -> usize {
        self.width as usize * self.height as usize * self.channels() as usize
    }
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let format = Format::from_content(bytes).unwrap_or(Format::Ppm);
    let mut source = Source::new(format, bytes);
    let header = read_header(&mut source)?;
    let channels = header.channels();
    let auto = if header.is_bitmap() { Transfer::Linear } else { Transfer::Srgb };
    let transfer = Transfer::of(space, auto);
    let bytes = match header.kind {
        b'1' => plain_bits(&mut source, &header)?,
        b'2' | b'3' => plain_numbers(&mut source, &header)?,
        b'4' => packed_bits(&mut source, &header)?,
        _ => binary_numbers(&mut source, &header)?,
    };
    let samples = coded(bytes, header.max, transfer);
    let size = (header.width, header.height);
    Ok(finish(format, size, channels, samples, transfer != Transfer::Linear))
}

fn read_header(source: &mut Source<'_>) -> Result<Header> {
    let kind = source.take(2, "the mark")?[1];
    let width = number(source, "a width")?;
    let height = number(source, "a height")?;
    let bitmap = matches!(kind, b'1' | b'4');
    let before = source.at;
    let max = if bitmap { 1 } else { number(source, "a largest value")? };
    let max = match u16::try_from(max) {
        Ok(max) if max > 0 => max,
        _ => {
            source.at = before;
            return Err(source.fault(format!("a largest value of {max}"), "1 to 65535"));
        }
    };
    // Text files have 1 byte for each bit, binary ones 8 bits in a byte.
    let (width, height) = source.check_size(width.into(), height.into(), if bitmap { 8 } else { 1 })?;
    if kind >= b'4' {
        match source.byte() {
            Some(b) if b.is_ascii_whitespace() => {}
            _ => return Err(source.fault("no blank after the header", "one blank before the pixels")),
        }
    }
    Ok(Header { kind, width, height, max })
}

/// Skips blanks and comments (`#` to the end of the line).
fn skip_blanks(source: &mut Source<'_>) {
    while let Some(byte) = source.peek() {
        if byte == b'#' {
            while source.peek().is_some_and(|b| b != b'\n' && b != b'\r') {
                source.at += 1;
            }
        } else if byte.is_ascii_whitespace() {
            source.at += 1;
        } else {
            return;
        }
    }
}

/// The next whole number in decimal.
fn number(source: &mut Source<'_>, what: &str) -> Result<u32> {
    skip_blanks(source);
    let start = source.at;
    let mut value = 0u32;
    while let Some(digit) = source.peek().filter(u8::is_ascii_digit) {
        let longer = value.checked_mul(10).and_then(|v| v.checked_add(u32::from(digit - b'0')));
        let Some(longer) = longer else {
            source.at = start;
            return Err(source.fault("a number above 4294967295", what));
        };
        value = longer;
        source.at += 1;
    }
    if source.at == start {
        return Err(source.fault(found_here(source), format!("{what}: a whole number")));
    }
    Ok(value)
}

fn found_here(source: &Source<'_>) -> String {
    match source.peek() {
        None => "the end of the file".to_owned(),
        Some(byte) => format!("'{}'", byte.escape_ascii()),
    }
}

/// Numbers in decimal, as they are kept: in a byte, or in two with the high one first if the largest is above 255.
fn plain_numbers(source: &mut Source<'_>, header: &Header) -> Result<Vec<u8>> {
    let count = header.sample_count();
    // Each number but the last takes two bytes at least.
    require(source, count.saturating_mul(2).saturating_sub(1), count)?;
    let mut bytes = Vec::with_capacity(count * header.sample_bytes());
    for _ in 0..count {
        let value = number(source, "a pixel value")?;
        match u16::try_from(value) {
            Ok(v) if v <= header.max => bytes.extend(&v.to_be_bytes()[2 - header.sample_bytes()..]),
            _ => return Err(too_bright(source, value, header.max)),
        }
    }
    Ok(bytes)
}

fn too_bright(source: &Source<'_>, value: u32, max: u16) -> ImageErrorKind {
    source
        .fault(format!("a pixel value of {value}"), format!("at most {max}, the largest value of the header"))
}

fn require(source: &Source<'_>, bytes: usize, samples: usize) -> Result<()> {
    let rest = source.rest().len();
    if rest < bytes {
        return Err(source.fault(format!("{rest} more bytes"), format!("{samples} pixel values")));
    }
    Ok(())
}

/// Digits 0 (white) and 1 (black), which need no blanks between them.
fn plain_bits(source: &mut Source<'_>, header: &Header) -> Result<Vec<u8>> {
    let count = header.sample_count();
    require(source, count, count)?;
    let mut codes = Vec::with_capacity(count);
    for _ in 0..count {
        skip_blanks(source);
        match source.peek() {
            Some(bit @ (b'0' | b'1')) => codes.push(u8::from(bit == b'0')),
            _ => return Err(source.fault(found_here(source), "0 or 1")),
        }
        source.at += 1;
    }
    Ok(codes)
}

/// Eight pixels in a byte, rows padded to whole bytes, 1 is black.
fn packed_bits(source: &mut Source<'_>, header: &Header) -> Result<Vec<u8>> {
    let width = header.width as usize;
    let stride = width.div_ceil(8);
    let pixels = source.take(stride * header.height as usize, "pixels")?;
    let bit = |row: &[u8], x: usize| u8::from(row[x / 8] >> (7 - x % 8) & 1 == 0);
    Ok(pixels.chunks_exact(stride).flat_map(|row| (0..width).map(move |x| bit(row, x))).collect())
}

/// One byte for each value, or two, the high one first, if the largest value is above 255.
fn binary_numbers(source: &mut Source<'_>, header: &Header) -> Result<Vec<u8>> {
    let (start, size) = (source.at, header.sample_bytes());
    let pixels = source.take(header.sample_count() * size, "pixels")?;
    let value = |bytes: &[u8]| bytes.iter().fold(0, |value, byte| value << 8 | u32::from(*byte));
    let mut values = pixels.chunks_exact(size).map(value);
    if let Some(i) = values.position(|v| v > header.max.into()) {
        source.at = start + i * size;
        return Err(too_bright(source, value(&pixels[i * size..][..size]), header.max));
    }
    Ok(pixels.to_vec())
}
