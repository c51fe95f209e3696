//! Light from infinity.

use penombre_image::Image;
use penombre_math::color::luminance;
use penombre_math::distribution::Distribution2D;
use penombre_math::{Spectrum, Vec2, Vec3, float, quick};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Which directions of an [`Environment`] are sampled how often.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EnvironmentSampling {
    /// In proportion to luminance: fit for use alone.
    Complete,
    /// In proportion to the luminance above the mean, 0 below it \[Karlik2019\]: less noise together with samples
    /// of the BSDF under multiple importance sampling, wrong alone. Falls back to `Complete` where nothing is
    /// above the mean.
    #[default]
    Compensated,
}

/// A direction drawn from an [`Environment`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    /// Towards the environment, unit.
    pub wi: Vec3,
    /// What comes from there, W/(sr·m²).
    pub radiance: Spectrum,
    /// Density of `wi` per solid angle, 1/sr; above 0.
    pub pdf: f32,
}

/// Radiance from all directions by an equirectangular image, or the same from everywhere.
///
/// +y is up. The top row is straight up, the middle of the image lies towards −z, where a camera without a turn
/// looks; right of it comes +x, left of it −x, and the left and right edges meet at +z:
/// φ = atan2(x, −z) = 2π·(u − ½), θ = acos(y) = π·v, v downwards. Directions are in the environment's own space:
/// turn them before and after.
///
/// Between the centres of pixels the radiance is bilinear, around the seam and up to the poles. Each pixel's cell
/// is sampled with the mean of the bilinear function over it, so nothing that shines is left out, and evenly in
/// solid angle within: a constant image has exactly the density 1/4π.
#[derive(Clone, Debug)]
pub struct Environment {
    size: [u32; 2],
    /// Sound colours, row by row.
    pixels: Arc<[Spectrum]>,
    cells: Distribution2D,
    rows: Vec<Row>,
    mean: Spectrum,
}

/// One row of cells.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// cos θ at its upper border.
    cos_top: f64,
    /// How much that is above the lower one.
    height: f64,
    /// Solid angle of the unit square over that of a cell of this row times the number of cells: what turns a
    /// density on the square into one per steradian.
    per_steradian: f32,
}

/// If less than this share of the light is above the mean, the image is even but for rounding.
const EVEN: f64 = 1e-4;

impl Environment {
    /// From an image in linear light; negative and NaN samples count as 0, infinite ones as 10³⁷. `None` if it has
    /// no pixels.
    pub fn new(image: Arc<Image>, sampling: EnvironmentSampling) -> Option<Self> {
        let (width, height) = (image.width() as usize, image.height() as usize);
        if width == 0 || height == 0 {
            return None;
        }
        let rows = rows(height);
        let light = smoothed(&image);
        let mean_light = mean(&light, width, &rows);
        let weigh = |floor: f64| -> Vec<f32> {
            let weight = |(i, l): (usize, &f32)| ((f64::from(*l) - floor) * rows[i / width].height) as f32;
            light.iter().enumerate().map(weight).collect()
        };
        let complete = || Distribution2D::new(&weigh(0.0), width, height);
        let cells = match sampling {
            EnvironmentSampling::Complete => complete(),
            EnvironmentSampling::Compensated => {
                let above = weigh(mean_light);
                let total: f64 = above.iter().map(|w| f64::from(w.max(0.0))).sum();
                // The heights of all rows add up to 2.
                let all = 2.0 * width as f64 * mean_light;
                if total > EVEN * all { Distribution2D::new(&above, width, height) } else { complete() }
            }
        }?;
        let mean = Spectrum::from_rgb([0, 1, 2].map(|channel| {
            let lane: Vec<f32> = sound_pixels(&image).map(|rgb| rgb[channel]).collect();
            mean(&lane, width, &rows) as f32
        }));
        let pixels = sound_pixels(&image).map(Spectrum::from_rgb).collect();
        Some(Self { size: [image.width(), image.height()], pixels, cells, rows, mean })
    }

    /// The same radiance from everywhere, which is an image of one pixel.
    pub fn constant(radiance: Spectrum) -> Self {
        let mut image = Image::new(1, 1, 3);
        image.data_mut().copy_from_slice(&radiance.to_rgb());
        Self::new(Arc::new(image), EnvironmentSampling::Complete).expect("the image has a pixel")
    }

    /// Mean radiance over all directions, W/(sr·m²), for the [power](super::power::of_environment).
    pub fn mean_radiance(&self) -> Spectrum {
        self.mean
    }

    /// What comes from the unit direction `wi`, W/(sr·m²); black if it is NaN.
    pub fn radiance(&self, wi: Vec3) -> Spectrum {
        self.lookup(place(wi))
    }

