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
//! * The plane distances of the box carry 4 roundings (\[Ize2013\], and one of the stretch), 4u·|t|, and roundings of the
//!   origin's share of them, which are taken off beforehand (see [`BoxRay`]).
//! * Spheres lose half of the double precision digits where a ray grazes them: below 3u·T.
//! * The distance is rounded to `f32`: u·T.
//!
//! In sum less than `E` = 16u·T = 2⁻²⁰·T. A ray that meets the box at `t` has T ≤ |t| + s/|d|, with `s` the longest side
//! of the box and `d` the main component of the direction. So `E` has two parts. Of 2⁻²⁰·s/|d| the boxes take care:
//! all their sides are moved outward by twice 2⁻²⁰·s, which the ray crosses in no less time ([`Node::new`]). Of
//! 2⁻²⁰·|t| the exit and the limit take care, which are stretched by 1 + 2⁻¹⁸; hits before the origin
//! would need the near planes stretched, so rays that look there have an allowance for the whole scene instead.
//! Arithmetic in double precision may also move a point aside, by a share of the distance `D` to the farthest
//! corner: that is taken off in space (see [`BoxRay`]), since a ray along a plane has no distance to it. NaN
//! (a plane beyond the range of numbers) never rejects a box.

use crate::kernel::{ROW, item, row_at};
use crate::lanes::{Eight, Machine};
use crate::prepared::PreparedRay;
use penombre_math::{Bounds3, Vec3A};

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
    User,
    /// No primitive: [`ChildRef::RETURN`] or [`ChildRef::NOTHING`].
    Mark,
}

/// Kind and index in the array of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChildRef(pub(crate) u32);

impl ChildRef {
    pub(crate) const INDEX_BITS: u32 = 29;
    /// Exclusive limit of indices.
    pub(crate) const LIMIT: usize = 1 << Self::INDEX_BITS;
    pub(crate) const ROOT: Self = Self(0);

    pub(crate) fn new(kind: Kind, index: usize) -> Self {
        debug_assert!(index < Self::LIMIT);
        Self(((kind as u32) << Self::INDEX_BITS) | index as u32)
    }

    /// The way back from an instance, or the end.
    pub(crate) const RETURN: Self = Self((Kind::Mark as u32) << Self::INDEX_BITS);
    /// Nothing to visit: in places of a node that have no child.
    pub(crate) const NOTHING: Self = Self(Self::RETURN.0 | 1);

    #[inline(always)]
    pub(crate) fn is_node(self) -> bool {
        self.0 < 1 << Self::INDEX_BITS
    }

    #[inline(always)]
    pub(crate) fn is_triangles(self) -> bool {
        self.0 >> Self::INDEX_BITS == Kind::Triangles as u32
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
            6 => Kind::User,
            _ => Kind::Mark,
        }
    }

    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & (Self::LIMIT as u32 - 1)) as usize
    }
}

/// Up to eight children and their boxes: eight rows of eight words. Rows 0 to 5 are the planes min x, y, z, max x, y, z
/// as bits of `f32`, row 6 the references, row 7 for each octant of directions the lanes from far to near, three bits
/// each. Boxes of places without a child are turned inside out, so that no ray enters them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    rows: [[u32; WIDTH]; 8],
}

/// Row of the references.
const CHILDREN: usize = 6;
/// Row of the orders.
const ORDERS: usize = 7;

impl Node {
    pub(crate) const EMPTY: Self = {
        let (min, max) = ([f32::INFINITY.to_bits(); WIDTH], [f32::NEG_INFINITY.to_bits(); WIDTH]);
        Self { rows: [min, min, min, max, max, max, [ChildRef::NOTHING.0; WIDTH], [0; WIDTH]] }
    };

