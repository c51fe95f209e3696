//! OpenEXR files with channels of half the resolution, as luminance and chroma are stored \[OpenEXR\].
//!
//! The library refuses such files when it checks their headers. So it gets a copy that says that all channels are whole, and
//! unpacks each block by a header that says how many bytes come out.

use super::blocks::Blocks;
use super::{Choice, Fault, attribute_text, check_channel_count, check_layer, chosen, finished, reported};
use crate::codec::{Result, Source, zeroed};
use crate::format::Format;
use crate::io::{ColorSpace, Decoded};
use ::exr::block::chunk::CompressedBlock;
use ::exr::block::reader::ChunksReader;
use ::exr::error::Error;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::f16;
use std::io::Cursor;

/// How many pixels a sample stands for, across and down.
type Sampling = [usize; 2];

/// Flags in the version field: tiles, deep data, several parts.
const OTHER_KINDS: u32 = 0x200 | 0x800 | 0x1000;

/// Decodes a file with subsampled channels; `None` if it has none, or is not of the kind that may have some.
pub fn decode(bytes: &[u8], space: ColorSpace) -> Option<Result<Decoded>> {
    let (whole, samplings) = made_whole(bytes)?;
    Some(reported(&whole, |cursor, bytes| decode_from(cursor, bytes, &samplings, space)))
}

/// A copy of the file in which all channels have the full resolution, and what they have in truth. `None` if that is so
/// already, or if the header cannot be read, which the library will tell.
fn made_whole(bytes: &[u8]) -> Option<(Vec<u8>, Vec<Sampling>)> {
    let version = u32::from_le_bytes(*bytes.get(4..)?.first_chunk()?);
    let mut source = Source { format: Format::Exr, bytes, at: 8 };
    while version & OTHER_KINDS == 0 && source.peek()? != 0 {
        let name = attribute_text(&mut source);
        let kind = attribute_text(&mut source);
        let length = u32::from_le_bytes(*source.rest().first_chunk()?) as usize;
        source.at += 4;
        let end = source.at.checked_add(length).filter(|end| *end <= bytes.len())?;
        if name != b"channels" || kind != b"chlist" {
            source.at = end;
            continue;
        }
        let (mut whole, mut samplings) = (None, Vec::new());
        while source.at < end && source.peek()? != 0 {
            attribute_text(&mut source);
            // Type, linearity and three spare bytes stand before the two numbers.
            let at = source.at + 8;
            let number = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..end)?.first_chunk()?) as usize);
            let sampling = [number(at)?, number(at + 4)?];
            if sampling != [1, 1] {
                let copy = whole.get_or_insert_with(|| bytes.to_vec());
                copy[at..at + 8].copy_from_slice(&[1, 0, 0, 0, 1, 0, 0, 0]);
            }
            samplings.push(sampling);
            source.at = at + 8;
        }
        return Some((whole?, samplings));
    }
    None
}

fn decode_from(
    cursor: &mut Cursor<&[u8]>,
    bytes: &[u8],
    samplings: &[Sampling],
    space: ColorSpace,
) -> std::result::Result<Decoded, Fault> {
    let reader = ::exr::block::read(cursor, false)?;
    let source = Source::new(Format::Exr, bytes);
    check_channel_count(&source, reader.headers()).map_err(Fault::Ours)?;
    let choice = chosen(&source, reader.headers()).map_err(Fault::Ours)?;
    let mut header = reader.headers()[0].clone();
    let size = check_layer(&source, &header).map_err(Fault::Ours)?;
    check_samplings(&source, &header, size, samplings).map_err(Fault::Ours)?;
    let [width, height] = [size.0 as usize, size.1 as usize];
    for (channel, [x, y]) in header.channels.list.iter_mut().zip(samplings) {
        channel.sampling = Vec2(*x, *y);
    }
    let plane =
        |c: &usize| zeroed::<f32>(size.0 / samplings[*c][0] as u32, size.1 / samplings[*c][1] as u32, 1);
    let planes = choice.channels.iter().map(plane).collect::<Result<_>>().map_err(Fault::Ours)?;
    let mut picture = Picture { header, width, choice, planes };
    let mut blocks = Blocks::new(0);
    let mut chunks = reader.filter_chunks(false, |_, _, _| true)?;
    while let Some(chunk) = chunks.read_next_chunk() {
        let chunk = chunk?;
        blocks.take(&chunk, &picture.header)?;
        let place = picture.header.get_block_data_indices(&chunk.compressed_block)?;
        let section = picture.header.get_absolute_block_pixel_coordinates(place)?;
        section.validate(Some(picture.header.layer_size))?;
        if let CompressedBlock::ScanLine(block) = chunk.compressed_block {
            picture.read_block(block.compressed_pixels_le, section)?;
        }
    }
    let count = picture.choice.channels.len();
    let mut samples = zeroed::<f32>(size.0, size.1, count as u32).map_err(Fault::Ours)?;
    for (k, (plane, channel)) in picture.planes.iter().zip(&picture.choice.channels).enumerate() {
        stretch(plane, [width, height], samplings[*channel], samples.iter_mut().skip(k).step_by(count));
    }
    Ok(finished(samples, size, &picture.choice, &picture.header, space))
}

