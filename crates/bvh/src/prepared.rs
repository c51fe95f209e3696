//! A ray made ready for traversal.

use crate::Ray;
use crate::primitive::{abs_sum, wide};
use penombre_math::Vec3;

/// Direction components below this share of the largest count as zero: their products with coordinates could
/// underflow, which the error bounds of boxes would have to cover.
const NEGLIGIBLE: f64 = 1.0 / (1u64 << 40) as f64;

/// A checked ray in double precision: all that spheres, parallelograms and disks need.
pub(crate) struct Line {
    pub(crate) origin: [f64; 3],
    /// Without negligible components.
    pub(crate) dir: [f64; 3],
    pub(crate) t_min: f32,
    pub(crate) t_max: f32,
}

impl Line {
    /// `None` if the ray can hit nothing: no direction, an empty range, or something not finite.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let (origin, dir) = (wide(ray.origin), wide(ray.dir));
        // Sums of `f32` numbers are finite in `f64` exactly if the numbers are.
        let finite = abs_sum(origin) + abs_sum(dir) < f64::INFINITY;
        let longest = longest(dir);
        let least = longest * NEGLIGIBLE;
        let dir = dir.map(|d| if d.abs() < least { 0.0 } else { d });
        let sane = finite & (longest > 0.0) & (ray.t_min < ray.t_max);
        sane.then_some(Self { origin, dir, t_min: ray.t_min, t_max: ray.t_max })
    }
}

#[inline(always)]
fn longest(dir: [f64; 3]) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    larger(larger(dir[0].abs(), dir[1].abs()), dir[2].abs())
}

/// A checked ray with what triangles and boxes derive from it.
pub(crate) struct PreparedRay {
    pub(crate) line: Line,
    pub(crate) origin: Vec3,
    /// The two minor axes, then the main one (largest direction component).
    pub(crate) axes: [usize; 3],
    /// Minor components divided by the main one (\[Woop2013\]).
    pub(crate) shear: [f32; 2],
    /// The direction times a power of two, of moderate length.
    pub(crate) scaled_dir: [f32; 3],
    /// Distances times this are distances along `scaled_dir`. A power of two.
    pub(crate) box_scale: f32,
}

impl PreparedRay {
    /// `None` if the ray can hit nothing: no direction, an empty range, or something not finite.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let line = Line::new(ray)?;
        let size = ray.dir.abs();
        let axes = if size.x >= size.y && size.x >= size.z {
            [1, 2, 0]
        } else if size.y >= size.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let (up, down) = moderation(longest(line.dir) as f32);
        let scaled_dir = line.dir.map(|d| d as f32 * up);
        let main = scaled_dir[axes[2]];
        Some(Self {
            line,
            origin: ray.origin,
            axes,
            shear: [scaled_dir[axes[0]] / main, scaled_dir[axes[1]] / main],
            scaled_dir,
            box_scale: down,
        })
    }
}

/// A power of two that brings `longest` to about 1, and its reciprocal; both 1 for ordinary rays.
#[inline(always)]
fn moderation(longest: f32) -> (f32, f32) {
    const ORDINARY: f32 = (1u32 << 20) as f32;
    if (1.0 / ORDINARY..=ORDINARY).contains(&longest) {
        return (1.0, 1.0);
    }
    // The biased exponent e stands for 2^(e − 127); subnormal numbers have e = 0.
    let exponent = (longest.to_bits() >> 23) as i32 - 127;
    let power = |e: i32| f32::from_bits(((e.clamp(-126, 126) + 127) as u32) << 23);
    (power(-exponent), power(exponent))
}
