//! The watertight triangle test of \[Woop2013\], with exact signs.
//!
//! Vertices are taken relative to the origin and sheared so that the ray becomes the main axis. The three
//! edge functions then are differences of two products of `f32` numbers. Rounding is monotone, so an `f32`
//! edge function that is not 0 has the right sign; where it is 0 (or overflowed) the products are exact in
//! `f64`. `f32` therefore only serves to reject, many triangles at once; whatever remains is computed in
//! `f64`. So weights are accurate however thin the triangle is, and the distance is that of the point hit,
//! not of another point of an edge-on triangle.

use super::{Meeting, cross, difference, wide};
use crate::kernel::{item, row_at};
use crate::lanes::{Eight, Lanes as _, Machine, Turn};
use crate::prepared::{PreparedRay, TurnedRay};
use penombre_math::{Vec3, Vec4};

/// Triangles tested at once.
pub(crate) const BLOCK: usize = 8;

type Lanes = [f32; BLOCK];

/// Up to eight triangles of one leaf.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct TriangleBlock {
    /// By vertex, axis, triangle.
    vertices: [[Lanes; 3]; 3],
    /// Numbers of the triangles among all primitives; [`UNUSED`] in lanes without one.
    numbers: [u32; BLOCK],
}

/// No triangle: a number with the sign bit set.
const UNUSED: u32 = u32::MAX;

/// True if the corners are finite and not on one line.
pub(crate) fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(wide);
    let normal = cross(difference(b, a), difference(c, a));
    corners.iter().all(|v| v.is_finite()) && normal != [0.0; 3]
}

impl TriangleBlock {
    pub(crate) const EMPTY: Self = Self { vertices: [[[0.0; BLOCK]; 3]; 3], numbers: [UNUSED; BLOCK] };

    /// Adds a triangle by its number among all primitives. The caller adds eight at most.
    pub(crate) fn push(&mut self, corners: [Vec3; 3], number: u32) {
        let lane = self.len();
        for (vertex, corner) in corners.iter().enumerate() {
            for axis in 0..3 {
                self.vertices[vertex][axis][lane] = corner[axis];
            }
        }
        self.numbers[lane] = number;
    }

    /// The number of a triangle among all primitives.
    #[inline(always)]
    pub(crate) fn number(&self, lane: usize) -> u32 {
        *item(&self.numbers, lane)
    }