/// Refuses all but halves of even sizes.
fn check_samplings(
    source: &Source<'_>,
    header: &Header,
    size: (u32, u32),
    samplings: &[Sampling],
) -> Result<()> {
    let corner = header.own_attributes.layer_position;
    let fits = |[x, y]: Sampling| {
        let divides =
            |side: u32, start: i32, n: usize| (side as usize).is_multiple_of(n) && start % n as i32 == 0;
        (1..=2).contains(&x)
            && (1..=2).contains(&y)
            && divides(size.0, corner.x(), x)
            && divides(size.1, corner.y(), y)
    };
    let list = &header.channels.list;
    if samplings.len() != list.len() {
        // As where the header has two lists, of which the library takes the second.
        let found = format!("a list of {} channels, then one of {}", samplings.len(), list.len());
        return Err(source.fault(found, "one attribute \"channels\""));
    }
    let odd = list.iter().zip(samplings).find(|(_, sampling)| !fits(**sampling));
    let Some((channel, [x, y])) = odd else { return Ok(()) };
    let name = channel.name.to_string();
    let found = format!(
        "channel {} with a sample for {x} × {y} pixels of {} × {}",
        name.escape_debug(),
        size.0,
        size.1
    );
    Err(source.unsupported(found, "one for 1 or 2 pixels across and down, in an even size"))
}

/// What is read of a file. The header has the true sampling of its channels.
struct Picture {
    header: Header,
    width: usize,
    choice: Choice,
    /// The samples of the chosen channels.
    planes: Vec<Vec<f32>>,
}

impl Picture {
    fn read_block(&mut self, packed: Vec<u8>, section: IntegerBounds) -> ::exr::error::UnitResult {
        let start = section.position.to_usize("rows")?.y();
        let (rows, area) = (start..start + section.size.y(), section.size.area());
        let width = self.width;
        let sampled = |c: &::exr::meta::attribute::ChannelDescription, y: usize| {
            if y.is_multiple_of(c.sampling.y()) { width / c.sampling.x() } else { 0 }
        };
        let list = self.header.channels.list.clone();
        let bytes: usize = rows
            .clone()
            .flat_map(|y| list.iter().map(move |c| sampled(c, y) * c.sample_type.bytes_per_sample()))
            .sum();
        // The library takes a number of bytes for each pixel, which is whole where rows come in pairs.
        if area == 0 || !bytes.is_multiple_of(area) {
            return Err(Error::NotSupported("blocks of an odd number of rows".into()));
        }
        self.header.channels.bytes_per_pixel = bytes / area;
        let compression = self.header.compression;
        let data = compression.decompress_image_section_from_le(&self.header, packed, section, false)?;
        let mut rest = data.as_slice();
        for y in rows {
            for (index, channel) in list.iter().enumerate() {
                let count = sampled(channel, y);
                let length = count * channel.sample_type.bytes_per_sample();
                let (row, after) = rest
                    .split_at_checked(length)
                    .ok_or_else(|| Error::Invalid("a block is too short".into()))?;
                rest = after;
                let Some(k) = self.choice.channels.iter().position(|c| *c == index) else { continue };
                let at = y / channel.sampling.y() * count;
                let target = self.planes[k].get_mut(at..at + count);
                let target = target.ok_or_else(|| Error::Invalid("a block outside of the picture".into()))?;
                target.iter_mut().zip(values(row, channel.sample_type)).for_each(|(t, v)| *t = v);
            }
        }
        Ok(())
    }
}

