//! Shadow rays to points of lights.

use crate::light::{AnyLight, LightSample};
use crate::sampler::{self, Series};
use crate::scene::{Departure, Scene};
use penombre_bvh::Ray;
use penombre_math::rounding::gamma;
use penombre_math::{Vec2, Vec3};
use penombre_sys::{Vectorizable, vectorize};

/// A shadow ray to a light without a surface ends this share of its length before it, so that one that lies in a surface is
/// not hidden by that surface's rounding. No bound of an error: that would depend on the angle at which the surface is met.
const LIGHT_SLACK: f32 = 1e-5;

/// The ray from a surface to a point of a light. Its parameter runs from 0 at the surface to 1 at the light.
#[inline(always)]
pub fn shadow_ray(departure: &Departure, light: Vec3) -> Ray {
    shadow_ray_from(departure.origin(light), light)
}

/// The same from an origin that has left the surface.
#[inline(always)]
pub fn shadow_ray_from(origin: Vec3, light: Vec3) -> Ray {
    Ray::new(origin, light - origin, 0.0, 1.0 - LIGHT_SLACK)
}

/// The ray to a sampled point of a light, which the light's own surface does not stop.
#[inline(always)]
pub fn shadow_ray_to(origin: Vec3, light: &LightSample) -> Ray {
    if light.normal == Vec3::ZERO {
        shadow_ray_from(origin, light.point)
    } else {
        ray_before(origin, light.point, light.p_error(), light.normal)
    }
}

/// The ray to a point of a surface, which ends before that surface: `p_error` bounds per axis how far the point lies off it,
/// `normal` is its geometric normal (unit).
///
/// With the end e and the exact way e − o, the direction is d = (e − o)(1 + δ) per axis, |δ| ≤ u, the unit roundoff. The
/// surface, n·(x − p) = 0, is met at t < 1 only if n·(e − p) ≤ n·(e − o − t·d) ≤ u·|n|·|e − o|, since n·d < 0; hits are
/// computed in double precision and rounded once, which does not take them below 1. So e has to stand off by the error of
/// p, u·|e − o|, and u·|e| for the rounding of e; twice that covers the roundings of the bound itself (\[PBRT4\], 6.8.6).
#[inline(always)]
pub fn ray_before(origin: Vec3, p: Vec3, p_error: Vec3, normal: Vec3) -> Ray {
    let back = origin - p;
    let distance = normal.abs().dot(p_error + (back.abs() + p.abs()) * gamma(2));
    let end = p + normal * distance.copysign(back.dot(normal));
    Ray::new(origin, end - origin, 0.0, 1.0)
}

/// Rays from one surface point to several points of a light.
#[derive(Clone, Copy, Debug)]
pub struct SoftShadow {
    /// Where they begin.
    pub departure: Departure,
    /// Index of the light in the scene.
    pub light: u32,
    /// Where on the light they end.
    pub series: Series,
    /// How many.
    pub count: u32,
}

/// Places for rays that are yet to be made.
const PLACES: [Ray; 32] = [Ray { origin: Vec3::ZERO, dir: Vec3::ZERO, t_min: 0.0, t_max: 0.0 }; 32];

/// Makes the rays of many requests at once, which takes a fraction of the time of one after the other.
#[derive(Debug, Default)]
pub struct SoftShadows {
    series: Vec<(Series, u32)>,
    /// Where each begins, which light it goes to, and its place among all rays.
    ways: Vec<(Departure, u32, usize)>,
    points: Vec<[f32; 2]>,
}

impl SoftShadows {
    /// Remembers a request and keeps places for its rays.
    pub fn push(&mut self, soft: SoftShadow, rays: &mut Vec<Ray>) {
        let SoftShadow { departure, light, series, count } = soft;
        self.series.push((series, count));
        self.ways.push((departure, light, rays.len()));
        let count = count as usize;
        match PLACES.get(..count) {
            Some(places) => rays.extend_from_slice(places),
            None => rays.resize(rays.len() + count, PLACES[0]),
        }
    }

    /// Makes all rays that were asked for, in their places, and forgets the requests.
    pub fn make(&mut self, scene: &Scene, rays: &mut [Ray]) {
        if self.series.is_empty() {
            return;
        }
        self.points.clear();
        sampler::fill(&self.series, &mut self.points);
        vectorize(Rays { scene, all: self, rays });
        self.series.clear();
        self.ways.clear();
    }
}

/// From points of the unit square to rays, as work for wide vectors.
struct Rays<'a> {
    scene: &'a Scene,
    all: &'a SoftShadows,
    rays: &'a mut [Ray],
}

impl Vectorizable for Rays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut points = self.all.points.as_slice();
        for ((departure, light, place), (_, count)) in self.all.ways.iter().zip(&self.all.series) {
            let count = *count as usize;
            let (own, rest) = points.split_at(count);
            let light: &AnyLight = &self.scene.lights()[*light as usize].value;
            let rays = self.rays[*place..*place + count].iter_mut().zip(own);
            // What a light is, is asked once, not for each ray.
            match light.parallelogram() {
                Some((origin, [a, b])) => {
                    for (ray, [x, y]) in rays {
                        *ray = shadow_ray(departure, origin + a * *x + b * *y);
                    }
                }
                None => {
                    for (ray, point) in rays {
                        *ray = shadow_ray(departure, light.sample_point(Vec2::from(*point)));
                    }
                }
            }
            points = rest;
        }
    }
}

#[cfg(test)]
mod tests;
