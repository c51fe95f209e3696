//! The immutable scene: everything built, nothing that can fail any more.

mod build;
mod hierarchy;
mod preview;
mod shapes;
mod summary;
mod surface;

use crate::camera::AnyCamera;
use crate::light::AnyLight;
use crate::material::{AnyMaterial, PhongView, Shade};
use crate::texture::{AnyTexture, TexturePoint};
use penombre_bvh::{Hit, Ray};
use penombre_math::Bounds3;
use shapes::Shapes;
use std::sync::Arc;

pub use hierarchy::Hierarchy;
pub use preview::Placement;
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
}

/// A thing and its name in the scene file.
#[derive(Clone, Debug)]
pub struct Named<T> {
    /// The name; empty if the program made it.
    pub name: String,
    /// The thing.
    pub value: T,
}

impl Scene {
    /// Finds the nearest hit of each ray, in the order of the rays.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.shapes.bvh.closest_batch(rays, hits);
    }

    /// Finds the nearest hit of one ray; for inspectors, batches are faster.
    pub fn closest(&self, ray: &Ray) -> Hit {
        self.shapes.bvh.closest(ray)
    }

    /// Tells for each ray whether anything lies on it, in the order of the rays.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.shapes.bvh.occluded_batch(rays, blocked);
    }

    /// The material at a surface point in Phong's terms.
    pub fn phong_view(&self, at: &SurfacePoint) -> PhongView {
        let shade = Shade {
            point: TexturePoint { uv: at.uv },
            normal: at.facing_normal(),
            wo: at.wo,
            vertex_color: at.color,
            textures: &self.textures,
        };
        self.materials[at.material as usize].value.phong_view(&shade)
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
