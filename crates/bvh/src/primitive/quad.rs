//! Parallelograms.
//!
//! Walls of a room are given by corners and sides rounded to `f32`, so even parallelograms meant to share an
//! edge leave gaps of an ulp. Edges are therefore extended by two ulps of the largest corner coordinate.

use super::{Key, Meetings, abs_sum, cross, difference, dot, rounded_out, scaled, splat, sum, wide};
use crate::lanes::Lanes;
use crate::{Quad, prepared::Line};
use penombre_math::Bounds3;

/// Share of a length by which a computed point may be off in its plane: 2⁻⁵² a step, less than 16 steps.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// Share of the largest corner coordinate by which edges are extended: two ulps, 2⁻²³ each at most.
const EXTENSION: f64 = 1.0 / (1u64 << 22) as f64;

/// Rounding grows as the ray comes closer to the plane; beyond this factor (0.014°) it is not followed.
const STEEPEST: f64 = 4096.0;

/// A parallelogram that can be hit, with the plane and the two dual vectors that yield `u` and `v`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadRecord {
    origin: [f64; 3],
    /// Unit length.
    normal: [f64; 3],
    dual: [[f64; 3]; 2],
    /// Tolerance of `u` and `v` at the origin of the ray …
    slack: f64,
    /// … and what each unit of distance adds.
    slack_growth: f64,
    /// Largest length of a side times that of a dual vector (sums of components): 1 to 3, more if the sides
    /// lean.
    condition: f64,
    pub(crate) key: Key,
}

fn corners(quad: &Quad) -> [[f64; 3]; 4] {
    let (o, [s, t]) = (wide(quad.origin), quad.sides.map(wide));
    [o, sum(o, s), sum(o, t), sum(sum(o, s), t)]
}

impl QuadRecord {
    /// `None` if the sides are parallel or not finite.
    pub(crate) fn new(quad: &Quad, key: Key) -> Option<Self> {
        let sides = quad.sides.map(wide);
        let normal = cross(sides[0], sides[1]);
        let square = dot(normal, normal);
        if !(quad.origin.is_finite() && square > 0.0 && square < f64::INFINITY) {
            return None;
        }
        let dual =
            [scaled(cross(sides[1], normal), 1.0 / square), scaled(cross(normal, sides[0]), 1.0 / square)];
        let steepest = abs_sum(dual[0]).max(abs_sum(dual[1]));
        let size = abs_sum(sides[0]).max(abs_sum(sides[1]));
        let far = corners(quad).iter().flatten().fold(0f64, |far, x| far.max(x.abs()));
        Some(Self {
            origin: wide(quad.origin),
            condition: steepest * size,
            normal: scaled(normal, 1.0 / square.sqrt()),
            dual,
            slack: steepest * (EXTENSION * far + ROUNDING * size),
            slack_growth: ROUNDING * steepest,
            key,
        })
    }

    /// The box, `None` for a parallelogram that cannot be hit.
    pub(crate) fn bounds(quad: &Quad) -> Option<Bounds3> {
        let slack = Self::new(quad, Key { geometry: 0, prim: 0 })?.slack;
        let sides = quad.sides.map(wide);
        let corners = corners(quad);
        let pad: [f64; 3] = std::array::from_fn(|axis| slack * (sides[0][axis].abs() + sides[1][axis].abs()));
        let edge = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
            std::array::from_fn(|axis| corners.iter().fold(corners[0][axis], |e, c| pick(e, c[axis])))
        };
        rounded_out(difference(edge(f64::min), pad), sum(edge(f64::max), pad))
    }

    /// By how much an accepted point may lie beside the parallelogram, as a share of the distance between the
    /// ray's origin and the farthest corner of any box around it.
    pub(crate) fn aside(&self) -> f64 {
        // The distance to the far corner is at least half the sum of the sides' largest components, and at
        // least a third of any distance in the tolerance's sum of components; both sides may be exceeded.
        32.0 * ROUNDING * STEEPEST * self.condition.max(1.0)
    }

    /// Plane first, then `u` and `v`. The tolerances make neighbours overlap by their rounding errors, so
    /// that nothing leaks between them.
    #[inline(always)]
    pub(crate) fn meet<const N: usize, V: Lanes<N>>(&self, line: &Line<V>) -> Meetings<N> {
        let normal = splat(self.normal);
        let from_origin = difference(line.origin, splat(self.origin));
        let per_height = V::splat(1.0) / dot(normal, line.dir);
        let distance = -dot(normal, from_origin) * per_height;
        let t = distance.narrow();
        let ahead = line.holds(t);
        if ahead == 0 {
            return Meetings::NONE;
        }
        let place = sum(from_origin, scaled(line.dir, distance));
        let (u, v) = (dot(splat(self.dual[0]), place), dot(splat(self.dual[1]), place));
        let slope = (abs_sum(line.dir) * per_height.abs()).smaller(V::splat(STEEPEST));
        let slack = V::splat(self.slack) + V::splat(self.slack_growth) * abs_sum(from_origin) * slope;
        let (least, most) = (-slack, V::splat(1.0) + slack);
        let inside = least.at_most(u) & u.at_most(most) & least.at_most(v) & v.at_most(most);
        Meetings { open: ahead & inside, t: t.store(), u: unit(u).store(), v: unit(v).store() }
    }
}

/// Clamped to \[0, 1\].
#[inline(always)]
fn unit<const N: usize, V: Lanes<N>>(x: V) -> V {
    V::splat(1.0).smaller(V::splat(0.0).larger(x))
}
