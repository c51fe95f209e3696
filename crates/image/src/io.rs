//! Reading and writing image files.

use crate::codec;
use crate::error::{ImageError, ImageErrorKind};
use crate::format::Format;
use crate::image::Image;
use crate::tone::ToneCurve;
use std::cell::Cell;
use std::fs::File;
use std::io::{Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// The largest number of pixels an image file may have: 2²⁸, a square of 16 384.
pub const MAX_PIXELS: u64 = 1 << 28;

/// How [`save`] and [`encode`] write. The default is an sRGB file without metadata.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// The tone curve of 8-bit files.
    pub tone: ToneCurve,
    /// Exposure of 8-bit files in stops (EV): values are multiplied by 2^exposure before the tone curve.
    pub exposure: f32,
    /// Names and texts to keep in the file: text chunks in PNG, comments in JPEG and Radiance, string attributes in
    /// OpenEXR. (there, names of the format's own get the prefix `text.`). Netpbm and PFM have no place for them.
    pub metadata: Vec<(String, String)>,
    /// Write `.ppm` exactly as the course program does: P3, all pixels on one line, truncated instead of rounded, no
    /// tone curve; but values below 0 and NaN are written as 0, where that program would write a negative
    /// number that no reader accepts.
    pub course_ppm: bool,
}

/// What the numbers of a file mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// What the format says: integers are sRGB (or the gamma a PNG states), floats are linear.
    #[default]
    Auto,
    /// Numbers taken as they are, integers divided by their maximum: normal maps, roughness, masks.
    Linear,
    /// sRGB-encoded whatever the format says; alpha is never encoded.
    Srgb,
}

/// A decoded file.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// The pixels in linear light; with 2 or 4 channels if the file has alpha.
    pub image: Image,
    /// Whether the numbers in the file were display values, which decoding has made linear.
    pub was_srgb: bool,
    /// The format of the file.
    pub format: Format,
    /// Names and texts in the file (PNG text chunks, OpenEXR string attributes), in file order.
    pub metadata: Vec<(String, String)>,
}

/// Writes `image` to a file, in the format of the extension. The file appears whole or not at all.
///
/// # Errors
///
/// Unknown extension, an image the format cannot hold (no pixels, for example), or a failure of the file system.
pub fn save(path: &Path, image: &Image, options: &WriteOptions) -> Result<(), ImageError> {
    let format = Format::from_path(path)?;
    write(path, |bytes| encode(format, image, options, bytes))
}

/// Writes what `encode` makes to a file, which appears whole or not at all.
pub(crate) fn write(
    path: &Path,
    encode: impl FnOnce(&mut Vec<u8>) -> Result<(), ImageErrorKind>,
) -> Result<(), ImageError> {
    let mut bytes = Vec::new();
    encode(&mut bytes).map_err(|kind| ImageError::new(path, kind))?;
    penombre_sys::write_atomic(path, |w| w.write_all(&bytes))
        .map_err(|e| ImageError::new(path, ImageErrorKind::Io(e)))
}

/// Writes `image` in `format` to `w`. The same input gives the same bytes.
///
/// # Errors
///
/// An image the format cannot hold, or a failure of `w`.
pub fn encode(
    format: Format,
    image: &Image,
    options: &WriteOptions,
    w: &mut dyn Write,
) -> Result<(), ImageErrorKind> {
    check_writable(format, image.width(), image.height(), options)?;
    match format {
        Format::Png => codec::png::encode(image, options, w),
        Format::Jpeg => codec::jpeg::encode(image, options, w),
        Format::Ppm => codec::pnm::encode_ppm(image, options, w),
        Format::Pgm => codec::pnm::encode_pgm(image, options, w),
        Format::Pfm => codec::pfm::encode(image, w),
        Format::Exr => codec::exr::encode(image, options, w),
        Format::Hdr => codec::hdr::encode(image, options, w),
        Format::Tga => codec::tga::encode(image, options, w),
        Format::Bmp => codec::packed::encode_bmp(image, options, w),
        Format::Webp => codec::packed::encode_webp(image, options, w),
        Format::Gif => Err(format.unwritten()),
    }
}

/// Refuses pictures without pixels, and texts with a NUL character.
pub(crate) fn check_writable(
    format: Format,
    width: u32,
    height: u32,
    options: &WriteOptions,
) -> Result<(), ImageErrorKind> {
    if width == 0 || height == 0 {
        let reason = format!("an image of {width} × {height} pixels cannot be written");
        return Err(ImageErrorKind::NotWritable { format, reason });
    }
    if let Some((name, _)) =
        options.metadata.iter().find(|(name, text)| name.contains('\0') || text.contains('\0'))
    {
        let reason = format!("the text of {name:?} has a NUL character");
        return Err(ImageErrorKind::NotWritable { format, reason });
    }
    Ok(())
}

/// Reads an image file, as [`decode`] does with [`ColorSpace::Auto`].
///
/// # Errors
///
/// A failure of the file system, or what [`decode`] finds wrong.
pub fn load(path: &Path) -> Result<Image, ImageError> {
    decode(&read(path)?, path, ColorSpace::Auto).map(|d| d.image)
}

