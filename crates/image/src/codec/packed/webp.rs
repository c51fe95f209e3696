//! The chunks of a WebP file \[WebP\]: the decoding library takes what a cut file lacks for zeros.

use crate::codec::{Result, Source};
use std::ops::Range;

/// Bytes of the length and name before what is in a chunk.
const HEAD: usize = 8;

/// Bytes before the chunks in a frame of an animation.
const FRAME: usize = 16;

/// The file without what stands behind it, which the decoding library would take for chunks. Checks that the file is as
/// long as it says, that its chunks fill it, and that pictures are as large as their canvas.
pub fn check<'a>(source: &Source<'a>) -> Result<&'a [u8]> {
    let mut source = source.placed(4);
    let size = length(source.take(4, "the size of the file")?);
    // The size counts what follows it; the last chunk's padding may be left out on both sides.
    let (end, length_of_file) = (size.saturating_add(HEAD), source.bytes.len());
    source.at = 4;
    if end > length_of_file {
        return Err(source.fault(
            format!("a size of {size} bytes in a file of {length_of_file}"),
            format!("at most the {} bytes that follow", length_of_file - HEAD),
        ));
    }
    source.at = HEAD;
    if source.bytes[HEAD..end].len() < 4 + HEAD {
        source.at = 4;
        return Err(source.fault(format!("a size of {size} bytes"), "room for a chunk with the picture"));
    }
    source.at += 4;
    check_picture(&source)?;
    let canvas = self::size(source.bytes).filter(|_| source.rest().starts_with(b"VP8X"));
    while source.at < end {
        let at = source.at;
        let (name, data) = chunk(&mut source, end)?;
        let chunk = source.placed(at);
        match (&name, canvas) {
            (b"ANMF", Some(canvas)) if data.len() >= FRAME => check_frame(&chunk, data, canvas)?,
            (_, canvas) => check_filled(&chunk, picture_size(&name, &source.bytes[data]), canvas)?,
        }
    }
    Ok(&source.bytes[..end])
}

/// Width and height in the first chunk of a file that begins with these bytes.
pub fn size(head: &[u8]) -> Option<[u32; 2]> {
    let name = head.get(12..)?.first_chunk()?;
    let data = head.get(12 + HEAD..)?;
    // Flags stand before the canvas.
    if name == b"VP8X" { data.get(4..10).map(canvas) } else { picture_size(name, data) }
}

/// Checks a frame of an animation, which stands at `source.at`. Behind its transparency comes a lossy picture: the
/// library takes the next chunk for one whatever its name.
fn check_frame(source: &Source<'_>, data: Range<usize>, most: [u32; 2]) -> Result<()> {
    let size = canvas(&source.bytes[data.start + 6..data.start + 12]);
    if size[0] > most[0] || size[1] > most[1] {
        let [w, h] = size;
        return Err(source.fault(format!("a frame of {w} × {h} pixels"), "at most the canvas"));
    }
    let mut inside = source.placed(data.start + FRAME);
    let mut before = *b"ANMF";
    while inside.at < data.end {
        let at = inside.at;
        let (name, data) = chunk(&mut inside, data.end)?;
        let chunk = source.placed(at);
        if &before == b"ALPH" && &name != b"VP8 " {
            return Err(
                chunk.fault(format!("chunk \"{}\"", name.escape_ascii()), "chunk VP8 behind chunk ALPH")
            );
        }
        check_filled(&chunk, picture_size(&name, &source.bytes[data]), Some(size))?;
        before = name;
    }
    Ok(())
}

/// A picture must be as large as its canvas, if there is any: the library takes memory for it before it compares.
fn check_filled(source: &Source<'_>, picture: Option<[u32; 2]>, canvas: Option<[u32; 2]>) -> Result<()> {
    match picture.zip(canvas).filter(|(picture, canvas)| picture != canvas) {
        Some(sizes) => {
            let [found, expected] = [sizes.0, sizes.1].map(|[w, h]| format!("{w} × {h} pixels"));
            Err(source.fault(format!("a picture of {found}"), format!("{expected}, as its canvas")))
        }
        None => Ok(()),
    }
}

/// Width and height, less one, in three bytes each.
fn canvas(bytes: &[u8]) -> [u32; 2] {
    [0, 3].map(|at| 1 + u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0]))
}

/// Width and height in the data of a lossy or lossless picture.
fn picture_size(name: &[u8; 4], data: &[u8]) -> Option<[u32; 2]> {
    match name {
        b"VP8 " => {
            let side = |at| Some(u32::from(u16::from_le_bytes(*data.get(at..)?.first_chunk()?) & 0x3fff));
            Some([side(6)?, side(8)?])
        }
        b"VP8L" => {
            let bits = u32::from_le_bytes(*data.get(1..)?.first_chunk()?);
            Some([(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1])
        }
        _ => None,
    }
}

/// The first chunk says what the picture is.
fn check_picture(source: &Source<'_>) -> Result<()> {
    let name = &source.rest()[..4];
    if [b"VP8 ", b"VP8L", b"VP8X"].contains(&&[name[0], name[1], name[2], name[3]]) {
        return Ok(());
    }
    Err(source.fault(format!("chunk \"{}\"", name.escape_ascii()), "chunk VP8, VP8L or VP8X"))
}

/// Goes over a chunk, and its padding to an even length; its name, and where its data are.
fn chunk(source: &mut Source<'_>, end: usize) -> Result<([u8; 4], Range<usize>)> {
    let left = end - source.at;
    if left < HEAD {
        let found = format!("{left} bytes behind the last chunk");
        return Err(source.fault(found, "the end of the file, or a whole chunk"));
    }
    let head = source.rest();
    let (name, size) = ([head[0], head[1], head[2], head[3]], length(&head[4..HEAD]));
    if size > left - HEAD {
        return Err(source.fault(
            format!("chunk \"{}\" of {size} bytes", name.escape_ascii()),
            format!("at most the {} bytes left of the size of the file", left - HEAD),
        ));
    }
    let start = source.at + HEAD;
    // The padding of the last chunk may be left out.
    source.at = (start + size + size % 2).min(source.bytes.len());
    Ok((name, start..start + size))
}

/// Four bytes, the lowest first.
fn length(bytes: &[u8]) -> usize {
    bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes) as usize)
}
