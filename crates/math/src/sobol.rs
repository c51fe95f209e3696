//! Low-discrepancy and independent points as pure functions of an index and a seed.
//!
//! The points are *padded*: every pair of dimensions takes a fresh seed, and with it a fresh scrambling of
//! the first two Sobol dimensions and a fresh order \[Burley2020\]. In the order of the index they are a
//! scrambled (0, 2)-sequence in base 2: each aligned block of 2ᵏ indices puts exactly one point into each of
//! the 2ᵏ elementary boxes of every shape. Nothing depends on how many points will be taken.
//!
//! The price of padding in an order that serves every prefix: an integrand that is a pure product of
//! functions of two *padded* dimensions, each of mean zero, has about 1.6 times the variance it has with
//! independent points.

use crate::hash::{combine, combine64, mix64, unit_f32};

/// The three scrambling keys of a seed.
struct Keys {
    order: u32,
    first: u32,
    second: u32,
}

#[inline]
const fn keys(seed: u32) -> Keys {
    let bits = mix64(seed as u64 | 1 << 32);
    // The third key is a further hash of the other two (multiplier of \[LEcuyer1999\]).
    let order = (bits.wrapping_mul(0x27bb_2ee6_87b0_b0fd) >> 32) as u32;
    Keys { order, first: bits as u32, second: (bits >> 32) as u32 }
}

/// Laine and Karras' permutation, in which a bit is flipped depending on `seed` and the bits *below* it only;
/// constants of the improved variant of \[Vegdahl2021\]. `seed` must be mixed well.
#[inline(always)]
const fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Nested uniform (Owen) scrambling of a binary fraction `x` (the top bit weighs ½): each bit is flipped or
/// not depending on the bits above it and `seed`, which should be well mixed ([`crate::hash`]).
#[inline]
pub const fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// The second Sobol dimension of an index, bits reversed: bit k is the sum modulo 2 of all index bits j with
/// C(j, k) odd, that is, whose number j holds all binary digits of k. Five steps do one digit each.
#[inline(always)]
const fn second_dimension_reversed(mut i: u32) -> u32 {
    i ^= (i >> 1) & 0x5555_5555;
    i ^= (i >> 2) & 0x3333_3333;
    i ^= (i >> 4) & 0x0f0f_0f0f;
    i ^= (i >> 8) & 0x00ff_00ff;
    i ^ (i >> 16)
}

/// Point `index` of the one-dimensional sequence of `seed`, in [0, 1). Seeds need not be mixed, only differ.
#[inline]
pub const fn sobol_1d(index: u32, seed: u32) -> f32 {
    let Keys { order, first, .. } = keys(seed);
    unit_f32(laine_karras(owen_scramble(index, order), first).reverse_bits())
}

/// Point `index` of the two-dimensional sequence of `seed`, in [0, 1)². Seeds need not be mixed, only differ.
#[inline]
pub const fn sobol_2d(index: u32, seed: u32) -> [f32; 2] {
    let Keys { order, first, second } = keys(seed);
    // Nested scrambling of the order keeps aligned blocks of 2ᵏ indices together.
    let index = owen_scramble(index, order);
    let x = laine_karras(index, first);
    let y = laine_karras(second_dimension_reversed(index), second);
    // One reversal serves both.
    let reversed = ((x as u64) << 32 | y as u64).reverse_bits();
    [unit_f32(reversed as u32), unit_f32((reversed >> 32) as u32)]
}

/// Consecutive points of a two-dimensional sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sobol2dRun {
    /// Index of the first.
    pub first: u32,
    /// The sequence.
    pub seed: u32,
    /// How many.
    pub count: u32,
}

/// Appends all points of the runs, one run after the other: what [`sobol_2d`] gives one by one, in loops that a
/// compiler turns into vector code. Inlined, to be compiled for the caller's instruction set.
#[inline(always)]
pub fn sobol_2d_runs(runs: impl Iterator<Item = Sobol2dRun>, points: &mut Vec<[f32; 2]>) {
    let mut lanes = PointLanes::default();
    let mut filled = 0usize;
    for Sobol2dRun { first, seed, count } in runs {
        let keys = keys(seed);
        let mut done = 0;
        // Half of the lanes at a time, where they are free.
        while count - done >= HALF as u32 && filled.is_multiple_of(HALF) {
            lanes.fill_half(filled / HALF, first.wrapping_add(done), &keys);
            (done, filled) = (done + HALF as u32, filled + HALF);
            if filled == LANES {
                points.extend_from_slice(&lanes.points());
                filled = 0;
            }
        }
        for k in done..count {
            lanes.index[filled] = first.wrapping_add(k);
            lanes.order[filled] = keys.order;
            lanes.first[filled] = keys.first;
            lanes.second[filled] = keys.second;
            filled += 1;
            if filled == LANES {
                points.extend_from_slice(&lanes.points());
                filled = 0;
            }
        }
    }
    points.extend_from_slice(&lanes.points()[..filled]);
}

/// Points computed at once.
const LANES: usize = 8;
const HALF: usize = LANES / 2;

/// Indices and keys of as many points.
#[derive(Default)]
struct PointLanes {
    index: [u32; LANES],
    order: [u32; LANES],
    first: [u32; LANES],
    second: [u32; LANES],
}

impl PointLanes {
    /// Consecutive points of one sequence in one half.
    #[inline(always)]
    fn fill_half(&mut self, half: usize, first: u32, keys: &Keys) {
        let set = |lanes: &mut [u32; LANES], values: [u32; HALF]| {
            if let Some(lanes) = lanes.as_chunks_mut().0.get_mut(half) {
                *lanes = values;
            }
        };
        set(&mut self.index, std::array::from_fn(|k| first.wrapping_add(k as u32)));
        set(&mut self.order, [keys.order; HALF]);
        set(&mut self.first, [keys.first; HALF]);
        set(&mut self.second, [keys.second; HALF]);
    }

    #[inline(always)]
    fn points(&self) -> [[f32; 2]; LANES] {
        let mut index = self.index;
        for (index, order) in index.iter_mut().zip(self.order) {
            *index = laine_karras(index.reverse_bits(), order).reverse_bits();
        }
        let (mut x, mut y) = ([0f32; LANES], [0f32; LANES]);
        for lane in 0..LANES {
            x[lane] = unit_f32(laine_karras(index[lane], self.first[lane]).reverse_bits());
        }
        for lane in 0..LANES {
            let second = second_dimension_reversed(index[lane]);
            y[lane] = unit_f32(laine_karras(second, self.second[lane]).reverse_bits());
        }
        std::array::from_fn(|lane| [x[lane], y[lane]])
    }
}

/// Independent uniform number `index` of `seed`, in [0, 1).
#[inline]
pub const fn independent_1d(index: u32, seed: u32) -> f32 {
    unit_f32(combine(seed, index))
}

/// Independent uniform point `index` of `seed`, in [0, 1)².
#[inline]
pub const fn independent_2d(index: u32, seed: u32) -> [f32; 2] {
    let bits = combine64(seed, index);
    [unit_f32((bits >> 32) as u32), unit_f32(bits as u32)]
}

#[cfg(test)]
mod tests;
