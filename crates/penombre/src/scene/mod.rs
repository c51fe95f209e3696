//! The immutable scene: everything built, nothing that can fail any more.

mod build;
mod preview;
mod summary;
mod surface;

use crate::camera::AnyCamera;
use crate::light::AnyLight;
use crate::material::{AnyMaterial, PhongView, Shade};
use crate::shape::AnyShape;
use crate::texture::{AnyTexture, TexturePoint};
use penombre_bvh::{Bvh, Hit, Ray};
use penombre_math::{Bounds3, Transform};

pub use preview::Placement;
pub use summary::{Count, Summary};
pub use surface::{Departure, SurfacePoint};

/// A scene ready to be rendered: shapes in their acceleration structure, materials, textures, lights, cameras.
#[derive(Debug)]
pub struct Scene {
    bvh: Bvh,
    shapes: Vec<BuiltShape>,
    placed: Vec<Placed>,
    materials: Vec<Named<AnyMaterial>>,
    textures: Vec<AnyTexture>,
    lights: Vec<Named<AnyLight>>,
    cameras: Vec<Named<AnyCamera>>,
    bounds: Bounds3,
}

/// A thing and its name in the scene file.
#[derive(Clone, Debug)]
pub struct Named<T> {
    /// The name; empty if the program made it.
    pub name: String,
    /// The thing.
    pub value: T,
}

/// A shape with the materials of its slots.
#[derive(Debug)]
struct BuiltShape {
    name: String,
    shape: AnyShape,
    /// Material index per slot; never empty.
    materials: Vec<u32>,
}

/// One appearance of a shape: a geometry of the acceleration structure's upper level.
#[derive(Debug)]
struct Placed {
    /// Index into the shapes.
    shape: u32,
    /// The map from the geometry's space, or none if that is world space.
    to_world: Option<Transform>,
}

impl Scene {
    /// Finds the nearest hit of each ray, in the order of the rays.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.bvh.closest_batch(rays, hits);
    }

    /// Finds the nearest hit of one ray; for inspectors, batches are faster.
    pub fn closest(&self, ray: &Ray) -> Hit {
        self.bvh.closest(ray)
    }

    /// Tells for each ray whether anything lies on it, in the order of the rays.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.bvh.occluded_batch(rays, blocked);
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
        &self.shapes[shape as usize].name
    }

    /// A box around all shapes, world space.
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }
}
