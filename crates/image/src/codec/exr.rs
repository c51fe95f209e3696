//! OpenEXR \[OpenEXR\]: 32 bits with ZIP compression out; the first layer with colour or luminance in, or all of them.

mod blocks;
mod fault;
mod layered;
mod subsampled;

pub use layered::{decode_layers, encode_layers};

use super::{Result, Source, Transfer, finish, zeroed};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use ::exr::block::UncompressedBlock;
use ::exr::block::lines::LineRef;
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::error::UnitResult;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{AttributeValue, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes, standard_names};
use ::exr::prelude::{SmallVec, WritableImage, f16};
use blocks::Blocks;
use fault::{Fault, attribute_text, reported};
use penombre_math::color::luminance;
use std::io::{Cursor, Write};

/// ZIP makes at best 1032 bytes of one; the smallest sample has two.
pub const PIXELS_PER_BYTE: u64 = 1040 / 2;

/// More channels than any renderer writes: searching them by name takes time by their square.
const MAX_CHANNELS: usize = 4096;

/// A file of any length may unpack to this many bytes.
const SMALL: u64 = 1 << 24;
/// A tile may take this many bytes in any file.
const LARGEST_TILE: u64 = 1 << 26;

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let list = image.channel_names().iter().enumerate().map(|(i, name)| {
        let samples = image.pixels().map(|pixel| pixel[i]).collect();
        AnyChannel::new(*name, FlatSamples::F32(samples))
    });
    write_part(image.width(), image.height(), list, options, w)
}

/// Writes a file of one part with these channels.
fn write_part(
    width: u32,
    height: u32,
    channels: impl Iterator<Item = AnyChannel<FlatSamples>>,
    options: &WriteOptions,
    w: &mut dyn Write,
) -> Result<()> {
    let mut attributes = LayerAttributes { layer_name: None, ..LayerAttributes::named("") };
    for (name, text) in &options.metadata {
        attributes.other.insert(attribute_name(name)?, AttributeValue::Text(utf8(text)));
    }
    let size = (width as usize, height as usize);
    let encoding = Encoding { compression: ::exr::prelude::Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels.collect()));
    let mut file = Cursor::new(Vec::new());
    ::exr::prelude::Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|e| unwritable(e.to_string()))?;
    let mut bytes = file.into_inner();
    sort_attributes(&mut bytes);
    w.write_all(&bytes)?;
    Ok(())
}

fn unwritable(reason: String) -> ImageErrorKind {
    ImageErrorKind::NotWritable { format: Format::Exr, reason }
}

/// A name for an attribute of ours, 1 to 255 bytes. The format's own names have their own types, so those get the prefix
/// `text.`: a text must not be what keeps a finished render from its file.
fn attribute_name(name: &str) -> Result<Text> {
    let own = standard_names::ALL.contains(&name.as_bytes());
    let name = if own { format!("text.{name}") } else { name.to_owned() };
    if name.is_empty() || name.len() > 255 {
        return Err(unwritable(format!("a text has a name of {} bytes, not 1 to 255", name.len())));
    }
    Ok(utf8(&name))
}

fn utf8(text: &str) -> Text {
    Text::from_bytes_unchecked(SmallVec::from_slice(text.as_bytes()))
}

/// Puts the attributes of the (only) header in the order of their names. The library keeps them in a hash map, so their
/// order would change from run to run.
fn sort_attributes(file: &mut [u8]) {
    // Magic number and version take 8 bytes; then name, 0, type, 0, length, value; a 0 ends the list.
    let start = 8;
    let mut end = start;
    let mut attributes = Vec::new();
    while file[end] != 0 {
        let text_end = |from: usize| from + file[from..].iter().position(|b| *b == 0).unwrap_or(0);
        let name_end = text_end(end);
        let kind_end = text_end(name_end + 1);
        let length = file[kind_end + 1..].first_chunk::<4>().map_or(0, |l| u32::from_le_bytes(*l));
        let next = kind_end + 5 + length as usize;
        attributes.push((file[end..name_end].to_vec(), file[end..next].to_vec()));
        end = next;
    }
    attributes.sort();
    let sorted: Vec<u8> = attributes.into_iter().flat_map(|(_, bytes)| bytes).collect();
    file[start..end].copy_from_slice(&sorted);
}

/// Which layer, and which of its channels, in the order of our samples.
#[derive(Debug, PartialEq)]
struct Choice {
    layer: usize,
    channels: Vec<usize>,
    /// The colours are luminance and two chromas, not red, green and blue.
    chroma: bool,
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    subsampled::decode(bytes, space)
        .unwrap_or_else(|| reported(bytes, |cursor, bytes| decode_from(cursor, bytes, space)))
}