    /// The direction of the uniform point `u` ∈ [0, 1)².
    pub fn sample(&self, u: Vec2) -> EnvironmentSample {
        let s = self.cells.sample(u);
        let row = &self.rows[s.row];
        let inside = (f64::from(s.point.y) * self.rows.len() as f64 - s.row as f64).clamp(0.0, 1.0);
        let cos = row.cos_top - inside * row.height;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (s_phi, c_phi) = quick::sin_cos((TAU * (f64::from(s.point.x) - 0.5)) as f32);
        let wi = Vec3::new((sin * f64::from(s_phi)) as f32, cos as f32, (-sin * f64::from(c_phi)) as f32);
        let v = quick::atan2(sin as f32, cos as f32) * (1.0 / PI) as f32;
        let radiance = self.lookup(Vec2::new(s.point.x, v));
        EnvironmentSample { wi, radiance, pdf: s.pdf * row.per_steradian }
    }

    /// Density with which [`sample`](Self::sample) gives the unit direction `wi`, 1/sr; 0 if it is NaN.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let point = place(wi);
        let row = (f64::from(point.y) * self.rows.len() as f64) as usize;
        self.cells.pdf(point) * self.rows[row.min(self.rows.len() - 1)].per_steradian
    }

    /// The bilinear function at (u, v).
    fn lookup(&self, place: Vec2) -> Spectrum {
        let [width, height] = self.size;
        // From the centre of the pixel before the first one; the whole numbers are the pixels on either side.
        let x = f64::from(place.x) * f64::from(width) + 0.5;
        let y = f64::from(place.y) * f64::from(height) + 0.5;
        if x.is_nan() || y.is_nan() {
            return Spectrum::BLACK;
        }
        let (column, row) = (x as u32, y as u32);
        let (fx, fy) = ((x - f64::from(column)) as f32, (y - f64::from(row)) as f32);
        // `column` runs from 0 to `width`.
        let columns =
            [if column == 0 { width - 1 } else { column - 1 }, if column < width { column } else { 0 }];
        let pixel = |x: u32, y: u32| self.pixels[y as usize * width as usize + x as usize];
        let across = |y: u32| pixel(columns[0], y) * (1.0 - fx) + pixel(columns[1], y) * fx;
        across(row.saturating_sub(1).min(height - 1)) * (1.0 - fy) + across(row.min(height - 1)) * fy
    }
}

/// (u, v) of a direction, both in [0, 1). The angles come from arc tangents, which are accurate at the poles, too.
fn place(wi: Vec3) -> Vec2 {
    let across = (wi.x * wi.x + wi.z * wi.z).sqrt();
    let u = quick::atan2(wi.x, -wi.z) * (1.0 / TAU) as f32 + 0.5;
    let v = quick::atan2(across, wi.y) * (1.0 / PI) as f32;
    let below_one = |x: f32| if x >= 1.0 { 1.0f32.next_down() } else { x.max(0.0) };
    if wi.is_nan() { Vec2::NAN } else { Vec2::new(below_one(u), below_one(v)) }
}

fn rows(height: usize) -> Vec<Row> {
    let cosine = |border: usize| float::sin_cos_degrees(180.0 * border as f64 / height as f64).1;
    let row = |i: usize| {
        let (cos_top, cos_bottom) = (cosine(i), cosine(i + 1));
        let tall = cos_top - cos_bottom;
        // A cell has the share 1/(width·height) of the square and 2π/width·tall of the sphere.
        let per_steradian = (1.0 / (height as f64 * TAU * tall)) as f32;
        Row { cos_top, height: tall, per_steradian }
    };
    (0..height).map(row).collect()
}

/// A pixel as used.
fn sound(rgb: [f32; 3]) -> [f32; 3] {
    rgb.map(|v| if v > 0.0 { v.min(1e37) } else { 0.0 })
}

fn sound_pixels(image: &Image) -> impl Iterator<Item = [f32; 3]> {
    image.rgb_pixels().map(sound)
}

/// Luminance, averaged over each cell as its bilinear function: the pixel counts ¾, its neighbours ⅛ each way.
fn smoothed(image: &Image) -> Vec<f32> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let light: Vec<f32> = sound_pixels(image).map(luminance).collect();
    let mix = |before: f32, here: f32, after: f32| 0.125 * before + 0.75 * here + 0.125 * after;
    let mut across = Vec::with_capacity(light.len());
    for row in light.chunks_exact(width) {
        across.extend((0..width).map(|x| mix(row[(x + width - 1) % width], row[x], row[(x + 1) % width])));
    }
    let at = |x: usize, y: usize| across[y * width + x];
    let cell = |i: usize| {
        let (x, y) = (i % width, i / width);
        mix(at(x, y.saturating_sub(1)), at(x, y), at(x, (y + 1).min(height - 1)))
    };
    (0..light.len()).map(cell).collect()
}

/// Mean over the sphere of values of the cells.
fn mean(values: &[f32], width: usize, rows: &[Row]) -> f64 {
    let sum = |row: &[f32]| row.iter().map(|v| f64::from(*v)).sum::<f64>();
    let total: f64 = values.chunks_exact(width).zip(rows).map(|(v, r)| sum(v) * r.height).sum();
    total / (2.0 * width as f64)
}
