//! Film: sums of samples per pixel.
//!
//! A sample adds to the one pixel that it was drawn for, with weight 1: [`PixelFilter`] decides where around the pixel
//! it is drawn \[Ernst2006\]. Samples are summed in double precision, in
//! order within chunks of [`SAMPLE_CHUNK`] samples, and the chunks of a pixel are added in order: the sums are the
//! same whoever computed which chunk when, and whether a chunk came whole or sample by sample.

mod estimate;
mod features;
mod filter;
mod layers;

use penombre_image::Image;
use penombre_math::Spectrum;
use std::collections::BTreeMap;

pub use estimate::Estimate;
pub use features::{Feature, FeatureSum};
pub use filter::{FilterKind, FilterTable, PixelFilter};
pub use layers::{BACKGROUND_DEPTH, FilmLayer};

/// Samples per pixel that are summed at a time; chunk boundaries lie at its multiples.
pub const SAMPLE_CHUNK: u32 = 16;

/// A rectangle of pixels; `x1` and `y1` lie outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// First column.
    pub x0: u32,
    /// First row, counted from the top.
    pub y0: u32,
    /// Column after the last.
    pub x1: u32,
    /// Row after the last.
    pub y1: u32,
}

impl Tile {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        (self.x1 - self.x0) as usize * (self.y1 - self.y0) as usize
    }

    /// The pixels row by row.
    pub fn iter(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let t = *self;
        (t.y0..t.y1).flat_map(move |y| (t.x0..t.x1).map(move |x| [x, y]))
    }
}

/// The sum of some samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSum {
    /// Sums of linear red, green and blue.
    pub rgb: [f64; 3],
    /// Samples in the sums; dropped ones left out.
    pub count: u32,
}

impl PixelSum {
    /// Adds one sample; the caller has seen that it is finite.
    pub fn add(&mut self, sample: Spectrum) {
        for (sum, value) in self.rgb.iter_mut().zip(sample.to_rgb()) {
            *sum += f64::from(value);
        }
        self.count += 1;
    }
}

/// What can be summed in chunks.
trait Sum: Clone + Default {
    /// Adds the sum of further samples.
    fn add_sum(&mut self, other: &Self);
}

impl Sum for PixelSum {
    fn add_sum(&mut self, other: &Self) {
        for (sum, value) in self.rgb.iter_mut().zip(other.rgb) {
            *sum += value;
        }
        self.count += other.count;
    }
}

/// Sums of some samples of the pixels of a tile, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileSums {
    /// Of all samples, or of those of even index if the others are kept apart.
    pub color: Vec<PixelSum>,
    /// Of the samples of odd index, for an estimate of the error; empty without one.
    pub odd: Vec<PixelSum>,
    /// What the samples' rays met first; empty if nobody asks.
    pub features: Vec<FeatureSum>,
}

impl TileSums {
    /// No samples yet of so many pixels, with or without an estimate and features.
    pub fn new(pixels: usize, estimate: bool, features: bool) -> Self {
        Self {
            color: vec![PixelSum::default(); pixels],
            odd: vec![PixelSum::default(); if estimate { pixels } else { 0 }],
            features: vec![FeatureSum::default(); if features { pixels } else { 0 }],
        }
    }
}

/// Sums of one kind for all pixels; without memory until the first come.
#[derive(Debug)]
struct Plane<S> {
    /// Sums of whole chunks.
    whole: Vec<S>,
    /// Sums of the chunk that is not complete yet.
    open: Vec<S>,
}

impl<S: Sum> Plane<S> {
    const EMPTY: Self = Self { whole: Vec::new(), open: Vec::new() };

    /// Adds the sums of a tile, the last of its chunk if `closed`. Tiles without sums add nothing.
    fn fold(&mut self, [width, height]: [u32; 2], tile: Tile, sums: &[S], closed: bool) {
        if self.whole.is_empty() && !sums.is_empty() {
            self.whole = vec![S::default(); width as usize * height as usize];
            self.open = self.whole.clone();
        }
        for ([x, y], sum) in tile.iter().zip(sums) {
            let pixel = y as usize * width as usize + x as usize;
            self.open[pixel].add_sum(sum);
            if closed {
                let chunk = std::mem::take(&mut self.open[pixel]);
                self.whole[pixel].add_sum(&chunk);
            }
        }
    }

    /// The sums of all samples of each pixel; nothing if none ever came.
    fn totals(&self) -> impl Iterator<Item = S> {
        self.whole.iter().zip(&self.open).map(|(whole, open)| {
            let mut total = whole.clone();
            total.add_sum(open);
            total
        })
    }
}

/// The sums of an image, built up from the sums of tiles and chunks in any order of arrival.
#[derive(Debug)]
pub struct Film {
    size: [u32; 2],
    color: Plane<PixelSum>,
    odd: Plane<PixelSum>,
    features: Plane<FeatureSum>,
    tiles: Vec<TileState>,
}

