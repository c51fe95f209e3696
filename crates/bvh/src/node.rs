//! Nodes of eight boxes and the test of a ray against them.
//!
//! # Why no box hides a hit
//!
//! Call `T` the largest |t| at which the ray meets the two planes of a box across the ray's main axis; it
//! grows with the box. With `u` = 2⁻²⁴:
//!
//! * A triangle is accepted exactly if the ray meets a triangle whose vertices are moved by rounding: every
//!   coordinate relative to the origin by a factor 1 ± 2u, and by 4u·|S·z| for the shear
//!   ([`crate::primitive`]). Divided by the direction that is 2u·|t| + 4u·T; planes with |t| beyond 2T decide
//!   nothing.
//! * The plane distances of the box carry 3 roundings (\[Ize2013\]), 3u·|t|.
//! * Spheres lose half of the double precision digits where a ray grazes them: below 3u·T.
//! * The distance is rounded to `f32`: u·T.
//!
//! In sum less than 16u·T = 2⁻²⁰·T, taken off the entry and added to the exit, plus a constant for underflow.
//! Arithmetic in double precision may also move a point aside, by a share of the distance `D` to the farthest
//! corner: that is taken off in space (see [`BoxRay`]), since a ray along a plane has no distance to it. NaN
//! (a plane through the origin along the ray, or overflow) never rejects a box.

use crate::lanes::Machine;
use crate::prepared::PreparedRay;
use penombre_math::{Bounds3, Vec3};

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// What a child reference leads to: the upper three bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Node,
    Triangles,
    Sphere,
    Quad,
    Disk,
    Instance,
}

/// Kind and index in the array of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChildRef(u32);

impl ChildRef {
    const INDEX_BITS: u32 = 29;
    /// Exclusive limit of indices.
    pub(crate) const LIMIT: usize = 1 << Self::INDEX_BITS;
    pub(crate) const ROOT: Self = Self(0);

    pub(crate) fn new(kind: Kind, index: usize) -> Self {
        debug_assert!(index < Self::LIMIT);
        Self(((kind as u32) << Self::INDEX_BITS) | index as u32)
    }

    #[inline(always)]
    pub(crate) fn kind(self) -> Kind {
        match self.0 >> Self::INDEX_BITS {
            0 => Kind::Node,
            1 => Kind::Triangles,
            2 => Kind::Sphere,
            3 => Kind::Quad,
            4 => Kind::Disk,
            _ => Kind::Instance,
        }
    }

    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & (Self::LIMIT as u32 - 1)) as usize
    }
}

/// Up to eight children and their boxes, one row per plane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Rows: min x, y, z, max x, y, z.
    planes: [[f32; WIDTH]; 6],
    children: [ChildRef; WIDTH],
    count: u32,
}

