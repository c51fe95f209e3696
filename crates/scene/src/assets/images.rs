//! Image files.

use super::UNREADABLE_HELP;
use super::twins::Candidate;
use crate::description::{Node, ValueKind};
use crate::readers::MeshTexture;
use penombre_image::{ColorSpace, Image, ImageErrorKind, decode};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An image file and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ImageKey {
    pub path: PathBuf,
    pub space: ColorSpace,
}

/// Why there is no image, and what to do about it.
#[derive(Clone, Debug)]
pub(super) struct ImageFault {
    pub message: String,
    pub help: &'static str,
}

/// A decoded image with the hash of its file, or why there is none.
pub(super) type ImageResult = Result<(Arc<Image>, [u8; 32]), ImageFault>;
pub(super) type Images = HashMap<ImageKey, ImageResult>;

impl ImageKey {
    pub fn of_node(node: &Node, path: PathBuf) -> Self {
        let space = match node.param("encoding").map(|p| &p.value.kind) {
            Some(ValueKind::String(word)) if word == "linear" => ColorSpace::Linear,
            Some(ValueKind::String(word)) if word == "srgb" => ColorSpace::Srgb,
            _ => ColorSpace::Auto,
        };
        Self { path, space }
    }

    pub fn of_texture(texture: &MeshTexture) -> Self {
        Self::of_node(&texture.node, texture.path.clone())
    }

    /// What two files must share for their images to be the same; the ending tells TGA files.
    pub fn candidate(&self, length: u64) -> Candidate<'_, (ColorSpace, bool)> {
        let is_tga = self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
        Candidate { path: &self.path, length, kind: (self.space, is_tga) }
    }

    /// Reads and decodes it. `name`: how messages call it.
    pub fn read(&self, name: &str) -> ImageResult {
        let bytes = std::fs::read(&self.path).map_err(|e| ImageFault {
            message: format!("`{name}` cannot be read: {e}"),
            help: UNREADABLE_HELP,
        })?;
        let decoded = decode(&bytes, Path::new(name), self.space)
            .map_err(|e| ImageFault { message: e.to_string(), help: image_help(&e.kind) })?;
        Ok((Arc::new(decoded.image), *blake3::hash(&bytes).as_bytes()))
    }
}

/// What to do about an image that cannot be decoded.
fn image_help(kind: &ImageErrorKind) -> &'static str {
    match kind {
        ImageErrorKind::UnknownContent { .. } => {
            "what counts is the content and not the name: is this an image in one of these formats?"
        }
        ImageErrorKind::Malformed { .. } => "the file is damaged or was cut: save or copy it anew",
        ImageErrorKind::TooLarge { .. } | ImageErrorKind::OutOfMemory { .. } => {
            "make the image smaller; if it is not that large, the file is damaged"
        }
        _ => "save it as PNG, or as OpenEXR if it has more than 16 bits",
    }
}
