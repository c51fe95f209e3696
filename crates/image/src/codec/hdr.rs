//! Radiance RGBE \[Ward1991\]: three mantissas and a shared exponent in four bytes, run-length coded.

use super::{Result, Source, Transfer, finish, room};
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use std::io::Write;

/// Widths for which rows are stored as four run-length coded planes.
const PLANAR_WIDTHS: std::ops::RangeInclusive<u32> = 8..=0x7fff;

/// Longest header line that is read, in bytes.
const MAX_LINE: usize = 4096;

/// Run-length coding in planes makes at best 127 values of two bytes; the older form repeats pixels further.
pub const PIXELS_PER_BYTE: u64 = 256;

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    w.write_all(b"#?RADIANCE\n")?;
    for (name, text) in &options.metadata {
        let line: String = format!("# {name}: {text}").chars().filter(|c| !c.is_control()).collect();
        writeln!(w, "{line}")?;
    }
    write!(w, "FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height(), image.width())?;
    let width = image.width() as usize;
    let pixels: Vec<[u8; 4]> = image.rgb_pixels().map(to_rgbe).collect();
    let mut bytes = Vec::with_capacity(width * 4);
    for row in pixels.chunks_exact(width) {
        bytes.clear();
        if PLANAR_WIDTHS.contains(&image.width()) {
            bytes.extend([2, 2, (width >> 8) as u8, width as u8]);
            for plane in 0..4 {
                let values: Vec<u8> = row.iter().map(|p| p[plane]).collect();
                encode_plane(&values, &mut bytes);
            }
        } else {
            bytes.extend(row.as_flattened());
        }
        w.write_all(&bytes)?;
    }
    Ok(())
}

/// Runs of at least three equal values (up to 127) and stretches of others (up to 128).
fn encode_plane(values: &[u8], out: &mut Vec<u8>) {
    let run_at = |i: usize| values[i..].iter().take(127).take_while(|v| **v == values[i]).count();
    let mut at = 0;
    while at < values.len() {
        let run = run_at(at);
        if run >= 3 {
            out.extend([128 + run as u8, values[at]]);
            at += run;
            continue;
        }
        let start = at;
        while at < values.len() && at - start < 128 && run_at(at) < 3 {
            at += 1;
        }
        out.push((at - start) as u8);
        out.extend(&values[start..at]);
    }
}

/// The colour rounded to 8 bits of its largest component. Negative values and NaN become 0, values beyond the format's
/// range its largest one.
fn to_rgbe(rgb: [f32; 3]) -> [u8; 4] {
    // Largest value of the format: 255/256 · 2¹²⁷.
    let largest = f32::from_bits(0x7eff_0000);
    let rgb = rgb.map(|c| c.max(0.0).min(largest));
    let top = rgb[0].max(rgb[1]).max(rgb[2]);
    if top < f32::MIN_POSITIVE {
        return [0; 4];
    }
    // The smallest power of two above `top` has this exponent (top is not subnormal): −125 to 127.
    let mut exponent = (top.to_bits() >> 23) as i32 - 126;
    if (top * two_to(-exponent) * 256.0).round() > 255.0 && exponent < 127 {
        exponent += 1;
    }
    let [r, g, b] = rgb.map(|c| (c * two_to(-exponent) * 256.0).round() as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// 2^n, exactly, for n from −127 to 127.
fn two_to(n: i32) -> f32 {
    // 2⁻¹²⁷ is subnormal: a single bit of the fraction.
    if n == -127 { f32::from_bits(1 << 22) } else { f32::from_bits(((n + 127) as u32) << 23) }
}

fn from_rgbe(pixel: [u8; 4]) -> [f32; 3] {
    let [r, g, b, e] = pixel;
    if e == 0 {
        return [0.0; 3];
    }
    [r, g, b].map(|m| f32::from(m) / 256.0 * two_to(i32::from(e) - 128))
}

/// What the header says.
struct Header {
    width: u32,
    height: u32,
    /// The file holds columns, one after the other, instead of rows.
    columns: bool,
    bottom_up: bool,
    right_to_left: bool,
    /// Product of the exposures, by which the stored values are to be divided.
    exposure: f32,
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let mut source = Source::new(Format::Hdr, bytes);
    let header = read_header(&mut source)?;
    let (lines, length) =
        if header.columns { (header.width, header.height) } else { (header.height, header.width) };
    // Every line takes four bytes at least: a gigantic number of them in a short file ends here.
    let rest = source.rest().len();
    if rest / 4 < lines as usize {
        return Err(source.fault(format!("{rest} more bytes"), format!("{lines} lines of pixels")));
    }
    let mut samples = room(header.width, header.height, 3)?;
    let mut line = vec![[0u8; 4]; length as usize];
    for _ in 0..lines {
        read_row(&mut source, &mut line)?;
        samples.extend(line.iter().flat_map(|p| from_rgbe(*p)).map(|v| v / header.exposure));
    }
    if header.columns {
        samples = transposed(&samples, length as usize);
    }
    if header.right_to_left {
        for row in samples.chunks_exact_mut(header.width as usize * 3) {
            row.as_chunks_mut::<3>().0.reverse();
        }
    }
    if header.bottom_up {
        samples = samples.chunks_exact(header.width as usize * 3).rev().flatten().copied().collect();
    }
    let transfer = Transfer::of(space, Transfer::Linear);
    transfer.apply_to_colors(&mut samples, 3);
    let size = (header.width, header.height);
    Ok(finish(Format::Hdr, size, 3, samples, transfer != Transfer::Linear))
}

/// Columns of that length as rows.
fn transposed(columns: &[f32], length: usize) -> Vec<f32> {
    let pixels = columns.as_chunks::<3>().0;
    let row = |y: usize| pixels.iter().skip(y).step_by(length);
    (0..length).flat_map(row).flatten().copied().collect()
}

fn read_header(source: &mut Source<'_>) -> Result<Header> {
    let mut exposure = 1.0f32;
    loop {
        let start = source.at;
        let Some(line) = source.line(MAX_LINE) else {
            return Err(source.fault("the end of the file", "an empty line, then the size"));
        };
        let text = String::from_utf8_lossy(line);
        let text = text.trim_end();
        if text.is_empty() {
            break;
        }
        if let Some(format) = text.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            source.at = start;
            return Err(source.unsupported(quoted(text), "FORMAT=32-bit_rle_rgbe"));
        }
        if let Some(value) = text.strip_prefix("EXPOSURE=") {
            match value.trim().parse::<f32>() {
                Ok(value) if value.is_finite() && value > 0.0 => exposure *= value,
                _ => {
                    source.at = start;
                    return Err(source.fault(quoted(text), "an exposure: a number above 0"));
                }
            }
        }
    }
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(source.fault(format!("a total exposure of {exposure}"), "a finite number above 0"));
    }
    read_size(source, exposure)
}

