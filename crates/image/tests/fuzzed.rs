//! What every image file must stand, whatever it says: what the fuzz targets call, and the replay of what they have kept.

use penombre_image::{ColorSpace, Format, WriteOptions, decode, decode_layers, encode_layers};
use std::path::Path;

/// Reads an image of any format, and once more with true sums and lengths, behind which its content is looked at.
pub fn image(data: &[u8]) {
    read(data);
    if let Some(sealed) = sealed(data) {
        read(&sealed);
    }
}

/// The same file with the sum of each PNG chunk, or the length of the WebP file, as it should be; `None` for others.
pub fn sealed(data: &[u8]) -> Option<Vec<u8>> {
    let mut sealed = data.to_vec();
    match data {
        [0x89, b'P', b'N', b'G', ..] => {
            let mut at = 8;
            while let Some(head) = sealed.get(at..at + 4) {
                let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
                let end = at + 8 + length;
                let Some(sum) = sealed.get(at + 4..end).map(crc32fast::hash) else { break };
                let Some(place) = sealed.get_mut(end..end + 4) else { break };
                place.copy_from_slice(&sum.to_be_bytes());
                at = end + 4;
            }
        }
        [b'R', b'I', b'F', b'F', _, _, _, _, ..] => {
            let length = data.len() as u32 - 8;
            sealed[4..8].copy_from_slice(&length.to_le_bytes());
        }
        _ => return None,
    }
    (sealed != data).then_some(sealed)
}

fn read(data: &[u8]) {
    for space in [ColorSpace::Auto, ColorSpace::Linear] {
        match decode(data, Path::new("fuzzed"), space) {
            Ok(decoded) => assert!(decoded.image.width() > 0 && decoded.image.height() > 0),
            Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        }
    }
}

/// Reads an OpenEXR image as layers; what was read can be written. Those of other formats are their images in floats.
pub fn layers(data: &[u8]) {
    if Format::from_content(data) == Some(Format::Exr)
        && let Ok(found) = decode_layers(data, Path::new("fuzzed"))
    {
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
