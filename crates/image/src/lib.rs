//! Pixels, image files and image metrics.
//!
//! An [`Image`] holds linear light in `f32`. [`load`] and [`save`] go between images and files, [`ToneCurve`] and
//! [`quantise`] between linear light and 8-bit values, and [`metrics`] says how far apart two images are. [`Layers`]
//! are pictures with more than colour, which [`save_layers`] writes to one OpenEXR file.
//! Readers take hostile files: whatever the bytes, they answer with an image or an [`ImageError`], and
//! check sizes before they allocate.
#![forbid(unsafe_code)]

mod codec;
mod error;
mod format;
mod heatmap;
mod image;
mod io;
mod layers;
pub mod metrics;
mod probe;
mod tone;

pub use error::{ImageError, ImageErrorKind, LayerError, ShapeError};
pub use format::Format;
pub use heatmap::heatmap;
pub use image::{Image, Pixel};
pub use io::{
    ColorSpace, Decoded, MAX_PIXELS, WriteOptions, decode, encode, load, load_as, panic_is_contained, save,
};
pub use layers::{
    Channel, DecodedLayers, Layer, Layers, STANDARD_LAYERS, Samples, decode_layers, encode_layers,
    layer_path, load_layers, save_layers,
};
pub use probe::{ImageSize, PROBE_BYTES, probe};
pub use tone::{ToneCurve, UnknownName, quantise, quantise_rgba};
