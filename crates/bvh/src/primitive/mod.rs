//! Tests of rays against single primitives. They decide alone what is hit: trees only save work.

mod disk;
mod instance;
mod quad;
mod sphere;
mod triangle;

pub(crate) use disk::DiskRecord;
pub(crate) use instance::InstanceRecord;
pub(crate) use quad::QuadRecord;
pub(crate) use sphere::SphereRecord;
pub(crate) use triangle::{BLOCK, TriangleBlock, has_area};

use crate::prepared::PreparedRay;
use penombre_math::{Bounds3, Vec3};

/// Geometry and primitive index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) geometry: u32,
    pub(crate) prim: u32,
}

/// A hit inside the ray's range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

impl PreparedRay {
    /// Rounds a distance; `Some` if it lies in the ray's range, which NaN does not.
    #[inline(always)]
    fn in_range(&self, t: f64) -> Option<f32> {
        let t = t as f32;
        (t > self.t_min && t < self.t_max).then_some(t)
    }
}

#[inline(always)]
fn wide(v: Vec3) -> [f64; 3] {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn scaled(a: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn abs_sum(a: [f64; 3]) -> f64 {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// The `f32` box around a box in double precision, `None` if it is not finite.
pub(crate) fn rounded_out(min: [f64; 3], max: [f64; 3]) -> Option<Bounds3> {
    let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
    let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
    let bounds = Bounds3 { min: Vec3::from_array(min.map(down)), max: Vec3::from_array(max.map(up)) };
    bounds.is_finite().then_some(bounds)
}
