//! Jittered points in strata, as pure functions of an index and a key.
//!
//! Every [`STRATA`] consecutive indices put one point into each cell of a 4 × 4 grid, in an order of their own: the
//! points of a longer run begin with those of a shorter one, and nothing depends on how many will be taken. Two
//! blocks are independent, so beyond 16 samples the error falls as that of independent points does, from a lower
//! start; Sobol points stay the better choice.
//!
//! The order of the cells is x ↦ a·x + b over the field of 16 elements, a ≠ 0 and b random. These 240 orders take
//! any two indices to any two different cells equally often. The variance of a mean depends on pairs of points
//! only, so part of a block is as good as with an order chosen from all 16!.

use penombre_math::hash;

/// Points that fill all cells once.
pub const STRATA: u32 = 16;

/// Point `index` of the sequence of `key`, in [0, 1)². Keys need not be mixed, only differ.
#[inline]
pub fn stratified_2d(index: u32, key: u32) -> [f32; 2] {
    // The top bit tells orders of blocks from jitters; no film has 2³¹ samples in one dimension of a pixel.
    let order = hash::combine64(key, (index / STRATA) | (1 << 31));
    // All of the upper half chooses a, so that its 15 values are even to 2⁻³².
    let a = 1 + (((order >> 32) * u64::from(STRATA - 1)) >> 32) as u32;
    let cell = field_product(a, index % STRATA) ^ (order as u32 % STRATA);
    let jitter = hash::combine64(key, index);
    let coordinate = |cell: u32, jitter: u32| hash::unit_f32((cell << 30) | (jitter >> 2));
    [coordinate(cell & 3, (jitter >> 32) as u32), coordinate(cell >> 2, jitter as u32)]
}

/// The product of two elements of the field of 16, as polynomials over two elements modulo x⁴ + x + 1.
#[inline]
const fn field_product(a: u32, b: u32) -> u32 {
    // Without carries, then x⁴ = x + 1 for the upper three bits.
    let product = (a * (b & 1)) ^ (a * (b & 2)) ^ (a * (b & 4)) ^ (a * (b & 8));
    let upper = product >> 4;
    (product ^ upper ^ (upper << 1)) & 15
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::{chi_square_uniform, sidak};

    fn cell([x, y]: [f32; 2], edge: u32) -> usize {
        let at = |v: f32| (v * edge as f32) as usize;
        at(x) + edge as usize * at(y)
    }

    #[test]
    fn the_field_has_inverses_and_distributes() {
        for a in 1..STRATA {
            let mut seen = [false; STRATA as usize];
            for b in 0..STRATA {
                seen[field_product(a, b) as usize] = true;
                for c in 0..STRATA {
                    assert_eq!(field_product(a, b ^ c), field_product(a, b) ^ field_product(a, c));
                    let (left, right) = (field_product(field_product(a, b), c), field_product(b, c));
                    assert_eq!(left, field_product(a, right));
                }
            }
            assert_eq!(seen, [true; STRATA as usize]);
        }
    }

    #[test]
    fn every_block_fills_every_cell_once() {
        for (key, block) in (0..50).map(|i| (i * 7919, i % 5)) {
            let mut cells = [0; STRATA as usize];
            for i in 0..STRATA {
                cells[cell(stratified_2d(block * STRATA + i, key), 4)] += 1;
            }
            assert_eq!(cells, [1; STRATA as usize]);
        }
    }

    /// Chi² at a significance of 0.01 over all five: single points on a fine grid, and pairs of cells.
    #[test]
    fn points_and_pairs_are_uniform() {
        let alpha = sidak(0.01, 5);
        let mut points = vec![0.0; 64 * 64];
        for key in 0..1000 {
            (0..256).for_each(|i| points[cell(stratified_2d(i, key), 64)] += 1.0);
        }
        let found = chi_square_uniform(&points);
        assert!(found.p_value >= alpha, "{found:?}");
        for (i, j) in [(0, 1), (3, 14), (16 + 7, 16 + 8), (15, 16)] {
            let mut pairs = vec![0.0; 256];
            for key in 0..200_000 {
                let at = |k| cell(stratified_2d(k, key), 4);
                pairs[at(i) * 16 + at(j)] += 1.0;
            }
            // Two of one block never share a cell; two of different blocks are independent.
            if i / STRATA == j / STRATA {
                assert!((0..16).all(|c| pairs[c * 17] == 0.0));
                pairs = (0..256).filter(|p| p % 17 != 0).map(|p| pairs[p]).collect();
            }
            let found = chi_square_uniform(&pairs);
            assert!(found.p_value >= alpha, "{i} {j}: {found:?}");
        }
    }

    /// Strata pay: the mean of x·y over one block has far less variance than that of 16 independent points.
    #[test]
    fn a_block_has_less_variance_than_independent_points() {
        let variance = |point: fn(u32, u32) -> [f32; 2]| {
            let mean = |key| {
                let sum: f32 = (0..STRATA).map(|i| point(i, key)).map(|[x, y]| x * y).sum();
                f64::from(sum / STRATA as f32) - 0.25
            };
            (0..20_000).map(|key| mean(key) * mean(key)).sum::<f64>() / 20_000.0
        };
        let independent = variance(penombre_math::sobol::independent_2d);
        // Var(x·y) is 7/144 over the square and 0.003445 on average over the cells, a share of 0.0709.
        assert!((independent * 16.0 * 144.0 / 7.0 - 1.0).abs() < 0.05, "{independent}");
        let share = variance(stratified_2d) / independent;
        assert!((share / 0.0709 - 1.0).abs() < 0.07, "{share}");
    }
}
