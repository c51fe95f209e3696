//! Which file format.

use crate::codec::tga;
use crate::error::{ImageError, ImageErrorKind};
use std::fmt;
use std::path::Path;

/// An image file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// PNG; written with 8 bits per colour.
    Png,
    /// JPEG; written with quality 95.
    Jpeg,
    /// Netpbm colour (P3, P6); written as P6, or as the course program's P3.
    Ppm,
    /// Netpbm grey (P2, P5) and bitmap (P1, P4); written as P5.
    Pgm,
    /// Portable float map, colour (PF) or grey (Pf).
    Pfm,
    /// OpenEXR; written with 32-bit floats and ZIP compression.
    Exr,
    /// Radiance RGBE.
    Hdr,
    /// Truevision TGA; written without compression.
    Tga,
    /// Windows bitmap.
    Bmp,
    /// WebP; written without loss.
    Webp,
    /// GIF: the first frame is read; not written.
    Gif,
}

impl Format {
    /// The extensions [`from_path`](Self::from_path) knows: those of the formats that are written.
    pub const EXTENSIONS: &'static [&'static str] = &[
        ".png", ".jpg", ".jpeg", ".ppm", ".pnm", ".pgm", ".pbm", ".pfm", ".exr", ".hdr", ".pic", ".tga",
        ".bmp", ".webp",
    ];

    /// The format in which a file of this name is written: its extension, in either case, says so.
    ///
    /// # Errors
    ///
    /// If there is no extension or an unknown one: the message lists the known ones. If the format is only read (GIF).
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("png") => Self::Png,
            Some("jpg" | "jpeg") => Self::Jpeg,
            Some("ppm" | "pnm") => Self::Ppm,
            Some("pgm" | "pbm") => Self::Pgm,
            Some("pfm") => Self::Pfm,
            Some("exr") => Self::Exr,
            Some("hdr" | "pic") => Self::Hdr,
            Some("tga") => Self::Tga,
            Some("bmp") => Self::Bmp,
            Some("webp") => Self::Webp,
            Some("gif") => return Err(ImageError::new(path, Self::unwritten(Self::Gif))),
            other => {
                let found = other.map_or("no extension".to_owned(), |e| format!("the extension \".{e}\""));
                return Err(ImageError::new(path, ImageErrorKind::UnknownExtension { found }));
            }
        };
        Ok(format)
    }

    /// That this format is read and not written.
    pub(crate) fn unwritten(self) -> ImageErrorKind {
        let reason = format!("is read, but not written; expected one of {}", Self::EXTENSIONS.join(", "));
        ImageErrorKind::NotWritable { format: self, reason }
    }

    /// The format of a file: what its first bytes announce, else TGA, which announces nothing, if it is called so.
    #[must_use]
    pub fn of_file(bytes: &[u8], path: &Path) -> Option<Self> {
        let is_called_tga = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
        Self::from_content(bytes).or(is_called_tga.then_some(Self::Tga))
    }

    /// The format a file's first bytes announce, if any. TGA has no mark; a header that can be none but a TGA's counts.
    #[must_use]
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [b'#', b'?', ..] => Some(Self::Hdr),
            [b'P', b'F' | b'f', b'\n' | b'\r' | b' ' | b'\t', ..] => Some(Self::Pfm),
            [b'P', b'3' | b'6', ..] => Some(Self::Ppm),
            [b'P', b'1' | b'2' | b'4' | b'5', ..] => Some(Self::Pgm),
            [b'B', b'M', ..] => Some(Self::Bmp),
            [b'G', b'I', b'F', b'8', b'7' | b'9', b'a', ..] => Some(Self::Gif),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::Webp),
            _ => tga::is_plausible(bytes).then_some(Self::Tga),
        }
    }

    /// Whether files of this format hold display values, so that [`save`](crate::save) applies exposure and tone
    /// curve; the others hold linear light.
    #[must_use]
    pub fn is_8_bit(self) -> bool {
        !matches!(self, Self::Pfm | Self::Exr | Self::Hdr)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Ppm => "PPM",
            Self::Pgm => "PGM",
            Self::Pfm => "PFM",
            Self::Exr => "OpenEXR",
            Self::Hdr => "Radiance",
            Self::Tga => "TGA",
            Self::Bmp => "BMP",
            Self::Webp => "WebP",
            Self::Gif => "GIF",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_of_the_list_are_known_and_no_others() {
        for extension in Format::EXTENSIONS {
            let upper = format!("Folder.x/A{}", extension.to_uppercase());
            assert_eq!(
                Format::from_path(Path::new(&upper)).unwrap(),
                Format::from_path(Path::new(&format!("a{extension}"))).unwrap()
            );
        }
        for name in ["a.tgb", "a", ".png", "a.", "png", "a.gif"] {
            let message = Format::from_path(Path::new(name)).unwrap_err().to_string();
            for part in Format::EXTENSIONS.iter().chain([&name]) {
                assert!(message.contains(*part), "{message} lacks {part}");
            }
        }
    }
}
