//! OpenEXR: 32-bit floats with ZIP compression out; the first layer with colour or luminance in.

use super::{Result, Source, Transfer, finish, room};
use crate::error::ImageErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use ::exr::block::UncompressedBlock;
use ::exr::block::lines::LineRef;
use ::exr::block::reader::ChunksReader;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::meta::attribute::{AttributeValue, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes, standard_names};
use ::exr::prelude::{SmallVec, WritableImage, f16};
use std::io::{Cursor, Write};

/// ZIP makes at best 1032 bytes of one; the smallest sample has two.
const PIXELS_PER_BYTE: u64 = 1040 / 2;

/// A file of any length may unpack to this many bytes.
const SMALL: u64 = 1 << 24;

/// Channel names of our images with 1, 2, 3 and 4 channels.
const NAMES: [&[&str]; 4] = [&["Y"], &["Y", "A"], &["R", "G", "B"], &["R", "G", "B", "A"]];

pub fn encode(image: &Image, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let channels = image.channels() as usize;
    let list = NAMES[channels - 1].iter().enumerate().map(|(i, name)| {
        let samples = image.data().iter().skip(i).step_by(channels).copied().collect();
        AnyChannel::new(*name, FlatSamples::F32(samples))
    });
    let mut attributes = LayerAttributes { layer_name: None, ..LayerAttributes::named("") };
    for (name, text) in &options.metadata {
        attributes.other.insert(attribute_name(name)?, AttributeValue::Text(utf8(text)));
    }
    let size = (image.width() as usize, image.height() as usize);
    let encoding = Encoding { compression: ::exr::prelude::Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list.collect()));
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

/// A name for an attribute of ours: 1 to 255 bytes, none of the format's own names.
fn attribute_name(name: &str) -> Result<Text> {
    if name.is_empty() || name.len() > 255 || standard_names::ALL.contains(&name.as_bytes()) {
        return Err(unwritable(format!("\"{name}\" cannot be the name of a text")));
    }
    Ok(utf8(name))
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
}

pub fn decode(bytes: &[u8], space: ColorSpace) -> Result<Decoded> {
    let source = Source::new(Format::Exr, bytes);
    let library = |e: ::exr::error::Error| match e {
        ::exr::error::Error::NotSupported(what) => source.unsupported(what, "a flat picture"),
        e => source.fault(e.to_string(), "valid OpenEXR data"),
    };
    // Headers first, with nothing allocated for pixels.
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(library)?;
    let choice = choose(reader.headers()).ok_or_else(|| {
        source.unsupported(channel_names(reader.headers()), "a flat layer with channels R, G, B or Y")
    })?;
    let header = reader.headers()[choice.layer].clone();
    let (width, height) = check_layer(&source, &header)?;
    let channels = choice.channels.len() as u32;
    let mut samples = room(width, height, channels)?;
    samples.resize(width as usize * height as usize * channels as usize, 0.0);
    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| {
            block.layer == choice.layer && tile.is_largest_resolution_level()
        })
        .map_err(library)?;
    while let Some(chunk) = chunks.read_next_chunk() {
        let block = chunk
            .and_then(|chunk| UncompressedBlock::decompress_chunk(chunk, chunks.meta_data(), false))
            .map_err(library)?;
        for line in block.lines(&header.channels) {
            let Some(place) = choice.channels.iter().position(|c| *c == line.location.channel) else {
                continue;
            };
            let start = line.location.position.1 * width as usize + line.location.position.0;
            let row = samples
                .get_mut(start * channels as usize..(start + line.location.sample_count) * channels as usize)
                .ok_or_else(|| source.fault("a block outside of the picture", "blocks inside"))?;
            let targets = row.iter_mut().skip(place).step_by(channels as usize);
            read_line(line, header.channels.list[line.location.channel].sample_type, targets)
                .map_err(library)?;
        }
    }
    let transfer = Transfer::of(space, Transfer::Linear);
    transfer.apply_to_colors(&mut samples, channels);
    let was_srgb = transfer != Transfer::Linear;
    let mut decoded = finish(Format::Exr, (width, height), channels, samples, was_srgb);
    decoded.metadata = texts(&header);
    Ok(decoded)
}

fn read_line<'a>(
    line: LineRef<'_>,
    kind: SampleType,
    targets: impl Iterator<Item = &'a mut f32>,
) -> ::exr::error::UnitResult {
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

/// The first flat layer with R, G, B (and A), else the first with Y (and A), else the same with a common prefix such
/// as `diffuse.`.
fn choose(headers: &[Header]) -> Option<Choice> {
    let wanted = [NAMES[2], NAMES[0]];
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    for colors in wanted {
        for (layer, header) in flat() {
            if let Some(channels) = find_channels(header, "", colors) {
                return Some(Choice { layer, channels });
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
                    return Some(Choice { layer, channels });
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

/// Refuses sizes, and rows of many channels, that the file cannot hold.
fn check_layer(source: &Source<'_>, header: &Header) -> Result<(u32, u32)> {
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
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
        return Err(ImageErrorKind::TooLarge { format: Format::Exr, width, height, bytes, limit });
    }
    Ok(size)
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
