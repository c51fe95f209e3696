//! Spheres.

use super::{Key, Meeting, Meetings, difference, dot, rounded_out, scaled, splat, sum, wide};
use crate::lanes::Lanes;
use crate::{Sphere, prepared::Line};
use penombre_math::Bounds3;

/// A sphere that can be hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereRecord {
    center: [f64; 3],
    /// Of the radius; exact.
    square: f64,
    pub(crate) key: Key,
}

impl SphereRecord {
    pub(crate) fn new(sphere: &Sphere, key: Key) -> Self {
        let radius = f64::from(sphere.radius);
        Self { center: wide(sphere.center), square: radius * radius, key }
    }

    /// The box, `None` for a sphere that cannot be hit.
    pub(crate) fn bounds(sphere: &Sphere) -> Option<Bounds3> {
        let (c, r) = (wide(sphere.center), f64::from(sphere.radius));
        if r > 0.0 { rounded_out(c.map(|x| x - r), c.map(|x| x + r)) } else { None }
    }

    /// The nearest intersection in range. All in `f64`; the discriminant comes from the distance of the line
    /// to the centre, which stays accurate far away, and the smaller root from the product of both
    /// (\[Haines2019\]).
    #[inline(always)]
    pub(crate) fn meet<const N: usize, V: Lanes<N>>(&self, line: &Line<V>) -> Meetings<N> {
        let square = V::splat(self.square);
        let from_center = difference(line.origin, splat(self.center));
        let a = dot(line.dir, line.dir);
        let b = -dot(from_center, line.dir);
        let nearest = sum(from_center, scaled(line.dir, b / a));
        let quarter_chord = square - dot(nearest, nearest);
        let crossed = V::splat(0.0).at_most(quarter_chord);
        if crossed == 0 {
            return Meetings::NONE;
        }
        let c = dot(from_center, from_center) - square;
        let q = b + (a * quarter_chord).sqrt().copysign(b);
        let (t0, t1) = (c / q, q / a);
        let (first, second) = (t0.smaller(t1).narrow(), t1.larger(t0).narrow());
        let (first_holds, second_holds) = (line.holds(first), line.holds(second));
        let (first, second) = (first.store(), second.store());
        let t = std::array::from_fn(|i| if first_holds >> i & 1 == 1 { first[i] } else { second[i] });
        Meetings::of(crossed & (first_holds | second_holds), t)
    }

    /// The intersection behind the nearest one.
    #[inline(always)]
    pub(crate) fn meet_behind(&self, line: Line, nearest: Option<Meeting>) -> Option<Meeting> {
        let t_min = f64::from(nearest?.t);
        self.meet(&Line { t_min, ..line }).single()
    }
}
