//! Portable float map \[PFM\]: a text header, then 32-bit floats, rows from bottom to top.

use super::{Result, Source, Transfer, finish, room};
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded};
use std::io::Write;

/// Grey for one and two channels, else colour; little-endian; alpha is left out.
pub fn encode(image: &Image, w: &mut dyn Write) -> Result<()> {
    let grey = image.channels() < 3;
    let kind = if grey { "Pf" } else { "PF" };
    write!(w, "{kind}\n{} {}\n-1.0\n", image.width(), image.height())?;
    let keep = if grey { 1 } else { 3 };
    let mut bytes = Vec::with_capacity(image.width() as usize * keep * 4);
    for row in image.rows().rev() {
        bytes.clear();
        bytes.extend(row.flat_map(|pixel| pixel.rgb().into_iter().take(keep)).flat_map(f32::to_le_bytes));
        w.write_all(&bytes)?;
    }
    Ok(())
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let mut source = Source::new(Format::Pfm, bytes);
    let channels = if source.take(2, "the mark")? == b"PF" { 3 } else { 1 };
    let width = size(&mut source, "a width")?;
    let height = size(&mut source, "a height")?;
    let start = source.at;
    let scale = match token(&mut source)?.parse::<f32>() {
        Ok(s) if s.is_finite() && s != 0.0 => s,
        _ => {
            source.at = start;
            let found = printable(&token(&mut source)?);
            source.at = start;
            return Err(source.fault(found, "a scale: a finite number other than 0"));
        }
    };
    source.take(1, "the blank before the pixels")?;
    let (width, height) = source.check_size(width, height, 1)?;
    let row_bytes = width as usize * channels as usize * 4;
    let pixels = source.take(row_bytes * height as usize, "pixels")?;
    let mut samples = room(width, height, channels)?;
    for row in pixels.chunks_exact(row_bytes).rev() {
        for sample in row.as_chunks::<4>().0 {
            let value = if scale < 0.0 { f32::from_le_bytes(*sample) } else { f32::from_be_bytes(*sample) };
            samples.push(value * scale.abs());
        }
    }
    let transfer = Transfer::of(space, Transfer::Linear);
    transfer.apply_to_colors(&mut samples, channels);
    Ok(finish(Format::Pfm, (width, height), channels, samples, transfer != Transfer::Linear))
}

fn size(source: &mut Source<'_>, what: &str) -> Result<u64> {
    let start = source.at;
    let text = token(source)?;
    text.parse::<u32>().map(u64::from).map_err(|_| {
        source.at = start;
        source.fault(printable(&text), format!("{what}: a whole number from 1 to {}", u32::MAX))
    })
}

/// The next word of the header; the blank after it stays.
fn token(source: &mut Source<'_>) -> Result<String> {
    while source.peek().is_some_and(|b| b.is_ascii_whitespace()) {
        source.at += 1;
    }
    let word: Vec<u8> =
        source.rest().iter().take(64).take_while(|b| !b.is_ascii_whitespace()).copied().collect();
    if word.is_empty() {
        return Err(source.fault("the end of the file", "width, height and scale"));
    }
    source.at += word.len();
    Ok(String::from_utf8_lossy(&word).into_owned())
}

fn printable(text: &str) -> String {
    format!("\"{}\"", text.escape_debug())
}
