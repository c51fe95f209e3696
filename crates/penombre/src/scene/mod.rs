//! The immutable scene: everything built, nothing that can fail any more.

mod build;
mod emitters;
mod hierarchy;
mod light_samples;
mod opacity;
mod preview;
mod shapes;
mod specular;
mod summary;
mod surface;

use crate::bsdf::Bsdf;
use crate::camera::AnyCamera;
use crate::light::AnyLight;
use crate::material::{AnyMaterial, PhongView, Shade};
use crate::texture::{AnyTexture, TexturePoint};
use emitters::Emitters;
use penombre_bvh::{Hit, Ray};
use penombre_math::Bounds3;
use shapes::Shapes;
use specular::SpecularSpheres;
use std::sync::Arc;

pub use crate::registry::Named;
pub use build::INSTANCE_SCHEMA;
pub use emitters::NO_EMITTER;
pub use hierarchy::Hierarchy;
pub use light_samples::LightSamples;
pub use preview::Placement;
pub use specular::{NOT_SPECULAR, SpecularSphere};
pub use summary::{Count, Summary};
pub use surface::{Departure, SurfacePoint};

/// A scene ready to be rendered: shapes in their acceleration structure, materials, textures, lights, cameras.
#[derive(Debug)]
pub struct Scene {
    shapes: Arc<Shapes>,
    /// Material index per slot of each shape; never empty.
    slots: Vec<Vec<u32>>,
    materials: Vec<Named<AnyMaterial>>,
    textures: Vec<AnyTexture>,
    lights: Vec<Named<AnyLight>>,
    cameras: Vec<Named<AnyCamera>>,
    emitters: Emitters,
    specular: SpecularSpheres,
    /// Whether each shape has a material that is not entirely there; empty if none has.
    cut_outs: Vec<bool>,
    /// True if a material is made of others.
    has_mixes: bool,
}

impl Scene {
    /// Finds the nearest hit of each ray, in the order of the rays. Holes and cut-outs are not hit.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        match self.filter() {
            None => self.shapes.bvh.closest_batch(rays, hits),
            Some(filter) => self.shapes.bvh.closest_batch_where(rays, &filter, hits),
        }
    }

    /// Finds the nearest hit of one ray; for inspectors, batches are faster.
    pub fn closest(&self, ray: &Ray) -> Hit {
        match self.filter() {
            None => self.shapes.bvh.closest(ray),
            Some(filter) => self.shapes.bvh.closest_where(ray, &filter),
        }
    }

    /// Tells for each ray whether anything lies on it, in the order of the rays.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        match self.filter() {
            None => self.shapes.bvh.occluded_batch(rays, blocked),
            Some(filter) => self.shapes.bvh.occluded_batch_where(rays, &filter, blocked),
        }
    }

    /// The material at a surface point in Phong's terms.
    pub fn phong_view(&self, at: &SurfacePoint) -> PhongView {
        self.materials[at.material as usize].value.phong_view(&self.shade(at, 0.0))
    }

    /// How the surface scatters light; `u` ∈ [0, 1) chooses among several models. In the local frame the shading normal
    /// [`SurfacePoint::ns`] is at +z.
    #[inline]
    pub fn bsdf(&self, at: &SurfacePoint, u: f32) -> Bsdf {
        self.materials[at.material as usize].value.bsdf(&self.shade(at, u))
    }

    /// True if a surface's model may depend on the uniform number of [`bsdf`](Self::bsdf).
    #[inline]
    pub fn has_mixes(&self) -> bool {
        self.has_mixes
    }

    #[inline]
    fn shade(&self, at: &SurfacePoint, u: f32) -> Shade<'_> {
        Shade {
            point: TexturePoint { uv: at.uv },
            normal: at.facing_normal(),
            wo: at.wo,
            outside: at.outside(),
            vertex_color: at.color,
            textures: &self.textures,
            materials: &self.materials,
            u,
        }
    }

    /// The lights in file order.
    pub fn lights(&self) -> &[Named<AnyLight>] {
        &self.lights
    }

    /// The materials in file order, then the default material.
    pub fn materials(&self) -> &[Named<AnyMaterial>] {
        &self.materials
    }

    /// The cameras in file order; at least one.
    pub fn cameras(&self) -> &[Named<AnyCamera>] {
        &self.cameras
    }

    /// The name of the shape of a surface point.
    pub fn shape_name(&self, shape: u32) -> &str {
        &self.shapes.list[shape as usize].name
    }

    /// A box around all shapes, world space.
    pub fn bounds(&self) -> Bounds3 {
        self.shapes.bounds
    }
}