fn decode_from(
    cursor: &mut Cursor<&[u8]>,
    bytes: &[u8],
    space: ColorSpace,
) -> std::result::Result<Decoded, Fault> {
    // Headers first, with nothing allocated for pixels.
    let reader = ::exr::block::read(cursor, false)?;
    let source = Source::new(Format::Exr, bytes);
    check_channel_count(&source, reader.headers()).map_err(Fault::Ours)?;
    let choice = chosen(&source, reader.headers()).map_err(Fault::Ours)?;
    let header = reader.headers()[choice.layer].clone();
    let size = check_layer(&source, &header).map_err(Fault::Ours)?;
    let channels = choice.channels.len() as u32;
    let mut samples = zeroed::<f32>(size.0, size.1, channels).map_err(Fault::Ours)?;
    each_block(reader, choice.layer, |block| {
        read_block(block, &header, &choice, size.0 as usize, &mut samples)
    })?;
    Ok(finished(samples, size, &choice, &header, space))
}

/// Unpacks the blocks of one part, those of its full size, each of which must come once.
fn each_block(
    reader: Reader<&mut Cursor<&[u8]>>,
    part: usize,
    mut put: impl FnMut(&UncompressedBlock) -> UnitResult,
) -> std::result::Result<(), Fault> {
    let mut blocks = Blocks::new(part);
    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == part && tile.is_largest_resolution_level())?;
    while let Some(chunk) = chunks.read_next_chunk() {
        let chunk = chunk?;
        blocks.take(&chunk, &chunks.headers()[part])?;
        put(&UncompressedBlock::decompress_chunk(chunk, chunks.meta_data(), false)?)?;
    }
    Ok(())
}

/// The image of samples as they stand in the file.
fn finished(
    mut samples: Vec<f32>,
    size: (u32, u32),
    choice: &Choice,
    header: &Header,
    space: ColorSpace,
) -> Decoded {
    let channels = choice.channels.len() as u32;
    if choice.chroma {
        to_rgb(&mut samples, channels);
    }
    let transfer = Transfer::of(space, Transfer::Linear);
    transfer.apply_to_colors(&mut samples, channels);
    let mut decoded = finish(Format::Exr, size, channels, samples, transfer != Transfer::Linear);
    decoded.metadata = texts(header);
    decoded
}

/// Puts the chosen channels of a block where they belong in the interleaved samples of a picture of this width.
fn read_block(
    block: &UncompressedBlock,
    header: &Header,
    choice: &Choice,
    width: usize,
    samples: &mut [f32],
) -> UnitResult {
    let channels = choice.channels.len();
    for line in block.lines(&header.channels) {
        let Some(place) = choice.channels.iter().position(|c| *c == line.location.channel) else {
            continue;
        };
        let start = line.location.position.1 * width + line.location.position.0;
        let row = samples
            .get_mut(start * channels..(start + line.location.sample_count) * channels)
            .ok_or_else(|| ::exr::error::Error::Invalid("a block outside of the picture".into()))?;
        let kind = header.channels.list[line.location.channel].sample_type;
        read_line(line, kind, row.iter_mut().skip(place).step_by(channels))?;
    }
    Ok(())
}

fn read_line<'a>(
    line: LineRef<'_>,
    kind: SampleType,
    targets: impl Iterator<Item = &'a mut f32>,
) -> UnitResult {
    match kind {
        SampleType::F16 => {
            for (target, value) in targets.zip(line.read_samples::<f16>()) {
                *target = value?.to_f32();
            }
        }
        SampleType::F32 => {
            for (target, value) in targets.zip(line.read_samples::<f32>()) {
                *target = value?;
            }
        }
        SampleType::U32 => {
            for (target, value) in targets.zip(line.read_samples::<u32>()) {
                *target = value? as f32;
            }
        }
    }
    Ok(())
}

/// Luminance, (R − Y) / Y and (B − Y) / Y \[OpenEXR\].
const CHROMA: [&str; 3] = ["Y", "RY", "BY"];

/// Makes red, green and blue of luminance and chroma, Rec. 709, in place.
fn to_rgb(samples: &mut [f32], channels: u32) {
    for pixel in samples.chunks_exact_mut(channels as usize) {
        let [y, ry, by] = [pixel[0], pixel[1], pixel[2]];
        let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
        let [wr, wg, wb] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(luminance);
        pixel[..3].copy_from_slice(&[r, (y - wr * r - wb * b) / wg, b]);
    }
}

/// The channels to be read, or that there are none.
fn chosen(source: &Source<'_>, headers: &[Header]) -> Result<Choice> {
    choose(headers)
        .ok_or_else(|| source.unsupported(channel_names(headers), "a flat layer with channels R, G, B or Y"))
}

