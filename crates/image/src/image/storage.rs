//! How the samples of an image are kept.

use std::fmt;
use std::sync::Arc;

/// The samples of an image, interleaved, top row first: linear floats, or the whole numbers of a file with their linear
/// values, which take a half or a quarter of the memory.
#[derive(Clone, Debug)]
pub enum Storage {
    Floats(Vec<f32>),
    Codes(Codes),
}

/// Whole numbers and the linear values that they stand for.
#[derive(Clone, Debug)]
pub enum Codes {
    /// Bytes.
    Narrow { bytes: Vec<u8>, tables: Tables<256> },
    /// Pairs of bytes, the high one first.
    Wide { bytes: Vec<u8>, tables: Tables<65_536> },
}

/// Linear value of each of `N` numbers.
#[derive(Clone)]
pub struct Tables<const N: usize> {
    pub color: Arc<[f32; N]>,
    pub alpha: Arc<[f32; N]>,
}

impl Storage {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Floats(floats) => floats.len(),
            Self::Codes(Codes::Narrow { bytes, .. }) => bytes.len(),
            Self::Codes(Codes::Wide { bytes, .. }) => bytes.len() / 2,
        }
    }

    /// Memory that they take, bytes.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Floats(floats) => 4 * floats.len() as u64,
            Self::Codes(Codes::Narrow { bytes, .. } | Codes::Wide { bytes, .. }) => bytes.len() as u64,
        }
    }

    /// The samples of pixel `index` of an image with 1 to 4 channels; what lies behind them is 0.
    #[inline]
    pub fn pixel(&self, index: usize, channels: usize) -> [f32; 4] {
        match channels {
            1 => self.padded::<1>(index),
            2 => self.padded::<2>(index),
            3 => self.padded::<3>(index),
            _ => self.padded::<4>(index),
        }
    }

    #[inline]
    fn padded<const N: usize>(&self, index: usize) -> [f32; 4] {
        let samples: [f32; N] = match self {
            Self::Floats(floats) => floats.as_chunks().0[index],
            Self::Codes(Codes::Narrow { bytes, tables }) => {
                let codes: &[u8; N] = &bytes.as_chunks().0[index];
                std::array::from_fn(|c| tables.of(c, N)[usize::from(codes[c])])
            }
            Self::Codes(Codes::Wide { bytes, tables }) => {
                let codes: &[[u8; 2]; N] = &bytes.as_chunks().0.as_chunks().0[index];
                std::array::from_fn(|c| tables.of(c, N)[usize::from(u16::from_be_bytes(codes[c]))])
            }
        };
        std::array::from_fn(|c| samples.get(c).copied().unwrap_or(0.0))
    }

    /// All samples as floats.
    pub fn into_floats(self, channels: usize) -> Vec<f32> {
        match self {
            Self::Floats(floats) => floats,
            Self::Codes(_) => {
                let pixels = 0..self.len() / channels;
                let mut floats = Vec::with_capacity(self.len());
                pixels.for_each(|i| floats.extend_from_slice(&self.pixel(i, channels)[..channels]));
                floats
            }
        }
    }
}

impl<const N: usize> fmt::Debug for Tables<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Not all of them: images are shown where tests fail.
        f.debug_struct("Tables").field("of", &N).finish_non_exhaustive()
    }
}

impl<const N: usize> Tables<N> {
    /// The table of one of so many channels.
    #[inline]
    fn of(&self, channel: usize, channels: usize) -> &[f32; N] {
        if channels.is_multiple_of(2) && channel + 1 == channels { &self.alpha } else { &self.color }
    }
}

impl From<Vec<f32>> for Storage {
    fn from(floats: Vec<f32>) -> Self {
        Self::Floats(floats)
    }
}

impl From<Codes> for Storage {
    fn from(codes: Codes) -> Self {
        Self::Codes(codes)
    }
}
