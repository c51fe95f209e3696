//! Affine transforms that carry their inverse.

use crate::{Bounds3, rounding::gamma};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec3};

/// An invertible affine map with its inverse, both rounded once from double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    forward: Affine3A,
    inverse: Affine3A,
    flips_handedness: bool,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The map that moves nothing.
    pub const IDENTITY: Self =
        Self { forward: Affine3A::IDENTITY, inverse: Affine3A::IDENTITY, flips_handedness: false };

    /// Rounds `map` and its double-precision inverse. `None` if the map is singular, not finite, or so
    /// extreme that it or its inverse overflows an `f32`.
    pub fn new(map: DAffine3) -> Option<Self> {
        let determinant = map.matrix3.determinant();
        if !map.is_finite() || determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let inverse = map.inverse();
        let (forward, inverse) = (map.as_affine3a(), inverse.as_affine3a());
        // Rounding may make a nearly singular map singular, or turn it over. Products of `f32` entries fit a
        // double.
        let rounded = |m: Mat3A| DMat3::from_cols_array(&m.to_cols_array().map(f64::from)).determinant();
        let faithful =
            rounded(forward.matrix3) * determinant > 0.0 && rounded(inverse.matrix3) * determinant > 0.0;
        let usable = forward.is_finite() && inverse.is_finite() && faithful;
        usable.then_some(Self { forward, inverse, flips_handedness: determinant < 0.0 })
    }

    /// A translation.
    pub fn translation(by: DVec3) -> Option<Self> {
        Self::new(DAffine3::from_translation(by))
    }

    /// The map from the target space back.
    pub fn inverse(&self) -> Self {
        Self { forward: self.inverse, inverse: self.forward, flips_handedness: self.flips_handedness }
    }

    /// True if nothing moves.
    pub fn is_identity(&self) -> bool {
        self.forward == Affine3A::IDENTITY
    }

    /// True if the map turns right-handed frames into left-handed ones (a mirroring).
    pub fn flips_handedness(&self) -> bool {
        self.flips_handedness
    }

    /// The image of a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.forward.transform_point3(p)
    }

    /// The image of a vector (a difference of points).
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.forward.transform_vector3(v)
    }

    /// The direction of the image of a normal, *not* normalised: multiplied by the inverse transpose.
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let m: Mat3A = self.inverse.matrix3;
        Vec3::new(Vec3::from(m.x_axis).dot(n), Vec3::from(m.y_axis).dot(n), Vec3::from(m.z_axis).dot(n))
    }

    /// The image of a point and a bound on its absolute error per axis, given the bound `error` on that of
    /// `p` (\[PBRT4\], 6.8.5).
    pub fn point_with_error(&self, p: Vec3, error: Vec3) -> (Vec3, Vec3) {
        let m = self.forward.matrix3.abs();
        let rows = |v: Vec3| Vec3::from(m.x_axis * v.x + m.y_axis * v.y + m.z_axis * v.z);
        let translation = Vec3::from(self.forward.translation).abs();
        // A product goes through four roundings: its own and three sums.
        let bound = rows(error) * (1.0 + gamma(4)) + (rows(p.abs()) + translation) * gamma(4);
        (self.point(p), bound)
    }

    /// A box around the image of a box: it holds the exact image of every point and every computed one. A few
    /// ulps larger than the tightest, except for the identity. A box that is not finite may become empty.
    pub fn bounds(&self, b: &Bounds3) -> Bounds3 {
        if b.is_empty() || self.is_identity() {
            return if b.is_empty() { Bounds3::EMPTY } else { *b };
        }
        let images = b.corners().map(|c| self.point_with_error(c, Vec3::ZERO));
        let tight = Bounds3::of_points(images.map(|(image, _)| image));
        // Errors inside are at most those of the worst corner. Twice that also covers the rounding of the
        // sums here.
        let slack = images.iter().fold(Vec3::ZERO, |worst, (_, error)| error.max(worst)) * 2.0;
        Bounds3 { min: tight.min - slack, max: tight.max + slack }
    }
}

#[cfg(test)]
mod tests;