/// The first flat layer with R, G, B (and A), else the first with Y, RY, BY, else with Y (and A), else the same with a common prefix such
/// as `diffuse.`.
fn choose(headers: &[Header]) -> Option<Choice> {
    let wanted: [&[&str]; 3] = [&["R", "G", "B"], &CHROMA, &["Y"]];
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    for colors in wanted {
        for (layer, header) in flat() {
            if let Some(channels) = find_channels(header, "", colors) {
                return Some(Choice { layer, channels, chroma: colors == CHROMA });
            }
        }
    }
    for colors in wanted {
        for (layer, header) in flat() {
            for channel in &header.channels.list {
                let name = channel.name.to_string();
                let Some(prefix) = name.strip_suffix(colors[0]).filter(|p| p.ends_with('.')) else {
                    continue;
                };
                if let Some(channels) = find_channels(header, prefix, colors) {
                    return Some(Choice { layer, channels, chroma: colors == CHROMA });
                }
            }
        }
    }
    None
}

/// The indices of the colours, then of alpha if there is one. Subsampled channels do not count.
fn find_channels(header: &Header, prefix: &str, colors: &[&str]) -> Option<Vec<usize>> {
    let find = |name: &str| {
        let whole = format!("{prefix}{name}");
        let list = &header.channels.list;
        list.iter().position(|c| c.name.bytes() == whole.as_bytes() && c.sampling == (1, 1).into())
    };
    let mut found: Vec<usize> = colors.iter().map(|name| find(name)).collect::<Option<_>>()?;
    found.extend(find("A"));
    Some(found)
}

fn channel_names(headers: &[Header]) -> String {
    let name = |h: &Header| {
        let names: Vec<String> = h.channels.list.iter().take(8).map(|c| c.name.to_string()).collect();
        format!("{}channels {}", if h.deep { "deep " } else { "" }, names.join(", ").escape_debug())
    };
    headers.iter().take(4).map(name).collect::<Vec<_>>().join("; ")
}

/// Refuses headers with very many channels.
fn check_channel_count(source: &Source<'_>, headers: &[Header]) -> Result<()> {
    let count = headers.iter().map(|h| h.channels.list.len()).max().unwrap_or(0);
    if count > MAX_CHANNELS {
        return Err(source.unsupported(format!("{count} channels"), format!("at most {MAX_CHANNELS}")));
    }
    Ok(())
}

/// Refuses sizes, and rows of many channels, that the file cannot hold.
fn check_layer(source: &Source<'_>, header: &Header) -> Result<(u32, u32)> {
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    // Of several parts the first one's window is as good a place as any.
    let window = source.bytes.windows(11).position(|w| w == b"dataWindow\0");
    let source = &source.placed(window.unwrap_or(source.at));
    let size = source.check_size(width, height, PIXELS_PER_BYTE)?;
    let list = &header.channels.list;
    if let Some(channel) = list.iter().find(|c| c.sampling != (1, 1).into()) {
        let found = format!("subsampled channel {}", channel.name.to_string().escape_debug());
        return Err(source.unsupported(found, "channels of full resolution"));
    }
    let pixel_bytes: u64 = list.iter().map(|c| c.sample_type.bytes_per_sample() as u64).sum();
    let limit = (source.bytes.len() as u64).saturating_mul(PIXELS_PER_BYTE * 2).max(SMALL);
    if (width * height).saturating_mul(pixel_bytes) > limit {
        let bytes = source.bytes.len() as u64;
        let limit = limit / pixel_bytes;
        let offset = source.at as u64;
        return Err(ImageErrorKind::TooLarge { format: Format::Exr, offset, width, height, bytes, limit });
    }
    check_tiles(source, header, pixel_bytes, limit)?;
    Ok(size)
}

/// Refuses tiles that are far larger than the picture: a block of one may claim to take as much as a whole tile.
fn check_tiles(source: &Source<'_>, header: &Header, pixel_bytes: u64, limit: u64) -> Result<()> {
    let BlockDescription::Tiles(tiles) = &header.blocks else { return Ok(()) };
    let (width, height) = (tiles.tile_size.0 as u64, tiles.tile_size.1 as u64);
    if width.saturating_mul(height).saturating_mul(pixel_bytes) <= limit.max(LARGEST_TILE) {
        return Ok(());
    }
    let place = source.bytes.windows(6).position(|w| w == b"tiles\0");
    let source = source.placed(place.unwrap_or(source.at));
    Err(source.fault(
        format!("tiles of {width} × {height} pixels"),
        format!("tiles of at most {} pixels", limit.max(LARGEST_TILE) / pixel_bytes.max(1)),
    ))
}

/// The string attributes that are not the format's own, by name.
fn texts(header: &Header) -> Vec<(String, String)> {
    let own = header.own_attributes.other.iter().chain(&header.shared_attributes.other);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut texts: Vec<_> = own
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(t) => Some((text(name.bytes()), text(t.bytes()))),
            _ => None,
        })
        .collect();
    texts.sort();
    texts
}
