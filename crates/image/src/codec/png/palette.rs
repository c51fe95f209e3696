//! Pictures with a palette that lacks colours which their samples can name.

use super::fault::Fault;
use crate::codec::palette::first_outside;
use ::png::{ColorType, Info};

/// A palette with fewer colours than the samples of its picture can name.
pub struct Short {
    colors: usize,
    /// Bits of a sample.
    depth: u32,
}

impl Short {
    /// `None` for other pictures.
    pub fn of(info: &Info<'_>) -> Option<Self> {
        let depth = info.bit_depth as u32;
        let colors = info.palette.as_ref()?.len() / 3;
        (info.color_type == ColorType::Indexed && colors < 1 << depth).then_some(Self { colors, depth })
    }

    /// Checks the samples of a row of this width, packed as they are in the file.
    pub fn check(&self, row: &[u8], width: usize) -> Result<(), Fault> {
        match first_outside(row, self.depth, width, self.colors) {
            Some((_, color)) => Err(Fault::Here(
                format!("colour {color} in the picture's data"),
                format!("colours 0 to {} of the palette", self.colors - 1),
            )),
            None => Ok(()),
        }
    }
}

/// Where the pixels of each pass of an interlaced picture begin, and the steps between them: across and down \[PNG\].
const PASSES: [[u32; 4]; 7] =
    [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];

/// The number of pixels in each row, in the order of the file.
pub fn row_widths(info: &Info<'_>) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (info.width, info.height);
    let passes: &[[u32; 4]] = if info.interlaced { &PASSES } else { &[[0, 0, 1, 1]] };
    passes.iter().flat_map(move |[x, y, dx, dy]| {
        let columns = width.saturating_sub(*x).div_ceil(*dx) as usize;
        let rows = if columns == 0 { 0 } else { height.saturating_sub(*y).div_ceil(*dy) as usize };
        std::iter::repeat_n(columns, rows)
    })
}
