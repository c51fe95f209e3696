//! Primitives that the crate does not know.

use crate::Ray;
use penombre_math::Bounds3;
use std::fmt::Debug;

/// A list of primitives of the caller's making: curves, height fields, distance fields, sets of points. For
/// [`Geometry::User`](crate::Geometry::User).
///
/// All answers must be the same every time, from any thread. Wrong ones harm nobody, but then hits may be missed, and
/// depend on the shape of the hierarchy.
///
/// ```
/// use penombre_bvh::{BuildOptions, Bvh, Geometry, Ray, UserHit, UserPrimitives};
/// use penombre_math::{Bounds3, Vec3};
/// use std::sync::Arc;
///
/// /// Upright cylinders without caps: x and z of the axis, radius. Height from 0 to 1.
/// #[derive(Debug)]
/// struct Columns(Vec<(f32, f32, f32)>);
///
/// impl UserPrimitives for Columns {
///     fn len(&self) -> usize {
///         self.0.len()
///     }
///
///     fn bounds(&self, index: usize) -> Option<Bounds3> {
///         let (x, z, radius) = self.0[index];
///         // A margin for the roundings below.
///         let radius = radius * 1.0001;
///         Some(Bounds3 {
///             min: Vec3::new(x - radius, -0.0001, z - radius),
///             max: Vec3::new(x + radius, 1.0001, z + radius),
///         })
///     }
///
///     fn intersect(&self, index: usize, ray: &Ray) -> Option<UserHit> {
///         let (x, z, radius) = self.0[index];
///         let (ox, oz) = (f64::from(ray.origin.x - x), f64::from(ray.origin.z - z));
///         let (dx, dz) = (f64::from(ray.dir.x), f64::from(ray.dir.z));
///         let (a, b) = (dx * dx + dz * dz, ox * dx + oz * dz);
///         let root = (b * b - a * (ox * ox + oz * oz - f64::from(radius).powi(2))).sqrt();
///         // Both walls, the near one first. Beside the column the root is NaN, which is in no range.
///         let walls = [(-b - root) / a, (-b + root) / a].map(|t| t as f32);
///         let on_it = |t: f32| ray.t_min < t && t < ray.t_max && (0.0..=1.0).contains(&ray.at(t).y);
///         let t = walls.into_iter().find(|&t| on_it(t))?;
///         Some(UserHit { t, u: ray.at(t).y, v: 0.0 })
///     }
/// }
///
/// let columns = Columns((0..100).map(|i| (i as f32, 0.0, 0.25)).collect());
/// let bvh = Bvh::build(vec![Geometry::User(Arc::new(columns))], &BuildOptions::default())?;
/// let hit = bvh.closest(&Ray::new(Vec3::new(7.0, 0.5, 3.0), -Vec3::Z, 0.0, f32::INFINITY));
/// assert_eq!((hit.prim, hit.t, hit.u), (7, 2.75, 0.5));
/// # Ok::<(), penombre_bvh::BuildError>(())
/// ```
pub trait UserPrimitives: Send + Sync + Debug {
    /// How many there are.
    fn len(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A box that holds all points `ray.at(t)` that [`intersect`](Self::intersect) may report, as it computes them: where
    /// it rounds, the box needs a margin of as much. Rounding `t` itself to `f32` is allowed for. Primitives without a
    /// box, or with one that is empty or not finite, are skipped and counted in
    /// [`Stats::skipped`](crate::Stats::skipped).
    fn bounds(&self, index: usize) -> Option<Bounds3>;

    /// The nearest hit of the ray with one primitive.
    ///
    /// The ray is given in the space of the hierarchy that was built from the list: in local space inside an instance. Its
    /// direction has any length, and negligible components of it are 0. A hit counts if `ray.t_min < t` and `t <
    /// ray.t_max`, and no number of it is NaN; others are ignored.
    ///
    /// May be asked about rays that miss the box. Where a [`Filter`](crate::Filter) refused a hit, it is asked for the
    /// next one, with the `t` of that as `t_min`; the same crossing, found once more a little farther on, would be
    /// taken for another.
    fn intersect(&self, index: usize, ray: &Ray) -> Option<UserHit>;
}

/// What [`UserPrimitives::intersect`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserHit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Becomes [`Hit::u`](crate::Hit::u); of any meaning.
    pub u: f32,
    /// Becomes [`Hit::v`](crate::Hit::v); of any meaning.
    pub v: f32,
}