    /// A node of eight children at most.
    pub(crate) fn new(children: &[(Bounds3, ChildRef)]) -> Self {
        let mut node = Self::EMPTY;
        for (lane, (bounds, child)) in children.iter().enumerate() {
            let pad = (bounds.max - bounds.min).max_element() * BOX_PAD;
            for axis in 0..3 {
                node.rows[axis][lane] = (bounds.min[axis] - pad).next_down().to_bits();
                node.rows[axis + 3][lane] = (bounds.max[axis] + pad).next_up().to_bits();
            }
            node.rows[CHILDREN][lane] = child.0;
        }
        node.rows[ORDERS] = orders(children);
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
    pub(crate) fn order(&self, octant: u32) -> u32 {
        *item(&self.rows[ORDERS], octant as usize)
    }

    #[inline(always)]
    fn row<M: Machine>(&self, row: u32) -> M::Eight {
        M::Eight::load(row_at(&self.rows, row))
    }

    /// Where the ray enters all boxes and where it leaves them: those are met that it enters no later. `limit` is the
    /// best distance so far in the units of the box ray.
    #[inline(always)]
    pub(crate) fn cross<M: Machine>(&self, ray: &SpreadRay<M>, limit: f32) -> (M::Eight, M::Eight) {
        // No closures and no `map`: they would not be compiled for the instruction set chosen.
        let ([x, y, z], near, far, rows) = (ray.inverse, &ray.near, &ray.far, ray.rows);
        let [x_far, y_far, z_far] = ray.stretched;
        let x0 = self.row::<M>(rows[0]).about_mul_sub(x, near[0]);
        let y0 = self.row::<M>(rows[1]).about_mul_sub(y, near[1]);
        let z0 = self.row::<M>(rows[2]).about_mul_sub(z, near[2]);
        let x1 = self.row::<M>(rows[3]).about_mul_sub(x_far, far[0]);
        let y1 = self.row::<M>(rows[4]).about_mul_sub(y_far, far[1]);
        let z1 = self.row::<M>(rows[5]).about_mul_sub(z_far, far[2]);
        // Where one number is NaN, the second of two is taken: the one that is a number.
        let enter = x0.larger(y0).larger(z0.larger(ray.t_min));
        let leave = x1.smaller(y1).smaller(z1.smaller(M::Eight::splat(limit)));
        (enter, leave)
    }
}

/// For each octant the lanes by the place where their boxes end along its diagonal, the farthest first, three bits each: so
/// what lies in a larger box is met before that (measured: up to a quarter fewer leaves than by their middles). Lanes
/// without a child come last; they are in no mask.
fn orders(children: &[(Bounds3, ChildRef)]) -> [u32; WIDTH] {
    // By side (forward, backward), axis, lane. A quarter of it, so that the sum of three is finite.
    let (mut max, mut min) = ([[0f32; WIDTH]; 3], [[0f32; WIDTH]; 3]);
    for (lane, (bounds, _)) in children.iter().enumerate() {
        for axis in 0..3 {
            (max[axis][lane], min[axis][lane]) = (bounds.max[axis] * 0.25, bounds.min[axis] * -0.25);
        }
    }
    let ends = [max, min];
    let mut rest = 0;
    (children.len()..WIDTH).for_each(|lane| rest |= (lane as u32) << (3 * lane));
    std::array::from_fn(|octant| {
        let [x, y, z] = std::array::from_fn(|axis| &ends[octant >> axis & 1][axis]);
        let keys = std::array::from_fn(|lane| {
            if lane >= children.len() {
                return i32::MIN;
            }
            let bits = (x[lane] + y[lane] + z[lane]).to_bits() as i32;
            // As a whole number in the order of places. The lane makes it one of its own.
            (bits ^ ((bits >> 31) & i32::MAX)) & !7 | (7 - lane as i32)
        });
        let lanes = ranks(&keys).into_iter().enumerate().take(children.len());
        lanes.fold(rest, |order, (lane, rank)| order | (lane as u32) << (3 * rank))
    })
}

/// How many others are larger than each.
fn ranks(keys: &[i32; WIDTH]) -> [u32; WIDTH] {
    let mut ranks = [0; WIDTH];
    for key in keys {
        for (rank, other) in ranks.iter_mut().zip(keys) {
            *rank += u32::from(key > other);
        }
    }
    ranks
}

/// By this share of its longest side a box is larger than what it holds, on every side; see the module's comment.
const BOX_PAD: f32 = 1.0 / (1u32 << 19) as f32;

/// The distances of far planes are stretched by this factor; see the module's comment.
pub(crate) const STRETCH: f32 = 1.0 + 1.0 / (1u32 << 18) as f32;

/// A [`BoxRay`] in vector registers.
#[derive(Clone, Copy)]
pub(crate) struct SpreadRay<M: Machine> {
    inverse: [M::Eight; 3],
    near: [M::Eight; 3],
    far: [M::Eight; 3],
    /// `inverse` times [`STRETCH`], for far planes.
    stretched: [M::Eight; 3],
    t_min: M::Eight,
    /// Where in a node the rows of near and far planes lie.
    rows: [u32; 6],
}

#[inline(always)]
fn spread<M: Machine>([x, y, z]: &[f32; 3]) -> [M::Eight; 3] {
    [M::Eight::splat(*x), M::Eight::splat(*y), M::Eight::splat(*z)]
}

/// For each octant where in a node the rows of the near planes lie, x, y, z, and those of the far ones.
static ROWS: [[u32; 8]; 8] = {
    let mut rows = [[0; 8]; 8];
    let mut octant = 0;
    while octant < 8 {
        let mut axis = 0;
        while axis < 3 {
            let backward = octant as u32 >> axis & 1;
            rows[octant][axis] = ROW * (axis as u32 + 3 * backward);
            rows[octant][axis + 3] = ROW * (axis as u32 + 3 * (1 - backward));
            axis += 1;
        }
        octant += 1;
    }
    rows
};

/// A ray as boxes want it, with the direction scaled by a power of two to a moderate length: a plane at `p` is met at
/// about `p · inverse − near`, or `p · stretched − far` if it is a far one.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct BoxRay {
    inverse: [f32; 3],
    near: [f32; 3],
    far: [f32; 3],
    t_min: f32,
    scale: f32,
    /// A bit for each axis, x first, along which the ray goes backward.
    pub(crate) octant: u32,
    /// `inverse` times [`STRETCH`].
    stretched: [f32; 3],
}

