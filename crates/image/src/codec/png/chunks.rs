//! The chunks of a PNG file \[PNG\], looked through before it is decoded: the decoding library skips what is broken beside
//! the picture and has few words for the rest.

use super::PIXELS_PER_BYTE;
use crate::codec::{Result, Source};
use crate::format::Format;
use std::borrow::Cow;

/// What every file begins with. Programs that take it for text change its ends of lines.
const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// Bytes of a chunk beside its data: length and name before, check sum behind.
const FRAME: usize = 12;

/// What a decoder needs of a file for its still picture.
pub struct Still<'a> {
    /// The file, without the chunks of an animation.
    pub bytes: Cow<'a, [u8]>,
    /// Width and height in pixels, as many as such a file may have.
    pub size: (u32, u32),
    /// Where chunks were left out, as places in `bytes`, and how long they were.
    left_out: Vec<(usize, usize)>,
}

impl Still<'_> {
    /// The place in the whole file of one in `bytes`.
    pub fn place(&self, at: usize) -> usize {
        at + self.left_out.iter().filter(|(start, _)| *start <= at).map(|(_, length)| length).sum::<usize>()
    }
}

/// A chunk: where it begins, and what is in it.
struct Chunk<'a> {
    at: usize,
    name: [u8; 4],
    data: &'a [u8],
}

impl Chunk<'_> {
    fn end(&self) -> usize {
        self.at + self.data.len() + FRAME
    }

    /// Its name, readable.
    fn shown(&self) -> String {
        format!("chunk {}", self.name.escape_ascii())
    }
}

/// The numbers of the first chunk that others depend on.
#[derive(Clone, Copy)]
struct Header {
    size: (u32, u32),
    color_type: u8,
}

/// What has come so far.
#[derive(Default)]
struct Seen {
    header: Option<Header>,
    palette: bool,
    data: bool,
    /// The chunk before was one of image data.
    in_data: bool,
}

/// Checks length, name and check sum of every chunk up to the last, the header's numbers, and that what a picture
/// needs is there and in order. What stands behind the last chunk does not count.
pub fn check(bytes: &[u8]) -> Result<Still<'_>> {
    let mut source = Source::new(Format::Png, bytes);
    let signature = &bytes[..bytes.len().min(SIGNATURE.len())];
    if signature != SIGNATURE {
        let [found, expected] = [signature, SIGNATURE].map(|s| format!("\"{}\"", s.escape_ascii()));
        return Err(source.fault(found, expected));
    }
    source.at = SIGNATURE.len();
    let mut seen = Seen::default();
    let mut animation = Vec::new();
    loop {
        let chunk = read(&mut source, &seen)?;
        seen.take(&source, &chunk)?;
        if matches!(&chunk.name, b"acTL" | b"fcTL" | b"fdAT") {
            animation.push((chunk.at, chunk.end()));
        }
        source.at = chunk.end();
        if let (b"IEND", Some(header)) = (&chunk.name, seen.header) {
            let (bytes, left_out) = without(&bytes[..source.at], &animation);
            return Ok(Still { bytes, size: header.size, left_out });
        }
    }
}

/// The chunk at the present place.
fn read<'a>(source: &mut Source<'a>, seen: &Seen) -> Result<Chunk<'a>> {
    let at = source.at;
    let rest = source.rest();
    let Some((head, rest)) = rest.split_at_checked(8) else {
        let expected = match (seen.header, seen.data) {
            (None, _) => "chunk IHDR",
            (_, false) => "chunk IDAT, with the picture",
            _ => "chunk IEND",
        };
        source.at += rest.len();
        return Err(source.fault("the end of the file", expected));
    };
    let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]);
    let name = [head[4], head[5], head[6], head[7]];
    if !name.iter().all(u8::is_ascii_alphabetic) {
        source.at += 4;
        return Err(source.fault(
            format!("\"{}\"", name.escape_ascii()),
            "the name of a chunk, four letters, behind the chunk before it",
        ));
    }
    let whole = (length as usize).checked_add(4).filter(|whole| *whole <= rest.len());
    let Some(whole) = whole else {
        let left = rest.len().saturating_sub(4);
        return Err(source.fault(
            format!("chunk {} of {length} bytes", name.escape_ascii()),
            format!("at most the {left} bytes that are left before the end of the file"),
        ));
    };
    let (data, sum) = rest[..whole].split_at(whole - 4);
    let chunk = Chunk { at, name, data };
    let found = sum.first_chunk().map_or(0, |sum| u32::from_be_bytes(*sum));
    let mut crc = crc32fast::Hasher::new();
    crc.update(&name);
    crc.update(data);
    let expected = crc.finalize();
    if found != expected {
        source.at += 8 + data.len();
        return Err(
            source.fault(format!("CRC 0x{found:08x} of {}", chunk.shown()), format!("CRC 0x{expected:08x}"))
        );
    }
    Ok(chunk)
}

