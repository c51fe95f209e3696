//! JPEG: quality 95 out; grey and colour in.

mod scan;

use super::{Result, Source, Transfer, coded, expected, finish, zeroed};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use crate::tone::quantise;
use ::image::ExtendedColorType;
use ::image::codecs::jpeg::JpegEncoder;
use std::io::{Cursor, Write};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::colorspace::ColorSpace as JpegColors;
use zune_jpeg::zune_core::options::DecoderOptions;

const QUALITY: u8 = 95;

/// The fewest bits an 8 × 8 block can take leave this many pixels to a byte.
pub const PIXELS_PER_BYTE: u64 = 1024;

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let unwritable = |reason| ImageErrorKind::NotWritable { format: Format::Jpeg, reason };
    let bytes = quantise(image, options.tone, options.exposure);
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, QUALITY)
        .encode(&bytes, image.width(), image.height(), ExtendedColorType::Rgb8)
        .map_err(|e| unwritable(e.to_string()))?;
    // Comments go after the start-of-image mark and the first segment (JFIF wants to be first).
    let first = file.get(4..6).map_or(0, |l| usize::from(u16::from_be_bytes([l[0], l[1]])) + 4);
    let (head, tail) = file.split_at(first.min(file.len()));
    w.write_all(head)?;
    for (name, text) in &options.metadata {
        let comment = format!("{name}: {text}");
        let length = u16::try_from(comment.len() + 2)
            .map_err(|_| unwritable(format!("the text of \"{name}\" is longer than 65 533 bytes")))?;
        w.write_all(&[0xff, 0xfe])?;
        w.write_all(&length.to_be_bytes())?;
        w.write_all(comment.as_bytes())?;
    }
    w.write_all(tail)?;
    Ok(())
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    check_frame(bytes)?;
    let mut cursor = Cursor::new(bytes);
    // The portable code path of the decoder: the same bits on every processor.
    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_strict_mode(true)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let mut decoder = JpegDecoder::new_with_options(&mut cursor, options);
    let headers = decoder.decode_headers();
    let info = decoder.info();
    let grey = decoder.input_colorspace() == Some(JpegColors::Luma);
    let (Ok(()), Some(info)) = (&headers, info) else {
        drop(decoder);
        return Err(fault(&cursor, headers.err().as_ref()));
    };
    let at = first_segment(bytes, is_frame).unwrap_or(0);
    let source = Source { format: Format::Jpeg, bytes, at };
    let (width, height) = source.check_size(info.width.into(), info.height.into(), PIXELS_PER_BYTE)?;
    require_end(bytes)?;
    let (out, channels) = if grey { (JpegColors::Luma, 1) } else { (JpegColors::RGB, 3) };
    decoder.set_options(options.jpeg_set_out_colorspace(out));
    let mut buffer = zeroed::<u8>(width, height, channels)?;
    if let Err(error) = decoder.decode_into(&mut buffer) {
        drop(decoder);
        return Err(fault(&cursor, Some(&error)));
    }
    // Now that the library has found the number of scans within reason.
    if let Some(at) = scan::cut_at(bytes) {
        let found = "the end of the data of the picture";
        return Err(Source { format: Format::Jpeg, bytes, at }.fault(found, "data for all of its blocks"));
    }
    let transfer = Transfer::of(space, Transfer::Srgb);
    let samples = coded(buffer, 255, transfer);
    Ok(finish(Format::Jpeg, (width, height), channels, samples, transfer != Transfer::Linear))
}

/// Whether a mark is that of a frame: C0 to CF, but for tables, conditions of arithmetic coding and a spare one.
pub fn is_frame(mark: u8) -> bool {
    matches!(mark, 0xc0..=0xcf) && !matches!(mark, 0xc4 | 0xc8 | 0xcc)
}

