//! Shapes that shine.

use crate::light::LightSample;
use crate::light::sampling::{
    DirectionSample, DirectionSampler, Parallelogram, SphericalCap, SphericalDisk, SphericalTriangle,
};
use crate::scene::Scene;
use penombre_bvh::{Hit, Ray, Triangles};
use penombre_math::distribution::Distribution1D;
use penombre_math::rounding::gamma;
use penombre_math::{Spectrum, Transform, Vec2, Vec3};
use std::sync::Arc;

/// One appearance of a shape that shines.
#[derive(Clone, Debug)]
pub struct ShapeEmitter {
    /// Index of the geometry in the upper level.
    pub placed: u32,
    pub form: Form,
    pub glow: Glow,
    /// Watts of luminance, for the choice; 0 if it is not sampled.
    pub power: f32,
}

/// What is sampled, world space.
#[derive(Clone, Debug)]
pub enum Form {
    /// A sphere or disk that a map bent.
    Unsampled,
    Quad {
        shape: Parallelogram,
        /// The map mirrors it, and the outside is on the other side of the product of the sides.
        mirrored: bool,
    },
    Disk {
        center: Vec3,
        normal: Vec3,
        radius: f32,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    Mesh {
        mesh: Arc<GlowingMesh>,
        to_world: Option<Transform>,
    },
}

/// What it sends.
#[derive(Clone, Copy, Debug)]
pub enum Glow {
    /// The same from all points, to the inside and to the outside.
    Even([Spectrum; 2]),
    /// To be looked up at each point.
    Varying,
}

/// The triangles of a mesh, with weights.
#[derive(Debug)]
pub struct GlowingMesh {
    pub triangles: Triangles,
    /// By area and luminance.
    pub choice: Distribution1D,
    pub glow: Glow,
    /// If the glow is even: the outside is that of the vertices' order.
    pub as_wound: bool,
    /// Sum of area · luminance over both sides, in the mesh's own space.
    pub sum: f64,
}

impl GlowingMesh {
    fn corners(&self, triangle: usize, to_world: Option<&Transform>) -> [Vec3; 3] {
        let corners = self.triangles.indices[triangle].map(|i| self.triangles.positions[i as usize]);
        to_world.map_or(corners, |map| corners.map(|p| map.point(p)))
    }
}

/// Where on a shape a point lies, for its hit's primitive and coordinates.
enum Place<'a> {
    /// The point tells.
    ByPoint,
    Parallelogram(&'a Parallelogram),
    Triangle(u32, [Vec3; 3]),
}

impl ShapeEmitter {
    /// Centre, radius and outer radiance, if it is a ball that shines evenly, in its place and without holes.
    pub fn ball(&self, scene: &Scene) -> Option<(Vec3, f32, Spectrum)> {
        let in_place = scene.shapes.placed[self.placed as usize].to_world.is_none();
        match (&self.form, self.glow) {
            (Form::Sphere { center, radius }, Glow::Even([_, outside]))
                if in_place && scene.cut_outs.is_empty() =>
            {
                (!outside.is_black()).then_some((*center, *radius, outside))
            }
            _ => None,
        }
    }

    /// A direction from which its light reaches a point.
    pub fn sample(&self, scene: &Scene, from: Vec3, u: Vec2) -> Option<LightSample> {
        let (direction, outside, place) = match &self.form {
            Form::Unsampled => return None,
            Form::Quad { shape, mirrored } => {
                let outside = self.shining_side(shape.faces(from) != *mirrored)?;
                (shape.sample_from(from, u)?, outside, Place::Parallelogram(shape))
            }
            Form::Disk { center, normal, radius } => {
                let seen = SphericalDisk::new(from, *center, *normal, *radius)?;
                let outside = self.shining_side(seen.is_in_front())?;
                (seen.sample(u), outside, Place::ByPoint)
            }
            Form::Sphere { center, radius } => {
                let seen = SphericalCap::new(from, *center, *radius)?;
                let outside = self.shining_side(!seen.is_inside())?;
                (seen.sample(u), outside, Place::ByPoint)
            }
            Form::Mesh { mesh, to_world } => {
                let chosen = mesh.choice.sample_discrete(u.x);
                let corners = mesh.corners(chosen.index, to_world.as_ref());
                let seen = SphericalTriangle::new(from, corners)?;
                let outside = self.shining_side(mesh.outside(&seen, to_world.as_ref()))?;
                let inside = seen.sample(Vec2::new(chosen.remapped, u.y));
                let direction = DirectionSample { pdf: inside.pdf * chosen.probability, ..inside };
                (direction, outside, Place::Triangle(chosen.index as u32, corners))
            }
        };
        let radiance = match self.glow {
            Glow::Even(sides) => sides[usize::from(outside)],
            Glow::Varying => self.look(scene, from, direction.point, &place),
        };
        let radiance = radiance * self.share_there(scene, from, direction.point, &place);
        // The product underflows for a triangle of little weight that is huge.
        let sound = !radiance.is_black() && direction.pdf > 0.0;
        sound.then(|| {
            let aside = self.aside(scene, &direction, &place);
            let normal = self.normal(direction.point, &place);
            LightSample { aside, ..LightSample::of_shape(direction, normal, radiance) }
        })
    }