/// Reads an image file with its texts, as [`decode`] does.
///
/// # Errors
///
/// A failure of the file system, or what [`decode`] finds wrong.
pub fn load_as(path: &Path, space: ColorSpace) -> Result<Decoded, ImageError> {
    decode(&read(path)?, path, space)
}

/// The bytes of an image file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, ImageError> {
    let fail = |kind| ImageError::new(path, kind);
    let mut file = File::open(path).map_err(|e| fail(ImageErrorKind::Io(e)))?;
    // The first bytes decide: what is no image (a device without end, a film) is not read to its end.
    let mut bytes = Vec::new();
    Read::by_ref(&mut file).take(HEAD).read_to_end(&mut bytes).map_err(|e| fail(ImageErrorKind::Io(e)))?;
    // What is only called TGA must be a file at least.
    let known = Format::from_content(&bytes).is_some()
        || Format::of_file(&bytes, path).is_some() && file.metadata().is_ok_and(|m| m.is_file());
    if !known {
        return Err(unknown(&bytes, path));
    }
    file.take(MAX_FILE).read_to_end(&mut bytes).map_err(|e| fail(ImageErrorKind::Io(e)))?;
    Ok(bytes)
}

fn unknown(bytes: &[u8], path: &Path) -> ImageError {
    ImageError::new(path, ImageErrorKind::UnknownContent { found: readable(bytes) })
}

/// Bytes that tell a format.
const HEAD: u64 = 64;

/// Bytes of a file that are read at most: [`MAX_PIXELS`] of four floats, and a header.
const MAX_FILE: u64 = MAX_PIXELS * 16 + (1 << 20);

/// Decodes the bytes of an image file, whose format is told by the first of them. `name` is for messages, and for TGA
/// files whose first bytes could be anything's.
///
/// Sizes are checked against [`MAX_PIXELS`] and against what so many bytes can hold before memory is taken.
///
/// # Errors
///
/// What is wrong with the file, and where.
pub fn decode(bytes: &[u8], name: &Path, space: ColorSpace) -> Result<Decoded, ImageError> {
    let fail = |kind| ImageError::new(name, kind);
    let Some(format) = Format::of_file(bytes, name) else { return Err(unknown(bytes, name)) };
    let decoded = decode_contained(format, || match format {
        Format::Png => codec::png::decode(bytes, space),
        Format::Jpeg => codec::jpeg::decode(bytes, space),
        Format::Ppm | Format::Pgm => codec::pnm::decode(bytes, space),
        Format::Pfm => codec::pfm::decode(bytes, space),
        Format::Exr => codec::exr::decode(bytes, space),
        Format::Hdr => codec::hdr::decode(bytes, space),
        Format::Tga => codec::tga::decode(bytes, space),
        Format::Bmp => codec::packed::decode_bmp(bytes, space),
        Format::Webp => codec::packed::decode_webp(bytes, space),
        Format::Gif => codec::packed::decode_gif(bytes, space),
    });
    decoded.map_err(fail)
}

/// Runs third-party decoding code; a panic there is an error of the file.
pub(crate) fn decode_contained<T>(
    format: Format,
    run: impl FnOnce() -> Result<T, ImageErrorKind>,
) -> Result<T, ImageErrorKind> {
    let broken = || ImageErrorKind::Malformed {
        format,
        offset: 0,
        found: "content its decoder cannot handle".to_owned(),
        expected: format!("a valid {format} file"),
    };
    contain_panic(run).unwrap_or_else(|| Err(broken()))
}

/// The first bytes of a file for a message.
fn readable(bytes: &[u8]) -> String {
    match bytes {
        [] => "an empty file".to_owned(),
        _ => format!("\"{}\"", bytes[..bytes.len().min(8)].escape_ascii()),
    }
}

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is inside a decoder whose panic would be caught and turned into an error: a program's panic hook
/// stays silent then.
#[must_use]
pub fn panic_is_contained() -> bool {
    CONTAINED.get()
}

/// Runs third-party decoding code; `None` if it panicked.
fn contain_panic<T>(run: impl FnOnce() -> T) -> Option<T> {
    let before = CONTAINED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(run));
    CONTAINED.set(before);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_of_decoders_are_caught_and_marked() {
        assert_eq!(contain_panic(panic_is_contained), Some(true));
        assert!(!panic_is_contained());
        assert_eq!(contain_panic(|| -> u8 { panic!("expected in this test") }), None);
        assert!(!panic_is_contained());
    }

    #[test]
    fn foreign_bytes_are_named() {
        let error = decode(b"hello, world", Path::new("a.png"), ColorSpace::Auto).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("a.png") && text.contains("hello, w") && text.contains("PNG"), "{text}");
        let empty = decode(b"", Path::new("e"), ColorSpace::Auto).unwrap_err().to_string();
        assert!(empty.contains("empty"), "{empty}");
        let missing = load(Path::new("no/such/file.png")).unwrap_err();
        assert!(matches!(missing.kind, ImageErrorKind::Io(_)));
    }

    #[test]
    fn images_without_pixels_are_not_written() {
        for format in [Format::Png, Format::Jpeg, Format::Ppm, Format::Pfm, Format::Exr, Format::Hdr] {
            let result = encode(format, &Image::new(0, 3, 3), &WriteOptions::default(), &mut Vec::new());
            assert!(matches!(result, Err(ImageErrorKind::NotWritable { .. })), "{format}");
        }
    }
}
