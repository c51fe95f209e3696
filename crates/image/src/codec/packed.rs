//! BMP \[BMP\], GIF \[GIF\] (its first frame) and WebP \[WebP\], by the decoders and encoders of the `image` library.

mod bmp;
mod gif;
mod webp;

use super::{Result, Source, Transfer, coded, eight_bit, expected, finish, keep_first, zeroed};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use ::image::codecs::bmp::{BmpDecoder, BmpEncoder};
use ::image::codecs::gif::GifDecoder;
use ::image::codecs::webp::{WebPDecoder, WebPEncoder};
use ::image::{ColorType, ExtendedColorType, ImageDecoder, ImageError, ImageResult, Limits};
use std::io::{Cursor, ErrorKind, Write};

/// Pixels that a file of any length may have: these formats can leave out what has the colour of the ground, or need no
/// bits at all for a picture of one colour.
pub const SMALL: u64 = 1 << 24;

/// Memory beside the pixels that a decoder may take, bytes.
const SPARE: u64 = 1 << 26;

/// At best: 8 pixels in a byte, or 255 in a run of two bytes.
pub const BMP_PIXELS_PER_BYTE: u64 = 128;

/// A code of 12 bits stands for at most 4096 pixels.
pub const GIF_PIXELS_PER_BYTE: u64 = 2731;

/// Four times what a large lossy picture of one colour takes in practice.
pub const WEBP_PIXELS_PER_BYTE: u64 = 2048;

pub fn encode_bmp(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let (bytes, channels) = eight_bit(image, options);
    let mut file = Vec::new();
    let written = BmpEncoder::new(&mut file).encode(&bytes, image.width(), image.height(), kind_of(channels));
    written.map_err(|e| unwritable(Format::Bmp, &e))?;
    w.write_all(&file)?;
    Ok(())
}

pub fn encode_webp(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    if image.width().max(image.height()) > 1 << 14 {
        let reason = format!("{} × {} pixels, more than 16384 on a side", image.width(), image.height());
        return Err(ImageErrorKind::NotWritable { format: Format::Webp, reason });
    }
    let (bytes, channels) = eight_bit(image, options);
    let mut file = Vec::new();
    let encoder = WebPEncoder::new_lossless(&mut file);
    let written = encoder.encode(&bytes, image.width(), image.height(), kind_of(channels));
    written.map_err(|e| unwritable(Format::Webp, &e))?;
    w.write_all(&file)?;
    Ok(())
}

fn kind_of(channels: u8) -> ExtendedColorType {
    if channels == 4 { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 }
}

fn unwritable(format: Format, error: &ImageError) -> ImageErrorKind {
    ImageErrorKind::NotWritable { format, reason: error.to_string() }
}

pub fn decode_bmp(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let source = Source::new(Format::Bmp, bytes);
    let (size, at) = bmp::size(&source)?;
    let (width, height) = check_size(&source.placed(at), size, BMP_PIXELS_PER_BYTE)?;
    bmp::check_colors(&source, [width as usize, height as usize])?;
    run(Format::Bmp, bytes, space, BMP_PIXELS_PER_BYTE, |cursor| Ok(Box::new(BmpDecoder::new(cursor)?)))
}

/// Width and height in the beginning of a BMP file, and the byte where they stand.
pub fn bmp_size(head: &[u8]) -> Result<([u64; 2], usize)> {
    bmp::size(&Source::new(Format::Bmp, head))
}

/// Width and height in the beginning of a WebP file.
pub fn webp_size(head: &[u8]) -> Option<[u32; 2]> {
    webp::size(head)
}

pub fn decode_gif(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    gif::check(&Source::new(Format::Gif, bytes))?;
    run(Format::Gif, bytes, space, GIF_PIXELS_PER_BYTE, |cursor| Ok(Box::new(GifDecoder::new(cursor)?)))
}

pub fn decode_webp(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let bytes = webp::check(&Source::new(Format::Webp, bytes))?;
    run(Format::Webp, bytes, space, WEBP_PIXELS_PER_BYTE, |cursor| Ok(Box::new(WebPDecoder::new(cursor)?)))
}

fn check_size(source: &Source<'_>, [width, height]: [u64; 2], pixels_per_byte: u64) -> Result<(u32, u32)> {
    let length = source.bytes.len() as u64;
    source.check_size(width, height, pixels_per_byte.max(SMALL.div_ceil(length.max(1))))
}

