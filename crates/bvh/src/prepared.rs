//! A ray made ready for traversal.

use crate::Ray;
use crate::lanes::Lanes;
use crate::primitive::abs_sum;
use penombre_math::Vec3;

/// Direction components below this share of the largest count as zero: their products with coordinates could
/// underflow, which the error bounds of boxes would have to cover.
const NEGLIGIBLE: f64 = 1.0 / (1u64 << 40) as f64;

/// Rays in double precision, one a lane: all that spheres, parallelograms and disks need.
#[derive(Clone, Copy)]
pub(crate) struct Line<V = f64> {
    pub(crate) origin: [V; 3],
    /// Without negligible components.
    pub(crate) dir: [V; 3],
    pub(crate) t_min: V,
    pub(crate) t_max: V,
}

impl<V> Line<V> {
    /// The lines, and as bits those that may hit anything: not without a direction, with an empty range, or
    /// with something not finite.
    #[inline(always)]
    pub(crate) fn new<const N: usize>(rays: &[Ray; N]) -> (Self, u32)
    where
        V: Lanes<N>,
    {
        let origin: [V; 3] =
            [part(rays, |r| r.origin.x), part(rays, |r| r.origin.y), part(rays, |r| r.origin.z)];
        let dir: [V; 3] = [part(rays, |r| r.dir.x), part(rays, |r| r.dir.y), part(rays, |r| r.dir.z)];
        let (t_min, t_max): (V, V) = (part(rays, |r| r.t_min), part(rays, |r| r.t_max));
        // Sums of `f32` numbers are finite in `f64` exactly if the numbers are.
        let finite = (abs_sum(origin) + abs_sum(dir)).below(V::splat(f64::INFINITY));
        let longest = longest(dir);
        let sane = finite & V::splat(0.0).below(longest) & t_min.below(t_max);
        let least = longest * V::splat(NEGLIGIBLE);
        // No closures on lanes: they would not be compiled for the instruction set chosen.
        let dir = [dir[0].zero_below(least), dir[1].zero_below(least), dir[2].zero_below(least)];
        (Self { origin, dir, t_min, t_max }, sane)
    }
}

/// One number of each ray.
#[inline(always)]
fn part<const N: usize, V: Lanes<N>>(rays: &[Ray; N], number: fn(&Ray) -> f32) -> V {
    V::widen(std::array::from_fn(|lane| number(&rays[lane])))
}

/// The largest size of a component.
#[inline(always)]
fn longest<const N: usize, V: Lanes<N>>(dir: [V; 3]) -> V {
    dir[0].abs().larger(dir[1].abs()).larger(dir[2].abs())
}

/// A checked ray with what triangles and boxes derive from it.
#[derive(Clone, Copy)]
pub(crate) struct PreparedRay {
    pub(crate) origin: Vec3,
    /// Without negligible components.
    pub(crate) dir: [f32; 3],
    pub(crate) t_min: f32,
    pub(crate) t_max: f32,
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
        let (o, d) = (ray.origin, ray.dir);
        let size = d.abs();
        let largest = larger(size.x, larger(size.y, size.z));
        // Nothing of a number is 0 exactly if it is finite.
        let nothing = o * 0.0 + d * 0.0;
        let sane = (nothing.x + nothing.y + nothing.z == 0.0) & (largest > 0.0) & (ray.t_min < ray.t_max);
        if !sane {
            return None;
        }
        // Without branches, which nobody could foretell.
        let x_is_main = usize::from((size.x >= size.y) & (size.x >= size.z));
        let y_is_main = usize::from(size.y >= size.z) & (1 - x_is_main);
        let main_axis = 2 - 2 * x_is_main - y_is_main;
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][main_axis];
        let least = f64::from(largest) * NEGLIGIBLE;
        let dir = [telling(d.x, least), telling(d.y, least), telling(d.z, least)];
        let (up, down) = moderation(largest);
        let scaled_dir = [dir[0] * up, dir[1] * up, dir[2] * up];
        let main = scaled_dir[main_axis];
        Some(Self {
            origin: o,
            dir,
            t_min: ray.t_min,
            t_max: ray.t_max,
            axes,
            shear: [scaled_dir[axes[0]] / main, scaled_dir[axes[1]] / main],
            scaled_dir,
            box_scale: down,
        })
    }

    /// The ray in double precision.
    #[inline(always)]
    pub(crate) fn line(&self) -> Line {
        let o = self.origin;
        Line {
            origin: [f64::from(o.x), f64::from(o.y), f64::from(o.z)],
            dir: [f64::from(self.dir[0]), f64::from(self.dir[1]), f64::from(self.dir[2])],
            t_min: f64::from(self.t_min),
            t_max: f64::from(self.t_max),
        }
    }
}

/// The component, 0 if it is negligible.
#[inline(always)]
fn telling(d: f32, least: f64) -> f32 {
    if f64::from(d.abs()) < least { 0.0 } else { d }
}

/// The larger one; `b` if either is NaN. One instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
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
