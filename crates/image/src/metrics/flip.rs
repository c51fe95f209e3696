//! LDR-FLIP \[Andersson2020\], written from the paper: the difference a viewer notices when flipping between two images
//! on a screen. Colours are filtered with the eye's contrast sensitivity and compared in a perceptual space; edges and points,
//! found by derivatives of Gaussians, raise the error where they differ.

use super::filter::{Plane, gaussian, normalised};
use crate::image::Image;
use crate::tone::unit;
use penombre_math::{DMat3, DVec3, float};

/// Contrast sensitivity (table 1 of the paper): amplitude and width of Gaussians for the achromatic, the red–green and the
/// blue–yellow channel.
const ACHROMATIC: [(f32, f32); 1] = [(1.0, 0.0047)];
const RED_GREEN: [(f32, f32); 1] = [(1.0, 0.0053)];
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The largest of the widths above; it sets the radius of all three filters.
const WIDEST: f32 = 0.04;

/// Exponent that compresses large colour differences, q_c.
const COLOR_EXPONENT: f32 = 0.7;
/// Colour differences up to this part of the largest one (p_c) …
const COLOR_KNEE: f32 = 0.4;
/// … take up this part of the range (p_t).
const RANGE_KNEE: f32 = 0.95;
/// Width of the feature detectors in degrees, w.
const FEATURE_WIDTH: f32 = 0.082;
/// Exponent of the feature difference, q_f.
const FEATURE_EXPONENT: f32 = 0.5;

const PI: f32 = std::f32::consts::PI;

/// FLIP error of each pixel, 0 to 1, of `test` against `reference`, both cut to 0…1.
pub fn flip(test: &Image, reference: &Image, pixels_per_degree: f32) -> Vec<f32> {
    let colors = Colors::new();
    let opponents = [test, reference].map(|image| opponent_planes(image, &colors));
    let [test_colors, reference_colors] =
        [&opponents[0], &opponents[1]].map(|planes| perceived(planes, pixels_per_degree, &colors));
    let largest = colors.largest_difference();
    let [test_features, reference_features] =
        [&opponents[0], &opponents[1]].map(|planes| features(&planes[0], pixels_per_degree));
    let color_errors = test_colors.iter().zip(&reference_colors).map(|(a, b)| color_error(*a, *b, largest));
    let feature_errors = test_features.iter().zip(&reference_features).map(|(a, b)| feature_error(*a, *b));
    color_errors.zip(feature_errors).map(|(color, feature)| float::pow(color, 1.0 - feature)).collect()
}

/// The matrices between linear Rec. 709 and CIE XYZ, relative to the white point.
struct Colors {
    /// XYZ / white of linear RGB.
    from_rgb: DMat3,
    to_rgb: DMat3,
}

impl Colors {
    /// From the chromaticities of the primaries and D65 (ITU-R BT.709).
    fn new() -> Self {
        let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
        let white = xyz(0.3127, 0.3290);
        let amounts = primaries.inverse() * white;
        let from_rgb = DMat3::from_diagonal(white.recip()) * primaries * DMat3::from_diagonal(amounts);
        Self { from_rgb, to_rgb: from_rgb.inverse() }
    }

    /// Linearised CIELAB (YCxCz) of linear RGB.
    fn opponent(&self, rgb: [f32; 3]) -> [f32; 3] {
        let xyz = self.from_rgb * DVec3::from_array(rgb.map(f64::from));
        let ycc = [116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z)];
        ycc.map(|v| v as f32)
    }

    /// CIELAB, with colourfulness scaled by lightness (Hunt effect), of YCxCz, cut to what the screen can show.
    fn perceived(&self, opponent: [f32; 3]) -> [f32; 3] {
        let [y, cx, cz] = opponent.map(f64::from);
        let y = (y + 16.0) / 116.0;
        let rgb = self.to_rgb * DVec3::new(y + cx / 500.0, y, y - cz / 200.0);
        self.hunt_lab(rgb.clamp(DVec3::ZERO, DVec3::ONE))
    }

    fn hunt_lab(&self, rgb: DVec3) -> [f32; 3] {
        let [x, y, z] = (self.from_rgb * rgb).to_array().map(|t| lab_curve(t as f32));
        let lightness = 116.0 * y - 16.0;
        let scale = 0.01 * lightness;
        [lightness, 500.0 * (x - y) * scale, 200.0 * (y - z) * scale]
    }

    /// The difference between green and blue, the largest on a screen.
    fn largest_difference(&self) -> f32 {
        let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| self.hunt_lab(rgb));
        float::pow(distance(green, blue), COLOR_EXPONENT)
    }
}

/// The cube root of CIELAB with its linear part near black.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { float::pow(t, 1.0 / 3.0) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// HyAB: city-block distance between lightness and chroma.
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let (da, db) = (a[1] - b[1], a[2] - b[2]);
    (a[0] - b[0]).abs() + (da * da + db * db).sqrt()
}

