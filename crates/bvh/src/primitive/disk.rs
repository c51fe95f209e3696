//! Disks.

use super::{Key, Meeting, difference, dot, rounded_out, scaled, sum, wide};
use crate::{Disk, prepared::Line};
use penombre_math::{Bounds3, Vec3};

/// A disk that can be hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiskRecord {
    center: Vec3,
    radius: f32,
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
            center: disk.center,
            radius: disk.radius,
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
    pub(crate) fn meet(&self, line: &Line) -> Option<Meeting> {
        let from_center = difference(line.origin, wide(self.center));
        let distance = -dot(self.normal, from_center) / dot(self.normal, line.dir);
        let t = line.in_range(distance)?;
        let place = sum(from_center, scaled(line.dir, distance));
        let radius = f64::from(self.radius);
        (dot(place, place) <= radius * radius).then_some(Meeting { t, u: 0.0, v: 0.0 })
    }
}
