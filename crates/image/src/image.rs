//! The pixel buffer.

mod storage;

use crate::error::ShapeError;
use std::ops::{Deref, Range};
pub(crate) use storage::{Codes, Storage, Tables};

/// A picture in memory: linear light, rows from top to bottom, samples interleaved.
///
/// One channel is grey, two are grey and alpha, three are linear Rec. 709 red, green and blue, four are those and
/// alpha. Alpha is straight (not multiplied in). Pictures from files of 8 and 16 bits keep the numbers of the file, and
/// take as many bytes for a sample, until they are changed.
#[derive(Clone, Debug)]
pub struct Image {
    width: u32,
    height: u32,
    channels: u32,
    data: Storage,
}

/// The samples of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    samples: [f32; 4],
    channels: usize,
}

impl Deref for Pixel {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.samples[..self.channels]
    }
}

/// The same size and the same linear values.
impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        let shape = |image: &Self| [image.width, image.height, image.channels];
        shape(self) == shape(other)
            && (0..self.pixel_count()).all(|i| self.samples_of(i) == other.samples_of(i))
    }
}

impl Image {
    /// A black image (alpha 0, where there is one) of `width` × `height` pixels with 1 to 4 channels.
    ///
    /// # Panics
    ///
    /// If `channels` is not 1 to 4, or the image does not fit the address space: sizes from outside must be
    /// checked before.
    #[must_use]
    pub fn new(width: u32, height: u32, channels: u32) -> Self {
        assert!((1..=4).contains(&channels), "an image has 1 to 4 channels, not {channels}");
        let length = sample_count(width, height, channels).expect("the image fits the address space");
        Self { width, height, channels, data: vec![0.0; length].into() }
    }

    /// An image from its samples: `width × height × channels` of them, interleaved, top row first.
    ///
    /// # Errors
    ///
    /// If there are not 1 to 4 channels, or the number of samples is another one.
    pub fn from_data(width: u32, height: u32, channels: u32, data: Vec<f32>) -> Result<Self, ShapeError> {
        Self::from_storage(width, height, channels, data.into())
    }

    /// The same from samples that are kept in any way.
    pub(crate) fn from_storage(
        width: u32,
        height: u32,
        channels: u32,
        data: Storage,
    ) -> Result<Self, ShapeError> {
        let fits = sample_count(width, height, channels) == Some(data.len());
        if !(1..=4).contains(&channels) || !fits {
            return Err(ShapeError { width, height, channels, found: data.len() });
        }
        Ok(Self { width, height, channels, data })
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

    /// Samples per pixel, 1 to 4.
    #[must_use]
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// What the channels are called in files that name them: Y, Y and A, R, G, B, or those and A.
    #[must_use]
    pub fn channel_names(&self) -> &'static [&'static str] {
        match self.channels {
            1 => &["Y"],
            2 => &["Y", "A"],
            3 => &["R", "G", "B"],
            _ => &["R", "G", "B", "A"],
        }
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.data.len() / self.channels as usize
    }

    /// Memory that the samples take, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.data.bytes()
    }

    /// All samples, interleaved, top row first.
    #[must_use]
    pub fn to_data(&self) -> Vec<f32> {
        self.data.clone().into_floats(self.channels as usize)
    }

    /// All samples to change, interleaved, top row first.
    pub fn data_mut(&mut self) -> &mut [f32] {
        if let Storage::Codes(_) = self.data {
            let codes = std::mem::replace(&mut self.data, Vec::new().into());
            self.data = codes.into_floats(self.channels as usize).into();
        }
        match &mut self.data {
            Storage::Floats(floats) => floats,
            Storage::Codes(_) => unreachable!("they have become floats"),
        }
    }

    /// The samples, without the image around them.
    #[must_use]
    pub fn into_data(self) -> Vec<f32> {
        self.data.into_floats(self.channels as usize)
    }

    /// The samples of one pixel; y = 0 is the top row.
    ///
    /// # Panics
    ///
    /// If the pixel is outside of the image.
    #[must_use]
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        self.samples_of(self.index(x, y))
    }

    /// The samples of one pixel, to change; y = 0 is the top row.
    ///
    /// # Panics
    ///
    /// If the pixel is outside of the image.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> &mut [f32] {
        let (index, channels) = (self.index(x, y), self.channels as usize);
        &mut self.data_mut()[index * channels..(index + 1) * channels]
    }

    /// The colour of one pixel; grey is repeated, alpha is left out.
    ///
    /// # Panics
    ///
    /// If the pixel is outside of the image.
    #[must_use]
    #[inline]
    pub fn rgb(&self, x: u32, y: u32) -> [f32; 3] {
        self.samples_of(self.index(x, y)).rgb()
    }

    /// All pixels, top row first.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = Pixel> + '_ {
        (0..self.pixel_count()).map(|i| self.samples_of(i))
    }

    /// The colours of all pixels, top row first; grey is repeated, alpha is left out.
    pub fn rgb_pixels(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        self.pixels().map(|pixel| pixel.rgb())
    }

    /// The same picture with three channels; grey is repeated, alpha is left out.
    #[must_use]
    pub fn to_rgb(&self) -> Self {
        let data: Vec<f32> = self.rgb_pixels().flatten().collect();
        Self { width: self.width, height: self.height, channels: 3, data: data.into() }
    }

    /// BLAKE3 hash, in hexadecimal, of the red, green and blue samples as little-endian `f32`, top row first. Two
    /// renders are the same bits exactly if their digests (and sizes) are equal.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut bytes = Vec::with_capacity(self.width as usize * 12);
        for row in self.rows() {
            bytes.clear();
            bytes.extend(row.flat_map(|pixel| pixel.rgb()).flat_map(f32::to_le_bytes));
            hasher.update(&bytes);
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Mean of red, green and blue over all pixels, summed in `f64` row by row; zero for an empty image.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0f64; 3];
        for row in self.rows() {
            let mut row_sum = [0.0f64; 3];
            for pixel in row {
                for (s, c) in row_sum.iter_mut().zip(pixel.rgb()) {
                    *s += f64::from(c);
                }
            }
            for (s, r) in sum.iter_mut().zip(row_sum) {
                *s += r;
            }
        }
        sum.map(|s| s / self.pixel_count().max(1) as f64)
    }

    /// The pixels of each row, from the top one on.
    pub fn rows(
        &self,
    ) -> impl ExactSizeIterator<Item = impl ExactSizeIterator<Item = Pixel> + '_> + DoubleEndedIterator + '_
    {
        let width = self.width as usize;
        (0..self.height as usize).map(move |y| (y * width..(y + 1) * width).map(|i| self.samples_of(i)))
    }

    /// Hands over the colours of these pixels, counted from the upper left one. How the samples are kept is asked once and
    /// not for each of them.
    #[inline]
    pub(crate) fn each_rgb(&self, pixels: Range<usize>, mut take: impl FnMut([f32; 3])) {
        match &self.data {
            Storage::Floats(floats) if self.channels == 3 => {
                floats.as_chunks().0[pixels].iter().for_each(|rgb| take(*rgb));
            }
            _ => pixels.for_each(|i| take(self.samples_of(i).rgb())),
        }
    }

    #[inline]
    fn samples_of(&self, index: usize) -> Pixel {
        let channels = self.channels as usize;
        Pixel { samples: self.data.pixel(index, channels), channels }
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        let (width, height) = (self.width, self.height);
        assert!(x < width && y < height, "pixel {x}, {y} is outside of {width} × {height}");
        y as usize * width as usize + x as usize
    }
}