    /// Bound on how far the test of rays may find the surface from a point of it, the rounding of the point's coordinates left
    /// out: of triangles it works on the corners relative to the ray's origin, each rounded once, with some seven operations
    /// after it; under a map rays are mapped back, and shapes were mapped with four roundings a coordinate each.
    fn aside(&self, scene: &Scene, sample: &DirectionSample, place: &Place<'_>) -> f32 {
        let DirectionSample { point, distance, .. } = *sample;
        let tested = match place {
            Place::Triangle(_, corners) => {
                let extent = corners.iter().map(|c| (*c - point).abs().max_element()).fold(0.0, f32::max);
                (extent + distance) * gamma(8)
            }
            _ => 0.0,
        };
        let map = &scene.shapes.placed[self.placed as usize].to_world;
        let mapped = map.map_or(0.0, |map| {
            let (_, bound) = map.point_with_error(map.inverse().point(point), Vec3::ZERO);
            4.0 * (bound.max_element() + distance * gamma(4))
        });
        tested + mapped
    }

    /// A unit normal at a point.
    fn normal(&self, point: Vec3, place: &Place<'_>) -> Vec3 {
        let across = match (&self.form, place) {
            (Form::Quad { shape, .. }, _) => shape.normal(),
            (Form::Disk { normal, .. }, _) => *normal,
            (Form::Sphere { center, .. }, _) => point - *center,
            (_, Place::Triangle(_, [o, a, b])) => (*a - *o).cross(*b - *o),
            _ => Vec3::ZERO,
        };
        across.normalize_or_zero()
    }

    /// The side, if it may shine.
    #[inline]
    fn shining_side(&self, outside: bool) -> Option<bool> {
        let shines = match self.glow {
            Glow::Even(sides) => !sides[usize::from(outside)].is_black(),
            Glow::Varying => true,
        };
        shines.then_some(outside)
    }

    /// A ray to a point of it and its hit.
    fn hit(&self, from: Vec3, point: Vec3, place: &Place<'_>) -> (Ray, Hit) {
        let (prim, [u, v]) = match place {
            Place::ByPoint => (0, [0.0; 2]),
            Place::Parallelogram(shape) => (0, shape.shares(point)),
            Place::Triangle(prim, corners) => (*prim, shares_of(*corners, point)),
        };
        let ray = Ray::new(from, point - from, 0.0, f32::INFINITY);
        (ray, Hit { t: 1.0, u, v, geometry: self.placed, prim, instance: Hit::NO_INSTANCE })
    }

    /// The radiance from a point of it, looked up.
    fn look(&self, scene: &Scene, from: Vec3, point: Vec3, place: &Place<'_>) -> Spectrum {
        let (ray, hit) = self.hit(from, point, place);
        scene.surface(&ray, &hit).map_or(Spectrum::BLACK, |at| scene.emitted(&at))
    }

    /// Opacity at a point of it: a shadow ray ends before it would meet a hole there.
    #[inline]
    fn share_there(&self, scene: &Scene, from: Vec3, point: Vec3, place: &Place<'_>) -> f32 {
        if scene.cut_outs.is_empty() {
            return 1.0;
        }
        let (ray, hit) = self.hit(from, point, place);
        scene.opacity(&ray, &hit)
    }

    /// Density with which [`sample`](Self::sample) gives a direction that meets a primitive of it at that distance; `None`:
    /// never.
    pub fn pdf(&self, prim: u32, from: Vec3, wi: Vec3, distance: f32) -> Option<f32> {
        Some(match &self.form {
            Form::Unsampled => return None,
            Form::Quad { shape, mirrored } => {
                self.shining_side(shape.faces(from) != *mirrored)?;
                shape.pdf_from(from, distance)
            }
            Form::Disk { center, normal, radius } => {
                let seen = SphericalDisk::new(from, *center, *normal, *radius)?;
                self.shining_side(seen.is_in_front())?;
                seen.pdf_of_hit(wi, distance)
            }
            Form::Sphere { center, radius } => {
                let seen = SphericalCap::new(from, *center, *radius)?;
                self.shining_side(!seen.is_inside())?;
                if seen.is_beyond(distance) { 0.0 } else { seen.pdf_of_hit(wi, distance) }
            }
            Form::Mesh { mesh, to_world } => {
                let probability = mesh.choice.probability(prim as usize);
                if probability <= 0.0 {
                    return None;
                }
                let seen = SphericalTriangle::new(from, mesh.corners(prim as usize, to_world.as_ref()))?;
                self.shining_side(mesh.outside(&seen, to_world.as_ref()))?;
                probability * seen.pdf_of_hit(wi, distance)
            }
        })
    }
}

impl GlowingMesh {
    /// True if a point sees the outside of a triangle; of no meaning if the glow varies.
    fn outside(&self, seen: &SphericalTriangle, to_world: Option<&Transform>) -> bool {
        let mirrored = to_world.is_some_and(Transform::flips_handedness);
        seen.is_in_front() == (self.as_wound != mirrored)
    }
}

/// A hit's coordinates at a point of a triangle: the shares of the sides from the first corner.
fn shares_of(corners: [Vec3; 3], p: Vec3) -> [f32; 2] {
    let [o, a, b] = corners;
    Parallelogram::new(o, [a - o, b - o]).map_or([0.0; 2], |both| both.shares(p))
}
