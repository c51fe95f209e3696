//! What can be wrong with an image or its file.

use crate::format::Format;
use std::path::{Path, PathBuf};

/// A failure to read or write an image file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", path.display())]
pub struct ImageError {
    /// The file, as the caller named it.
    pub path: PathBuf,
    /// What happened.
    #[source]
    pub kind: ImageErrorKind,
}

impl ImageError {
    pub(crate) fn new(path: &Path, kind: ImageErrorKind) -> Self {
        Self { path: path.to_path_buf(), kind }
    }
}

/// The reasons of an [`ImageError`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageErrorKind {
    /// The extension names no format.
    #[error("found {found}, expected a file name that ends in one of {}", Format::EXTENSIONS.join(", "))]
    UnknownExtension {
        /// The extension in quotes, or words that say there is none.
        found: String,
    },
    /// The first bytes are those of no known format.
    #[error(
        "byte 0: found {found}, expected the start of a PNG, JPEG, PPM/PGM/PBM, PFM, OpenEXR, Radiance, TGA, BMP, WebP or \
         GIF file"
    )]
    UnknownContent {
        /// The first bytes, readable.
        found: String,
    },
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The bytes break the rules of their format.
    #[error("{format}, byte {offset}: found {found}, expected {expected}")]
    Malformed {
        /// The format of the file.
        format: Format,
        /// Bytes before the fault; where a decoder reads ahead, the place it had reached.
        offset: u64,
        /// What stands there.
        found: String,
        /// What the format wants there.
        expected: String,
    },
    /// A file of a kind that is not read.
    #[error("{format}, byte {offset}: found {found}, which is not supported; expected {expected}")]
    Unsupported {
        /// The format of the file.
        format: Format,
        /// Bytes before the place.
        offset: u64,
        /// What stands there.
        found: String,
        /// What is supported.
        expected: String,
    },
    /// More pixels than are allowed, or than the file can hold.
    #[error(
        "{format}, byte {offset}: found a size of {width} × {height} pixels in a file of {bytes} bytes, expected at most {limit} \
         pixels"
    )]
    TooLarge {
        /// The format of the file.
        format: Format,
        /// Bytes before the size, or before what states it.
        offset: u64,
        /// Width the file claims.
        width: u64,
        /// Height the file claims.
        height: u64,
        /// Length of the file.
        bytes: u64,
        /// The largest number of pixels accepted for this file.
        limit: u64,
    },
    /// The memory for the pixels could not be had.
    #[error("not enough memory for {width} × {height} pixels")]
    OutOfMemory {
        /// Width in pixels.
        width: u64,
        /// Height in pixels.
        height: u64,
    },
    /// The image cannot be written in this format.
    #[error("{format}: {reason}")]
    NotWritable {
        /// The format asked for.
        format: Format,
        /// Why not.
        reason: String,
    },
}

/// Samples that do not make an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found} samples, expected {width} × {height} pixels of {channels} channels (1 to 4)")]
pub struct ShapeError {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub channels: u32,
    /// Number of samples given.
    pub found: usize,
}

/// A layer that does not go with the others.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("layer \"{}\": {reason}", layer.escape_debug())]
pub struct LayerError {
    /// Name of the layer.
    pub layer: String,
    /// What is wrong with it.
    pub reason: String,
}