impl Pixel {
    /// The colour; grey is repeated, alpha is left out.
    #[must_use]
    #[inline]
    pub fn rgb(&self) -> [f32; 3] {
        let [first, second, third, _] = self.samples;
        if self.channels < 3 { [first; 3] } else { [first, second, third] }
    }

    /// Alpha, if there is any.
    #[must_use]
    #[inline]
    pub fn alpha(&self) -> Option<f32> {
        match self.channels {
            2 => Some(self.samples[1]),
            4 => Some(self.samples[3]),
            _ => None,
        }
    }
}

fn sample_count(width: u32, height: u32, channels: u32) -> Option<usize> {
    (width as usize).checked_mul(height as usize)?.checked_mul(channels as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_where_they_belong() {
        let mut image = Image::new(3, 2, 3);
        image.pixel_mut(2, 0).copy_from_slice(&[1.0, 2.0, 3.0]);
        image.pixel_mut(0, 1)[1] = 5.0;
        assert_eq!(image.to_data()[6..9], [1.0, 2.0, 3.0]);
        assert_eq!(image.to_data()[10], 5.0);
        assert_eq!(image.rgb(2, 0), [1.0, 2.0, 3.0]);
        assert_eq!(image.pixel_count(), 6);
        assert_eq!(image.mean(), [1.0 / 6.0, 7.0 / 6.0, 0.5]);
    }

    #[test]
    fn wrong_shapes_are_refused() {
        assert!(Image::from_data(2, 2, 3, vec![0.0; 12]).is_ok());
        let error = Image::from_data(2, 2, 3, vec![0.0; 11]).unwrap_err();
        assert!(error.to_string().contains("11"), "{error}");
        assert!(Image::from_data(1, 1, 0, vec![]).is_err());
        assert!(Image::from_data(1, 1, 5, vec![0.0; 5]).is_err());
        assert!(Image::from_data(u32::MAX, u32::MAX, 4, vec![]).is_err());
    }

    #[test]
    fn grey_and_alpha_become_colour() {
        let grey = Image::from_data(1, 2, 2, vec![0.25, 1.0, 0.5, 0.0]).unwrap();
        assert_eq!(grey.to_rgb().to_data(), [0.25, 0.25, 0.25, 0.5, 0.5, 0.5]);
        let rgba = Image::from_data(1, 1, 4, vec![1.0, 2.0, 3.0, 0.5]).unwrap();
        assert_eq!(rgba.to_rgb().to_data(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn digest_is_blake3_of_the_rgb_bytes() {
        let samples: Vec<f32> = (0..3 * 7 * 5).map(|i| i as f32 * 0.37 - 1.0).collect();
        let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
        let image = Image::from_data(7, 5, 3, samples).unwrap();
        assert_eq!(image.digest(), blake3::hash(&bytes).to_hex().to_string());
        assert_eq!(image.digest().len(), 64);
        assert_eq!(Image::new(0, 0, 3).digest(), blake3::hash(b"").to_hex().to_string());
        let grey = Image::from_data(1, 1, 1, vec![0.5]).unwrap();
        assert_eq!(grey.digest(), grey.to_rgb().digest());
    }
}