impl BoxRay {
    pub(crate) const EMPTY: Self = Self {
        inverse: [0.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        t_min: 0.0,
        scale: 0.0,
        octant: 0,
        stretched: [0.0; 3],
    };

    /// `aside` is the allowance for points moved aside, as a share of the distance to the farthest corner; `raw` the
    /// ray's direction that may have negligible components, if the ray is ordinary: it is known sooner.
    #[inline(always)]
    pub(crate) fn new(ray: &PreparedRay, aside: f32, raw: Vec3A) -> Self {
        let (o, d) = (ray.origin, ray.scaled_dir());
        let raw = if ray.is_ordinary() { raw } else { d };
        let (size, far) = (o.abs(), ray.reach);
        // A ray along the planes meets them far beyond all others, on the side where they are; planes through it
        // (or nearly so) on the outer side of their boxes.
        let along = d.cmpeq(Vec3A::ZERO);
        let inverse = Vec3A::select(along, Vec3A::splat(PARALLEL).copysign(raw), Vec3A::ONE / raw);
        let shift = Vec3A::select(along, Vec3A::splat(far * (aside + BESIDE)), Vec3A::splat(far * aside));
        let (at, steep) = (o * inverse, inverse.abs());
        // Rounding of `o · inverse` and of what is subtracted from it, the shift in space, and underflow.
        let mut allowance = (size * ORIGIN_ROUNDINGS + shift) * steep + UNDERFLOW;
        if ray.t_min < 0.0 {
            // What the stretch does not do before the origin.
            allowance += far * (STRETCH - 1.0) * steep.min_element();
        }
        let (mut near, mut far_less) = (at + allowance, (at - allowance) * STRETCH);
        if !ray.is_ordinary() {
            // Products of planes must not overflow: then the axis decides nothing.
            let tame = ((far + size) * steep).cmplt(Vec3A::splat(TAME));
            near = Vec3A::select(tame, near, Vec3A::INFINITY);
            far_less = Vec3A::select(tame, far_less, Vec3A::NEG_INFINITY);
        }
        Self {
            inverse: inverse.to_array(),
            near: near.to_array(),
            far: far_less.to_array(),
            t_min: ray.t_min * ray.box_scale - f32::MIN_POSITIVE,
            scale: ray.box_scale,
            octant: raw.is_negative_bitmask(),
            stretched: (inverse * STRETCH).to_array(),
        }
    }

    #[inline(always)]
    pub(crate) fn spread<M: Machine>(&self) -> SpreadRay<M> {
        let [x0, y0, z0, x1, y1, z1, ..] = *item(&ROWS, self.octant as usize);
        SpreadRay {
            rows: [x0, y0, z0, x1, y1, z1],
            inverse: spread::<M>(&self.inverse),
            near: spread::<M>(&self.near),
            far: spread::<M>(&self.far),
            stretched: spread::<M>(&self.stretched),
            t_min: M::Eight::splat(self.t_min),
        }
    }

    /// A distance limit in box units, rounded up.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f32) -> f32 {
        let t = t * self.scale;
        t + (t.abs() * (STRETCH - 1.0) + f32::MIN_POSITIVE)
    }
}

