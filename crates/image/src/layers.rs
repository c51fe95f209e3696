//! Pictures of many layers: colour, and what else a renderer knows of each pixel.

mod files;

pub use files::{DecodedLayers, decode_layers, encode_layers, layer_path, load_layers, save_layers};

use crate::error::{LayerError, ShapeError};
use crate::image::Image;

/// The layers that programs know, and their channels. The colour of the picture has no name and may also have alpha
/// (`A`), or be grey (`Y`). A single number is `X`, as Blender calls it.
///
/// | layer | what it holds |
/// |---|---|
/// | `""` | radiance, linear Rec. 709 |
/// | `albedo` | share of light that comes back, 0 to 1, linear Rec. 709 |
/// | `normal` | unit vector in world space; a mean of some may be shorter |
/// | `position` | point in world space, metres |
/// | `depth` | distance from the camera along the viewing direction, metres |
/// | `uv` | texture coordinates |
/// | `variance` | variance of the pixel's mean, by colour |
/// | `object-id`, `material-id`, `samples` | whole numbers, best kept as [`Samples::U32`] |
pub const STANDARD_LAYERS: &[(&str, &[&str])] = &[
    ("", &["R", "G", "B"]),
    ("albedo", &["R", "G", "B"]),
    ("normal", &["X", "Y", "Z"]),
    ("position", &["X", "Y", "Z"]),
    ("depth", &["Z"]),
    ("uv", &["U", "V"]),
    ("variance", &["R", "G", "B"]),
    ("object-id", &["X"]),
    ("material-id", &["X"]),
    ("samples", &["X"]),
];

/// The samples of one channel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Numbers.
    F32(Vec<f32>),
    /// Whole numbers: identities and counts. As floats they would be exact up to 2²⁴ only.
    U32(Vec<u32>),
}

impl Samples {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(samples) => samples.len(),
            Self::U32(samples) => samples.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One sample as a float, whole numbers rounded to the nearest.
    fn at(&self, i: usize) -> f32 {
        match self {
            Self::F32(samples) => samples[i],
            Self::U32(samples) => samples[i] as f32,
        }
    }
}

impl From<Vec<f32>> for Samples {
    fn from(samples: Vec<f32>) -> Self {
        Self::F32(samples)
    }
}

impl From<Vec<u32>> for Samples {
    fn from(samples: Vec<u32>) -> Self {
        Self::U32(samples)
    }
}

/// One channel of a [`Layer`].
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Usually one letter; no dot, which is what parts it from the layer's name in a file.
    pub name: String,
    /// The samples, as many as the picture has pixels.
    pub samples: Samples,
}

/// Channels that belong together. They are kept in the order R, G, B, other names by alphabet, A.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    name: String,
    channels: Vec<Channel>,
}

