//! What every image file must stand, whatever it says: what the fuzz targets call, and the replay of what they have kept.

use penombre_image::{ColorSpace, WriteOptions, decode, decode_layers, encode_layers};
use std::path::Path;

/// Reads an image of any format.
pub fn image(data: &[u8]) {
    for space in [ColorSpace::Auto, ColorSpace::Linear] {
        match decode(data, Path::new("fuzzed"), space) {
            Ok(decoded) => assert!(decoded.image.width() > 0 && decoded.image.height() > 0),
            Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        }
    }
}

/// Reads an image as layers; what was read can be written.
pub fn layers(data: &[u8]) {
    if let Ok(found) = decode_layers(data, Path::new("fuzzed")) {
        encode_layers(&found.layers, &WriteOptions::default(), &mut Vec::new()).expect("a sound picture");
    }
}

#[cfg(test)]
mod replayed {
    use super::*;

    #[test]
    fn kept_images() {
        for target in ["bmp", "exr", "gif", "hdr", "jpeg", "pfm", "png", "pnm", "tga", "webp"] {
            for (name, data) in penombre_lab::kept_corpus(target) {
                // A failing test shows the last line.
                eprintln!("{target}/{name}");
                image(&data);
                layers(&data);
            }
        }
    }
}
