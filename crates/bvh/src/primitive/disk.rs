//! Disks.

use super::{Key, Meetings, difference, dot, rounded_out, scaled, splat, sum, wide};
use crate::lanes::Lanes;
use crate::{Disk, prepared::Line};
use penombre_math::Bounds3;

/// A disk that can be hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiskRecord {
    center: [f64; 3],
    /// Of the radius; exact.
    square: f64,
    /// Unit length.
    normal: [f64; 3],
    pub(crate) key: Key,
}

impl DiskRecord {
    /// `None` if it has no normal, no radius, or is not finite.
    pub(crate) fn new(disk: &Disk, key: Key) -> Option<Self> {
        let normal = wide(disk.normal);
        let length = dot(normal, normal).sqrt();
        let usable = disk.center.is_finite()
            && length > 0.0
            && length.is_finite()
            && disk.radius > 0.0
            && disk.radius.is_finite();
        usable.then(|| Self {
            center: wide(disk.center),
            square: f64::from(disk.radius) * f64::from(disk.radius),
            normal: scaled(normal, 1.0 / length),
            key,
        })
    }

    /// The box, `None` for a disk that cannot be hit.
    pub(crate) fn bounds(disk: &Disk) -> Option<Bounds3> {
        let n = Self::new(disk, Key { geometry: 0, prim: 0 })?.normal;
        // From the other two components: 1 − n² would lose small tilts.
        let half: [f64; 3] = std::array::from_fn(|axis| {
            let (p, q) = (n[(axis + 1) % 3], n[(axis + 2) % 3]);
            f64::from(disk.radius) * (p * p + q * q).sqrt()
        });
        let c = wide(disk.center);
        rounded_out(difference(c, half), sum(c, half))
    }

    #[inline(always)]
    pub(crate) fn meet<const N: usize, V: Lanes<N>>(&self, line: &Line<V>) -> Meetings<N> {
        let normal = splat(self.normal);
        let from_center = difference(line.origin, splat(self.center));
        let distance = -dot(normal, from_center) / dot(normal, line.dir);
        let t = distance.narrow();
        let place = sum(from_center, scaled(line.dir, distance));
        let inside = dot(place, place).at_most(V::splat(self.square));
        Meetings::of(line.holds(t) & inside, t.store())
    }
}
