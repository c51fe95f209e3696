//! Layers: what a film knows of each pixel besides its colour.

use super::features::{ALBEDO, DEPTH, NORMAL, POSITION, UV};
use super::{FeatureSum, Film, estimate};
use penombre_image::{Layer, STANDARD_LAYERS};

/// Depth where there is nothing, metres: a merge by depth puts everything before it, as with Blender's.
pub const BACKGROUND_DEPTH: f32 = 1e10;

/// A layer beside the colour. Those of first hits are means over the pixel's samples, drawn as the pixel filter says,
/// through mirrors and glass nothing is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FilmLayer {
    /// Share of the light that the first surface scatters, plus what it emits, at most 1. Black where there is nothing.
    Albedo,
    /// Distance along the viewing direction in metres, mean over the samples that met something;
    /// [`BACKGROUND_DEPTH`] where none did.
    Depth,
    /// Number of the first sample's material in file order from 1, 0 for nothing.
    MaterialId,
    /// Mean of the unit shading normals that face the viewer, world space: shorter than 1 where they differ; 0 where
    /// there is nothing.
    Normal,
    /// Number of the first sample's object from 1: shapes, then instances, then lights, each in file order; 0 for
    /// nothing.
    ObjectId,
    /// World space, metres, mean over the samples that met something; 0 where none did.
    Position,
    /// Samples in the pixel's mean.
    Samples,
    /// Surface coordinates, mean over the samples that met something; 0 where none did.
    Uv,
    /// Estimated variance of the pixel's mean by colour, see [`Estimate`](super::Estimate); 0 where it is not known.
    Variance,
}

impl FilmLayer {
    /// Names in files and commands, in the order of the variants.
    pub const NAMES: &'static [&'static str] =
        &["albedo", "depth", "material-id", "normal", "object-id", "position", "samples", "uv", "variance"];

    const ALL: [Self; 9] = [
        Self::Albedo,
        Self::Depth,
        Self::MaterialId,
        Self::Normal,
        Self::ObjectId,
        Self::Position,
        Self::Samples,
        Self::Uv,
        Self::Variance,
    ];

    /// The layer of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// True if it comes from the features of first hits.
    pub fn needs_features(self) -> bool {
        !matches!(self, Self::Samples | Self::Variance)
    }

    /// True if it needs an estimate of the error.
    pub fn needs_estimate(self) -> bool {
        self == Self::Variance
    }

    /// Number of its channels.
    pub fn channel_count(self) -> usize {
        self.channels().len()
    }

    /// Names of its channels.
    fn channels(self) -> &'static [&'static str] {
        STANDARD_LAYERS.iter().find(|(name, _)| *name == self.name()).map_or(&["X"], |(_, channels)| channels)
    }
}

impl Film {
    /// A layer so far.
    pub fn layer(&self, layer: FilmLayer) -> Layer {
        let (name, channels) = (layer.name(), layer.channels());
        let floats = |data: Vec<f32>| Layer::interleaved(name, channels, &data);
        let whole = |data: Vec<u32>| Layer::new(name).with(channels[0], data);
        match layer {
            FilmLayer::Albedo => floats(self.features(|f| f.mean_of_all::<3>(ALBEDO))),
            FilmLayer::Normal => floats(self.features(|f| f.mean_of_all::<3>(NORMAL))),
            FilmLayer::Position => floats(self.features(|f| f.mean_of_hits::<3>(POSITION, 0.0))),
            FilmLayer::Depth => floats(self.features(|f| f.mean_of_hits::<1>(DEPTH, BACKGROUND_DEPTH))),
            FilmLayer::Uv => floats(self.features(|f| f.mean_of_hits::<2>(UV, 0.0))),
            FilmLayer::ObjectId => whole(self.features(|f| [f.ids()[0]])),
            FilmLayer::MaterialId => whole(self.features(|f| [f.ids()[1]])),
            FilmLayer::Samples => whole(self.totals().map(|s| s.count).collect()),
            FilmLayer::Variance => {
                let variance = |h| estimate::variance(&h).unwrap_or_default().map(|v| v as f32);
                floats(self.halves().flat_map(variance).collect())
            }
        }
    }

    /// Values of all pixels, of samples that met nothing where no features were gathered.
    fn features<T, const N: usize>(&self, values: impl Fn(&FeatureSum) -> [T; N]) -> Vec<T> {
        let mut sums = self.features.totals();
        (0..self.pixels()).flat_map(|_| values(&sums.next().unwrap_or_default())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Feature, Tile, TileSums};
    use super::*;
    use penombre_math::{Spectrum, Vec2, Vec3};

    #[test]
    fn names_are_standard_and_find_their_layers() {
        for layer in FilmLayer::ALL {
            assert_eq!(FilmLayer::from_name(layer.name()), Some(layer));
            assert!(STANDARD_LAYERS.iter().any(|(name, _)| *name == layer.name()), "{layer:?}");
        }
        assert_eq!(FilmLayer::from_name("normals"), None);
        assert_eq!(FilmLayer::ALL.len(), FilmLayer::NAMES.len());
    }

    /// Two pixels: one that meets a surface with one of its two samples, the first, and one that meets nothing.
    #[test]
    fn means_are_over_all_samples_or_over_hits() {
        let feature = Feature {
            albedo: Spectrum::from_rgb([0.5, 0.25, 1.0]),
            normal: Vec3::Z,
            position: Vec3::new(1.0, 2.0, 3.0),
            depth: 4.0,
            uv: Vec2::new(0.25, 0.75),
            object: 7,
            material: 3,
        };
        let tile = Tile { x0: 0, y0: 0, x1: 2, y1: 1 };
        let mut film = Film::new(2, 1, 1);
        for (sample, met) in [Some(&feature), None].into_iter().enumerate() {
            let mut sums = TileSums::new(2, false, true);
            sums.features[0].add(met);
            sums.features[1].add(None);
            film.merge(0, tile, sample as u32, 1, sums);
        }
        let pixel = |layer, x| film.layer(layer).to_image(2, 1).unwrap().pixel(x, 0).to_vec();
        assert_eq!(pixel(FilmLayer::Albedo, 0), [0.25, 0.125, 0.5]);
        assert_eq!(pixel(FilmLayer::Normal, 0), [0.0, 0.0, 0.5]);
        assert_eq!(pixel(FilmLayer::Position, 0), [1.0, 2.0, 3.0]);
        assert_eq!([pixel(FilmLayer::Depth, 0), pixel(FilmLayer::Depth, 1)], [[4.0], [BACKGROUND_DEPTH]]);
        assert_eq!(pixel(FilmLayer::Uv, 0)[..2], [0.25, 0.75]);
        assert_eq!([pixel(FilmLayer::ObjectId, 0), pixel(FilmLayer::ObjectId, 1)], [[7.0], [0.0]]);
        assert_eq!(pixel(FilmLayer::MaterialId, 0), [3.0]);
        assert_eq!(pixel(FilmLayer::Albedo, 1), [0.0; 3]);
    }
}