/// A decoder of the library that has read the header.
type Open = for<'c> fn(&'c mut Cursor<&[u8]>) -> ImageResult<Box<dyn ImageDecoder + 'c>>;

fn run(format: Format, bytes: &[u8], space: ColorSpace, pixels_per_byte: u64, open: Open) -> Result<Decoded> {
    let mut cursor = Cursor::new(bytes);
    let decoded = open(&mut cursor).map_err(Fault::Library).and_then(|mut decoder| {
        let (width, height) = decoder.dimensions();
        // GIF states its size behind the mark, WebP in one of three ways behind that of its first chunk.
        let source = Source { format, bytes, at: if format == Format::Gif { 6 } else { 12 } };
        let size = check_size(&source, [width.into(), height.into()], pixels_per_byte)?;
        let color = decoder.color_type();
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(2 * decoder.total_bytes() + SPARE);
        decoder.set_limits(limits)?;
        let mut codes = zeroed::<u8>(size.0, size.1, color.channel_count().into())?;
        decoder.read_image_boxed(&mut codes)?;
        Ok((size, color, codes))
    });
    let (size, color, codes) = decoded.map_err(|fault| told(format, bytes, cursor.position(), fault))?;
    let codes = if color == ColorType::Rgba8 { without_idle_alpha(codes) } else { codes };
    let channels = (codes.len() / (size.0 as usize * size.1 as usize)) as u32;
    let transfer = Transfer::of(space, Transfer::Srgb);
    Ok(finish(format, size, channels, coded(codes, 255, transfer), transfer != Transfer::Linear))
}

/// What the decoding library says, or what we do.
enum Fault {
    Library(ImageError),
    Ours(ImageErrorKind),
}

impl From<ImageError> for Fault {
    fn from(error: ImageError) -> Self {
        Self::Library(error)
    }
}

impl From<ImageErrorKind> for Fault {
    fn from(kind: ImageErrorKind) -> Self {
        Self::Ours(kind)
    }
}

/// A fault with the place that the decoder had reached.
fn told(format: Format, bytes: &[u8], reached: u64, fault: Fault) -> ImageErrorKind {
    let at = usize::try_from(reached).map_or(bytes.len(), |at| at.min(bytes.len()));
    let source = Source { format, bytes, at };
    match fault {
        Fault::Ours(kind) => kind,
        Fault::Library(ImageError::IoError(e)) if e.kind() == ErrorKind::UnexpectedEof => {
            source.fault("the end of the file", "the rest of the picture")
        }
        Fault::Library(ImageError::Unsupported(what)) => {
            let text = one_line(&what.to_string());
            let what = text.split_once("format features ").map_or(&*text, |(_, what)| what);
            source.unsupported(what, format!("a usual {format} file"))
        }
        Fault::Library(error) => {
            let text = one_line(&error.to_string());
            let found = text.strip_prefix(&format!("Format error decoding {}: ", library_name(format)));
            let expected = expected(&WORDS, &text).map(str::to_owned);
            source.fault(found.unwrap_or(&text), expected.unwrap_or_else(|| format!("valid {format} data")))
        }
    }
}

fn library_name(format: Format) -> &'static str {
    match format {
        Format::Bmp => "Bmp",
        Format::Gif => "Gif",
        _ => "WebP",
    }
}

/// What texts of the library contain, and what was expected then.
const WORDS: [(&str, &str); 12] = [
    ("VP8 magic", "bytes 9d 01 2a before the size"),
    ("lossless signature", "byte 2f before the size"),
    ("lossless version", "version 0"),
    ("image truncated", "data for all pixels of the first picture"),
    ("LZW", "codes that have a meaning so far"),
    ("minimal code size", "codes of 1 to 11 bits"),
    ("than one plane", "one plane"),
    ("channel bit count", "1, 2, 4, 8, 16, 24 or 32 bits that go with the compression"),
    ("compression type", "none, runs (1, 2) or masks (3, 6)"),
    ("header too small", "a header of 12, 40, 52, 56, 108 or 124 bytes"),
    ("exceeds maximum size", "as many colours as the samples can name, or fewer"),
    ("soft limit", "at most 65535 pixels across and down"),
];

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('"', "")
}

/// Red, green and blue alone if no pixel is transparent: these formats say too little of whether there is alpha.
fn without_idle_alpha(mut codes: Vec<u8>) -> Vec<u8> {
    if codes.as_chunks::<4>().0.iter().all(|p| p[3] == 255) {
        keep_first(&mut codes, 4, 3);
    }
    codes
}
