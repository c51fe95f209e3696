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
//! * The plane distances of the box carry 3 roundings (\[Ize2013\]), 3u·|t|, and roundings of the origin's share of
//!   them, which are taken off beforehand (see [`BoxRay`]).
//! * Spheres lose half of the double precision digits where a ray grazes them: below 3u·T.
//! * The distance is rounded to `f32`: u·T.
//!
//! In sum less than 16u·T = 2⁻²⁰·T, taken off the entry and added to the exit, plus a constant for underflow.
//! Arithmetic in double precision may also move a point aside, by a share of the distance `D` to the farthest
//! corner: that is taken off in space (see [`BoxRay`]), since a ray along a plane has no distance to it. NaN
//! (a plane through the origin along the ray, or overflow) never rejects a box.

use crate::lanes::{Eight, Machine};
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
    /// The way back from an instance.
    Return,
}

/// Kind and index in the array of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChildRef(pub(crate) u32);

impl ChildRef {
    const INDEX_BITS: u32 = 29;
    /// Exclusive limit of indices.
    pub(crate) const LIMIT: usize = 1 << Self::INDEX_BITS;
    pub(crate) const ROOT: Self = Self(0);

    pub(crate) fn new(kind: Kind, index: usize) -> Self {
        debug_assert!(index < Self::LIMIT);
        Self(((kind as u32) << Self::INDEX_BITS) | index as u32)
    }

    /// The way back from an instance.
    pub(crate) const RETURN: Self = Self((Kind::Return as u32) << Self::INDEX_BITS);

    #[inline(always)]
    pub(crate) fn is_node(self) -> bool {
        self.0 < 1 << Self::INDEX_BITS
    }

    #[inline(always)]
    pub(crate) fn kind(self) -> Kind {
        match self.0 >> Self::INDEX_BITS {
            0 => Kind::Node,
            1 => Kind::Triangles,
            2 => Kind::Sphere,
            3 => Kind::Quad,
            4 => Kind::Disk,
            5 => Kind::Instance,
            _ => Kind::Return,
        }
    }

    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & (Self::LIMIT as u32 - 1)) as usize
    }
}

/// Up to eight children and their boxes: eight rows of eight words. Rows 0 to 5 are the planes min x, y, z, max x, y, z
/// as bits of `f32`, row 6 the references, row 7 for each octant of directions the lanes from far to near, three bits
/// each, and above them a bit for each lane in use.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    rows: [[u32; WIDTH]; 8],
}

/// Row of the references.
const CHILDREN: usize = 6;
/// Row of the orders.
const ORDERS: usize = 7;
/// Bits of an order word below the lanes in use.
const LANES_FROM: u32 = 24;

impl Node {
    pub(crate) const EMPTY: Self = Self { rows: [[0; WIDTH]; 8] };

    /// A node of eight children at most.
    pub(crate) fn new(children: &[(Bounds3, ChildRef)]) -> Self {
        let mut node = Self::EMPTY;
        for (lane, (bounds, child)) in children.iter().enumerate() {
            for axis in 0..3 {
                node.rows[axis][lane] = bounds.min[axis].to_bits();
                node.rows[axis + 3][lane] = bounds.max[axis].to_bits();
            }
            node.rows[CHILDREN][lane] = child.0;
        }
        node.rows[ORDERS] = std::array::from_fn(|octant| order(children, octant));
        node
    }

    /// The child's reference as it lies in the row of references.
    #[inline(always)]
    pub(crate) fn child(&self, lane: u32) -> ChildRef {
        ChildRef(self.rows[CHILDREN][lane as usize % WIDTH])
    }

    /// All references.
    #[inline(always)]
    pub(crate) fn children(&self) -> &[u32; WIDTH] {
        &self.rows[CHILDREN]
    }

    /// The lanes from far to near for a ray of that octant, three bits each.
    #[inline(always)]
    pub(crate) fn order(&self, octant: usize) -> u32 {
        self.rows[ORDERS][octant % WIDTH]
    }