#[derive(Debug, Default)]
struct TileState {
    /// First sample that is not in the sums.
    next_sample: u32,
    /// Chunks that wait for an earlier one, by first sample: samples in it and sums per pixel.
    early: BTreeMap<u32, (Tile, u32, TileSums)>,
}

impl TileState {
    /// The sums of the next chunk in order, if it has come.
    fn take_next(&mut self) -> Option<(Tile, TileSums)> {
        let (tile, count, sums) = self.early.remove(&self.next_sample)?;
        self.next_sample += count;
        Some((tile, sums))
    }
}

impl Film {
    /// A film without samples, of so many pixels, whose chunks come in so many tiles.
    pub fn new(width: u32, height: u32, tiles: usize) -> Self {
        let mut states = Vec::new();
        states.resize_with(tiles, TileState::default);
        Self {
            size: [width, height],
            color: Plane::EMPTY,
            odd: Plane::EMPTY,
            features: Plane::EMPTY,
            tiles: states,
        }
    }

    /// Adds the sums of one tile of the samples `first_sample` up to `first_sample + count`: a chunk (or what the job
    /// has of it), or a single sample. Sums that come before earlier ones of the same tile are kept until those have
    /// come; repeated ones are left out.
    pub fn merge(&mut self, index: usize, tile: Tile, first_sample: u32, count: u32, sums: TileSums) {
        let state = &mut self.tiles[index];
        if first_sample >= state.next_sample {
            state.early.insert(first_sample, (tile, count, sums));
        }
        while let Some((tile, sums)) = self.tiles[index].take_next() {
            let closed = self.tiles[index].next_sample.is_multiple_of(SAMPLE_CHUNK);
            self.color.fold(self.size, tile, &sums.color, closed);
            self.odd.fold(self.size, tile, &sums.odd, closed);
            self.features.fold(self.size, tile, &sums.features, closed);
        }
    }

    /// Number of pixels.
    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// The sums of the samples of even and of odd index of each pixel. Without an estimate the first has all.
    fn halves(&self) -> impl Iterator<Item = [PixelSum; 2]> {
        let (mut even, mut odd) = (self.color.totals(), self.odd.totals());
        (0..self.pixels()).map(move |_| [even.next().unwrap_or_default(), odd.next().unwrap_or_default()])
    }

    /// The sums of all samples of each pixel.
    fn totals(&self) -> impl Iterator<Item = PixelSum> {
        self.halves().map(|[mut even, odd]| {
            even.add_sum(&odd);
            even
        })
    }

    /// Memory of a film and the image developed from it, bytes; with or without an estimate of the error and
    /// features.
    pub fn bytes(width: u32, height: u32, estimate: bool, features: bool) -> u64 {
        let sums = size_of::<PixelSum>() * if estimate { 2 } else { 1 };
        let features = if features { size_of::<FeatureSum>() } else { 0 };
        let per_pixel = 2 * (sums + features) + 3 * size_of::<f32>();
        u64::from(width) * u64::from(height) * per_pixel as u64
    }

    /// Samples in the film.
    pub fn samples(&self) -> u64 {
        self.totals().map(|s| u64::from(s.count)).sum()
    }

    /// The image so far: the mean of each pixel's samples, black where there are none.
    pub fn develop(&self) -> Image {
        let mean =
            |s: PixelSum| s.rgb.map(|v| if s.count == 0 { 0.0 } else { (v / f64::from(s.count)) as f32 });
        let data = self.totals().flat_map(mean).collect();
        Image::from_data(self.size[0], self.size[1], 3, data).expect("three values per pixel")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Tile = Tile { x0: 0, y0: 0, x1: 2, y1: 1 };

    fn sums(value: f64, count: u32) -> TileSums {
        TileSums { color: vec![PixelSum { rgb: [value; 3], count }; 2], ..TileSums::default() }
    }

    #[test]
    fn chunks_fold_in_order_whatever_the_order_of_arrival() {
        // 1e16 + 1 − 1e16 shows the order of sums in its result.
        let chunks = [(0, 1e16), (16, 1.0), (32, -1e16)];
        let arrive = |order: [usize; 3]| {
            let mut film = Film::new(2, 1, 1);
            for i in order {
                film.merge(0, TILE, chunks[i].0, 16, sums(chunks[i].1, 16));
            }
            film.develop().rgb(1, 0)[0]
        };
        let expected = arrive([0, 1, 2]);
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            assert_eq!(arrive(order).to_bits(), expected.to_bits());
        }
    }

    #[test]
    fn repeated_chunks_count_once_and_empty_pixels_are_black() {
        let mut film = Film::new(2, 2, 1);
        film.merge(0, TILE, 0, 16, sums(32.0, 16));
        film.merge(0, TILE, 0, 16, sums(32.0, 16));
        assert_eq!(film.samples(), 32);
        let image = film.develop();
        assert_eq!(image.rgb(0, 0), [2.0; 3]);
        assert_eq!(image.rgb(0, 1), [0.0; 3]);
    }
}
