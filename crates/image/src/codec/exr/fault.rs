//! What is wrong with an OpenEXR file, in words.

use crate::codec::{Result, Source, expected};
use crate::error::ImageErrorKind;
use crate::format::Format;
use ::exr::error::Error;
use std::io::Cursor;

/// What the decoding library says, or what we do.
pub enum Fault {
    Library(Error),
    Ours(ImageErrorKind),
    /// So many bytes before the place that the decoder has reached: what was found and what was expected.
    Before(usize, String, String),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Library(error)
    }
}

/// Runs a decoder and tells its fault with the place it had reached.
pub fn reported<'a, T>(
    bytes: &'a [u8],
    run: impl FnOnce(&mut Cursor<&'a [u8]>, &'a [u8]) -> std::result::Result<T, Fault>,
) -> Result<T> {
    check_attributes(bytes)?;
    let mut cursor = Cursor::new(bytes);
    run(&mut cursor, bytes).map_err(|fault| {
        let mut source = Source { format: Format::Exr, bytes, at: cursor.position() as usize };
        match fault {
            Fault::Ours(kind) => kind,
            Fault::Before(length, found, expected) => {
                source.at = source.at.saturating_sub(length);
                source.fault(found, expected)
            }
            Fault::Library(Error::NotSupported(what)) => unsupported(&source, &what),
            Fault::Library(error) => {
                let (found, expected) = words(&source, error.to_string().trim_start_matches("invalid: "));
                source.fault(found, expected)
            }
        }
    })
}

fn unsupported(source: &Source<'_>, what: &str) -> ImageErrorKind {
    let is_version = what.contains("version") || what.contains("flags");
    let what = what.trim_end_matches(" yet").trim_end_matches(" not supported").trim_end_matches(" are");
    let expected = if is_version {
        "version 2 with flags that are known"
    } else if what.contains("compression") {
        "no compression, RLE, ZIP, PIZ, PXR24, B44 or DWA"
    } else {
        "a flat picture"
    };
    source.unsupported(what, expected)
}

/// What was found and what was expected, of a text of the library that names what is invalid.
fn words(source: &Source<'_>, text: &str) -> (String, &'static str) {
    let text = text.replace("(None)", "").replace(" (invalid: ", ": ").replace(')', "");
    let text = text.trim_end_matches('.');
    if text == "reference to missing bytes" {
        let is_end = source.at >= source.bytes.len();
        let found =
            if is_end { "the end of the file" } else { "an attribute or a block that ends too early" };
        return (found.to_owned(), "the rest of the header and all blocks of the picture");
    }
    let expected = expected(&EXPECTED, text).unwrap_or("valid OpenEXR data");
    let is_sentence = SENTENCES.iter().any(|part| text.contains(part));
    (if is_sentence { text.to_owned() } else { format!("an invalid {text}") }, expected)
}

/// What texts of the library contain, and what was expected then.
const EXPECTED: [(&str, &str); 9] = [
    ("missing or invalid", "a header with all attributes that the format requires"),
    ("compressed", "data that the compression of the file has packed"),
    ("decompressed", "as many bytes as the rows or the tile take"),
    ("sample count", "as many bytes as the rows or the tile take"),
    ("sampling", "at least 1, and a divisor of the size and place of the picture"),
    ("flags", "flags that go together"),
    ("sorted", "channels in the order of their names, each once"),
    ("chunk count", "the number of blocks that the size asks for"),
    ("window", "at least one pixel, at places below 2^30"),
];

/// What only texts contain that say what is wrong, and do not only name it.
const SENTENCES: [&str; 9] =
    ["missing", "compressed", "exceeding", " not ", "too ", "zero ", "at least", "failed", "Overflow"];

/// Checks that no attribute of any header runs over the end of the file or has another length than its kind, which the
/// library does not look at.
fn check_attributes(bytes: &[u8]) -> Result<()> {
    let mut source = Source { format: Format::Exr, bytes, at: 8 };
    let version = bytes.get(4..8).and_then(|b| b.first_chunk()).map_or(0, |b| u32::from_le_bytes(*b));
    loop {
        // A zero ends a header. One more ends those of several parts.
        while source.peek().is_some_and(|byte| byte != 0) {
            check_attribute(&mut source)?;
        }
        source.at += 1;
        if version & SEVERAL_PARTS == 0 || source.peek().is_none_or(|byte| byte == 0) {
            return Ok(());
        }
    }
}

/// The flag of the version field.
const SEVERAL_PARTS: u32 = 0x1000;

fn check_attribute(source: &mut Source<'_>) -> Result<()> {
    let start = source.at;
    let name = attribute_text(source);
    let kind = attribute_text(source);
    let length = source.rest().first_chunk::<4>().map(|l| u32::from_le_bytes(*l) as usize);
    let left = source.rest().len().saturating_sub(4);
    let shown = format!("attribute \"{}\" of ", name[..name.len().min(64)].escape_ascii());
    source.at = start;
    let Some(length) = length.filter(|length| *length <= left) else {
        let length = length.map_or("a cut-off length".to_owned(), |length| format!("{length} bytes"));
        return Err(source.fault(shown + &length, format!("at most the {left} bytes left")));
    };
    let end = source.bytes.len() - left + length;
    if let Some(expected) = other_length(kind, &source.bytes[end - length..end]) {
        return Err(source.fault(format!("{shown}{length} bytes"), expected));
    }
    source.at = end;
    Ok(())
}

/// What length a value of this kind has, if this is another one \[OpenEXR\].
fn other_length(kind: &[u8], value: &[u8]) -> Option<String> {
    let length = match kind {
        b"chlist" => {
            let is_whole = list_length(value) == Some(value.len());
            return (!is_whole).then(|| "the length of its list of channels".to_owned());
        }
        b"compression" | b"envmap" | b"lineOrder" => 1,
        b"float" | b"int" => 4,
        b"double" | b"rational" | b"timecode" | b"v2f" | b"v2i" => 8,
        b"tiledesc" => 9,
        b"v3f" | b"v3i" => 12,
        b"box2f" | b"box2i" => 16,
        b"keycode" => 28,
        b"chromaticities" => 32,
        b"m33f" => 36,
        b"m44f" => 64,
        _ => return None,
    };
    (value.len() != length).then(|| format!("{length} bytes"))
}

/// Bytes up to the end of a list of channels: names with a zero and 16 bytes each, then a zero.
fn list_length(list: &[u8]) -> Option<usize> {
    let mut at = 0;
    while *list.get(at)? != 0 {
        at += list[at..].iter().position(|b| *b == 0)? + 17;
    }
    Some(at + 1)
}

/// A text of the header up to its closing zero, at most 255 bytes.
pub fn attribute_text<'a>(source: &mut Source<'a>) -> &'a [u8] {
    let rest = source.rest();
    let length = rest.iter().take(255).position(|b| *b == 0).unwrap_or(rest.len().min(255));
    source.at = (source.at + length + 1).min(source.bytes.len());
    &rest[..length]
}