/// The inverse of no direction: beyond the largest inverse of one, 2⁴⁰ times the moderate length 2²⁰.
pub(crate) const PARALLEL: f32 = (1u128 << 64) as f32;

/// By this share of the scene boxes reach out to rays that go along their planes: enough for such a ray to enter them
/// before anything else, for its distances in box units are below 2²⁰ times the scene.
pub(crate) const BESIDE: f32 = 1.0 / (1u32 << 24) as f32;

/// Products below this one are far from overflow.
const TAME: f32 = 1e37;

/// Eight unit roundoffs of the origin's share: forming it takes one, subtracting it up to two, adding allowances one each,
/// and stretching the far planes' inverse and share one each.
pub(crate) const ORIGIN_ROUNDINGS: f32 = 1.0 / (1u32 << 21) as f32;

/// Bound on what an underflowing product of the shear can cost, 2⁻¹⁵⁰ along the main axis, divided by the smallest
/// direction ratio, 2⁻⁴⁰, and by the shortest moderate direction, 2⁻²⁰, with a margin.
pub(crate) const UNDERFLOW: f32 = 1.0 / ((1u128 << 85) as f32);

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::Pcg32;
    use penombre_math::Vec3;

    #[test]
    fn orders_go_from_far_to_near_whatever_the_octant() {
        let mut rng = Pcg32::new(90);
        let mut number = || rng.next_f32() - 0.5;
        for count in 0..=WIDTH {
            let boxes: Vec<Bounds3> = (0..count)
                .map(|_| [number(), number(), number()].into())
                .map(|min: Vec3| Bounds3 { min, max: min + 0.1 })
                .collect();
            let children: Vec<_> = boxes.iter().map(|b| (*b, ChildRef::ROOT)).collect();
            for (octant, word) in orders(&children).into_iter().enumerate() {
                let lanes: Vec<usize> = (0..WIDTH).map(|i| (word >> (3 * i)) as usize % WIDTH).collect();
                let sign = |axis: usize| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
                let place = |lane: usize| boxes[lane].min.dot(Vec3::new(sign(0), sign(1), sign(2)));
                assert!(lanes[..count].windows(2).all(|pair| place(pair[0]) > place(pair[1]) - 1e-5));
                let mut sorted = lanes.clone();
                sorted.sort_unstable();
                assert!(sorted.into_iter().eq(0..WIDTH) && lanes[count..].iter().all(|&lane| lane >= count));
            }
        }
    }

    #[test]
    fn boxes_without_a_middle_have_an_order_too() {
        let wild = Bounds3 { min: Vec3::NEG_INFINITY, max: Vec3::splat(f32::INFINITY) };
        let children = [(wild, ChildRef::ROOT), (Bounds3::EMPTY, ChildRef::ROOT), (wild, ChildRef::ROOT)];
        for word in orders(&children) {
            assert_eq!((0..WIDTH).fold(0u32, |seen, i| seen | 1 << (word >> (3 * i) & 7)), 255);
        }
    }
}
