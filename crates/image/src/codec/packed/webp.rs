//! The chunks of a WebP file \[WebP\]: the decoding library takes what a cut file lacks for zeros.

use crate::codec::{Result, Source};

/// Bytes of the length and name before what is in a chunk.
const HEAD: usize = 8;

/// Checks that the file is as long as it says, and that its chunks fill it. What stands behind does not count.
pub fn check(source: &Source<'_>) -> Result<()> {
    let mut source = Source { format: source.format, bytes: source.bytes, at: 4 };
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
    while source.at < end {
        chunk(&mut source, end)?;
    }
    Ok(())
}

/// The first chunk says what the picture is.
fn check_picture(source: &Source<'_>) -> Result<()> {
    let name = &source.rest()[..4];
    if [b"VP8 ", b"VP8L", b"VP8X"].contains(&&[name[0], name[1], name[2], name[3]]) {
        return Ok(());
    }
    Err(source.fault(format!("chunk \"{}\"", name.escape_ascii()), "chunk VP8, VP8L or VP8X"))
}

/// Goes over a chunk, and its padding to an even length.
fn chunk(source: &mut Source<'_>, end: usize) -> Result<()> {
    let left = end - source.at;
    if left < HEAD {
        let found = format!("{left} bytes behind the last chunk");
        return Err(source.fault(found, "the end of the file, or a whole chunk"));
    }
    let (name, size) = source.rest()[..HEAD].split_at(4);
    let size = length(size);
    if size > left - HEAD {
        return Err(source.fault(
            format!("chunk \"{}\" of {size} bytes", name.escape_ascii()),
            format!("at most the {} bytes left of the size of the file", left - HEAD),
        ));
    }
    source.at += HEAD + size + size % 2;
    Ok(())
}

/// Four bytes, the lowest first.
fn length(bytes: &[u8]) -> usize {
    bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes) as usize)
}
