use super::*;

/// Pictures that the reference programs were given too (values from 0 to 1, linear light).
fn pattern(width: u32, height: u32, kind: u32) -> Image {
    let value = |x: i64, y: i64, c: i64| match kind {
        0 => (x * 5 + y * 3 + c * 40) % 256,
        1 => (x * 5 + y * 3 + c * 40 + (x / 8 + y / 8) % 2 * 24) % 256,
        2 => ((x * x + y * y * 3) / 16 + c * 85) % 256,
        3 => (x * 2 + y + c * 10) % 256,
        4 if (x - 30) * (x - 30) + (y - 20) * (y - 20) < 64 => 255 - (x * 2 + y + c * 10) % 256,
        4 => (x * 2 + y + c * 10) % 256,
        5 => 128,
        6 => (1 - x / 4 % 2) * 255,
        7 => i64::from(c == 1) * 255,
        _ => i64::from(c == 2) * 255,
    };
    let mut image = Image::new(width, height, 3);
    for y in 0..height {
        for x in 0..width {
            for c in 0..3 {
                image.pixel_mut(x, y)[c] = value(x.into(), y.into(), c as i64) as f32 / 255.0;
            }
        }
    }
    image
}

/// Numbers of other programs for a pair of patterns (second: the reference).
struct Expected {
    kinds: [u32; 2],
    size: [u32; 2],
    flip: f64,
    ssim: f64,
    mse: f64,
    rel_mse: f64,
    max_abs: f64,
    mean_ratio: f64,
    /// FLIP at the top left, in the middle, at the bottom right, and its largest value.
    map: [f32; 4],
}

/// FLIP from the authors' program (flip-evaluator 1.7, linear input, 67.0206 pixels per degree), SSIM from scikit-image
/// 0.26 (Gaussian weights, σ 1.5, population covariance) on the sRGB-encoded luminance, the rest from NumPy in f64.
const EXPECTED: [Expected; 7] = [
    Expected {
        kinds: [0, 1],
        size: [64, 48],
        flip: 0.338280,
        ssim: 0.60336223,
        mse: 0.0382827119,
        rel_mse: 2.84121882,
        max_abs: 0.9098039,
        mean_ratio: 0.989158164,
        map: [0.0, 0.713_961_5, 0.053_822_886, 0.977_979_8],
    },
    Expected {
        kinds: [0, 2],
        size: [64, 48],
        flip: 0.755097,
        ssim: 0.37713649,
        mse: 0.139564966,
        rel_mse: 2.6023803,
        max_abs: 0.9882353,
        mean_ratio: 1.02517213,
        map: [0.642_555_9, 0.897_401_2, 0.720_515_5, 0.985_791_6],
    },
    Expected {
        kinds: [3, 4],
        size: [80, 50],
        flip: 0.046853,
        ssim: 0.89958754,
        mse: 0.00459966069,
        rel_mse: 0.01001164,
        max_abs: 0.5058824,
        mean_ratio: 0.969101873,
        map: [0.0, 0.081_507_27, 0.0, 0.770_892_8],
    },
    Expected {
        kinds: [5, 6],
        size: [64, 32],
        flip: 0.725589,
        ssim: 0.00383908,
        mse: 0.250003845,
        rel_mse: 12.7210265,
        max_abs: 0.5019608,
        mean_ratio: 1.00392163,
        map: [0.750_174, 0.529_506_6, 0.981_044_3, 0.984_860_36],
    },
    Expected {
        kinds: [7, 8],
        size: [40, 40],
        flip: 1.0,
        ssim: 0.61720352,
        mse: 0.666666667,
        rel_mse: 33.6633663,
        max_abs: 1.0,
        mean_ratio: 1.0,
        map: [1.0; 4],
    },
    Expected {
        kinds: [0, 0],
        size: [40, 30],
        flip: 0.0,
        ssim: 1.0,
        mse: 0.0,
        rel_mse: 0.0,
        max_abs: 0.0,
        mean_ratio: 1.0,
        map: [0.0; 4],
    },
    Expected {
        kinds: [3, 5],
        size: [20, 15],
        flip: 0.770529,
        ssim: 0.60201380,
        mse: 0.133523023,
        rel_mse: 0.509698612,
        max_abs: 0.5019608,
        mean_ratio: 0.281249991,
        map: [0.958_104_8, 0.760_75, 0.591_578_25, 0.958_274_25],
    },
];

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let bound = relative * expected.abs().max(1e-3);
    assert!((found - expected).abs() <= bound, "{what}: {found}, expected {expected}");
}

