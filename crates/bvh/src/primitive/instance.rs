//! Placed hierarchies.

use super::{abs_sum, dot, rounded_out, sum};
use crate::{Bvh, Instance, Ray, prepared::PreparedRay};
use penombre_math::{Bounds3, DAffine3, DMat3, DVec3, Transform, Vec3};
use std::sync::Arc;

/// A nested hierarchy and the way into its space.
#[derive(Clone, Debug)]
pub(crate) struct InstanceRecord {
    pub(crate) bvh: Arc<Bvh>,
    /// Rows of the linear part of the map into local space, then its translation.
    rows: [[f64; 3]; 3],
    translation: [f64; 3],
    /// Index in the top-level list.
    pub(crate) index: u32,
    /// Allowance of boxes, as a share of the distance to their farthest corner.
    pub(crate) aside: f64,
    pub(crate) bounds: Bounds3,
}

impl InstanceRecord {
    /// `None` if there is nothing to hit, or its place is beyond the range of `f32`.
    pub(crate) fn new(instance: &Instance, index: u32) -> Option<Self> {
        let local = instance.bvh.bounds();
        if local.is_empty() {
            return None;
        }
        // The rounded map into local space is the truth; the way back is inverted from it, not from the other
        // one.
        let to_local = affine(&instance.to_world.inverse());
        let to_world = to_local.inverse();
        let world = world_bounds(&to_local, &to_world, &local)?;
        let linear = to_local.matrix3;
        let stretch = norm(&linear) * norm(&to_world.matrix3);
        let rows = std::array::from_fn(|r| linear.row(r).to_array());
        Some(Self {
            bvh: Arc::clone(&instance.bvh),
            rows,
            translation: to_local.translation.to_array(),
            index,
            aside: stretch * (LOCAL_ROUNDINGS * UNIT_ROUNDOFF + f64::from(instance.bvh.aside())),
            bounds: world,
        })
    }

    /// The ray in local space: the same distances along an unnormalised direction. Computed in `f64`, rounded
    /// once.
    #[inline(always)]
    pub(crate) fn local_ray(&self, ray: &PreparedRay) -> Option<PreparedRay> {
        let line = ray.line();
        let origin = sum(self.rows.map(|row| dot(row, line.origin)), self.translation);
        let dir = self.rows.map(|row| dot(row, line.dir));
        let narrow = |v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32));
        PreparedRay::new(&Ray::new(narrow(origin), narrow(dir), ray.t_min, ray.t_max), self.bvh.tree.extent)
    }
}

const UNIT_ROUNDOFF: f64 = 1.0 / (1u32 << 24) as f64;

/// Roundings to `f32` that a hit in local space may suffer, as shares of the distance to the farthest corner:
/// origin and direction 1 each, the triangle test 12 (its errors act along local axes), the rest is margin.
const LOCAL_ROUNDINGS: f64 = 32.0;

/// The exact entries of a transform.
fn affine(map: &Transform) -> DAffine3 {
    let column = |axis: Vec3| map.vector(axis).as_dvec3();
    DAffine3 {
        matrix3: DMat3::from_cols(column(Vec3::X), column(Vec3::Y), column(Vec3::Z)),
        translation: map.point(Vec3::ZERO).as_dvec3(),
    }
}

/// Largest sum of a row.
fn norm(m: &DMat3) -> f64 {
    (0..3).map(|r| abs_sum(m.row(r).to_array())).fold(0.0, f64::max)
}

/// The box of the image of `local`. It is widened by what does not shrink as the ray comes near: rounding the
/// local origin costs 2⁻²⁴ of the coordinates of the point hit, and cancellation in the `f64` transform 2⁻⁵⁰
/// of its terms.
fn world_bounds(to_local: &DAffine3, to_world: &DAffine3, local: &Bounds3) -> Option<Bounds3> {
    let corners = local.corners().map(|c| to_world.transform_point3(c.as_dvec3()));
    let min = corners.iter().fold(DVec3::INFINITY, |m, &c| m.min(c));
    let max = corners.iter().fold(DVec3::NEG_INFINITY, |m, &c| m.max(c));
    let terms = to_local.matrix3.abs() * min.abs().max(max.abs()) + to_local.translation.abs();
    let coordinates = local.min.abs().max(local.max.abs()).as_dvec3();
    let off = coordinates * (2.0 * UNIT_ROUNDOFF) + terms / (1u64 << 50) as f64;
    let pad = to_world.matrix3.abs() * off + DVec3::splat(f64::from(f32::MIN_POSITIVE));
    rounded_out((min - pad).to_array(), (max + pad).to_array())
}
