//! Orthonormal frames.

use glam::Vec3;

/// A right-handed orthonormal frame; local vectors have the normal at +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// World direction of local x.
    pub x: Vec3,
    /// World direction of local y.
    pub y: Vec3,
    /// World direction of local z, the normal.
    pub z: Vec3,
}

impl Frame {
    /// A frame around the unit vector `z`, without branches on its direction except for the sign of `z.z`
    /// (\[Duff2017\]).
    pub fn from_z(z: Vec3) -> Self {
        let sign = 1.0f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// World to local.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Local to world.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f32};

    fn directions() -> impl Iterator<Item = Vec3> {
        let poles = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z, Vec3::new(1.0, 0.0, -0.0)];
        let near_pole = (1..40).map(|i| Vec3::new(2f32.powi(-i), -(2f32.powi(-i)), -1.0).normalize());
        let random = (0..10_000).map(|i| {
            let number = |k| unit_f32(combine(i, k)) - 0.5;
            Vec3::new(number(0), number(1), number(2)).normalize()
        });
        poles.into_iter().chain(near_pole).chain(random)
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for z in directions() {
            let f = Frame::from_z(z);
            assert_eq!(f.z, z);
            for (a, b, dot) in
                [(f.x, f.x, 1.0), (f.y, f.y, 1.0), (f.x, f.y, 0.0), (f.x, f.z, 0.0), (f.y, f.z, 0.0)]
            {
                assert!((a.dot(b) - dot).abs() < 1e-6, "{z}: {f:?}");
            }
            assert!((f.x.cross(f.y) - f.z).length() < 1e-6, "{z}: {f:?}");
        }
    }

    #[test]
    fn world_and_local_are_inverse() {
        for z in directions() {
            let f = Frame::from_z(z);
            let v = Vec3::new(0.3, -0.8, 1.7);
            assert!((f.to_world(f.to_local(v)) - v).length() < 2e-6);
            assert!((f.to_local(z) - Vec3::Z).length() < 1e-6, "the normal is local +z");
        }
    }
}