#[test]
fn numbers_agree_with_other_programs() {
    for e in &EXPECTED {
        let [w, h] = e.size;
        let (a, b) = (pattern(w, h, e.kinds[0]), pattern(w, h, e.kinds[1]));
        let c = compare(&a, &b).unwrap();
        let pair = format!("{:?}", e.kinds);
        close(c.mse, e.mse, 1e-7, &pair);
        close(c.rmse, e.mse.sqrt(), 1e-7, &pair);
        close(c.rel_mse, e.rel_mse, 1e-6, &pair);
        close(c.max_abs, e.max_abs, 1e-6, &pair);
        close(c.mean_ratio, e.mean_ratio, 1e-6, &pair);
        close(c.ssim, e.ssim, 1e-5, &format!("ssim {pair}"));
        close(c.flip, e.flip, 1e-4, &format!("flip {pair}"));
        assert_eq!(c.non_finite, 0);
        let map = flip_map(&a, &b).unwrap();
        let places = [map.pixel(0, 0)[0], map.pixel(w / 2, h / 2)[0], map.pixel(w - 1, h - 1)[0]];
        let top = map.to_data().iter().copied().fold(0.0, f32::max);
        for (found, expected) in places.into_iter().chain([top]).zip(e.map) {
            assert!((found - expected).abs() < 2e-4, "{pair}: {found}, expected {expected}");
        }
    }
}

#[test]
fn signal_to_noise_is_in_decibels() {
    for (mse, decibels) in [(1.0, 0.0), (0.1, 10.0), (1e-6, 60.0), (100.0, -20.0), (1e-60, 600.0)] {
        close(psnr(mse), decibels, 1e-6, "psnr");
    }
    assert_eq!(psnr(0.0), f64::INFINITY);
    let a = Image::from_data(1, 1, 3, vec![0.5; 3]).unwrap();
    let b = Image::from_data(1, 1, 3, vec![0.25; 3]).unwrap();
    close(compare(&a, &b).unwrap().psnr, 12.041_199_8, 1e-6, "psnr of a difference of a quarter");
}

#[test]
fn sizes_that_differ_are_named() {
    let message = compare(&Image::new(4, 3, 3), &Image::new(3, 4, 3)).unwrap_err().to_string();
    assert!(message.contains("4×3") && message.contains("3×4"), "{message}");
    assert_eq!(compare(&Image::new(0, 0, 3), &Image::new(0, 0, 3)), Err(CompareError::Empty));
    assert!(flip_map(&Image::new(4, 3, 3), &Image::new(4, 4, 3)).is_err());
    assert!(error_map(&Image::new(4, 3, 3), &Image::new(5, 3, 3)).is_err());
}

#[test]
fn non_finite_pixels_are_counted_and_left_out() {
    let b = pattern(16, 16, 0);
    let mut a = pattern(16, 16, 0);
    a.pixel_mut(3, 4)[1] = f32::NAN;
    a.pixel_mut(5, 5)[0] = f32::INFINITY;
    a.pixel_mut(6, 6)[2] += 0.25;
    let c = compare(&a, &b).unwrap();
    assert_eq!(c.non_finite, 2);
    close(c.mse, 0.0625 / (254.0 * 3.0), 1e-6, "mse");
    assert!(c.flip > 0.0 && c.ssim < 1.0 && c.ssim.is_finite());
    let map = error_map(&a, &b).unwrap();
    assert!(map.pixel(3, 4)[0].is_nan() && map.pixel(5, 5)[0].is_nan());
    assert_eq!(*map.pixel(6, 6), [0.25]);
    assert_eq!(map.to_data().iter().filter(|v| **v == 0.0).count(), 253);
}

#[test]
fn every_metric_grows_with_the_difference() {
    let b = pattern(32, 32, 3);
    let shifted = |d: f32| {
        let data = b.to_data().iter().map(|v| v + d).collect();
        compare(&Image::from_data(32, 32, 3, data).unwrap(), &b).unwrap()
    };
    let steps = [0.0, 0.01, 0.05, 0.2].map(shifted);
    for pair in steps.windows(2) {
        assert!(pair[0].mse < pair[1].mse && pair[0].rel_mse < pair[1].rel_mse);
        assert!(pair[0].flip < pair[1].flip && pair[0].ssim > pair[1].ssim && pair[0].psnr > pair[1].psnr);
        assert!(pair[0].max_abs < pair[1].max_abs && pair[0].mean_ratio < pair[1].mean_ratio);
    }
}

#[test]
fn grey_and_alpha_compare_as_colour() {
    let grey = Image::from_data(2, 1, 2, vec![0.25, 0.0, 0.5, 1.0]).unwrap();
    let color = grey.to_rgb();
    let c = compare(&grey, &color).unwrap();
    assert_eq!((c.mse, c.flip, c.ssim, c.mean_ratio), (0.0, 0.0, 1.0, 1.0));
    let black = compare(&Image::new(3, 3, 1), &Image::new(3, 3, 4)).unwrap();
    assert_eq!((black.mean_ratio, black.psnr), (1.0, f64::INFINITY));
}
