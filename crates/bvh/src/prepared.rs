//! A ray made ready for traversal.

use crate::Ray;
use crate::kernel::{ROW, item};
use crate::lanes::Lanes;
use crate::primitive::abs_sum;
use penombre_math::{Vec3, Vec3A, Vec3Swizzles, Vec4};

/// Direction components below this share of the largest count as zero: their products with coordinates could
/// underflow, which the error bounds of boxes would have to cover.
pub(crate) const NEGLIGIBLE: f32 = 1.0 / (1u64 << 40) as f32;

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
        let least = longest * V::splat(f64::from(NEGLIGIBLE));
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

/// A checked ray with what triangles and boxes derive from it. All fields are words of 32 bits, of any value.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct PreparedRay {
    /// As triangles want it.
    pub(crate) turned: TurnedRay,
    pub(crate) t_min: f32,
    pub(crate) t_max: f32,
    /// Distances times this are distances along [`PreparedRay::scaled_dir`]. A power of two.
    pub(crate) box_scale: f32,
    /// No corner is farther from the origin, per axis.
    pub(crate) reach: f32,
    pub(crate) origin: Vec3A,
    /// Without negligible components.
    pub(crate) dir: Vec3A,
}

/// A ray whose axes have changed places so that the main one, along which the direction is largest, comes last.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct TurnedRay {
    /// In the new order of axes.
    pub(crate) origin: [f32; 3],
    /// Minor components of the direction divided by the main one (\[Woop2013\]).
    pub(crate) shear: [f32; 2],
    /// The main component of the direction …
    pub(crate) pace: f32,
    /// … and its reciprocal; NaN if that may not have all its digits.
    pub(crate) inverse_pace: f32,
    /// Single precision tells the place of hits beyond this distance: they are beyond `t_min`, and no number on the way
    /// is tiny or huge. Infinite if it tells nothing.
    pub(crate) beyond: f32,
    /// Hits before this distance are none; negative infinity if the ray looks before its origin, else 0.
    pub(crate) behind: f32,
    /// The axes in their new order, as places of their rows in a block of triangles.
    pub(crate) rows: [u32; 3],
}

/// Distances above this one have all their digits.
pub(crate) const NORMAL: f32 = 1.0 / (1u64 << 60) as f32;
/// Coordinates up to this may be multiplied by each other, and by any inverse of a direction.
pub(crate) const TAME: f32 = (1u64 << 57) as f32;
/// Directions of moderate length are no longer than this, and no shorter than its reciprocal.
pub(crate) const ORDINARY: f32 = (1u32 << 20) as f32;

/// A vector, from four numbers that lie side by side.
#[inline(always)]
pub(crate) fn packed(v: Vec3, more: f32) -> Vec3A {
    Vec3A::from_vec4(Vec4::new(v.x, v.y, v.z, more))
}

impl PreparedRay {
    pub(crate) const EMPTY: Self = Self {
        turned: TurnedRay {
            origin: [0.0; 3],
            shear: [0.0; 2],
            pace: 0.0,
            inverse_pace: 0.0,
            beyond: 0.0,
            behind: 0.0,
            rows: [0; 3],
        },
        t_min: 0.0,
        t_max: 0.0,
        box_scale: 0.0,
        reach: 0.0,
        origin: Vec3A::ZERO,
        dir: Vec3A::ZERO,
    };

    /// `None` if the ray can hit nothing: no direction, an empty range, or something not finite. `extent` is the largest
    /// coordinate of what it may hit.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, extent: f32) -> Option<Self> {
        let (o, d) = (packed(ray.origin, ray.t_min), packed(ray.dir, ray.t_max));
        let (t_min, t_max) = (ray.t_min, ray.t_max);
        let size = d.abs();
        // The largest size in every lane: sooner known than as a number.
        let longests = size.max(size.yzx()).max(size.zxy());
        let longest = longests.x;
        // Nothing of a number is 0 exactly if it is finite.
        let finite = (o * 0.0 + d * 0.0).cmpeq(Vec3A::ZERO).all();
        let sane = finite & (longest > 0.0) & (t_min < t_max);
        if !sane {
            return None;
        }
        let reach = extent + o.abs().max_element();
        let ordinary = (1.0 / ORDINARY..=ORDINARY).contains(&longest) && reach < TAME;
        let (up, box_scale) = if ordinary { (1.0, 1.0) } else { moderation(longest) };
        let telling = (size * up).cmpge(longests * (up * NEGLIGIBLE));
        let dir = Vec3A::select(telling, d, Vec3A::ZERO);
        // Without branches, which nobody could foretell.
        let axes = *item(&AXES, size.cmpeq(longests).bitmask() as usize);
        let turned = TurnedRay::new(ray, dir, axes, ordinary);
        Some(Self { origin: o, dir, t_min, t_max, turned, reach, box_scale })
    }

    /// Is the direction of moderate length, and no coordinate huge?
    #[inline(always)]
    pub(crate) fn is_ordinary(&self) -> bool {
        self.turned.beyond < f32::INFINITY
    }

    /// The direction times a power of two, of moderate length.
    #[inline(always)]
    pub(crate) fn scaled_dir(&self) -> Vec3A {
        if self.is_ordinary() { self.dir } else { self.dir / self.box_scale }
    }

    /// The ray in double precision.
    #[inline(always)]
    pub(crate) fn line(&self) -> Line {
        let (o, d) = (self.origin, self.dir);
        Line {
            origin: [f64::from(o.x), f64::from(o.y), f64::from(o.z)],
            dir: [f64::from(d.x), f64::from(d.y), f64::from(d.z)],
            t_min: f64::from(self.t_min),
            t_max: f64::from(self.t_max),
        }
    }
}

impl TurnedRay {
    #[inline(always)]
    fn new(ray: &Ray, dir: Vec3A, [kx, ky, kz]: [usize; 3], ordinary: bool) -> Self {
        let (origin, dir) = (ray.origin.as_ref(), dir.to_array());
        let pace = *item(&dir, kz);
        let beyond = if ray.t_min > NORMAL { ray.t_min } else { NORMAL };
        let (inverse_pace, beyond) = if ordinary { (1.0 / pace, beyond) } else { (f32::NAN, f32::INFINITY) };
        Self {
            rows: [kx as u32 * ROW, ky as u32 * ROW, kz as u32 * ROW],
            origin: [*item(origin, kx), *item(origin, ky), *item(origin, kz)],
            shear: [*item(&dir, kx) / pace, *item(&dir, ky) / pace],
            pace,
            inverse_pace,
            beyond,
            behind: if ray.t_min >= 0.0 { 0.0 } else { f32::NEG_INFINITY },
        }
    }
}

/// The axes by those along which the direction is largest, a bit each, x first: the first of them is the main one.
const AXES: [[usize; 3]; 8] = {
    let (x, y, z) = ([1, 2, 0], [2, 0, 1], [0, 1, 2]);
    [z, x, y, x, z, x, y, x]
};

/// A power of two that brings `longest` to about 1, and its reciprocal.
#[cold]
fn moderation(longest: f32) -> (f32, f32) {
    // The biased exponent e stands for 2^(e − 127); subnormal numbers have e = 0.
    let exponent = (longest.to_bits() >> 23) as i32 - 127;
    (power_of_two(-exponent), power_of_two(exponent))
}

#[inline(always)]
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent.clamp(-126, 126) + 127) as u32) << 23)
}
