use super::*;
use crate::hash::mix32;
use penombre_lab::{Moments, chi_square_uniform, sidak, z_test};

/// The second Sobol dimension by its direction numbers, bit by bit.
fn second_dimension(index: u32) -> u32 {
    let (mut direction, mut result) = (1u32 << 31, 0);
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            result ^= direction;
        }
        direction ^= direction >> 1;
    }
    result
}

#[test]
fn second_dimension_follows_the_direction_numbers() {
    for i in (0..1000).chain((0..10_000).map(mix32)).chain([u32::MAX]) {
        assert_eq!(second_dimension_reversed(i).reverse_bits(), second_dimension(i), "index {i}");
    }
}

#[test]
fn scrambling_keeps_common_leading_bits() {
    for i in 0..10_000u32 {
        let (x, seed) = (mix32(2 * i), mix32(2 * i + 1));
        let common = i % 32;
        let y = x ^ (1 << (31 - common)) ^ (mix32(!i).checked_shr(common + 1).unwrap_or(0));
        let difference = owen_scramble(x, seed) ^ owen_scramble(y, seed);
        assert_eq!(difference.leading_zeros(), common, "x {x:#x}, y {y:#x}, seed {seed:#x}");
    }
}

#[test]
fn scrambling_flips_the_branches_of_a_tree_independently() {
    // Each of the first 31 branches is turned for half of the seeds, each pair alike for half. α = 0.001
    // together.
    const SEEDS: u32 = 20_000;
    let nodes: Vec<(u32, u32)> =
        (0..5).flat_map(|depth| (0..1u32 << depth).map(move |path| (depth, path))).collect();
    let mut counts = vec![0u32; nodes.len() * nodes.len()];
    for seed in 0..SEEDS {
        let key = mix32(seed + 1);
        let turned: Vec<u32> = nodes
            .iter()
            .map(|&(depth, path)| {
                owen_scramble((u64::from(path) << (32 - depth)) as u32, key) >> (31 - depth) & 1
            })
            .collect();
        for (i, a) in turned.iter().enumerate() {
            for (j, b) in turned.iter().enumerate() {
                counts[i * nodes.len() + j] += if i == j { *a } else { a ^ b };
            }
        }
    }
    let each = sidak(0.001, nodes.len() * (nodes.len() + 1) / 2);
    let n = f64::from(SEEDS);
    for (pair, &count) in counts.iter().enumerate() {
        let p = z_test(f64::from(count), n / 4.0, n / 2.0).p_value;
        assert!(p > each, "nodes {:?} {:?}: {count}", nodes[pair / nodes.len()], nodes[pair % nodes.len()]);
    }
}

#[test]
fn aligned_blocks_are_nets() {
    for (trial, seed) in [0, 1, 2, 77, 0xffff_ffff].into_iter().enumerate() {
        for k in 0..=10u32 {
            for block in [0, 1, 5 + trial as u32, 1 << 20] {
                let points: Vec<[f32; 2]> = (0..1 << k).map(|i| sobol_2d((block << k) + i, seed)).collect();
                for wide in 0..=k {
                    let (columns, rows) = (1u32 << wide, 1u32 << (k - wide));
                    let mut hit = vec![false; 1 << k];
                    for [x, y] in &points {
                        let cell = (y * rows as f32) as u32 * columns + (x * columns as f32) as u32;
                        assert!(
                            !hit[cell as usize],
                            "two points in a box: seed {seed}, 2^{k}, {columns} columns"
                        );
                        hit[cell as usize] = true;
                    }
                }
                let mut hit = vec![false; 1 << k];
                (0..1 << k).for_each(|i| {
                    hit[(sobol_1d((block << k) + i, seed) * (1u32 << k) as f32) as usize] = true;
                });
                assert!(hit.iter().all(|h| *h), "one dimension: seed {seed}, 2^{k}");
            }
        }
    }
}

/// χ² in 32 × 32 bins of points, α = 0.001 for `tests` tests.
fn assert_uniform(name: &str, tests: usize, points: impl Iterator<Item = [f32; 2]>) {
    let mut bins = [0.0; 1024];
    points.for_each(|[x, y]| bins[(y * 32.0) as usize * 32 + (x * 32.0) as usize] += 1.0);
    let test = chi_square_uniform(&bins);
    assert!(test.p_value > sidak(0.001, tests), "{name}: {test:?}");
}

