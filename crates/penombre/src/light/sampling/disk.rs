//! Directions to disks.

use super::flat::slack;
use super::{DirectionSample, DirectionSampler, inside_unit_square, sample_at, unit_circle};
use penombre_math::{DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// A disk seen from a point.
///
/// The directions to it fill an elliptic cone. Its trace on the unit sphere, projected along the axis of the cone
/// onto the plane across it, is an ellipse with the sines of the half angles as semi-axes \[Guillen2017\]. Points
/// uniform in the ellipse give directions with the density cos θ/(π·sin α·sin β), θ from the axis: exact, without
/// the elliptic integrals of a uniform density. From afar it is uniform in solid angle; close to the disk its
/// inverse grows with 1/cos θ towards the rim only, where that of sampling by area grows with the inverse square of
/// the distance towards the foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalDisk {
    reference: DVec3,
    to_center: DVec3,
    /// Not below the distance of any point of the disk.
    farthest: f64,
    /// Axes of the ellipse, unit: across the plane of symmetry, in it, along the axis of the cone.
    axes: [DVec3; 3],
    /// Sines of the half angles along the first two axes, in (0, 1].
    sines: [f64; 2],
    normal: DVec3,
    /// From the reference point to the plane along the normal: below 0 if the point is in front.
    height: f64,
    /// 1/(π·sin α·sin β)
    scale: f64,
}

impl SphericalDisk {
    /// The disk seen from `reference`; the normal is a unit vector. `None` if the radius is not above 0, the plane
    /// goes through that point, or the disk is so far away that its solid angle is below about 10⁻³⁸ sr.
    pub fn new(reference: Vec3, center: Vec3, normal: Vec3, radius: f32) -> Option<Self> {
        let reference = reference.as_dvec3();
        let to_center = center.as_dvec3() - reference;
        let normal = normal.as_dvec3().try_normalize()?;
        let height = to_center.dot(normal);
        let (h, a) = (height.abs(), f64::from(radius));
        let farthest = to_center.length() + a;
        if !(a > 0.0 && h > slack(reference, center.as_dvec3(), normal) && (farthest as f32).is_finite()) {
            return None;
        }
        // In the plane of symmetry: y along the disk towards its centre, z along the normal away from the point.
        let ahead = normal * height.signum();
        let beside = to_center - normal * height;
        let along = beside.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        let middle = beside.length();
        let (near, far) = (middle - a, middle + a);
        let lengths = [near, far].map(|y| (y * y + h * h).sqrt());
        // The axis halves the angle between the directions to both ends.
        let y = near / lengths[0] + far / lengths[1];
        let z = h / lengths[0] + h / lengths[1];
        let length = (y * y + z * z).sqrt();
        let (y, z) = (y / length, z / length);
        let sine = half_sine(
            (near * far + h * h) / (lengths[0] * lengths[1]),
            2.0 * a * h / (lengths[0] * lengths[1]),
        );
        // Across: half of the chord through the point where the axis meets the disk, over its distance.
        let (meets, reach) = (h * y / z, h / z);
        let half_chord = ((far - meets) * (meets - near)).max(0.0);
        let across = (half_chord / (half_chord + reach * reach)).sqrt();
        let scale = 1.0 / (PI * across * sine);
        let sound = scale > 0.0 && (scale as f32).is_finite();
        let cone = along * y + ahead * z;
        let axes = [along.cross(ahead), ahead * y - along * z, cone];
        sound.then_some(Self {
            reference,
            to_center,
            farthest,
            axes,
            sines: [across, sine],
            normal,
            height,
            scale,
        })
    }

    /// True if the reference point is on the side of the normal.
    pub fn is_in_front(&self) -> bool {
        self.height < 0.0
    }
}

/// sin(γ/2) from cosine and sine of γ ∈ (0, π).
fn half_sine(cos: f64, sin: f64) -> f64 {
    // sin² (γ/2) = (1 − cos)/2, where 1 − cos = sin²/(1 + cos).
    if cos > 0.0 { sin / (2.0 * (1.0 + cos)).sqrt() } else { ((1.0 - cos) / 2.0).sqrt() }
}

impl DirectionSampler for SphericalDisk {
    fn sample(&self, u: Vec2) -> DirectionSample {
        let u = inside_unit_square(u);
        let radius = u.x.sqrt();
        let (s, c) = unit_circle(TAU * u.y);
        let (x, y) = (self.sines[0] * radius * c, self.sines[1] * radius * s);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let wi = self.axes[0] * x + self.axes[1] * y + self.axes[2] * z;
        let t = self.height / wi.dot(self.normal);
        // A direction that rounding made parallel to the plane: the disk is seen edge-on.
        let to = if t > 0.0 && t <= self.farthest { wi * t } else { self.to_center };
        let sample = sample_at(self.reference, to);
        DirectionSample { pdf: self.pdf_of_hit(sample.wi, sample.distance), ..sample }
    }

    fn pdf_of_hit(&self, wi: Vec3, _: f32) -> f32 {
        (wi.as_dvec3().dot(self.axes[2]).max(0.0) * self.scale) as f32
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let direction = wi.as_dvec3();
        let x = direction.dot(self.axes[0]) / self.sines[0];
        let y = direction.dot(self.axes[1]) / self.sines[1];
        if x * x + y * y <= 1.0 { self.pdf_of_hit(wi, 0.0) } else { 0.0 }
    }
}