/// The children that a ray may hit, as bits, and where it enters each.
pub(crate) struct Crossing {
    pub(crate) mask: u32,
    pub(crate) entry: [f32; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Self =
        Self { planes: [[0.0; WIDTH]; 6], children: [ChildRef::ROOT; WIDTH], count: 0 };

    /// Adds a child. The caller adds eight at most.
    pub(crate) fn push(&mut self, bounds: &Bounds3, child: ChildRef) {
        let lane = self.count as usize;
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[axis + 3][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
        self.count += 1;
    }

    #[inline(always)]
    pub(crate) fn child(&self, lane: usize) -> ChildRef {
        self.children[lane]
    }

    /// Tests all boxes. `limit` is the best distance so far in the units of the box ray. With `SPREAD` the
    /// spatial allowance is taken per box, else it is in the ray already.
    #[inline(always)]
    pub(crate) fn cross<M: Machine, const SPREAD: bool>(&self, ray: &BoxRay, limit: f32) -> Crossing {
        let near: [&[f32; WIDTH]; 3] = std::array::from_fn(|k| &self.planes[ray.near_rows[k]]);
        let far: [&[f32; WIDTH]; 3] = std::array::from_fn(|k| &self.planes[ray.far_rows[k]]);
        let mut entry = [0.0; WIDTH];
        let mut inside = [0u32; WIDTH];
        for lane in 0..WIDTH {
            let mut to_near: [f32; 3] = std::array::from_fn(|k| near[k][lane] - ray.near_origin[k]);
            let mut to_far: [f32; 3] = std::array::from_fn(|k| far[k][lane] - ray.far_origin[k]);
            if SPREAD {
                let reach = (0..3).fold(0.0, |r, k| larger(to_near[k].abs(), larger(to_far[k].abs(), r)));
                let aside = reach * ray.aside;
                for k in 0..3 {
                    to_near[k] -= ray.sign[k] * aside;
                    to_far[k] += ray.sign[k] * aside;
                }
            }
            let t0: [f32; 3] = std::array::from_fn(|k| to_near[k] * ray.inverse[k]);
            let t1: [f32; 3] = std::array::from_fn(|k| to_far[k] * ray.inverse[k]);
            let pad = larger(-t0[2], t1[2]) * RELATIVE_PAD + ray.pad;
            let enter = larger(t0[0], larger(t0[1], t0[2])) - pad;
            let leave = smaller(t1[0], smaller(t1[1], t1[2])) + pad;
            entry[lane] = larger(enter, ray.t_min);
            inside[lane] = if entry[lane] <= smaller(leave, limit) { u32::MAX } else { 0 };
        }
        Crossing { mask: M::top_bits(&inside) & ((1 << self.count) - 1), entry }
    }
}

/// 16 unit roundoffs; see the module's comment.
const RELATIVE_PAD: f32 = 1.0 / (1u32 << 20) as f32;

/// The larger one; `b` if either is NaN. One instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller one; `b` if either is NaN. One instruction.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// A ray as boxes want it: main axis last, direction scaled by a power of two to a moderate length.
pub(crate) struct BoxRay {
    near_rows: [usize; 3],
    far_rows: [usize; 3],
    /// The origin moved forward along each axis by the spatial allowance for near planes …
    near_origin: [f32; 3],
    /// … and backward for far planes.
    far_origin: [f32; 3],
    inverse: [f32; 3],
    /// Sign of the direction per axis.
    sign: [f32; 3],
    /// Spatial allowance as a share of the distance to the farthest corner.
    aside: f32,
    /// Allowance for underflow.
    pad: f32,
    pub(crate) t_min: f32,
    scale: f32,
}

impl BoxRay {
    /// `aside` is the allowance for points moved aside, as a share of the distance to the farthest corner of
    /// a box; with `SPREAD` each box takes its own distance, else that to the corners of `bounds` goes for
    /// all.
    #[inline(always)]
    pub(crate) fn new<const SPREAD: bool>(ray: &PreparedRay, bounds: &Bounds3, aside: f32) -> Self {
        let shift = if SPREAD || aside == 0.0 { 0.0 } else { farthest(ray.origin, bounds) * aside };
        let negative: [bool; 3] = std::array::from_fn(|k| ray.scaled_dir[ray.axes[k]] < 0.0);
        let sign = negative.map(|n| if n { -1.0 } else { 1.0 });
        let inverse = std::array::from_fn(|k| {
            let d = ray.scaled_dir[ray.axes[k]];
            // Also for −0: the sign must fit the rows.
            if d == 0.0 { f32::INFINITY } else { 1.0 / d }
        });
        let origin: [f32; 3] = std::array::from_fn(|k| ray.origin[ray.axes[k]]);
        Self {
            near_rows: std::array::from_fn(|k| ray.axes[k] + if negative[k] { 3 } else { 0 }),
            far_rows: std::array::from_fn(|k| ray.axes[k] + if negative[k] { 0 } else { 3 }),
            near_origin: std::array::from_fn(|k| origin[k] + sign[k] * shift),
            far_origin: std::array::from_fn(|k| origin[k] - sign[k] * shift),
            inverse,
            sign,
            aside,
            pad: UNDERFLOW * inverse[2].abs(),
            t_min: ray.t_min * ray.box_scale - f32::MIN_POSITIVE,
            scale: ray.box_scale,
        }
    }

    /// A distance limit in box units, rounded up.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f32) -> f32 {
        t * self.scale + f32::MIN_POSITIVE
    }
}

/// Bound on what an underflowing product of the shear can cost, in lengths of the main axis: 2⁻¹⁵⁰ there,
/// divided by the smallest direction ratio 2⁻⁴⁰, with a margin.
const UNDERFLOW: f32 = 1.0 / ((1u128 << 105) as f32);

/// The largest distance per axis from `origin` to a corner.
#[inline(always)]
fn farthest(origin: Vec3, bounds: &Bounds3) -> f32 {
    let reach = (bounds.min - origin).abs().max((bounds.max - origin).abs());
    larger(reach.x, larger(reach.y, reach.z))
}