    /// A corner of all triangles, by axes.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub(crate) fn corner(&self, corner: usize) -> &[Lanes; 3] {
        &self.vertices[corner]
    }

    /// All numbers as bits of `f32`.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub(crate) fn numbers(&self) -> &[u32; BLOCK] {
        &self.numbers
    }

    /// How many triangles there are.
    pub(crate) fn len(&self) -> usize {
        self.numbers.iter().position(|&number| number == UNUSED).unwrap_or(BLOCK)
    }

    /// A corner of all triangles relative to the ray: the minor coordinates, and the main one.
    #[inline(always)]
    fn sheared<M: Machine>(&self, corner: usize, ray: &TurnedRay) -> [M::Eight; 3] {
        let rows = &self.vertices[corner];
        let ([kx, ky, kz], [ox, oy, oz]) = (ray.rows, ray.origin);
        let z = M::Eight::load(row_at(rows, kz)).minus(M::Eight::splat(oz));
        let x = M::Eight::load(row_at(rows, kx)).minus(M::Eight::splat(ox));
        let y = M::Eight::load(row_at(rows, ky)).minus(M::Eight::splat(oy));
        [x.minus(M::Eight::splat(ray.shear[0]).times(z)), y.minus(M::Eight::splat(ray.shear[1]).times(z)), z]
    }

    /// What decides which triangles are met.
    #[inline(always)]
    fn sides<M: Machine>(&self, ray: &TurnedRay) -> Sides<M> {
        let corners = [self.sheared::<M>(0, ray), self.sheared::<M>(1, ray), self.sheared::<M>(2, ray)];
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = corners;
        let u = cx.times(by).minus(cy.times(bx));
        let v = ax.times(cy).minus(ay.times(cx));
        let w = bx.times(ay).minus(by.times(ax));
        // Both are true signs if they are numbers and not 0; NaN leaves the triangle open.
        let (least, most) = (w.smaller(u.smaller(v)), w.larger(u.larger(v)));
        let met = !least.around_zero_or(most, M::Eight::load_bits(&self.numbers)) & 0xff;
        Sides { corners, edges: [u, v, w], least, most, met }
    }

    /// The triangles that a ray may meet before `limit`, as bits: those that its line meets (and where an edge is met to
    /// the last digit or a number out of range, those that it may), but for those all of whose corners lie beyond
    /// the limit or behind the origin.
    #[inline(always)]
    pub(crate) fn met_before<M: Machine>(&self, ray: &TurnedRay, limit: f32) -> u32 {
        let sides = self.sides::<M>(ray);
        sides.met & sides.range(ray).reaches(ray, limit)
    }

    /// What single precision tells about hits before `limit`; `None` if there are none for sure.
    #[inline(always)]
    pub(crate) fn span<M: Machine>(&self, ray: &TurnedRay, limit: f32) -> Option<Span<M>> {
        let sides = self.sides::<M>(ray);
        let range = sides.range(ray);
        let met = sides.met & range.reaches(ray, limit);
        if met == 0 {
            return None;
        }
        let Sides { corners: [[ax, ay, _], [bx, by, _], [cx, cy, _]], edges: [u, v, w], least, most, .. } =
            sides;
        // The hit is the mean of the corners with the edge functions as weights.
        let Range { corners: [a, b, c], near, far } = range;
        let determinant = u.plus(v).plus(w);
        let inverse = determinant.abs().if_below(
            M::Eight::splat(TINY),
            M::Eight::splat(f32::NAN),
            M::Eight::splat(1.0).over(determinant),
        );
        let t = u.times(inverse).times(a).plus(v.times(inverse).times(b)).plus(w.times(inverse).times(c));
        let x = cx.abs().larger(ax.abs().larger(bx.abs()));
        let y = cy.abs().larger(ay.abs().larger(by.abs()));
        let blurred =
            x.times(y).times(inverse.abs()).times(far.minus(near)).times(M::Eight::splat(WEIGHT_SLACK));
        let rounded =
            near.abs().larger(far.abs()).times(M::Eight::splat(SLACK)).plus(M::Eight::splat(UNDERFLOW));
        let error = blurred.plus(rounded);
        let (from, to) = (t.minus(error), t.plus(error));
        Some(Span { met, sure: met & least.beside_zero(most), from, to })
    }

    /// A coordinate of the three corners of a triangle, by the place of its row, less that of a point.
    #[inline(always)]
    fn coordinate(&self, row: u32, lane: usize, from: f32) -> Vec4 {
        let [a, b, c] = &self.vertices;
        let of = |rows: &[Lanes; 3]| *item(row_at(rows, row), lane);
        Vec4::new(of(a), of(b), of(c), 0.0) - Vec4::splat(from)
    }

    /// The edge functions of one triangle, exact up to one rounding, and the main coordinates of its corners.
    #[inline(always)]
    fn edges<M: Machine>(&self, lane: usize, ray: &TurnedRay) -> (M::Four, M::Four) {
        let ([kx, ky, kz], [ox, oy, oz]) = (ray.rows, ray.origin);
        let z = self.coordinate(kz, lane, oz);
        let x = self.coordinate(kx, lane, ox) - z * ray.shear[0];
        let y = self.coordinate(ky, lane, oy) - z * ray.shear[1];
        let x = M::Four::widen(x.to_array());
        let y = M::Four::widen(y.to_array());
        // Products of two numbers of single precision are exact.
        (x.turned_back() * y.turned() - y.turned_back() * x.turned(), M::Four::widen(z.to_array()))
    }

    /// The exact test of one triangle.
    #[inline(always)]
    pub(crate) fn meet<M: Machine>(&self, lane: usize, ray: &PreparedRay) -> Option<Meeting> {
        let (meeting, met) = self.meet_evenly::<M>(lane, ray);
        met.then_some(meeting)
    }

    /// The same without branches: the hit, and whether there is one.
    #[inline(always)]
    pub(crate) fn meet_evenly<M: Machine>(&self, lane: usize, ray: &PreparedRay) -> (Meeting, bool) {
        let (edges, z) = self.edges::<M>(lane, &ray.turned);
        let none = M::Four::splat(0.0);
        let determinant = sum(edges.store());
        // All zero: edge-on, left to the neighbours. NaN: coordinates beyond the range of f32.
        let apart = (edges.below(none) & 7 != 0) & (none.below(edges) & 7 != 0);
        let flat = (determinant == 0.0) | determinant.is_nan();
        let meeting = weighted::<M>(edges, z, determinant, &ray.turned);
        (meeting, !(apart | flat) & (meeting.t > ray.t_min) & (meeting.t < ray.t_max))
    }

    /// [`TriangleBlock::meet`] of a triangle that is hit for sure.
    #[inline(always)]
    pub(crate) fn meet_surely<M: Machine>(&self, lane: usize, ray: &TurnedRay) -> Meeting {
        let (edges, z) = self.edges::<M>(lane, ray);
        weighted::<M>(edges, z, sum(edges.store()), ray)
    }
}

