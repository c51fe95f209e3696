//! Primitives of the caller's making.

use super::{Key, Meeting};
use crate::{Ray, UserHit, UserPrimitives, prepared::PreparedRay};
use penombre_math::{Bounds3, Vec3};
use std::sync::Arc;

/// One of a list.
#[derive(Clone, Debug)]
pub(crate) struct UserRecord {
    list: Arc<dyn UserPrimitives>,
    pub(crate) key: Key,
}

impl UserRecord {
    pub(crate) fn new(list: &Arc<dyn UserPrimitives>, key: Key) -> Self {
        Self { list: Arc::clone(list), key }
    }

    /// The box, `None` for what cannot be hit.
    pub(crate) fn bounds(list: &dyn UserPrimitives, prim: usize) -> Option<Bounds3> {
        list.bounds(prim).filter(|bounds| bounds.is_finite() && !bounds.is_empty())
    }

    /// The nearest hit beyond `t_min`. Believes nothing.
    pub(crate) fn meet(&self, ray: &PreparedRay, t_min: f32) -> Option<Meeting> {
        let ray = Ray::new(Vec3::from(ray.origin), Vec3::from(ray.dir), t_min, ray.t_max);
        let UserHit { t, u, v } = self.list.intersect(self.key.prim as usize, &ray)?;
        let counts = ray.t_min < t && t < ray.t_max && !u.is_nan() && !v.is_nan();
        counts.then_some(Meeting { t, u, v })
    }
}