/// The line `-Y height +X width`; other signs mirror the picture, and X first means columns.
fn read_size(source: &mut Source<'_>, exposure: f32) -> Result<Header> {
    let start = source.at;
    let line = source.line(MAX_LINE).unwrap_or_default();
    let after = source.at;
    source.at = start;
    let text = String::from_utf8_lossy(line).into_owned();
    let words: Vec<&str> = text.split_whitespace().collect();
    let fault = || source.fault(quoted(&text), "the size: -Y height +X width");
    let (columns, [y, height, x, width]) = match words[..] {
        [y @ ("+Y" | "-Y"), height, x @ ("+X" | "-X"), width] => (false, [y, height, x, width]),
        [x @ ("+X" | "-X"), width, y @ ("+Y" | "-Y"), height] => (true, [y, height, x, width]),
        _ => return Err(fault()),
    };
    let (Ok(height), Ok(width)) = (height.parse::<u64>(), width.parse::<u64>()) else {
        return Err(fault());
    };
    let (width, height) = source.check_size(width, height, PIXELS_PER_BYTE)?;
    source.at = after;
    Ok(Header { width, height, columns, bottom_up: y == "+Y", right_to_left: x == "-X", exposure })
}

fn quoted(text: &str) -> String {
    let cut: String = text.chars().take(80).collect();
    format!("\"{}\"", cut.escape_debug())
}

fn read_row(source: &mut Source<'_>, row: &mut [[u8; 4]]) -> Result<()> {
    match *source.rest() {
        [2, 2, high, low, ..] if high < 128 && PLANAR_WIDTHS.contains(&(row.len() as u32)) => {
            let width = usize::from(high) << 8 | usize::from(low);
            if width != row.len() {
                let found = format!("a row of {width} pixels");
                return Err(source.fault(found, format!("{} as in the header", row.len())));
            }
            source.at += 4;
            (0..4).try_for_each(|plane| read_plane(source, row, plane))
        }
        _ => read_old_row(source, row),
    }
}

fn read_plane(source: &mut Source<'_>, row: &mut [[u8; 4]], plane: usize) -> Result<()> {
    let mut x = 0;
    while x < row.len() {
        let place = source.at;
        let code = source.take(1, "a row of pixels")?[0];
        let (count, run) = if code > 128 { (usize::from(code) - 128, true) } else { (code.into(), false) };
        if count == 0 || count > row.len() - x {
            source.at = place;
            let found = format!("a run of {count} values");
            return Err(source.fault(found, format!("1 to {}, the rest of the row", row.len() - x)));
        }
        let values = source.take(if run { 1 } else { count }, "a row of pixels")?;
        for (i, pixel) in row[x..x + count].iter_mut().enumerate() {
            pixel[plane] = if run { values[0] } else { values[i] };
        }
        x += count;
    }
    Ok(())
}

/// Plain pixels; a pixel (1, 1, 1, n) repeats the one before n times, the next such pixel n·256 times, and so on.
fn read_old_row(source: &mut Source<'_>, row: &mut [[u8; 4]]) -> Result<()> {
    let (mut x, mut shift) = (0, 0u32);
    while x < row.len() {
        let place = source.at;
        let bytes = source.take(4, "a pixel")?;
        let pixel = [bytes[0], bytes[1], bytes[2], bytes[3]];
        if pixel[..3] != [1, 1, 1] {
            row[x] = pixel;
            (x, shift) = (x + 1, 0);
            continue;
        }
        let count = usize::from(pixel[3]).checked_shl(shift).unwrap_or(usize::MAX);
        if x == 0 || count > row.len() - x || shift > 24 {
            source.at = place;
            let found = format!("a repetition of {count} pixels at x = {x}");
            return Err(source.fault(found, format!("a pixel before it, and at most {} more", row.len() - x)));
        }
        let before = row[x - 1];
        row[x..x + count].fill(before);
        (x, shift) = (x + count, shift + 8);
    }
    Ok(())
}
