//! What a file is, by its name's ending and its first bytes.

use crate::readers::{MeshFormat, wide_encoding};
use penombre_image::Format;
use std::path::Path;

/// What the loader can do with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A scene in TOML, or in JSON if its name says so.
    Scene,
    /// A mesh.
    Mesh,
}

/// A file that can be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileKind {
    pub content: Content,
    /// True if only the content tells, and not the name.
    pub guessed: bool,
}

/// A file that cannot be read: what was found at its first byte and expected, and a hint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    pub message: String,
    pub help: String,
}

/// The formats that are read.
pub const KNOWN: &str =
    "scenes are read from .toml and .json, meshes from .obj, .off, .ply and .stl (.gz may follow)";

/// First bytes that tell what a file is.
const MAGIC: [(&[u8], &str); 13] = [
    (b"\x1f\x8b", "data compressed with gzip"),
    (b"x\x9c", "data compressed with zlib"),
    (b"x\xda", "data compressed with zlib"),
    (b"PK\x03\x04", "a zip archive"),
    (b"\xfd7zXZ\0", "data compressed with xz"),
    (b"\x28\xb5\x2f\xfd", "data compressed with zstd"),
    (b"BZh", "data compressed with bzip2"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"8BPS", "a Photoshop image"),
    (b"%PDF", "a PDF document"),
    (b"BLENDER", "a Blender file"),
    (b"\x7fELF", "a program"),
];

/// Formats that this version does not read, by ending.
const NOT_YET: [(&str, &str); 9] = [
    ("gltf", "a glTF scene"),
    ("glb", "a binary glTF scene"),
    ("pbrt", "a pbrt scene"),
    ("xml", "a Mitsuba scene"),
    ("usd", "a USD scene"),
    ("usda", "a USD scene"),
    ("usdz", "a USD scene"),
    ("blend", "a Blender file"),
    ("fbx", "an FBX scene"),
];

/// What to do with an image.
const IMAGE_HELP: &str = "name it by `file` of a texture or of an environment light in a scene; `penombre convert` writes images in other formats";

/// The format of an image, if it is one. First bytes that a text may have count only if they go on as in an image.
fn image_format(path: &Path, bytes: &[u8]) -> Option<Format> {
    let format = Format::of_file(bytes, path)?;
    let is_sure = match format {
        Format::Hdr => bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE"),
        Format::Ppm | Format::Pgm => bytes.get(2).is_some_and(|b| b.is_ascii_whitespace() || *b == b'#'),
        Format::Bmp => bytes[..bytes.len().min(64)].contains(&0),
        _ => true,
    };
    is_sure.then_some(format)
}

fn unreadable(message: String, help: &str) -> Unreadable {
    Unreadable { message, help: help.to_owned() }
}

/// What a file is; `bytes` begin with its first 64, or are all if there are fewer.
pub fn of_file(path: &Path, bytes: &[u8]) -> Result<FileKind, Unreadable> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let is_mesh = MeshFormat::of_path(path).is_some();
    if is_mesh && ending == "gz" {
        return Ok(FileKind { content: Content::Mesh, guessed: false });
    }
    if let Some(format) = image_format(path, bytes) {
        let article = if format == Format::Exr { "an" } else { "a" };
        return Err(unreadable(
            format!("found {article} {format} image, expected a scene or mesh"),
            IMAGE_HELP,
        ));
    }
    if let Some(name) = wide_encoding(bytes) {
        let message = format!("found text in {name}, expected a scene or mesh");
        return Err(unreadable(message, "save it as UTF-8"));
    }
    if let Some((_, what)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        let help = match *what {
            "data compressed with gzip" if is_mesh => "unpack it, or give it a name that ends in .gz",
            what if what.contains("compressed") || what.contains("archive") => "unpack it first",
            what if what.contains("image") => {
                "images are read as textures, if they are PNG, JPEG, OpenEXR, Radiance, TGA, BMP, WebP, GIF, PFM or PPM"
            }
            _ => KNOWN,
        };
        return Err(unreadable(format!("found {what}, expected a scene or mesh"), help));
    }
    let scene = [(&b"glTF"[..], "a binary glTF scene"), (b"Kaydara FBX Binary", "an FBX scene")];
    let scene = scene.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, what)| *what);
    let by_name = NOT_YET.iter().find(|(known, _)| *known == ending).map(|(_, what)| *what);
    if let Some(what) = scene.or(by_name) {
        return Err(unreadable(
            format!("found {what}, which is planned and not read yet, expected another scene or mesh"),
            KNOWN,
        ));
    }
    let kind = |content| Ok(FileKind { content, guessed: false });
    match ending.as_str() {
        _ if is_mesh => kind(Content::Mesh),
        _ if bytes.iter().all(u8::is_ascii_whitespace) => {
            Err(unreadable("found an empty file, expected a scene or mesh".to_owned(), KNOWN))
        }
        "toml" | "json" => kind(Content::Scene),
        _ => guess(bytes),
    }
}

/// A file whose name does not tell.
fn guess(bytes: &[u8]) -> Result<FileKind, Unreadable> {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    let first = lines.next().unwrap_or("");
    let is_version =
        |l: &str| l.strip_prefix("penombre").is_some_and(|rest| rest.trim_start().starts_with('='));
    if is_version(first) || lines.any(is_version) {
        return Ok(FileKind { content: Content::Scene, guessed: true });
    }
    let words: Vec<&str> = first.split_whitespace().collect();
    let looks_like = |what: &str, ending: &str| {
        let help = format!("give it a name that ends in {ending}");
        Err(Unreadable {
            message: format!("found what looks like {what}, expected a name that says so"),
            help,
        })
    };
    match words[..] {
        ["ply"] => looks_like("a PLY mesh", ".ply"),
        ["solid", ..] => looks_like("an STL mesh", ".stl"),
        ["OFF" | "COFF" | "NOFF" | "CNOFF" | "STOFF", ..] => looks_like("an OFF mesh", ".off"),
        ["v" | "vn" | "vt" | "mtllib" | "o" | "g" | "f", _, ..] => looks_like("an OBJ mesh", ".obj"),
        _ => {
            let found = bytes[..bytes.len().min(8)].escape_ascii();
            Err(unreadable(format!("found \"{found}\", expected a scene or mesh"), KNOWN))
        }
    }
}