    #[inline(always)]
    fn row<M: Machine>(&self, row: usize) -> M::Eight {
        M::Eight::load_bits(&self.rows[row % 8])
    }

    /// Tests all boxes: those that the ray may hit as bits, and where it enters each. `limit` is the best distance so
    /// far in the units of the box ray.
    #[inline(always)]
    pub(crate) fn cross<M: Machine>(&self, ray: &BoxRay, limit: f32) -> (u32, M::Eight) {
        // No closures and no `map`: they would not be compiled for the instruction set chosen.
        let inverse_x = M::Eight::splat(ray.inverse[0]);
        let inverse_y = M::Eight::splat(ray.inverse[1]);
        let inverse_z = M::Eight::splat(ray.inverse[2]);
        let x0 = self.row::<M>(ray.near_rows[0]).about_mul_sub(inverse_x, M::Eight::splat(ray.near[0]));
        let y0 = self.row::<M>(ray.near_rows[1]).about_mul_sub(inverse_y, M::Eight::splat(ray.near[1]));
        let z0 = self.row::<M>(ray.near_rows[2]).about_mul_sub(inverse_z, M::Eight::splat(ray.near[2]));
        let x1 = self.row::<M>(ray.far_rows[0]).about_mul_sub(inverse_x, M::Eight::splat(ray.far[0]));
        let y1 = self.row::<M>(ray.far_rows[1]).about_mul_sub(inverse_y, M::Eight::splat(ray.far[1]));
        let z1 = self.row::<M>(ray.far_rows[2]).about_mul_sub(inverse_z, M::Eight::splat(ray.far[2]));
        // Where one number is NaN, the second of two is taken: the one that is a number.
        let enter = x0.larger(y0).larger(z0.larger(M::Eight::splat(ray.t_min)));
        let leave = x1.smaller(y1).smaller(z1.smaller(M::Eight::splat(limit)));
        // Twice the allowance, taken off the entry alone.
        let reach = z0.opposite().larger(z1);
        let entry = reach.opposite().about_mul_sub(M::Eight::splat(2.0 * RELATIVE_PAD), enter.opposite());
        let used = self.rows[ORDERS][0] >> LANES_FROM;
        (entry.not_above(leave) & used, entry)
    }
}

/// Lanes by the place of their boxes along the diagonal of an octant, the farthest first; and the lanes in use. Unused
/// lanes come last; they are in no mask.
fn order(children: &[(Bounds3, ChildRef)], octant: usize) -> u32 {
    let mut lanes: [u32; WIDTH] = std::array::from_fn(|lane| lane as u32);
    let mut places = [0f64; WIDTH];
    for (lane, (bounds, _)) in children.iter().enumerate() {
        let sum = bounds.min.as_dvec3() + bounds.max.as_dvec3();
        let signed = |axis: usize| if octant >> axis & 1 == 0 { sum[axis] } else { -sum[axis] };
        let place = signed(0) + signed(1) + signed(2);
        // Insertion; equal places stay in the order of the lanes.
        let mut at = lane;
        while at > 0 && places[at - 1] < place {
            (places[at], lanes[at]) = (places[at - 1], lanes[at - 1]);
            at -= 1;
        }
        (places[at], lanes[at]) = (place, lane as u32);
    }
    let order = lanes.iter().enumerate().fold(0, |word, (i, lane)| word | lane << (3 * i));
    order | ((1u32 << children.len()) - 1) << LANES_FROM
}

/// 16 unit roundoffs; see the module's comment.
const RELATIVE_PAD: f32 = 1.0 / (1u32 << 20) as f32;