impl Layer {
    /// A layer without channels yet; the colour of the picture has the name `""`.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), channels: Vec::new() }
    }

    /// The same with one channel more.
    #[must_use]
    pub fn with(mut self, channel: impl Into<String>, samples: impl Into<Samples>) -> Self {
        self.channels.push(Channel { name: channel.into(), samples: samples.into() });
        self.channels.sort_by(|a, b| (rank(&a.name), &a.name).cmp(&(rank(&b.name), &b.name)));
        self
    }

    /// A layer from interleaved samples: those of the first pixel, in the order of the channels' names, then those of
    /// the next. What is left over at the end is no pixel and is left out.
    #[must_use]
    pub fn interleaved(name: impl Into<String>, channels: &[&str], samples: &[f32]) -> Self {
        channels.iter().enumerate().fold(Self::new(name), |layer, (i, channel)| {
            let plane: Vec<f32> = samples.chunks_exact(channels.len()).map(|pixel| pixel[i]).collect();
            layer.with(*channel, plane)
        })
    }

    /// The colour layer of a picture: Y, Y and A, R, G, B, or those and A.
    #[must_use]
    pub fn color(image: &Image) -> Self {
        let plane = |i: usize| image.pixels().map(|pixel| pixel[i]).collect::<Vec<f32>>();
        let names = image.channel_names().iter().enumerate();
        names.fold(Self::new(""), |layer, (i, name)| layer.with(*name, plane(i)))
    }

    /// The name, `""` for the colour of the picture.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The channels.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The channel of that name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Samples> {
        self.channels.iter().find(|c| c.name == name).map(|c| &c.samples)
    }

    /// Whether it holds colours: R, G and B, or Y.
    #[must_use]
    pub fn is_color(&self) -> bool {
        let has = |name| self.channel(name).is_some();
        (has("R") && has("G") && has("B")) || has("Y") && !has("X")
    }

    /// The layer as a picture of `width` × `height` pixels. Two numbers that are not grey and alpha get a third, 0,
    /// so that formats that know only grey and colour keep both.
    ///
    /// # Errors
    ///
    /// Other numbers of channels than 1 to 4, four of which the last is no alpha, or samples that are not that many.
    pub fn to_image(&self, width: u32, height: u32) -> Result<Image, ShapeError> {
        let pixels = width as usize * height as usize;
        let shape = |found| ShapeError { width, height, channels: self.channels.len() as u32, found };
        let alpha = self.channel("A").is_some();
        let channels = match self.channels.len() {
            2 if !alpha => 3,
            4 if !alpha => return Err(shape(pixels * 4)),
            n => n,
        };
        if let Some(wrong) = self.channels.iter().find(|c| c.samples.len() != pixels) {
            return Err(shape(wrong.samples.len()));
        }
        let mut data = vec![0.0; pixels * channels];
        for (c, channel) in self.channels.iter().enumerate() {
            for (i, value) in data.iter_mut().skip(c).step_by(channels).enumerate() {
                *value = channel.samples.at(i);
            }
        }
        Image::from_data(width, height, channels as u32, data)
    }
}

/// The place of a channel in its layer.
fn rank(name: &str) -> u32 {
    match name {
        "R" => 0,
        "G" => 1,
        "B" => 2,
        "A" => 4,
        _ => 3,
    }
}

/// Layers of one size. They are kept in the order of their names, so the colour, which has none, is the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: u32,
    height: u32,
    layers: Vec<Layer>,
}

impl Layers {
    /// Longest name of a channel in a file, with that of its layer and the dot, in bytes.
    pub const LONGEST_NAME: usize = 255;

    /// No layer yet, for pictures of `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, layers: Vec::new() }
    }

    /// A picture as the only layer.
    #[must_use]
    pub fn from_image(image: &Image) -> Self {
        Self { width: image.width(), height: image.height(), layers: vec![Layer::color(image)] }
    }

    /// Takes a layer in.
    ///
    /// # Errors
    ///
    /// A name that is there already or that no file can keep, a layer without channels, or a channel whose samples are
    /// not as many as there are pixels.
    pub fn push(&mut self, layer: Layer) -> Result<(), LayerError> {
        let fault = |reason: String| Err(LayerError { layer: layer.name.clone(), reason });
        if self.get(&layer.name).is_some() {
            return fault("the name is taken".to_owned());
        }
        if layer.channels.is_empty() {
            return fault("it has no channels".to_owned());
        }
        let pixels = self.width as usize * self.height as usize;
        for (i, channel) in layer.channels.iter().enumerate() {
            let (name, found) = (&channel.name, channel.samples.len());
            let whole = full_name(&layer.name, name);
            if name.is_empty()
                || name.contains('.')
                || whole.contains('\0')
                || whole.len() > Self::LONGEST_NAME
            {
                return fault(format!("\"{}\" is no name of a channel", whole.escape_debug()));
            }
            if layer.channels[..i].iter().any(|c| c.name == *name) {
                return fault(format!("it has two channels {name}"));
            }
            if found != pixels {
                return fault(format!("found {found} samples in channel {name}, expected {pixels}"));
            }
        }
        let place = self.layers.partition_point(|l| l.name < layer.name);
        self.layers.insert(place, layer);
        Ok(())
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All layers, the colour first.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The layer of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|l| l.name == name)
    }
}

/// The name of a channel in a file \[OpenEXR\].
pub(crate) fn full_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") }
}
