//! Tests of rays against single primitives. They decide alone what is hit: trees only save work.

mod disk;
mod instance;
mod quad;
mod sphere;
mod triangle;
mod user;

pub(crate) use disk::DiskRecord;
pub(crate) use instance::InstanceRecord;
pub(crate) use quad::QuadRecord;
pub(crate) use sphere::SphereRecord;
pub(crate) use triangle::{BLOCK, Span, TriangleBlock, has_area, range_end};
pub(crate) use user::UserRecord;

use crate::Hit;
use crate::kernel::item;
use crate::lanes::Lanes;
use crate::prepared::Line;
use penombre_math::{Bounds3, Vec3};
use std::ops::{Add, Mul, Sub};

/// Geometry and primitive index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) geometry: u32,
    pub(crate) prim: u32,
}

impl Key {
    /// From its number among all primitives; `starts` are those of the first ones of the geometries.
    #[inline(always)]
    pub(crate) fn numbered(number: u32, starts: &[u32]) -> Self {
        // Of geometries without primitives, which share their start, the last is taken, which has some.
        let geometry = match starts {
            [_] => 0,
            _ => starts.partition_point(|&start| start <= number) - 1,
        };
        Self { geometry: geometry as u32, prim: number - *item(starts, geometry) }
    }
}

/// A hit inside the ray's range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

impl Meeting {
    /// The whole hit.
    #[inline(always)]
    pub(crate) fn hit(self, key: Key, instance: u32) -> Hit {
        let (Self { t, u, v }, Key { geometry, prim }) = (self, key);
        Hit { t, u, v, geometry, prim, instance }
    }
}

impl<V> Line<V> {
    /// The distances that lie in the rays' ranges, as bits.
    #[inline(always)]
    fn holds<const N: usize>(&self, t: V) -> u32
    where
        V: Lanes<N>,
    {
        self.t_min.below(t) & t.below(self.t_max)
    }
}

/// Hits of `N` rays with one primitive.
pub(crate) struct Meetings<const N: usize> {
    /// The rays that hit, as bits; the numbers of others mean nothing.
    pub(crate) open: u32,
    t: [f64; N],
    u: [f64; N],
    v: [f64; N],
}

impl Meetings<1> {
    #[inline(always)]
    pub(crate) fn single(&self) -> Option<Meeting> {
        (self.open != 0).then(|| self.at(0))
    }
}

impl<const N: usize> Meetings<N> {
    const NONE: Self = Self { open: 0, t: [0.0; N], u: [0.0; N], v: [0.0; N] };

    /// Hits without coordinates.
    #[inline(always)]
    fn of(open: u32, t: [f64; N]) -> Self {
        Self { open, t, ..Self::NONE }
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Meeting {
        Meeting { t: self.t[lane] as f32, u: self.u[lane] as f32, v: self.v[lane] as f32 }
    }
}

/// Numbers with which vectors are computed: one or several at once.
trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V>> Number for V {}

#[inline(always)]
fn wide(v: Vec3) -> [f64; 3] {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

#[inline(always)]
fn splat<const N: usize, V: Lanes<N>>(v: [f64; 3]) -> [V; 3] {
    [V::splat(v[0]), V::splat(v[1]), V::splat(v[2])]
}

#[inline(always)]
fn dot<V: Number>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn scaled<V: Number>(a: [V; 3], s: V) -> [V; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
fn sum<V: Number>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn difference<V: Number>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn abs_sum<const N: usize, V: Lanes<N>>(a: [V; 3]) -> V {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// The `f32` box around a box in double precision, `None` if it is not finite.
pub(crate) fn rounded_out(min: [f64; 3], max: [f64; 3]) -> Option<Bounds3> {
    let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
    let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
    let bounds = Bounds3 { min: Vec3::from_array(min.map(down)), max: Vec3::from_array(max.map(up)) };
    bounds.is_finite().then_some(bounds)
}
