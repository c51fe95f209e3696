//! The header of a BMP file \[BMP\], and whether its palette has all colours of the picture.

use crate::codec::palette::first_outside;
use crate::codec::{Result, Source};

/// Bytes before the header of the picture.
const FILE_HEADER: usize = 14;

/// Width and height in pixels, and the byte where they stand.
pub fn size(source: &Source<'_>) -> Result<([u64; 2], usize)> {
    let mut source = source.placed(0);
    source.take(FILE_HEADER, "the header of the file")?;
    let header = source.take(4, "the length of the header")?;
    let at = source.at;
    // In words in the oldest files; rows from the top have a negative height.
    if header == [12, 0, 0, 0] {
        let h = source.take(4, "the size")?;
        return Ok(([[h[0], h[1]], [h[2], h[3]]].map(|n| u64::from(u16::from_le_bytes(n))), at));
    }
    let h = source.take(8, "the size")?;
    let side = |at: usize| i32::from_le_bytes([h[at], h[at + 1], h[at + 2], h[at + 3]]);
    Ok(([u64::try_from(side(0)).unwrap_or(0), side(4).unsigned_abs().into()], at))
}

/// Checks the colours of a picture of this size if its palette is shorter than its samples could name. What is wrong in
/// other ways is left to the library.
pub fn check_colors(source: &Source<'_>, [width, height]: [usize; 2]) -> Result<()> {
    let bytes = source.bytes;
    let number = |at: usize| {
        bytes.get(at..).and_then(|b| b.first_chunk()).map_or(0, |b| u32::from_le_bytes(*b)) as usize
    };
    // The oldest files, whose header has 12 bytes, have whole palettes.
    let (depth, colors) = (number(28) & 0xffff, number(46));
    if number(FILE_HEADER) < 40 || !matches!(depth, 1 | 2 | 4 | 8) || colors == 0 || colors >= 1 << depth {
        return Ok(());
    }
    let data = number(10).min(bytes.len());
    let depth = depth as u32;
    let outside = match number(30) {
        0 => plain(&bytes[data..], depth, [width, height], colors),
        1 | 2 => runs(&bytes[data..], depth, height, colors),
        _ => None,
    };
    let Some((at, color)) = outside else { return Ok(()) };
    let source = source.placed(data + at);
    Err(source.fault(format!("colour {color}"), format!("colours 0 to {} of the palette", colors - 1)))
}

/// The first colour outside of the palette, and its byte, in rows of a multiple of four bytes.
fn plain(data: &[u8], depth: u32, [width, height]: [usize; 2], colors: usize) -> Option<(usize, usize)> {
    let stride = (width * depth as usize).div_ceil(32) * 4;
    let rows = data.chunks(stride.max(1)).take(height).enumerate();
    rows.filter_map(|(y, row)| first_outside(row, depth, width, colors).map(|(at, c)| (y * stride + at, c)))
        .next()
}

/// The same in runs of pixels.
fn runs(data: &[u8], depth: u32, height: usize, colors: usize) -> Option<(usize, usize)> {
    let (mut at, mut row) = (0, 0);
    while let (Some(&[count, value]), true) = (data.get(at..at + 2), row < height) {
        at += 2;
        let (literals, length) = match (count, value) {
            (0, 0) => {
                row += 1;
                continue;
            }
            (0, 1) => return None,
            // Steps across and down.
            (0, 2) => {
                row += usize::from(*data.get(at + 1)?);
                at += 2;
                continue;
            }
            (0, count) => (usize::from(count), (usize::from(count) * depth as usize).div_ceil(8)),
            // A value of two samples is repeated: it is enough to see each of them once.
            (count, _) => (usize::from(count).min(8 / depth as usize), 0),
        };
        let start = if length > 0 { at } else { at - 1 };
        let end = start + length.max(1);
        if let Some((byte, color)) = first_outside(data.get(start..end)?, depth, literals, colors) {
            return Some((start + byte, color));
        }
        // Literal pixels take an even number of bytes.
        at += length.next_multiple_of(2);
    }
    None
}