impl Seen {
    /// Adds a chunk, if it may stand here.
    fn take(&mut self, source: &Source<'_>, chunk: &Chunk<'_>) -> Result<()> {
        let first = self.header.is_none();
        if first != (&chunk.name == b"IHDR") {
            let expected = if first { "chunk IHDR first" } else { "one chunk IHDR alone" };
            return Err(source.fault(chunk.shown(), expected));
        }
        let is_data = &chunk.name == b"IDAT";
        match &chunk.name {
            b"IHDR" => self.header = Some(header(source, chunk)?),
            b"PLTE" => self.add_palette(source, chunk)?,
            b"IDAT" => self.add_data(source, chunk)?,
            b"IEND" => self.end(source, chunk)?,
            // A capital says that the picture cannot be understood without this chunk.
            [b'A'..=b'Z', ..] => return Err(source.unsupported(chunk.shown(), "IHDR, PLTE, IDAT and IEND")),
            _ => {}
        }
        self.in_data = is_data;
        Ok(())
    }

    fn add_palette(&mut self, source: &Source<'_>, chunk: &Chunk<'_>) -> Result<()> {
        let length = chunk.data.len();
        if self.palette || self.data {
            return Err(source.fault(chunk.shown(), "one alone, before the first IDAT"));
        }
        if !length.is_multiple_of(3) || !(3..=768).contains(&length) {
            let found = format!("{} of {length} bytes", chunk.shown());
            return Err(source.fault(found, "1 to 256 colours of 3 bytes"));
        }
        self.palette = true;
        Ok(())
    }

    fn add_data(&mut self, source: &Source<'_>, chunk: &Chunk<'_>) -> Result<()> {
        if self.data && !self.in_data {
            return Err(source.fault("chunk IDAT behind others", "all chunks IDAT in a row"));
        }
        if self.header.is_some_and(|header| header.color_type == PALETTE) && !self.palette {
            return Err(source.fault(chunk.shown(), "chunk PLTE, with the colours, before it"));
        }
        self.data = true;
        Ok(())
    }

    fn end(&self, source: &Source<'_>, chunk: &Chunk<'_>) -> Result<()> {
        if !self.data {
            return Err(source.fault(chunk.shown(), "chunk IDAT, with the picture, before it"));
        }
        if !chunk.data.is_empty() {
            return Err(source.fault(format!("{} of {} bytes", chunk.shown(), chunk.data.len()), "0 bytes"));
        }
        Ok(())
    }
}

/// The kind of colour of pictures that have numbers of colours in a table.
const PALETTE: u8 = 3;

/// The numbers of the first chunk, if there is such a picture and its size is within reason.
fn header(source: &Source<'_>, chunk: &Chunk<'_>) -> Result<Header> {
    let Some((side, &[depth, color_type, compression, filter, interlace])) = chunk.data.split_at_checked(8)
    else {
        let found = format!("{} of {} bytes", chunk.shown(), chunk.data.len());
        return Err(source.fault(found, "13 bytes"));
    };
    // The numbers stand behind the length and the name of the chunk.
    let at = |n: usize| source.placed(chunk.at + 8 + n);
    let side = |n: usize| u64::from(u32::from_be_bytes([side[n], side[n + 1], side[n + 2], side[n + 3]]));
    let size = at(0).check_size(side(0), side(4), PIXELS_PER_BYTE)?;
    let depths: &[u8] = match color_type {
        0 => &[1, 2, 4, 8, 16],
        2 | 4 | 6 => &[8, 16],
        PALETTE => &[1, 2, 4, 8],
        _ => {
            let found = format!("colour type {color_type}");
            let expected = "0 (grey), 2 (colour), 3 (palette), 4 (grey and alpha) or 6 (colour and alpha)";
            return Err(at(9).fault(found, expected));
        }
    };
    if !depths.contains(&depth) {
        let list: Vec<String> = depths.iter().map(u8::to_string).collect();
        let found = format!("bit depth {depth} with colour type {color_type}");
        return Err(at(8).fault(found, format!("one of {}", list.join(", "))));
    }
    let methods =
        [("compression", compression, "0"), ("filter", filter, "0"), ("interlace", interlace, "0 or 1")];
    for (n, (what, method, expected)) in methods.into_iter().enumerate() {
        if method > u8::from(what == "interlace") {
            return Err(at(10 + n).fault(format!("{what} method {method}"), expected));
        }
    }
    Ok(Header { size, color_type })
}

/// The bytes without these ranges, and where in what is left these were and how long.
fn without<'a>(bytes: &'a [u8], ranges: &[(usize, usize)]) -> (Cow<'a, [u8]>, Vec<(usize, usize)>) {
    if ranges.is_empty() {
        return (Cow::Borrowed(bytes), Vec::new());
    }
    let (mut kept, mut left_out, mut from) = (Vec::new(), Vec::with_capacity(ranges.len()), 0);
    for &(start, end) in ranges {
        kept.extend_from_slice(&bytes[from..start]);
        left_out.push((kept.len(), end - start));
        from = end;
    }
    kept.extend_from_slice(&bytes[from..]);
    (Cow::Owned(kept), left_out)
}
