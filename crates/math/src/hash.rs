//! Integer mixing: seeds, counter-based random numbers, hash keys. Not for adversaries.

/// ⌊2⁶⁴/φ⌋, odd: the step of the Weyl sequence of \[Steele2014\].
const GOLDEN_64: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes 32 bits: a bijection (0 stays 0) of two multiplications in which every input bit flips every output
/// bit with a probability near ½. Form and search \[Wellons2018\], constants the best pair found there later.
#[inline]
pub const fn mix32(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    x = (x ^ (x >> 15)).wrapping_mul(0x735a_2d97);
    x ^ (x >> 15)
}

/// Mixes 64 bits: a bijection (0 stays 0), the output function of SplitMix64 \[Steele2014\] (Stafford's 13th
/// variant of the MurmurHash3 finaliser).
#[inline]
pub const fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// All 64 mixed bits of a seed and a value; the order of the two matters.
#[inline]
pub const fn combine64(seed: u32, value: u32) -> u64 {
    mix64((((seed as u64) << 32) | value as u64).wrapping_add(GOLDEN_64))
}

/// A new 32-bit seed from a seed and a value, such as a pixel number or a dimension. The order matters.
#[inline]
pub const fn combine(seed: u32, value: u32) -> u32 {
    (combine64(seed, value) >> 32) as u32
}

/// A 64-bit hash of words and of their number.
#[inline]
pub const fn hash_words(words: &[u32]) -> u64 {
    let mut state = mix64((words.len() as u64).wrapping_add(GOLDEN_64));
    let mut i = 0;
    while i < words.len() {
        state = mix64((state ^ words[i] as u64).wrapping_add(GOLDEN_64));
        i += 1;
    }
    state
}

/// A float in [0, 1) from the upper 24 bits: a multiple of 2⁻²⁴, never 1.
#[inline(always)]
pub const fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A double in [0, 1) from the upper 53 bits: a multiple of 2⁻⁵³, never 1.
#[inline]
pub const fn unit_f64(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

#[cfg(test)]
mod tests;
