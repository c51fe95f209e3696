//! The watertight triangle test of \[Woop2013\], with exact signs.
//!
//! Vertices are taken relative to the origin and sheared so that the ray becomes the main axis. The three
//! edge functions then are differences of two products of `f32` numbers. Rounding is monotone, so an `f32`
//! edge function that is not 0 has the right sign; where it is 0 (or overflowed) the products are exact in
//! `f64`. `f32` therefore only serves to reject, many triangles at once; whatever remains is computed in
//! `f64`. So weights are accurate however thin the triangle is, and the distance is that of the point hit,
//! not of another point of an edge-on triangle.

use super::{Key, Meeting, cross, difference, wide};
use crate::lanes::{Eight, Machine};
use crate::prepared::PreparedRay;
use penombre_math::Vec3;

/// Triangles tested at once.
pub(crate) const BLOCK: usize = 8;

type Lanes = [f32; BLOCK];

/// Up to eight triangles of one leaf.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct TriangleBlock {
    /// By vertex, axis, triangle.
    vertices: [[Lanes; 3]; 3],
    geometry: [u32; BLOCK],
    prim: [u32; BLOCK],
    count: u32,
}

/// True if the corners are finite and not on one line.
pub(crate) fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(wide);
    let normal = cross(difference(b, a), difference(c, a));
    corners.iter().all(|v| v.is_finite()) && normal != [0.0; 3]
}

impl TriangleBlock {
    pub(crate) const EMPTY: Self = Self {
        vertices: [[[0.0; BLOCK]; 3]; 3],
        geometry: [u32::MAX; BLOCK],
        prim: [u32::MAX; BLOCK],
        count: 0,
    };

    /// Adds a triangle. The caller adds eight at most.
    pub(crate) fn push(&mut self, corners: [Vec3; 3], key: Key) {
        let lane = self.count as usize;
        for (vertex, corner) in corners.iter().enumerate() {
            for axis in 0..3 {
                self.vertices[vertex][axis][lane] = corner[axis];
            }
        }
        (self.geometry[lane], self.prim[lane]) = (key.geometry, key.prim);
        self.count += 1;
    }

    #[inline(always)]
    pub(crate) fn key(&self, lane: usize) -> Key {
        Key { geometry: self.geometry[lane], prim: self.prim[lane] }
    }

    /// How many triangles there are.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.count as usize
    }

    /// The minor coordinates of a corner of all triangles, relative to the ray.
    #[inline(always)]
    fn sheared<M: Machine>(&self, corner: usize, ray: &PreparedRay) -> (M::Eight, M::Eight) {
        let rows = &self.vertices[corner];
        let [kx, ky, kz] = ray.axes;
        let z = M::Eight::load(&rows[kz]).minus(M::Eight::splat(ray.origin[kz]));
        let x = M::Eight::load(&rows[kx]).minus(M::Eight::splat(ray.origin[kx]));
        let y = M::Eight::load(&rows[ky]).minus(M::Eight::splat(ray.origin[ky]));
        (x.minus(M::Eight::splat(ray.shear[0]).times(z)), y.minus(M::Eight::splat(ray.shear[1]).times(z)))
    }

    /// The triangles that the signs of the `f32` edge functions do not exclude, as bits.
    #[inline(always)]
    pub(crate) fn candidates<M: Machine>(&self, ray: &PreparedRay) -> u32 {
        let (ax, ay) = self.sheared::<M>(0, ray);
        let (bx, by) = self.sheared::<M>(1, ray);
        let (cx, cy) = self.sheared::<M>(2, ray);
        let u = cx.times(by).minus(cy.times(bx));
        let v = ax.times(cy).minus(ay.times(cx));
        let w = bx.times(ay).minus(by.times(ax));
        // Both are true signs if they are numbers; NaN leaves the triangle open.
        let (least, most) = (w.smaller(u.smaller(v)), w.larger(u.larger(v)));
        !least.around_zero(most) & ((1 << self.count) - 1)
    }

    /// The exact test of one triangle.
    #[inline(always)]
    pub(crate) fn meet(&self, lane: usize, ray: &PreparedRay) -> Option<Meeting> {
        let [kx, ky, kz] = ray.axes;
        let sheared = |vertex: usize| {
            let axes = &self.vertices[vertex];
            let z = axes[kz][lane] - ray.origin[kz];
            let x = (axes[kx][lane] - ray.origin[kx]) - ray.shear[0] * z;
            let y = (axes[ky][lane] - ray.origin[ky]) - ray.shear[1] * z;
            [f64::from(x), f64::from(y), f64::from(z)]
        };
        let [a, b, c] = [sheared(0), sheared(1), sheared(2)];
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        // All zero: edge-on, left to the neighbours. NaN: coordinates beyond the range of f32.
        if determinant == 0.0 || determinant.is_nan() {
            return None;
        }
        let t = ray.in_range((u * a[2] + v * b[2] + w * c[2]) / (determinant * f64::from(ray.dir[kz])))?;
        Some(Meeting { t, u: (v / determinant) as f32, v: (w / determinant) as f32 })
    }
}