/// The larger one; `b` if either is NaN. One instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A ray as boxes want it: main axis last, direction scaled by a power of two to a moderate length. A plane at p is
/// met at about p·inverse − near.
#[derive(Clone, Copy)]
pub(crate) struct BoxRay {
    near_rows: [usize; 3],
    far_rows: [usize; 3],
    /// Origin times inverse for near planes: with all allowances, the plane is met earlier …
    near: [f32; 3],
    /// … and for far planes, met later.
    far: [f32; 3],
    inverse: [f32; 3],
    t_min: f32,
    scale: f32,
    /// A bit for each axis, x first, along which the ray goes backward.
    pub(crate) octant: usize,
}

impl BoxRay {
    /// `extent` is the largest coordinate of all boxes, and `aside` the allowance for points moved aside, as a share of
    /// the distance to the farthest corner of them.
    #[inline(always)]
    pub(crate) fn new(ray: &PreparedRay, extent: f32, aside: f32) -> Self {
        let far = farthest(ray.origin, extent);
        let shift = far * aside;
        let mut built = Self {
            near_rows: ray.axes,
            far_rows: ray.axes,
            near: [0.0; 3],
            far: [0.0; 3],
            inverse: [0.0; 3],
            t_min: 0.0,
            scale: ray.box_scale,
            octant: 0,
        };
        for k in 0..3 {
            let (d, o) = (ray.scaled_dir[ray.axes[k]], ray.origin[ray.axes[k]]);
            // A ray along the planes meets them far beyond all others, on the side where they are; planes through it
            // (or nearly so) on the outer side of their boxes.
            let (inverse, shift) = if d == 0.0 { (PARALLEL, shift + far * BESIDE) } else { (1.0 / d, shift) };
            let backward = (inverse.to_bits() >> 31) as usize;
            built.near_rows[k] += 3 * backward;
            built.far_rows[k] += 3 * (1 - backward);
            built.octant |= backward << ray.axes[k];
            let at = o * inverse;
            // Rounding of `at` and of what is subtracted from it, and the shift in space.
            let allowance = (o.abs() * ORIGIN_ROUNDINGS + shift) * inverse.abs();
            // Products of planes must not overflow: then the axis decides nothing.
            let tame = (far + o.abs()) * inverse.abs() < TAME;
            built.inverse[k] = inverse;
            built.near[k] = if tame { at + allowance } else { f32::INFINITY };
            built.far[k] = if tame { at - allowance } else { f32::NEG_INFINITY };
        }
        let pad = UNDERFLOW * built.inverse[2].abs();
        built.near = built.near.map(|at| at + pad);
        built.far = built.far.map(|at| at - pad);
        built.t_min = ray.t_min * ray.box_scale - f32::MIN_POSITIVE - pad;
        built
    }

    /// A distance limit in box units, rounded up.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f32) -> f32 {
        t * self.scale + f32::MIN_POSITIVE
    }
}

/// The inverse of no direction: beyond the largest inverse of one, 2⁴⁰ times the moderate length 2²⁰.
const PARALLEL: f32 = (1u128 << 64) as f32;

/// By this share of the scene boxes reach out to rays that go along their planes: enough for such a ray to enter them
/// before anything else, for its distances in box units are below 2²⁰ times the scene.
const BESIDE: f32 = 1.0 / (1u32 << 24) as f32;

/// Products below this one are far from overflow.
const TAME: f32 = 1e37;

/// Eight unit roundoffs of the origin's share: forming it takes one, subtracting it up to two, and adding allowances
/// one each.
const ORIGIN_ROUNDINGS: f32 = 1.0 / (1u32 << 21) as f32;

/// Bound on what an underflowing product of the shear can cost, in lengths of the main axis: 2⁻¹⁵⁰ there,
/// divided by the smallest direction ratio 2⁻⁴⁰, with a margin.
const UNDERFLOW: f32 = 1.0 / ((1u128 << 105) as f32);

/// No corner is farther from `origin`, per axis.
#[inline(always)]
fn farthest(origin: Vec3, extent: f32) -> f32 {
    extent + larger(origin.x.abs(), larger(origin.y.abs(), origin.z.abs()))
}
