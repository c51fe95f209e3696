//! Vectors compute what plain code does.

use super::avx2::{Avx2, Packed, PackedEight};
use super::avx512::Avx512;
use super::wide::Wide;
use super::written;
use crate::InstructionSet;
use crate::lanes::{Baseline, Eight, Lanes, Machine, Plain, PlainEight};
use std::mem::MaybeUninit;

fn has(set: InstructionSet) -> bool {
    InstructionSet::available().contains(&set)
}

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

/// Everything that two vectors yield, as bits, one lane after the other; NaN counts as one number.
#[inline(always)]
fn all<const N: usize, V: Lanes<N>>(a: [f64; N], b: [f64; N]) -> Vec<Vec<u64>> {
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
        V::splat(1.5),
        V::widen(a.map(|a| a as f32)),
    ];
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    let (below, at_most) = (x.below(y), x.at_most(y));
    let lane = |lane: usize| {
        let numbers = results.iter().map(|r| bits(r.store()[lane]));
        numbers.chain([below, at_most].map(|mask| u64::from(mask >> lane & 1))).collect()
    };
    (0..N).map(lane).collect()
}

#[target_feature(enable = "avx2,fma")]
fn packed(a: [f64; 4], b: [f64; 4]) -> Vec<Vec<u64>> {
    all::<4, Packed>(a, b)
}

#[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
fn wide(a: [f64; 8], b: [f64; 8]) -> Vec<Vec<u64>> {
    all::<8, Wide>(a, b)
}

#[test]
fn lanes_in_double_precision_compute_what_plain_code_does() {
    let n = NUMBERS.len();
    for i in 0..n * n {
        let a: [f64; 8] = std::array::from_fn(|lane| NUMBERS[(i + lane) % n]);
        let b: [f64; 8] = std::array::from_fn(|lane| NUMBERS[(i / n + 5 * lane) % n]);
        let each = a.iter().zip(&b).map(|(a, b)| all::<1, f64>([*a], [*b]));
        let plain: Vec<Vec<u64>> = each.flatten().collect();
        let (a4, b4) = (std::array::from_fn(|lane| a[lane]), std::array::from_fn(|lane| b[lane]));
        assert_eq!(all::<4, Plain>(a4, b4), plain[..4], "{a:?} {b:?}");
        if has(InstructionSet::Avx2) {
            // SAFETY: the processor was found to have AVX2.
            assert_eq!(unsafe { packed(a4, b4) }, plain[..4], "{a:?} {b:?}");
        }
        if has(InstructionSet::Avx512) {
            // SAFETY: the processor was found to have AVX-512.
            assert_eq!(unsafe { wide(a, b) }, plain, "{a:?} {b:?}");
        }
    }
}

/// Everything exact that two vectors yield, as bits; NaN counts as one number.
#[inline(always)]
fn exact<V: Eight>(a: [f32; 8], b: [f32; 8]) -> Vec<u32> {
    let (x, y) = (V::load(&a), V::load_bits(&b.map(f32::to_bits)));
    let numbers =
        [x.minus(y), x.times(y), x.plus(y), x.over(y), x.abs(), x.smaller(y), x.larger(y), V::splat(a[3])]
            .into_iter()
            .chain([x.if_below(y, y, x), x.or(y)])
            .chain(V::transposed([x, y, x, y, y, x, x, x]))
            .flat_map(|v| {
                let mut to = [0.0; 8];
                v.store(&mut to);
                to
            })
            .collect::<Vec<f32>>();
    let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
    let mut all: Vec<u32> = numbers.into_iter().map(bits).collect();
    all.extend([
        x.not_above(y),
        x.below(y),
        x.around_zero_or(y, V::splat(1.0)),
        x.around_zero_or(y, x),
        x.beside_zero(y),
    ]);
    all.extend((0..8).map(|lane| bits(x.lane(lane))));
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
    exact::<PackedEight>(a, b)
}

#[target_feature(enable = "avx2,fma")]
fn about(a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
    store(PackedEight::load(&a).about_mul_sub(PackedEight::load(&b), PackedEight::load(&c)))
}

#[test]
fn eight_lanes_compute_what_plain_code_does() {
    if !has(InstructionSet::Avx2) {
        eprintln!("NOT RUN: this processor has no AVX2");
        return;
    }
    let n = NUMBERS.len();
    for i in 0..n * n {
        let a = std::array::from_fn(|lane| NUMBERS[(i + lane) % n] as f32);
        let b = std::array::from_fn(|lane| NUMBERS[(i / n + 5 * lane) % n] as f32);
        // SAFETY: the processor was found to have AVX2.
        let found = unsafe { packed_eight(a, b) };
        assert_eq!(found, exact::<PlainEight>(a, b), "{a:?} {b:?}");
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
    let (mut to, mut numbers_to, mut packed) =
        ([MaybeUninit::new(0); 8], [MaybeUninit::new(0.0); 8], [MaybeUninit::new(0); 8]);
    // Lanes are in the mask whose number is not above its limit.
    let limits = M::Eight::load(&std::array::from_fn(|i| if mask >> i & 1 == 1 { f32::NAN } else { -1.0 }));
    let written_count = M::arrange(order, &words, numbers, limits, &mut to, &mut numbers_to);
    assert_eq!(written_count, mask.count_ones() as usize);
    M::compress(mask, &words, &mut packed);
    let count = mask.count_ones() as usize;
    let numbers = (0..count).map(|i| written(&numbers_to, i)).collect();
    (
        (0..count).map(|i| written(&to, i)).collect(),
        numbers,
        (0..count).map(|i| written(&packed, i)).collect(),
    )
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
            if has(InstructionSet::Avx2) {
                // SAFETY: the processor was found to have AVX2.
                assert_eq!(unsafe { arranged_avx2(mask, word) }, expected, "{mask:08b}");
            }
            if has(InstructionSet::Avx512) {
                // SAFETY: the processor was found to have AVX-512VL.
                assert_eq!(unsafe { arranged_avx512(mask, word) }, expected, "{mask:08b}");
            }
        }
    }
}
