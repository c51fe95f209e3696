//! Layers in files: one OpenEXR file, or one file for each.

use super::Layers;
use crate::codec;
use crate::error::{ImageError, ImageErrorKind};
use crate::format::Format;
use crate::io::{ColorSpace, WriteOptions, check_writable, decode, decode_contained, encode, read, write};
use crate::tone::ToneCurve;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A decoded file with all its layers.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedLayers {
    /// The layers. Half floats have become floats, display values linear.
    pub layers: Layers,
    /// The format of the file.
    pub format: Format,
    /// Names and texts in the file, as in [`Decoded`](crate::Decoded).
    pub metadata: Vec<(String, String)>,
}

/// Writes layers, and says to which files: all to one OpenEXR file, or, in the other formats, each to its
/// [`layer_path`]. Each file appears whole or not at all.
///
/// In 8-bit files only the colour of the picture has the tone curve and the exposure of the options (and
/// [`course_ppm`](WriteOptions::course_ppm)): other colours are plain sRGB, other numbers are cut to 0…1, so negative
/// ones are lost.
///
/// # Errors
///
/// Unknown extension, no layers, a layer that the format cannot hold, two layers with one path, or a failure of the
/// file system. Files written before that stay.
pub fn save_layers(path: &Path, layers: &Layers, options: &WriteOptions) -> Result<Vec<PathBuf>, ImageError> {
    let format = Format::from_path(path)?;
    if format == Format::Exr || layers.layers().is_empty() {
        write(path, |bytes| encode_layers(layers, options, bytes))?;
        return Ok(vec![path.to_path_buf()]);
    }
    let files: Vec<PathBuf> = layers.layers().iter().map(|layer| layer_path(path, layer.name())).collect();
    for (i, file) in files.iter().enumerate() {
        if files[..i].contains(file) {
            let reason = format!("the layer \"{}\" would overwrite another", layers.layers()[i].name());
            return Err(ImageError::new(file, ImageErrorKind::NotWritable { format, reason }));
        }
    }
    for (layer, file) in layers.layers().iter().zip(&files) {
        let unwritable = |reason| ImageErrorKind::NotWritable { format, reason };
        write(file, |bytes| {
            let image = layer.to_image(layers.width(), layers.height());
            let image = image.map_err(|e| unwritable(e.to_string()))?;
            encode(format, &image, &options_of(layer, options), bytes)
        })?;
    }
    Ok(files)
}

/// How a layer is written to a file of its own.
fn options_of(layer: &super::Layer, options: &WriteOptions) -> WriteOptions {
    if layer.name().is_empty() {
        return options.clone();
    }
    let tone = if layer.is_color() { ToneCurve::Srgb } else { ToneCurve::Raw };
    WriteOptions { tone, exposure: 0.0, course_ppm: false, metadata: options.metadata.clone() }
}

/// The file of one layer beside that of the colour: `image.albedo.pfm` for `image.pfm`. Characters that are neither
/// letters, digits, `.`, `_` nor `-` become `_`, so the file is in the same folder whatever the layer is called.
#[must_use]
pub fn layer_path(path: &Path, layer: &str) -> PathBuf {
    if layer.is_empty() {
        return path.to_path_buf();
    }
    let safe = |c: char| if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') { c } else { '_' };
    let mut name: OsString = path.file_stem().unwrap_or_default().to_owned();
    name.push(".");
    name.push(layer.chars().map(safe).collect::<String>());
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Writes layers as one OpenEXR file to `w`: one part, the channels `layer.channel` \[OpenEXR\] with 32 bits each, ZIP
/// compression. The same input gives the same bytes.
///
/// # Errors
///
/// No layers, no pixels, or a failure of `w`.
pub fn encode_layers(
    layers: &Layers,
    options: &WriteOptions,
    w: &mut dyn Write,
) -> Result<(), ImageErrorKind> {
    check_writable(Format::Exr, layers.width(), layers.height(), options)?;
    if layers.layers().is_empty() {
        let reason = "there are no layers".to_owned();
        return Err(ImageErrorKind::NotWritable { format: Format::Exr, reason });
    }
    codec::exr::encode_layers(layers, options, w)
}

/// Reads an image file with all its layers, as [`decode_layers`] does.
///
/// # Errors
///
/// A failure of the file system, or what [`decode_layers`] finds wrong.
pub fn load_layers(path: &Path) -> Result<DecodedLayers, ImageError> {
    decode_layers(&read(path)?, path)
}

/// Decodes the bytes of an image file with all layers; `name` is for messages only. Of an OpenEXR file of several parts
/// it is the part that [`decode`](crate::decode) would choose, else the first flat one; files of other formats have
/// one layer.
///
/// # Errors
///
/// What is wrong with the file, and where.
pub fn decode_layers(bytes: &[u8], name: &Path) -> Result<DecodedLayers, ImageError> {
    if Format::from_content(bytes) == Some(Format::Exr) {
        let decoded = decode_contained(Format::Exr, || codec::exr::decode_layers(bytes));
        return decoded.map_err(|kind| ImageError::new(name, kind));
    }
    let decoded = decode(bytes, name, ColorSpace::Auto)?;
    let layers = Layers::from_image(&decoded.image);
    Ok(DecodedLayers { layers, format: decoded.format, metadata: decoded.metadata })
}
