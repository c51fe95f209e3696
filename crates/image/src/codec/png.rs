//! PNG: 8-bit colour, and alpha, out; every depth and colour type in.

mod chunks;
mod fault;
mod palette;

use super::{Result, Source, Transfer, coded, eight_bit_rows, finish, zeroed};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use crate::tone::ToneCurve;
use ::png::{BitDepth, ColorType, DecodeOptions, Decoder, Encoder, EncodingError, Info, Transformations};
use fault::Fault;
use std::io::{Cursor, Write};

/// Deflate makes at best 1032 bytes of one, and a byte holds up to 8 pixels.
pub const PIXELS_PER_BYTE: u64 = 1040 * 8;

/// Bytes of unpacked pixels from which on a file is read twice: first to see that it is whole, with no memory for them.
const LARGE: u64 = 1 << 26;

/// Bytes of the picture in a chunk of a file that is written.
const PART: usize = 1 << 16;

/// Longest compressed text that is unpacked, in bytes.
const MAX_TEXT: usize = 1 << 20;

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    encode_rows(image, options, w).map_err(|error| match error {
        EncodingError::IoError(e) => ImageErrorKind::Io(e),
        other => ImageErrorKind::NotWritable { format: Format::Png, reason: other.to_string() },
    })
}

fn encode_rows(
    image: &Image,
    options: &WriteOptions,
    w: &mut dyn Write,
) -> std::result::Result<(), EncodingError> {
    let (rows, channels) = eight_bit_rows(image, options);
    let mut encoder = Encoder::new(w, image.width(), image.height());
    encoder.set_color(if channels == 4 { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    if options.tone != ToneCurve::Raw {
        encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    }
    if options.tone != ToneCurve::Srgb {
        encoder.add_text_chunk(TONE_KEY.to_owned(), options.tone.to_string())?;
    }
    for (name, text) in &options.metadata {
        if text.chars().all(|c| u32::from(c) < 256) {
            encoder.add_text_chunk(name.clone(), text.clone())?;
        } else {
            encoder.add_itxt_chunk(name.clone(), text.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer_with_size(PART)?;
    for row in rows {
        stream.write_all(&row)?;
    }
    stream.finish()?;
    writer.finish()
}

/// Names the tone curve of a picture that is not simply sRGB. A `raw` picture is *shown* as the course showed its own,
/// without a curve, which no chunk of the format says; reading it back we know what the values mean. The others show
/// display light as sRGB, which is what they are read back as.
const TONE_KEY: &str = "penombre:tone";

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let still = chunks::check(bytes)?;
    let mut cursor = Cursor::new(&*still.bytes);
    decode_from(&mut cursor, still.size, space).map_err(|fault| {
        let at = still.place(cursor.position() as usize);
        fault.told(&Source { format: Format::Png, bytes, at })
    })
}

fn decode_from(
    cursor: &mut Cursor<&[u8]>,
    (width, height): (u32, u32),
    space: ColorSpace,
) -> std::result::Result<Decoded, Fault> {
    check_rows(cursor)?;
    cursor.set_position(0);
    let mut reader = opened(cursor).read_info()?;
    let (color, depth) = reader.output_color_type();
    let channels = color.samples() as u32;
    let sample = if depth == BitDepth::Sixteen { 2 } else { 1 };
    let mut buffer = zeroed::<u8>(width, height, channels * sample).map_err(Fault::Ours)?;
    let used = reader.next_frame(&mut buffer)?.buffer_size();
    buffer.truncate(used);
    reader.finish()?;
    let transfer = Transfer::of(space, own_transfer(reader.info()));
    let samples = coded(buffer, if sample == 2 { u16::MAX } else { 255 }, transfer);
    let was_srgb = transfer != Transfer::Linear;
    let mut decoded = finish(Format::Png, (width, height), channels, samples, was_srgb);
    decoded.metadata = texts(reader.info());
    Ok(decoded)
}

fn opened<'a, 'b>(cursor: &'a mut Cursor<&'b [u8]>) -> Decoder<&'a mut Cursor<&'b [u8]>> {
    let mut options = DecodeOptions::default();
    options.set_ignore_adler32(false);
    // The sums of the chunks have been checked.
    options.set_ignore_crc(true);
    options.set_ignore_iccp_chunk(true);
    let mut decoder = Decoder::new_with_options(cursor, options);
    decoder.set_transformations(Transformations::EXPAND);
    decoder
}

/// Reads all rows of a large picture, and of one with fewer colours than its samples can name, and keeps none.
fn check_rows(cursor: &mut Cursor<&[u8]>) -> std::result::Result<(), Fault> {
    let mut decoder = opened(cursor);
    decoder.set_transformations(Transformations::IDENTITY);
    let mut reader = decoder.read_info()?;
    let info = reader.info();
    let bits = u64::from(info.bit_depth as u8) * info.color_type.samples() as u64;
    let is_large = u64::from(info.width) * u64::from(info.height) * bits / 8 > LARGE;
    let palette = palette::Short::of(info);
    if !is_large && palette.is_none() {
        return Ok(());
    }
    let mut widths = palette::row_widths(info);
    while let Some(row) = reader.next_interlaced_row()? {
        if let (Some(palette), Some(width)) = (&palette, widths.next()) {
            palette.check(row.data(), width)?;
        }
    }
    Ok(())
}

/// sRGB unless the file states another gamma (and neither that it is sRGB nor a profile), or is our own without one.
fn own_transfer(info: &Info<'_>) -> Transfer {
    let raw = ToneCurve::Raw.to_string();
    if info.uncompressed_latin1_text.iter().any(|t| t.keyword == TONE_KEY && t.text == raw) {
        return Transfer::Linear;
    }
    let stated = info.gama_chunk.map(|g| g.into_value());
    match stated {
        Some(gamma) if info.srgb.is_none() && gamma > 0.0 => {
            // 0.45455 is what programs write for sRGB.
            if (gamma - 0.45455).abs() < 0.005 {
                Transfer::Srgb
            } else if (gamma - 1.0).abs() < 1e-4 {
                Transfer::Linear
            } else {
                Transfer::Power(1.0 / gamma)
            }
        }
        _ => Transfer::Srgb,
    }
}

fn texts(info: &Info<'_>) -> Vec<(String, String)> {
    let plain = info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let utf8 = info.utf8_text.iter().filter_map(|t| {
        let mut t = t.clone();
        t.decompress_text_with_limit(MAX_TEXT).ok()?;
        Some((t.keyword.clone(), t.get_text().ok()?))
    });
    let packed = info.compressed_latin1_text.iter().filter_map(|t| {
        let mut t = t.clone();
        t.decompress_text_with_limit(MAX_TEXT).ok()?;
        Some((t.keyword.clone(), t.get_text().ok()?))
    });
    plain.chain(utf8).chain(packed).collect()
}
