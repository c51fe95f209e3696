//! Equal positions become one.

use penombre_math::Vec3;
use std::hash::{BuildHasher, RandomState};

/// Finds positions by their bits: a table with open addressing, at most half full. Its order is that in which the
/// positions come, whatever the keys.
pub(super) struct Weld {
    /// Indices of positions, or `EMPTY`; the length is a power of two.
    table: Vec<u32>,
    keys: [u64; 2],
}

const EMPTY: u32 = u32::MAX;

impl Weld {
    /// A table for a closed mesh of that many triangles, which has half as many vertices; it grows if there are more.
    pub fn with_room(triangles: usize) -> Self {
        // Random keys: no file can be made so that all its positions meet at one place of the table.
        let random = RandomState::new();
        let keys = [random.hash_one(0u8) | 1, random.hash_one(1u8) | 1];
        Self { table: vec![EMPTY; triangles.max(16).next_power_of_two()], keys }
    }

    /// The index of a position, which is added if it is new. The zeros of both signs are one.
    pub fn index(&mut self, position: Vec3, positions: &mut Vec<Vec3>) -> u32 {
        let position = position + Vec3::ZERO;
        let mut at = self.slot(position);
        loop {
            match self.table[at] {
                EMPTY => break,
                index if positions[index as usize] == position => return index,
                _ => at = (at + 1) & (self.table.len() - 1),
            }
        }
        let index = positions.len() as u32;
        positions.push(position);
        self.table[at] = index;
        if 2 * positions.len() > self.table.len() {
            self.grow(positions);
        }
        index
    }

    fn grow(&mut self, positions: &[Vec3]) {
        self.table = vec![EMPTY; 2 * self.table.len()];
        for (index, position) in positions.iter().enumerate() {
            let mut at = self.slot(*position);
            while self.table[at] != EMPTY {
                at = (at + 1) & (self.table.len() - 1);
            }
            self.table[at] = index as u32;
        }
    }

    /// Where to look first: products of 128 bits with the keys, folded.
    fn slot(&self, position: Vec3) -> usize {
        let [x, y, z] = position.to_array().map(|v| u64::from(v.to_bits()));
        let fold = |a: u64, b: u64| {
            let product = u128::from(a) * u128::from(b);
            (product as u64) ^ (product >> 64) as u64
        };
        let hash = fold(fold((x | y << 32) ^ self.keys[0], self.keys[1]) ^ z, self.keys[0]);
        hash as usize & (self.table.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_are_one_and_keep_their_order() {
        let mut weld = Weld::with_room(0);
        let mut positions = Vec::new();
        let point = |i: u32| Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32 * 1e-30);
        for round in 0..3 {
            for i in 0..1000 {
                assert_eq!(weld.index(point(i), &mut positions), i, "{round}");
            }
        }
        assert_eq!(positions, (0..1000).map(point).collect::<Vec<_>>());
        assert_eq!(weld.index(Vec3::new(-0.0, 0.0, -0.0), &mut positions), 0);
        assert_eq!(weld.index(Vec3::new(f32::MIN_POSITIVE, 0.0, 0.0), &mut positions), 1000);
    }
}
