use super::*;
use penombre_lab::{Pcg32, chi_square};
use proptest::{prelude::*, test_runner::RngSeed};

fn one(weights: &[f32]) -> Distribution1D {
    Distribution1D::new(weights).expect("there are weights")
}

#[test]
fn a_ramp_in_closed_form() {
    let d = one(&[1.0, 2.0, 3.0, 2.0]);
    assert_eq!((d.bins(), d.integral()), (4, 2.0));
    for (i, expected) in [0.125, 0.25, 0.375, 0.25].into_iter().enumerate() {
        assert!((d.probability(i) - expected).abs() < 1e-6);
        assert!((d.pdf((i as f32 + 0.5) / 4.0) - 4.0 * expected).abs() < 4e-6);
    }
    // u = ¼ is half of the way through the second bin: ⅛ + ½·¼.
    let s = d.sample(0.25);
    assert!((s.x - 0.375).abs() < 1e-6 && s.index == 1 && (s.pdf - 1.0).abs() < 1e-6, "{s:?}");
    assert_eq!(d.sample(0.0).x, 0.0);
    let s = d.sample_discrete(0.75);
    assert!(s.index == 3 && s.remapped < 1e-6 || s.index == 2 && s.remapped > 1.0 - 1e-6, "{s:?}");
    assert_eq!((d.probability(4), d.pdf(1.0), d.pdf(-0.1), d.pdf(f32::NAN)), (0.0, 0.0, 0.0, 0.0));
}

#[test]
fn probabilities_are_exactly_the_share_of_the_uniform_numbers() {
    // Every 24-bit number once.
    let weights = [0.0, 1e-30, 5.0, 0.0, 0.3, 1e6, 1e-12, 2.0, 0.0];
    let d = one(&weights);
    let mut counts = [0u32; 9];
    for i in 0..1 << 24 {
        counts[d.sample_discrete(i as f32 / 16_777_216.0).index] += 1;
    }
    for (i, &count) in counts.iter().enumerate() {
        assert_eq!(count as f32 / 16_777_216.0, d.probability(i), "bin {i}");
        assert_eq!(count > 0, weights[i] > 0.0, "bin {i}");
    }
}

#[test]
fn odd_weights_count_as_nothing() {
    assert_eq!(one(&[f32::NAN, 1.0, -5.0, 3.0]), one(&[0.0, 1.0, 0.0, 3.0]));
    assert_eq!(one(&[f32::INFINITY, 0.0]), one(&[f32::MAX, 0.0]));
    assert!(one(&[f32::MAX; 100]).integral().is_finite());
    assert_eq!(Distribution1D::new(&[]), None);
}

#[test]
fn no_weight_at_all_is_uniform() {
    for d in [one(&[0.0; 5]), one(&[f32::NAN, -1.0, 0.0, -0.0, f32::NEG_INFINITY])] {
        assert_eq!(d.integral(), 0.0);
        for i in 0..5 {
            assert!((d.probability(i) - 0.2).abs() < 1e-7);
            let s = d.sample((i as f32 + 0.5) / 5.0);
            assert!(
                s.index == i && (s.pdf - 1.0).abs() < 1e-6 && (s.x - (i as f32 + 0.5) / 5.0).abs() < 1e-6
            );
        }
    }
    let flat = Distribution2D::new(&[0.0; 6], 3, 2).expect("there are weights");
    assert_eq!(flat.integral(), 0.0);
    assert!((flat.pdf(Vec2::splat(0.4)) - 1.0).abs() < 1e-6);
}

#[test]
fn uniform_numbers_out_of_range_stay_inside() {
    let d = one(&[0.0, 1.0, 2.0, 0.0]);
    for u in [-1.0, 1.0, 2.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0f32.next_down()] {
        let s = d.sample(u);
        assert!((0.25..0.75).contains(&s.x) && s.pdf > 0.0, "{u}: {s:?}");
        assert!((0.0..1.0).contains(&d.sample_discrete(u).remapped));
    }
}

