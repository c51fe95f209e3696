//! The chunks of a WebP file \[WebP\]: the decoding library takes what a cut file lacks for zeros.

use crate::codec::{Result, Source};
use std::ops::Range;

/// Bytes of the length and name before what is in a chunk.
const HEAD: usize = 8;

/// Bytes before the chunks in a frame of an animation.
const FRAME: usize = 16;

/// Checks that the file is as long as it says, and that its chunks fill it. What stands behind does not count.
pub fn check(source: &Source<'_>) -> Result<()> {
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
    chunks(&mut source, end, canvas)
}

/// Width and height in the first chunk of a file that begins with these bytes.
pub fn size(head: &[u8]) -> Option<[u32; 2]> {
    let name = head.get(12..)?.first_chunk()?;
    let data = head.get(12 + HEAD..)?;
    // Flags stand before the canvas.
    if name == b"VP8X" { data.get(4..10).map(canvas) } else { picture_size(name, data) }
}

/// Goes over chunks up to `end`. Pictures in them must be as large as the canvas, if there is any: the library takes
/// memory for them before it compares.
fn chunks(source: &mut Source<'_>, end: usize, size: Option<[u32; 2]>) -> Result<()> {
    while source.at < end {
        let at = source.at;
        let (name, data) = chunk(source, end)?;
        let found = picture_size(&name, &source.bytes[data.clone()]);
        if let (Some(found), Some(size)) = (found.filter(|found| Some(*found) != size), size) {
            let [found, size] = [found, size].map(|[w, h]| format!("{w} × {h} pixels"));
            source.at = at;
            return Err(source.fault(format!("a picture of {found}"), format!("{size}, as its canvas")));
        }
        if &name == b"ANMF" && data.len() >= FRAME {
            let frame = canvas(&source.bytes[data.start + 6..data.start + 12]);
            if size.is_none_or(|size| frame[0] > size[0] || frame[1] > size[1]) {
                let [w, h] = frame;
                source.at = at;
                return Err(source.fault(format!("a frame of {w} × {h} pixels"), "at most the canvas"));
            }
            let next = source.at;
            source.at = data.start + FRAME;
            chunks(source, data.end, Some(frame))?;
            source.at = next;
        }
    }
    Ok(())
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
