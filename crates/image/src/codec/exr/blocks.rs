//! The blocks of a part, of which each must come once: an offset that leads to another one's block leaves a gap.

use super::Fault;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::math::Vec2;
use ::exr::meta::header::Header;
use std::collections::HashSet;

/// Bytes of a block's place in the picture and of its length, which stand before its data.
const ROW_HEAD: usize = 8;
const TILE_HEAD: usize = 20;

/// The blocks that have come so far, as columns and rows of blocks.
pub struct Blocks {
    part: usize,
    seen: HashSet<(usize, usize)>,
}

impl Blocks {
    /// Of a part, by its number; only those of its full size count.
    pub fn new(part: usize) -> Self {
        Self { part, seen: HashSet::new() }
    }

    /// Adds one that the decoder has just read, if it is a new one of the part, whose header this is.
    pub fn take(&mut self, chunk: &Chunk, header: &Header) -> Result<(), Fault> {
        let (length, place, name) = match &chunk.compressed_block {
            CompressedBlock::ScanLine(rows) => {
                let place = rows_of(rows.y_coordinate, header);
                (rows.compressed_pixels_le.len() + ROW_HEAD, place, format!("y = {}", rows.y_coordinate))
            }
            CompressedBlock::Tile(tile) => {
                let (index, level) = (tile.coordinates.tile_index, tile.coordinates.level_index);
                let place = (level == Vec2(0, 0)).then_some((index.x(), index.y()));
                let name = format!("tile {}, {} of level {}, {}", index.x(), index.y(), level.x(), level.y());
                (tile.compressed_pixels_le.len() + TILE_HEAD, place, name)
            }
            // Deep pictures are refused before.
            _ => return Ok(()),
        };
        let fault = |found: String, expected: &str| Err(Fault::Before(length, found, expected.to_owned()));
        if chunk.layer_index != self.part {
            let found = format!(
                "a block of part {}, where the table leads for part {}",
                chunk.layer_index, self.part
            );
            return fault(found, "offsets to the part's own blocks");
        }
        match place {
            None => fault(format!("a block with {name}"), "the place of a block of the picture"),
            Some(place) if !self.seen.insert(place) => {
                fault(format!("a second block with {name}"), "each block of the picture once")
            }
            Some(_) => Ok(()),
        }
    }
}

/// The block of rows that begins at y, if one does.
fn rows_of(y: i32, header: &Header) -> Option<(usize, usize)> {
    let row = usize::try_from(i64::from(y) - i64::from(header.own_attributes.layer_position.y())).ok()?;
    let rows = header.compression.scan_lines_per_block();
    (row < header.layer_size.height() && row.is_multiple_of(rows)).then_some((0, row / rows))
}