#[test]
fn a_million_bins_keep_their_order_of_size() {
    // Rows of large maps: probabilities stay within a grain or two of the weight's share.
    let weights: Vec<f32> = (0..1_000_000).map(|i| 1.0 + (i % 7) as f32).collect();
    let d = one(&weights);
    let total: f64 = weights.iter().map(|w| f64::from(*w)).sum();
    for (i, w) in weights.iter().enumerate() {
        let share = f64::from(*w) / total;
        let defensive = share * (1.0 - 1e6 / 16_777_216.0) + 1.0 / 16_777_216.0;
        assert!((f64::from(d.probability(i)) - defensive).abs() < 1.01 / 16_777_216.0, "bin {i}");
    }
}

#[test]
fn samples_of_two_dimensions_follow_the_weights() {
    // χ² of 500 000 points in the cells, α = 0.001.
    let (width, height) = (13, 7);
    let weights: Vec<f32> =
        (0..width * height).map(|i| if i / width == 3 { 0.0 } else { (i * i % 17) as f32 }).collect();
    let d = Distribution2D::new(&weights, width, height).expect("matching size");
    let total: f32 = weights.iter().sum();
    assert!((d.integral() - total / 91.0).abs() < 1e-5);
    let mut rng = Pcg32::new(5);
    let n = 500_000;
    let mut counts = vec![0.0; width * height];
    for _ in 0..n {
        let s = d.sample(Vec2::new(rng.next_f32(), rng.next_f32()));
        assert_eq!(s.pdf, d.pdf(s.point));
        assert_eq!(((s.point.x * 13.0) as usize, (s.point.y * 7.0) as usize), (s.column, s.row));
        counts[s.row * width + s.column] += 1.0;
    }
    let expected: Vec<f64> = weights.iter().map(|w| f64::from(n) * f64::from(w / total)).collect();
    let test = chi_square(&counts, &expected);
    assert!(test.p_value > 0.001, "{test:?}");
    let shuffled: Vec<f64> = expected.iter().rev().copied().collect();
    assert!(chi_square(&counts, &shuffled).p_value < 1e-9, "the test can fail");
}

#[test]
fn sizes_must_match() {
    assert_eq!(Distribution2D::new(&[1.0; 6], 4, 2), None);
    assert_eq!(Distribution2D::new(&[], 0, 0), None);
    assert_eq!(Distribution2D::new(&[1.0; 6], usize::MAX, 6), None);
    let d = Distribution2D::new(&[1.0; 6], 3, 2).expect("matching size");
    assert_eq!((d.width(), d.height()), (3, 2));
    assert_eq!((d.pdf(Vec2::new(1.0, 0.5)), d.pdf(Vec2::new(0.5, f32::NAN))), (0.0, 0.0));
}

/// Weights with zeros, tiny and huge numbers among them.
fn any_weights() -> impl Strategy<Value = Vec<f32>> {
    let weight = prop_oneof![
        Just(0.0f32),
        0.0f32..1.0,
        (-100f32..100.0).prop_map(f32::exp2),
        Just(-1.0),
        Just(f32::NAN)
    ];
    proptest::collection::vec(weight, 1..300)
}

/// The same cases in every run.
fn fixed() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(fixed())]

    #[test]
    fn samples_agree_with_the_density(
        weights in any_weights(),
        numbers in proptest::collection::vec(0.0f32..1.0, 20),
    ) {
        let d = one(&weights);
        let sum: f64 = (0..d.bins()).map(|i| f64::from(d.probability(i))).sum();
        prop_assert!((sum - 1.0).abs() < 1e-6);
        let mut numbers = numbers;
        numbers.sort_by(f32::total_cmp);
        let mut last = 0.0;
        for u in numbers {
            let s = d.sample(u);
            prop_assert!(s.x >= last && s.x < 1.0, "inversion is monotonic");
            last = s.x;
            prop_assert!(s.pdf > 0.0 && s.pdf == d.pdf(s.x), "{:?}", s);
            prop_assert!(weights[s.index] > 0.0 || d.integral() == 0.0);
            let c = d.sample_discrete(u);
            prop_assert!(c.index == s.index && c.probability == d.probability(c.index));
            prop_assert!((0.0..1.0).contains(&c.remapped));
        }
    }
}