fn opponent_planes(image: &Image, colors: &Colors) -> [Plane<f32>; 3] {
    let pixels: Vec<[f32; 3]> = image.rgb_pixels().map(|rgb| colors.opponent(rgb.map(unit))).collect();
    std::array::from_fn(|c| Plane {
        width: image.width() as usize,
        height: image.height() as usize,
        data: pixels.iter().map(|p| p[c]).collect(),
    })
}

/// What the eye resolves: the planes filtered by contrast sensitivity, in the perceptual space.
fn perceived(planes: &[Plane<f32>; 3], pixels_per_degree: f32, colors: &Colors) -> Vec<[f32; 3]> {
    let y = sensitivity(&planes[0], &ACHROMATIC, pixels_per_degree);
    let cx = sensitivity(&planes[1], &RED_GREEN, pixels_per_degree);
    let cz = sensitivity(&planes[2], &BLUE_YELLOW, pixels_per_degree);
    y.iter().zip(&cx).zip(&cz).map(|((y, cx), cz)| colors.perceived([*y, *cx, *cz])).collect()
}

/// The plane filtered with Σ a √(π/b) exp(−π² d²/b), d in degrees, normalised to sum 1.
fn sensitivity(plane: &Plane<f32>, gaussians: &[(f32, f32)], pixels_per_degree: f32) -> Vec<f32> {
    // exp(−π² d²/b) is a Gaussian with σ = √(b/2)/π.
    let sigma = |b: f32| (b / 2.0).sqrt() / PI * pixels_per_degree;
    let radius = (3.0 * sigma(WIDEST)).ceil() as usize;
    let mut result = vec![0.0; plane.data.len()];
    let mut total = 0.0;
    for (a, b) in gaussians {
        let weights = gaussian(sigma(*b), radius);
        let sum: f32 = weights.iter().sum();
        let volume = a * (PI / b).sqrt() * sum * sum;
        let weights = normalised(&weights);
        for (r, v) in result.iter_mut().zip(&plane.filtered(&weights, &weights).data) {
            *r += volume * v;
        }
        total += volume;
    }
    result.iter_mut().for_each(|r| *r /= total);
    result
}

/// Strength of edges and of points at one pixel.
#[derive(Clone, Copy)]
struct Feature {
    edge: f32,
    point: f32,
}

fn features(achromatic: &Plane<f32>, pixels_per_degree: f32) -> Vec<Feature> {
    let data = achromatic.data.iter().map(|y| (y + 16.0) / 116.0).collect();
    let plane = Plane { data, ..*achromatic };
    let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as usize;
    let flat = gaussian(sigma, radius);
    let x = |i: usize| i as f32 - radius as f32;
    let slope: Vec<f32> = flat.iter().enumerate().map(|(i, g)| -x(i) * g).collect();
    let bend = flat.iter().enumerate().map(|(i, g)| (x(i) * x(i) / (sigma * sigma) - 1.0) * g).collect();
    let (flat, slope, bend) = (normalised(&flat), balanced(slope), balanced(bend));
    let magnitude = |weights: &[f32]| {
        let across = plane.filtered(weights, &flat).data;
        let down = plane.filtered(&flat, weights).data;
        across.into_iter().zip(down).map(|(x, y)| (x * x + y * y).sqrt()).collect::<Vec<_>>()
    };
    let (edges, points) = (magnitude(&slope), magnitude(&bend));
    edges.into_iter().zip(points).map(|(edge, point)| Feature { edge, point }).collect()
}

/// Positive weights scaled to sum 1, negative ones to sum −1.
fn balanced(weights: Vec<f32>) -> Vec<f32> {
    let positive: f32 = weights.iter().filter(|g| **g > 0.0).sum();
    let negative: f32 = -weights.iter().filter(|g| **g < 0.0).sum::<f32>();
    weights.into_iter().map(|g| if g > 0.0 { g / positive } else { g / negative }).collect()
}

/// Colour difference, 0 to 1.
fn color_error(a: [f32; 3], b: [f32; 3], largest: f32) -> f32 {
    let difference = float::pow(distance(a, b), COLOR_EXPONENT);
    let knee = COLOR_KNEE * largest;
    if difference < knee {
        RANGE_KNEE / knee * difference
    } else {
        (RANGE_KNEE + (difference - knee) / (largest - knee) * (1.0 - RANGE_KNEE)).min(1.0)
    }
}

/// Feature difference, 0 to 1.
fn feature_error(a: Feature, b: Feature) -> f32 {
    let difference = (a.edge - b.edge).abs().max((a.point - b.point).abs());
    float::pow(difference * std::f32::consts::FRAC_1_SQRT_2, FEATURE_EXPONENT).min(1.0)
}