#[test]
fn one_index_of_many_seeds_is_uniform() {
    // Seeds as a sampler makes them, and consecutive ones.
    let indices = [0u32, 1, 2, 3, 64, 1000, 1 << 16, u32::MAX];
    for index in indices {
        assert_uniform("plain seeds", 16, (0..100_000).map(|seed| sobol_2d(index, seed)));
        assert_uniform("hashed seeds", 16, (0..100_000).map(|seed| sobol_2d(index, mix32(seed))));
        assert_uniform("independent", 16, (0..100_000).map(|seed| independent_2d(index, seed)));
    }
}

#[test]
fn different_seeds_are_uncorrelated() {
    // The same index in two padded dimensions, and two indices of one seed in different blocks.
    for index in [0u32, 1, 7, 500] {
        let pair = |seed: u32| [sobol_1d(index, seed), sobol_1d(index, seed + 1)];
        assert_uniform("neighbouring seeds, 1D", 16, (0..100_000).map(pair));
        let pair = |seed: u32| [sobol_2d(index, seed)[0], sobol_2d(index, seed ^ 1 << 20)[1]];
        assert_uniform("seeds that differ in a bit", 16, (0..100_000).map(pair));
        let pair = |seed: u32| [sobol_1d(index, seed), sobol_2d(index, seed + 1)[1]];
        assert_uniform("1D and 2D", 16, (0..100_000).map(pair));
        let pair = |seed: u32| [independent_1d(index, seed), independent_1d(index + 1, seed)];
        assert_uniform("neighbouring indices, independent", 16, (0..100_000).map(pair));
    }
}

#[test]
fn padded_dimensions_integrate_products_without_bias() {
    // Over 4000 pairs of seeds the mean of (x − ½)(y − ½) over 16 points is 0; α = 0.001 each.
    let estimate = |trial: u32| {
        let term = |i| (sobol_1d(i, 2 * trial) - 0.5) * (sobol_1d(i, 2 * trial + 1) - 0.5);
        f64::from((0..16).map(term).sum::<f32>()) / 16.0
    };
    let moments: Moments = (0..4000).map(estimate).collect();
    assert!(z_test(moments.mean(), moments.variance_of_mean(), 0.0).p_value > 0.001, "{moments:?}");
    // Pure products of padded dimensions are where padding costs: both points of an aligned pair lie in
    // opposite halves in either dimension, so their products agree. At most twice the variance of independent
    // points.
    let squares: Moments = (0..4000).map(|t| estimate(t).powi(2)).collect();
    let independent = 1.0 / 144.0 / 16.0;
    assert!(squares.mean() + 3.3 * squares.variance_of_mean().sqrt() < 2.0 * independent, "{squares:?}");
}

/// Root mean square error over 64 seeds of the integral of a smooth function with `n` points.
fn error(n: u32, point: impl Fn(u32, u32) -> [f32; 2]) -> f64 {
    // ∫∫ exp(x) · cos(y) over the unit square
    let exact = (1f64.exp() - 1.0) * 1f64.sin();
    let one = |seed: u32| {
        let value = |[x, y]: [f32; 2]| f64::from(x).exp() * f64::from(y).cos();
        let mean = (0..n).map(|i| value(point(i, seed))).sum::<f64>() / f64::from(n);
        (mean - exact).powi(2)
    };
    ((0..64).map(one).sum::<f64>() / 64.0).sqrt()
}

#[test]
fn errors_fall_with_the_power_of_each_kind() {
    let slope = |point: fn(u32, u32) -> [f32; 2]| (error(4096, point) / error(64, point)).log2() / 6.0;
    let (sobol, independent) = (slope(sobol_2d), slope(independent_2d));
    assert!(sobol < -1.3, "scrambled nets converge with n^-1.5 on smooth functions: {sobol}");
    assert!((-0.65..-0.35).contains(&independent), "independent points with n^-0.5: {independent}");
    assert!(error(256, sobol_2d) < error(256, independent_2d) / 10.0);
}

#[test]
fn points_never_change() {
    // Stored pictures and checkpoints depend on these.
    assert_eq!(sobol_2d(0, 0).map(f32::to_bits), [1_053_028_774, 1_051_570_106]);
    assert_eq!(sobol_2d(12345, 678).map(f32::to_bits), [1_057_962_572, 1_059_196_262]);
    assert_eq!(sobol_1d(3, 9).to_bits(), 1_062_346_353);
    assert_eq!(independent_2d(3, 9).map(f32::to_bits), [1_046_925_284, 1_060_276_750]);
}
