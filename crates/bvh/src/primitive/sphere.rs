//! Spheres.

use super::{Key, Meeting, Meetings, difference, dot, load, rounded_out, scaled, splat, sum, wide};
use crate::lanes::Lanes;
use crate::{Sphere, prepared::Line};
use penombre_math::Bounds3;

/// `N` spheres, one a lane, tested together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spheres<const N: usize> {
    /// Rows x, y, z.
    center: [[f64; N]; 3],
    /// Square of the radius, exact.
    square: [f64; N],
}

impl<const N: usize> Spheres<N> {
    /// Spheres that no ray hits.
    pub(crate) const NONE: Self = Self { center: [[0.0; N]; 3], square: [f64::NEG_INFINITY; N] };

    pub(crate) fn set(&mut self, lane: usize, sphere: &SphereRecord) {
        for (row, [x]) in self.center.iter_mut().zip(sphere.lanes.center) {
            row[lane] = x;
        }
        self.square[lane] = sphere.lanes.square[0];
    }

    /// The nearest intersections in range. All in `f64`; the discriminant comes from the distance of the line
    /// to the centre, which stays accurate far away, and the smaller root from the product of both
    /// (\[Haines2019\]).
    #[inline(always)]
    pub(crate) fn meet<V: Lanes<N>>(&self, line: &Line) -> Meetings<N> {
        let zero = V::splat(0.0);
        let dir: [V; 3] = splat(line.dir);
        let square = V::load(&self.square);
        let from_center = difference(splat(line.origin), load(&self.center));
        let a = V::splat(dot(line.dir, line.dir));
        let b = -dot(from_center, dir);
        let nearest = sum(from_center, scaled(dir, b / a));
        let quarter_chord = square - dot(nearest, nearest);
        let crossed = zero.at_most(quarter_chord);
        if crossed == 0 {
            return Meetings::NONE;
        }
        let c = dot(from_center, from_center) - square;
        let q = b + (a * quarter_chord).sqrt().copysign(b);
        let (t0, t1) = ((c / q).narrow(), (q / a).narrow());
        // Rounding keeps the order.
        let (first, second) = (t0.smaller(t1), t0.larger(t1));
        let (holds_first, holds_second) = (line.holds(first), line.holds(second));
        let (first, second) = (first.store(), second.store());
        let t = std::array::from_fn(|i| if holds_first >> i & 1 == 1 { first[i] } else { second[i] });
        Meetings { open: crossed & (holds_first | holds_second), t, ..Meetings::NONE }
    }
}

/// A sphere that can be hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereRecord {
    lanes: Spheres<1>,
    pub(crate) key: Key,
}

impl SphereRecord {
    pub(crate) fn new(sphere: &Sphere, key: Key) -> Self {
        let radius = f64::from(sphere.radius);
        let lanes = Spheres { center: wide(sphere.center).map(|x| [x]), square: [radius * radius] };
        Self { lanes, key }
    }

    /// The box, `None` for a sphere that cannot be hit.
    pub(crate) fn bounds(sphere: &Sphere) -> Option<Bounds3> {
        let (c, r) = (wide(sphere.center), f64::from(sphere.radius));
        if r > 0.0 { rounded_out(c.map(|x| x - r), c.map(|x| x + r)) } else { None }
    }

    #[inline(always)]
    pub(crate) fn meet(&self, line: &Line) -> Option<Meeting> {
        let meetings = self.lanes.meet::<f64>(line);
        (meetings.open != 0).then(|| meetings.at(0))
    }
}