/// Refuses what is neither baseline, extended nor progressive with Huffman codes \[JPEG\], and sizes that the file cannot
/// hold.
fn check_frame(bytes: &[u8]) -> Result<()> {
    let Some(at) = first_segment(bytes, is_frame) else { return Ok(()) };
    let source = Source { format: Format::Jpeg, bytes, at };
    let mark = bytes[at + 1];
    let what = match mark {
        0xc3 => "lossless coding",
        0xc5..=0xc7 => "hierarchical coding",
        0xc9 | 0xca => "arithmetic coding",
        0xcb => "lossless arithmetic coding",
        0xcd..=0xcf => "hierarchical arithmetic coding",
        _ => {
            // Mark, length and depth stand before the size.
            let Some(&[h0, h1, w0, w1]) = bytes.get(at + 5..at + 9) else { return Ok(()) };
            let [height, width] = [[h0, h1], [w0, w1]].map(|n| u16::from_be_bytes(n).into());
            return source.check_size(width, height, PIXELS_PER_BYTE).map(drop);
        }
    };
    Err(source.unsupported(format!("{what} (SOF{})", mark - 0xc0), "baseline or progressive"))
}

fn fault(cursor: &Cursor<&[u8]>, error: Option<&DecodeErrors>) -> ImageErrorKind {
    let at = cursor.position() as usize;
    let source = Source { format: Format::Jpeg, bytes: cursor.get_ref(), at };
    let text = match error {
        Some(DecodeErrors::ExhaustedData | DecodeErrors::IoErrors(_)) | None => {
            return source.fault("the end of the file", "the rest of the picture");
        }
        Some(error) => one_line(&error.to_string()),
    };
    if text.contains("Premature End") {
        return source.fault("the end of the file", "the rest of the picture");
    }
    let expected = expected(&WORDS, &text).unwrap_or("valid JPEG data");
    source.fault(text, expected)
}

/// What texts of the library contain, and what was expected then.
const WORDS: [(&str, &str); 13] = [
    ("Number of components cannot be zero", "a frame (SOF) of 1, 3 or 4 components before the first scan"),
    ("Start of Frame", "one frame (SOF)"),
    ("start of frame", "3 bytes for each component behind 8 others"),
    ("bits of precision", "8 bits"),
    ("invalid length", "the length of a segment, 2 or more"),
    ("Extra bytes", "the mark of the next segment"),
    ("component id", "a component of the frame"),
    ("able for component", "its table before the first scan"),
    ("uffman", "tables and codes of Huffman's kind (DHT)"),
    ("DQT", "tables of quantisation (DQT) of 64 values"),
    ("SOS", "the header of a scan (SOS) that fits the frame"),
    ("marker in bit stream", "codes of the picture, or the mark of a restart"),
    ("ampl", "1, 2 or 4 samples across and down"),
];

/// How texts of the library begin that only repeat what follows.
const HEADS: [&str; 5] = [
    "Error decoding huffman values: ",
    "Error parsing DQT segment. Reason:",
    "Error parsing SOF segment. Reason:",
    "Error parsing SOS Segment. Reason:",
    "[strict-mode]: ",
];

/// A text of the library, which it may have put in quotes with marks for ends of lines, as a part of a sentence.
fn one_line(text: &str) -> String {
    let text = text
        .replace("\\n", " ")
        .replace('"', "")
        .replace("one one of", "one of")
        .replace(" at index  {}", "");
    let text = HEADS.iter().find_map(|head| text.strip_prefix(head)).unwrap_or(&text);
    text.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches('.').to_owned()
}

/// A file cut off in its picture still decodes, with grey where the rest should be; so the end mark is required.
fn require_end(bytes: &[u8]) -> Result<()> {
    let picture = first_segment(bytes, |mark| mark == 0xda).unwrap_or(bytes.len());
    if bytes[picture..].windows(2).any(|pair| pair == [0xff, 0xd9]) {
        return Ok(());
    }
    let source = Source { format: Format::Jpeg, bytes, at: bytes.len() };
    Err(source.fault("the end of the file", "more of the picture, then the end mark FF D9"))
}

/// Where the first segment with such a mark starts.
pub fn first_segment(bytes: &[u8], wanted: impl Fn(u8) -> bool) -> Option<usize> {
    let mut at = 2;
    loop {
        match *bytes.get(at..at + 2)? {
            [0xff, mark] if wanted(mark) => return Some(at),
            // Fill bytes, and marks without a segment.
            [0xff, 0xff] => at += 1,
            [0xff, 0x00 | 0x01 | 0xd0..=0xd8] => at += 2,
            [0xff, _] => {
                let length = bytes.get(at + 2..at + 4)?;
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
            _ => at += 1,
        }
    }
}