/// The samples in a row of bytes, which have the order of the machine.
fn values(row: &[u8], kind: SampleType) -> impl Iterator<Item = f32> {
    row.chunks_exact(kind.bytes_per_sample()).map(move |b| match (kind, b) {
        (SampleType::F16, &[a, b]) => f16::from_bits(u16::from_ne_bytes([a, b])).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        _ => 0.0,
    })
}

/// A plane in full resolution: samples stand at the even pixels, and between them are their means.
fn stretch<'a>(
    plane: &[f32],
    [width, height]: [usize; 2],
    [sx, sy]: Sampling,
    targets: impl Iterator<Item = &'a mut f32>,
) {
    let columns = width / sx;
    let pair = |at: usize, step: usize, count: usize| (at / step, (at / step + at % step).min(count - 1));
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    for (target, (x, y)) in targets.zip(pixels) {
        let ((x0, x1), (y0, y1)) = (pair(x, sx, columns), pair(y, sy, height / sy));
        let at = |x: usize, y: usize| plane[y * columns + x];
        *target = 0.25 * (at(x0, y0) + at(x1, y0) + at(x0, y1) + at(x1, y1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::compression::Compression;
    use ::exr::meta::BlockDescription;
    use ::exr::meta::attribute::{ChannelDescription, LineOrder};
    use penombre_math::color::luminance;
    use std::path::Path;

    const SIZE: [usize; 2] = [8, 36];
    const CHROMA: [f32; 2] = [0.25, -0.5];

    fn luma(x: usize, y: usize) -> f32 {
        0.5 + (x * 3 + y) as f32 / 64.0
    }

    /// A file with luminance in full and chroma in half the resolution, half floats.
    fn file(compression: Compression, step: usize) -> Vec<u8> {
        let [w, h] = SIZE;
        let channel = |name: &str, n: usize| ChannelDescription {
            sampling: Vec2(n, n),
            ..ChannelDescription::named(name, SampleType::F16)
        };
        let channels = [channel("BY", step), channel("RY", step), channel("Y", 1)];
        let mut header = Header::new("".into(), Vec2(w, h), channels.iter().cloned().collect())
            .with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing);
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend(
                [name.as_bytes(), &[0], kind.as_bytes(), &[0], &(value.len() as u32).to_le_bytes(), value]
                    .concat(),
            );
        };
        let mut list = Vec::new();
        for c in &channels {
            let n = (c.sampling.x() as u32).to_le_bytes();
            list.extend([c.name.bytes(), &[0], &1u32.to_le_bytes(), &[0; 4], &n, &n].concat());
        }
        list.push(0);
        attribute("channels", "chlist", &list);
        let code = match compression {
            Compression::Uncompressed => 0,
            Compression::RLE => 1,
            Compression::ZIP1 => 2,
            Compression::ZIP16 => 3,
            _ => 4,
        };
        attribute("compression", "compression", &[code]);
        let window = [0, 0, w as i32 - 1, h as i32 - 1].map(i32::to_le_bytes).concat();
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        bytes.push(0);
        let rows = compression.scan_lines_per_block();
        let mut blocks = Vec::new();
        for start in (0..h).step_by(rows) {
            let end = (start + rows).min(h);
            let mut data: Vec<u8> = Vec::new();
            for y in start..end {
                for (k, c) in channels.iter().enumerate().filter(|(_, c)| y % c.sampling.y() == 0) {
                    for x in (0..w).step_by(c.sampling.x()) {
                        let v = [CHROMA[1], CHROMA[0], luma(x, y)][k];
                        data.extend(f16::from_f32(v).to_bits().to_ne_bytes());
                    }
                }
            }
            let section = IntegerBounds::new((0, start as i32), (w, end - start));
            header.channels.bytes_per_pixel = data.len() / section.size.area();
            blocks.push((start, compression.compress_image_section_to_le(&header, data, section).unwrap()));
        }
        let mut at = bytes.len() + 8 * blocks.len();
        for (_, block) in &blocks {
            bytes.extend((at as u64).to_le_bytes());
            at += 8 + block.len();
        }
        for (y, block) in blocks {
            bytes.extend(
                [&(y as u32).to_le_bytes()[..], &(block.len() as u32).to_le_bytes(), &block].concat(),
            );
        }
        bytes
    }

    #[test]
    fn luminance_and_chroma_of_half_resolution_are_read() {
        use Compression::{PIZ, RLE, Uncompressed, ZIP1, ZIP16};
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
            let bytes = file(compression, 2);
            let image = crate::decode(&bytes, Path::new("a.exr"), ColorSpace::Auto).unwrap().image;
            assert_eq!([image.width() as usize, image.height() as usize], SIZE);
            for (x, y) in [(0, 0), (3, 1), (7, 17), (1, 35)] {
                let [r, g, b] = image.rgb(x as u32, y as u32);
                let expected = f16::from_f32(luma(x, y)).to_f32();
                assert!((luminance([r, g, b]) - expected).abs() < 1e-5, "{compression:?}, {x}, {y}");
                assert!(
                    (r / expected - 1.0 - CHROMA[0]).abs() < 1e-5
                        && (b / expected - 1.0 - CHROMA[1]).abs() < 1e-5
                );
            }
            let layers = crate::decode_layers(&bytes, Path::new("a.exr")).unwrap().layers;
            assert_eq!(layers.get("").unwrap().to_image(8, 36).unwrap(), image);
        }
    }

    #[test]
    fn other_parts_of_the_resolution_and_cut_files_are_refused() {
        let message = |bytes: &[u8]| {
            crate::decode(bytes, Path::new("a.exr"), ColorSpace::Auto).unwrap_err().to_string()
        };
        let text = message(&file(Compression::Uncompressed, 4));
        assert!(text.contains("channel BY with a sample for 4 × 4 pixels"), "{text}");
        let whole = file(Compression::ZIP16, 2);
        for length in 0..whole.len() {
            message(&whole[..length]);
        }
    }

    #[test]
    fn each_block_must_come_once() {
        let mut bytes = file(Compression::ZIP16, 2);
        let table = bytes.windows(18).position(|w| w == b"screenWindowWidth\0").unwrap() + 18 + 6 + 4 + 4 + 1;
        bytes.copy_within(table + 8..table + 16, table);
        let error = crate::decode(&bytes, Path::new("a.exr"), ColorSpace::Auto).unwrap_err().to_string();
        assert!(error.contains("a second block with y = 16"), "{error}");
    }

    /// The library takes the last list of channels, and sampling is read from the first.
    #[test]
    fn a_second_list_of_channels_is_refused() {
        let bytes = file(Compression::ZIP16, 2);
        let start = bytes.windows(9).position(|w| w == b"channels\0").unwrap();
        let end = bytes.windows(12).position(|w| w == b"compression\0").unwrap();
        let list = b"channels\0chlist\0\x01\0\0\0\0";
        let message = |bytes: Vec<u8>| {
            crate::decode(&bytes, Path::new("a.exr"), ColorSpace::Auto).unwrap_err().to_string()
        };
        let other = message(
            [
                &bytes[..end],
                b"channels\0chlist\0\x13\0\0\0Y\0",
                &[1, 0, 0, 0],
                &[0; 4],
                &[1, 0, 0, 0, 1, 0, 0, 0, 0],
                &bytes[end..],
            ]
            .concat(),
        );
        assert!(other.contains("found a list of 3 channels, then one of 1"), "{other}");
        let empty = message([&bytes[..start], list, &bytes[start..]].concat());
        assert!(empty.contains("channel subsampling"), "{empty}");
    }

    #[test]
    fn between_samples_are_their_means() {
        let mut full = [0.0; 16];
        stretch(&[0.0, 2.0, 4.0, 8.0], [4, 4], [2, 2], full.iter_mut());
        assert_eq!(full[..8], [0.0, 1.0, 2.0, 2.0, 2.0, 3.5, 5.0, 5.0]);
        let mut same = [0.0; 4];
        stretch(&[1.0, 2.0, 3.0, 4.0], [2, 2], [1, 1], same.iter_mut());
        assert_eq!(same, [1.0, 2.0, 3.0, 4.0]);
    }
}
