//! All channels of an OpenEXR file, by layers.

use super::{
    Fault, channel_names, check_channel_count, check_layer, choose, each_block, read_line, reported,
    subsampled, texts, utf8, write_part,
};
use crate::codec::{Result, Source, zeroed};
use crate::format::Format;
use crate::io::{ColorSpace, Decoded, WriteOptions};
use crate::layers::{DecodedLayers, Layer, Layers, Samples, full_name};
use ::exr::block::lines::LineRef;
use ::exr::error::{Error, UnitResult};
use ::exr::image::{AnyChannel, FlatSamples};
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use std::io::{Cursor, Write};

pub fn encode_layers(layers: &Layers, options: &WriteOptions, w: &mut dyn Write) -> Result<()> {
    let channels = layers.layers().iter().flat_map(|layer| {
        layer.channels().iter().map(|channel| {
            let samples = match &channel.samples {
                Samples::F32(samples) => FlatSamples::F32(samples.clone()),
                Samples::U32(samples) => FlatSamples::U32(samples.clone()),
            };
            AnyChannel::new(utf8(&full_name(layer.name(), &channel.name)), samples)
        })
    });
    write_part(layers.width(), layers.height(), channels, options, w)
}

pub fn decode_layers(bytes: &[u8]) -> Result<DecodedLayers> {
    match subsampled::decode(bytes, ColorSpace::Auto) {
        Some(decoded) => decoded.map(|Decoded { image, metadata, .. }| DecodedLayers {
            layers: Layers::from_image(&image),
            format: Format::Exr,
            metadata,
        }),
        None => reported(bytes, decode_from),
    }
}

fn decode_from(cursor: &mut Cursor<&[u8]>, bytes: &[u8]) -> std::result::Result<DecodedLayers, Fault> {
    let reader = ::exr::block::read(cursor, false)?;
    let source = Source::new(Format::Exr, bytes);
    let headers = reader.headers();
    check_channel_count(&source, headers).map_err(Fault::Ours)?;
    let part = choose(headers).map(|c| c.layer).or_else(|| headers.iter().position(|h| !h.deep));
    let part =
        part.ok_or_else(|| Fault::Ours(source.unsupported(channel_names(headers), "a flat picture")))?;
    let header = headers[part].clone();
    let size = check_layer(&source, &header).map_err(Fault::Ours)?;
    let mut planes = planes(&header, size).map_err(Fault::Ours)?;
    each_block(reader, part, |block| {
        block.lines(&header.channels).try_for_each(|line| {
            let kind = header.channels.list[line.location.channel].sample_type;
            read_into(line, kind, size.0 as usize, &mut planes)
        })
    })?;
    let layers = group(&header, size, planes).map_err(|found| {
        Fault::Ours(source.fault(found, "channels with names of their own, like albedo.R"))
    })?;
    Ok(DecodedLayers { layers, format: Format::Exr, metadata: texts(&header) })
}

/// Room for the samples of each channel of the header.
fn planes(header: &Header, (width, height): (u32, u32)) -> Result<Vec<Samples>> {
    let plane = |kind| -> Result<Samples> {
        match kind {
            SampleType::U32 => zeroed(width, height, 1).map(Samples::U32),
            _ => zeroed(width, height, 1).map(Samples::F32),
        }
    };
    header.channels.list.iter().map(|c| plane(c.sample_type)).collect()
}

/// Puts one line of a block where it belongs in the samples of its channel.
fn read_into(line: LineRef<'_>, kind: SampleType, width: usize, planes: &mut [Samples]) -> UnitResult {
    let outside = || Error::Invalid("a block outside of the picture".into());
    let location = line.location;
    let start = location.position.1 * width + location.position.0;
    let range = start..start + location.sample_count;
    match planes.get_mut(location.channel).ok_or_else(outside)? {
        Samples::F32(samples) => {
            read_line(line, kind, samples.get_mut(range).ok_or_else(outside)?.iter_mut())
        }
        Samples::U32(samples) => {
            let row = samples.get_mut(range).ok_or_else(outside)?;
            for (target, value) in row.iter_mut().zip(line.read_samples::<u32>()) {
                *target = value?;
            }
            Ok(())
        }
    }
}

/// The channels by the part of their names before the last dot, or what is wrong with the names.
fn group(
    header: &Header,
    (width, height): (u32, u32),
    planes: Vec<Samples>,
) -> std::result::Result<Layers, String> {
    let mut groups: Vec<Layer> = Vec::new();
    for (channel, samples) in header.channels.list.iter().zip(planes) {
        let whole = String::from_utf8_lossy(channel.name.bytes());
        let (layer, name) = whole.rsplit_once('.').unwrap_or(("", whole.as_ref()));
        match groups.iter().position(|l| l.name() == layer) {
            Some(place) => {
                let group = groups.swap_remove(place).with(name, samples);
                groups.push(group);
            }
            None => groups.push(Layer::new(layer).with(name, samples)),
        }
    }
    let mut layers = Layers::new(width, height);
    for layer in groups {
        layers.push(layer).map_err(|e| e.to_string())?;
    }
    Ok(layers)
}
