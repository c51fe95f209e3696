//! Vectors compute what plain code does.

use super::avx2::{Avx2, Packed, PackedEight};
use super::avx512::Avx512;
use super::{has_avx2, has_avx512};
use crate::lanes::{Baseline, Eight, Lanes, Machine, Plain, PlainEight};

const NUMBERS: [f64; 12] = [
    0.0,
    -0.0,
    1.5,
    -1.5,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e-310,
    -1e300,
    16_777_217.5,
    1e-46,
    0.1,
];

/// Everything that two vectors yield, as bits; NaN counts as one number.
#[inline(always)]
fn all<V: Lanes<4>>(a: [f64; 4], b: [f64; 4]) -> Vec<u64> {
    let (x, y) = (V::load(&a), V::load(&b));
    let results = [
        x + y,
        x - y,
        x * y,
        x / y,
        -x,
        x.abs(),
        x.sqrt(),
        x.copysign(y),
        x.narrow(),
        x.smaller(y),
        x.larger(y),
        x.zero_below(y),
        V::splat(a[1]),
        V::widen(a.map(|a| a as f32)),
    ];
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    let mut all: Vec<u64> = results.iter().flat_map(|r| r.store()).map(bits).collect();
    all.extend([u64::from(x.below(y)), u64::from(x.at_most(y))]);
    all
}

#[target_feature(enable = "avx2,fma")]
fn packed(a: [f64; 4], b: [f64; 4]) -> Vec<u64> {
    all::<Packed>(a, b)
}

#[test]
fn four_lanes_compute_what_plain_code_does() {
    if !has_avx2() {
        eprintln!("NOT RUN: this processor has no AVX2");
        return;
    }
    let n = NUMBERS.len();
    for i in 0..n * n {
        let a = std::array::from_fn(|lane| NUMBERS[(i + lane) % n]);
        let b = std::array::from_fn(|lane| NUMBERS[(i / n + 5 * lane) % n]);
        // SAFETY: the processor was found to have AVX2.
        assert_eq!(unsafe { packed(a, b) }, all::<Plain>(a, b), "{a:?} {b:?}");
    }
}

/// Everything exact that two vectors yield, as bits; NaN counts as one number.
#[inline(always)]
fn exact<V: Eight>(a: [f32; 8], b: [f32; 8], store: impl Fn(V) -> [f32; 8]) -> Vec<u32> {
    let (x, y) = (V::load(&a), V::load_bits(&b.map(f32::to_bits)));
    let numbers =
        [x.minus(y), x.times(y), x.opposite(), x.smaller(y), x.larger(y), V::splat(a[3])].map(store).concat();
    let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
    let mut all: Vec<u32> = numbers.into_iter().map(bits).collect();
    all.extend([x.not_above(y), x.around_zero(y)]);
    all
}

#[target_feature(enable = "avx2,fma")]
fn store(x: PackedEight) -> [f32; 8] {
    let mut to = [0.0; 8];
    // SAFETY: the pointer is that of eight numbers, alignment is not asked for.
    unsafe { std::arch::x86_64::_mm256_storeu_ps(to.as_mut_ptr(), x.0) };
    to
}

#[target_feature(enable = "avx2,fma")]
fn packed_eight(a: [f32; 8], b: [f32; 8]) -> Vec<u32> {
    exact::<PackedEight>(a, b, |x| store(x))
}

#[target_feature(enable = "avx2,fma")]
fn about(a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
    store(PackedEight::load(&a).about_mul_sub(PackedEight::load(&b), PackedEight::load(&c)))
}

#[test]
fn eight_lanes_compute_what_plain_code_does() {
    if !has_avx2() {
        eprintln!("NOT RUN: this processor has no AVX2");
        return;
    }
    let n = NUMBERS.len();
    for i in 0..n * n {
        let a = std::array::from_fn(|lane| NUMBERS[(i + lane) % n] as f32);
        let b = std::array::from_fn(|lane| NUMBERS[(i / n + 5 * lane) % n] as f32);
        // SAFETY: the processor was found to have AVX2.
        let found = unsafe { packed_eight(a, b) };
        assert_eq!(found, exact::<PlainEight>(a, b, |x| x.0), "{a:?} {b:?}");
        // SAFETY: as above.
        let about = unsafe { about(a, b, a) };
        for ((x, y), found) in a.iter().zip(b).zip(about) {
            let expected = f64::from(*x) * f64::from(y) - f64::from(*x);
            let close = (f64::from(found) - expected).abs() <= 1e-6 * expected.abs() + 1e-38;
            assert!(close || !expected.is_finite() || expected.abs() > 1e38, "{x} {y}: {found}");
        }
    }
}

/// What two ways of arranging write, for every mask and some orders.
#[inline(always)]
fn arranged<M: Machine>(mask: u32, order: u32) -> (Vec<u32>, Vec<f32>, Vec<u32>) {
    let words = std::array::from_fn(|i| 100 + i as u32);
    let numbers = M::Eight::load(&std::array::from_fn(|i| i as f32 * 0.5));
    let (mut to, mut numbers_to, mut packed) = ([0; 8], [0.0; 8], [0; 8]);
    M::arrange(mask, order, &words, numbers, &mut to, &mut numbers_to);
    M::compress(mask, &words, &mut packed);
    let count = mask.count_ones() as usize;
    (to[..count].to_vec(), numbers_to[..count].to_vec(), packed[..count].to_vec())
}

#[target_feature(enable = "avx2,fma")]
fn arranged_avx2(mask: u32, order: u32) -> (Vec<u32>, Vec<f32>, Vec<u32>) {
    arranged::<Avx2>(mask, order)
}

#[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
fn arranged_avx512(mask: u32, order: u32) -> (Vec<u32>, Vec<f32>, Vec<u32>) {
    arranged::<Avx512>(mask, order)
}

#[test]
fn children_are_arranged_alike() {
    let orders = [[0, 1, 2, 3, 4, 5, 6, 7], [7, 6, 5, 4, 3, 2, 1, 0], [3, 1, 4, 0, 5, 7, 2, 6]];
    for order in orders {
        // What lies above the eight places is none of the order.
        let word = (0..8).fold(0xa500_0000, |word, i| word | (order[i] as u32) << (3 * i));
        for mask in 0..256u32 {
            let expected = arranged::<Baseline>(mask, word);
            let lanes = order.iter().filter(|lane| mask >> **lane & 1 == 1);
            assert_eq!(expected.0, lanes.map(|lane| 100 + *lane as u32).collect::<Vec<_>>());
            if has_avx2() {
                // SAFETY: the processor was found to have AVX2.
                assert_eq!(unsafe { arranged_avx2(mask, word) }, expected, "{mask:08b}");
            }
            if has_avx2() && has_avx512() {
                // SAFETY: the processor was found to have AVX-512VL.
                assert_eq!(unsafe { arranged_avx512(mask, word) }, expected, "{mask:08b}");
            }
        }
    }
}
