use super::*;
use penombre_lab::{chi_square_uniform, sidak, z_test};

#[test]
fn mix64_is_splitmix64() {
    // First outputs of the reference implementation with seed 0.
    let outputs = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
    for (i, expected) in outputs.into_iter().enumerate() {
        assert_eq!(mix64(GOLDEN_64.wrapping_mul(i as u64 + 1)), expected);
    }
}

/// The inverse of an odd number modulo 2³², by Newton's iteration.
fn inverse_of(odd: u32) -> u32 {
    (0..5).fold(odd, |x, _| x.wrapping_mul(2u32.wrapping_sub(odd.wrapping_mul(x))))
}

#[test]
fn mix32_is_a_bijection() {
    let unshift = |x: u32, by: u32| x ^ (x >> by) ^ (x.checked_shr(2 * by).unwrap_or(0));
    for i in 0..100_000u32 {
        let x = i.wrapping_mul(0x9e37_79b9);
        let y = unshift(mix32(x), 15).wrapping_mul(inverse_of(0x735a_2d97));
        let y = unshift(y, 15).wrapping_mul(inverse_of(0x21f0_aaad));
        assert_eq!(unshift(y, 16), x);
    }
}

/// Each input bit flips each output bit in half of the cases: Z-tests of all pairs of bits, α = 0.001
/// together.
fn assert_avalanche(name: &str, bits: u32, hash: impl Fn(u64) -> u64) {
    const TRIALS: u32 = 4000;
    let mut flips = vec![0u32; (bits * bits) as usize];
    for trial in 0..TRIALS {
        let x = mix64(u64::from(trial) + 77) >> (64 - bits);
        for i in 0..bits {
            let changed = hash(x) ^ hash(x ^ (1 << i));
            (0..bits).for_each(|o| flips[(i * bits + o) as usize] += (changed >> o & 1) as u32);
        }
    }
    let each = sidak(0.001, flips.len());
    let n = f64::from(TRIALS);
    for (pair, &count) in flips.iter().enumerate() {
        let p = z_test(f64::from(count), n / 4.0, n / 2.0).p_value;
        assert!(
            p > each,
            "{name}: input bit {}, output bit {}: {count} of {n}",
            pair as u32 / bits,
            pair as u32 % bits
        );
    }
}

#[test]
fn every_bit_depends_on_every_bit() {
    assert_avalanche("mix32", 32, |x| u64::from(mix32(x as u32)));
    assert_avalanche("mix64", 64, mix64);
    assert_avalanche("combine64", 64, |x| combine64((x >> 32) as u32, x as u32));
    assert_avalanche("hash_words", 64, |x| hash_words(&[x as u32, (x >> 32) as u32]));
}

#[test]
fn order_and_number_of_words_matter() {
    assert_ne!(combine(1, 2), combine(2, 1));
    assert_ne!(combine(0, 0), 0);
    let hashes = [&[][..], &[0], &[0, 0], &[1], &[0, 1], &[1, 0]].map(hash_words);
    for (i, h) in hashes.iter().enumerate() {
        assert!(hashes[..i].iter().all(|g| g != h));
    }
}

#[test]
fn counters_give_uniform_numbers() {
    // Runs of small numbers, as pixels and dimensions are; χ² at α = 0.001 each.
    for seed in 0..5 {
        let mut bins = [0.0; 4096];
        for i in 0..400_000 {
            let x = combine(seed, i);
            let y = combine(seed, i + 1);
            bins[((x >> 26) << 6 | y >> 26) as usize] += 1.0;
        }
        assert!(chi_square_uniform(&bins).p_value > 0.001, "seed {seed}");
    }
}

#[test]
fn unit_floats_reach_neither_end_too_far() {
    assert_eq!((unit_f32(0), unit_f64(0)), (0.0, 0.0));
    assert_eq!(unit_f32(u32::MAX), 1.0f32.next_down());
    assert_eq!(unit_f64(u64::MAX), 1.0f64.next_down());
    assert_eq!((unit_f32(1 << 31), unit_f64(1 << 63)), (0.5, 0.5));
}

#[test]
fn bits_never_change() {
    // Stored pictures and checkpoints depend on these.
    assert_eq!(mix32(1), 0x86d2_fa73);
    assert_eq!(combine(1, 2), 0xb370_3ad8);
    assert_eq!(hash_words(&[1, 2, 3]), 0x4e28_89b2_1ba4_3ff3);
}