/// The sum of the first three.
#[inline(always)]
fn sum([a, b, c, _]: [f64; 4]) -> f64 {
    a + b + c
}

/// Where a ray meets the plane of a triangle, from the edge functions, their sum, and the corners' main coordinates.
#[inline(always)]
fn weighted<M: Machine>(edges: M::Four, z: M::Four, determinant: f64, ray: &TurnedRay) -> Meeting {
    let [_, v, w, _] = edges.store();
    let t = sum((edges * z).store());
    let above = M::Four::load(&[t, v, w, 1.0]);
    let below = M::Four::load(&[determinant * f64::from(ray.pace), determinant, determinant, 1.0]);
    let [t, u, v, _] = (above / below).store();
    Meeting { t: t as f32, u: u as f32, v: v as f32 }
}

/// On which sides of a ray the edges of a block's triangles lie.
struct Sides<M: Machine> {
    /// Corners relative to the ray.
    corners: [[M::Eight; 3]; 3],
    /// Edge functions …
    edges: [M::Eight; 3],
    /// … the least …
    least: M::Eight,
    /// … and the largest of the three.
    most: M::Eight,
    /// Those that may be hit, as bits.
    met: u32,
}

impl<M: Machine> Sides<M> {
    /// Where along the ray the corners lie.
    #[inline(always)]
    fn range(&self, ray: &TurnedRay) -> Range<M> {
        let [[.., az], [.., bz], [.., cz]] = self.corners;
        let pace = M::Eight::splat(ray.inverse_pace);
        let (a, b, c) = (az.times(pace), bz.times(pace), cz.times(pace));
        Range { corners: [a, b, c], near: c.smaller(a.smaller(b)), far: c.larger(a.larger(b)) }
    }
}

/// Where along a ray the triangles of a block lie.
struct Range<M: Machine> {
    /// Their corners.
    corners: [M::Eight; 3],
    near: M::Eight,
    far: M::Eight,
}

impl<M: Machine> Range<M> {
    /// The triangles of which a part is before `limit` and not behind the ray, as bits, which hits have to be: they are a
    /// mean of the corners. NaN rejects none.
    #[inline(always)]
    fn reaches(&self, ray: &TurnedRay, limit: f32) -> u32 {
        !(M::Eight::splat(range_end(limit)).below(self.near) | self.far.below(M::Eight::splat(ray.behind)))
    }
}

/// Corners beyond this are no part of a hit before `limit`, whatever rounding does.
#[inline(always)]
pub(crate) fn range_end(limit: f32) -> f32 {
    let limit = if limit > 0.0 { limit } else { 0.0 };
    limit + (limit * SLACK + f32::MIN_POSITIVE)
}

/// What single precision tells about the triangles of a block.
pub(crate) struct Span<M: Machine> {
    /// Those that may be hit, as bits: exactly those, but for edges met to the last digit and numbers out of range.
    pub(crate) met: u32,
    /// Those that are hit for sure, at whatever distance.
    pub(crate) sure: u32,
    /// Hits are no nearer than this, if it is above 0 …
    pub(crate) from: M::Eight,
    /// … and no farther than this, if `from` has all its digits.
    pub(crate) to: M::Eight,
}

/// More than the roundings of the corners' distances and of their mean, as a share of the largest.
const SLACK: f32 = 1.0 / (1u32 << 20) as f32;
/// Three edge functions, each off by at most four roundings of a product of the largest coordinates, may move the mean by
/// 12 · 2⁻²⁴ of the corners' distance range times that product over the sum of the edge functions; with a margin.
const WEIGHT_SLACK: f32 = 1.0 / (1u32 << 19) as f32;
/// Sums of edge functions below this one may have lost digits.
const TINY: f32 = 1.0 / (1u64 << 60) as f32;
/// More than what underflow can change in a distance.
const UNDERFLOW: f32 = 1.0 / ((1u128 << 80) as f32);
