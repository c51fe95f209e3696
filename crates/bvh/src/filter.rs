//! Hits that count and hits that do not.

use crate::{Hit, Ray};

/// Decides which hits count: for cut-outs (leaves whose texture has holes), ray masks, and surfaces that only some rays
/// see. Asked by [`Bvh::closest_where`](crate::Bvh::closest_where) and its siblings.
///
/// A hit that is refused does not exist: the answer is what it would be without that point of the surface. So a ray
/// that is refused where it enters a sphere may still hit it from within.
///
/// Closures are filters; the types of their arguments have to be written out:
///
/// ```
/// use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Quad, Ray};
/// use penombre_math::Vec3;
///
/// let at = |z| Quad { origin: Vec3::new(0.0, 0.0, z), sides: [Vec3::X, Vec3::Y] };
/// let bvh = Bvh::build(vec![Geometry::Quads(vec![at(0.0), at(-1.0)])], &BuildOptions::default())?;
///
/// // The one in front is a chessboard: every other square is a hole.
/// let solid = |_index: usize, _ray: &Ray, hit: &Hit| {
///     hit.prim != 0 || ((hit.u * 8.0) as u32 + (hit.v * 8.0) as u32).is_multiple_of(2)
/// };
/// let down = |x| Ray::new(Vec3::new(x, 0.01, 2.0), -Vec3::Z, 0.0, f32::INFINITY);
/// assert_eq!(bvh.closest_where(&down(0.01), &solid).t, 2.0);
/// assert_eq!(bvh.closest_where(&down(0.14), &solid).t, 3.0);
/// assert_eq!(bvh.closest(&down(0.14)).t, 2.0);
/// # Ok::<(), penombre_bvh::BuildError>(())
/// ```
pub trait Filter: Sync {
    /// Whether `hit` counts. `index` is the place of the ray in its batch, 0 for a single one; `ray` is that ray in the
    /// world, also for hits inside an instance; `hit` is complete.
    ///
    /// Must depend on the arguments only. It is asked, in any order, about hits that would be the answer as far as is
    /// known by then: not about all, and more than once about some, for parts of a long triangle lie in several places
    /// of the hierarchy.
    fn accepts(&self, index: usize, ray: &Ray, hit: &Hit) -> bool;
}

impl<F: Fn(usize, &Ray, &Hit) -> bool + Sync> Filter for F {
    fn accepts(&self, index: usize, ray: &Ray, hit: &Hit) -> bool {
        self(index, ray, hit)
    }
}

/// Rays see a geometry if their masks have a bit in common: a [`Filter`] for lights that are hidden from the camera,
/// shadows that one object does not cast, and layers of a scene.
///
/// ```
/// use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Masks, Ray, Sphere};
/// use penombre_math::Vec3;
///
/// let ball = |x| Geometry::Spheres(vec![Sphere { center: Vec3::X * x, radius: 1.0 }]);
/// let bvh = Bvh::build(vec![ball(5.0), ball(10.0)], &BuildOptions::default())?;
///
/// const CAMERA: u32 = 1;
/// const SHADOW: u32 = 2;
/// let ray = Ray::new(Vec3::ZERO, Vec3::X, 0.0, f32::INFINITY);
/// // The ball in front casts shadows, but the camera does not see it. The other one is not listed: all see it.
/// let masks = Masks { geometries: &[SHADOW], rays: &[CAMERA, SHADOW] };
/// let mut hits = [Hit::MISS; 2];
/// bvh.closest_batch_where(&[ray, ray], &masks, &mut hits);
/// assert_eq!([hits[0].t, hits[1].t], [9.0, 4.0]);
/// # Ok::<(), penombre_bvh::BuildError>(())
/// ```
///
/// To combine masks with something else, call [`Filter::accepts`] of both in a closure.
#[derive(Clone, Copy, Debug, Default)]
pub struct Masks<'a> {
    /// One for each geometry in the list that the hierarchy was built from; whatever an instance holds has the mask of the
    /// instance. Those that are missing at the end have all bits, further ones mean nothing.
    pub geometries: &'a [u32],
    /// One for each ray of the batch, or one for a single ray. Those that are missing at the end have all bits, further
    /// ones mean nothing.
    pub rays: &'a [u32],
}

impl Filter for Masks<'_> {
    fn accepts(&self, index: usize, _ray: &Ray, hit: &Hit) -> bool {
        let mask = |list: &[u32], place: usize| list.get(place).copied().unwrap_or(u32::MAX);
        mask(self.geometries, hit.top_geometry() as usize) & mask(self.rays, index) != 0
    }
}
