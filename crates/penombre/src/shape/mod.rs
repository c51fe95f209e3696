//! Shapes: what rays hit.
//!
//! A shape gives the kernels its geometry, in world space, and afterwards tells what lies at a hit: point, error
//! bound, normals, coordinates, colour.

mod common;
mod tessellation;

use crate::registry::{Context, registry};
use penombre_bvh::{Geometry, Hit, Ray};
use penombre_math::{Bounds3, DAffine3, Spectrum, Vec2, Vec3};
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

pub use common::uniform_scale;
pub use tessellation::{Detail, Tessellation};

/// What a shape knows of a hit, in the space of its geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePoint {
    /// The point, put back onto the surface: the ray's parameter alone would leave it off by its rounding.
    pub p: Vec3,
    /// Bound per axis on how far `p` lies off the surface, as the kernels compute it: a ray that starts outside this
    /// box does not meet the same spot again. Along the surface `p` may be off by a rounding of the distance
    /// or of the surface's extent, whichever is less.
    pub p_error: Vec3,
    /// Geometric normal, unit, on the outside.
    pub ng: Vec3,
    /// Shading normal, unit; on the side of `ng`'s surface that the file says.
    pub ns: Vec3,
    /// How far `p` lies before the geometry on the ray, if [`Shape::smooth`] moved it to the smooth surface, metres.
    pub rise: f32,
    /// How far the smooth surface that the shading normals tell of may lie beyond `p`, along `ns` and against it, metres.
    pub bulge: [f32; 2],
    /// Surface coordinates.
    pub uv: Vec2,
    /// Interpolated vertex colour; white where there is none.
    pub color: Spectrum,
    /// Material slot, 0 but for meshes with several materials.
    pub slot: u32,
}

/// A surface. Built in world space: its `transform` parameter is applied when it is built, but for what
/// [`Shape::remainder`] returns.
pub trait Shape: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand. Besides the parameters
    /// it may depend on the node's mesh file, and on nothing else: scenes share built shapes.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// What the ray kernels trace.
    fn geometry(&self) -> Geometry;

    /// What lies at a hit of that geometry. `ray` is in the geometry's space.
    fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint;

    /// Moves what [`Shape::point`] found to the smooth surface that flat geometry stands for, if it does.
    fn smooth(&self, _ray: &Ray, _hit: &Hit, _at: &mut ShapePoint) {}

    /// Surface coordinates and material slot at a hit: those of [`Shape::point`], sooner.
    fn coordinates(&self, ray: &Ray, hit: &Hit) -> (Vec2, u32) {
        let at = self.point(ray, hit);
        (at.uv, at.slot)
    }

    /// The part of the transform that the shape cannot take into itself (a sphere that becomes an ellipsoid): it
    /// is placed as an instance under this map.
    fn remainder(&self) -> Option<DAffine3> {
        None
    }

    /// Triangles that look like it, in the geometry's space, for raster previews.
    fn tessellate(&self, detail: &Detail) -> Tessellation;

    /// A box around it, in the geometry's space.
    fn bounds(&self) -> Bounds3;

    /// Number of primitives that the kernels see.
    fn primitives(&self) -> usize {
        1
    }
}

/// Declares the shapes: the module, then the type.
macro_rules! shapes {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any shape.
            AnyShape: Shape { $($module::$type),+ }
        }

        impl AnyShape {
            /// What the ray kernels trace.
            pub fn geometry(&self) -> Geometry {
                match self { $(Self::$type(s) => s.geometry()),+ }
            }

            /// What lies at a hit of that geometry.
            pub fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint {
                match self { $(Self::$type(s) => s.point(ray, hit)),+ }
            }

            /// Moves what was found to the smooth surface that flat geometry stands for.
            pub fn smooth(&self, ray: &Ray, hit: &Hit, at: &mut ShapePoint) {
                match self { $(Self::$type(s) => s.smooth(ray, hit, at)),+ }
            }

            /// Surface coordinates and material slot at a hit.
            pub fn coordinates(&self, ray: &Ray, hit: &Hit) -> (Vec2, u32) {
                match self { $(Self::$type(s) => s.coordinates(ray, hit)),+ }
            }

            /// The part of the transform that the shape could not take into itself.
            pub fn remainder(&self) -> Option<DAffine3> {
                match self { $(Self::$type(s) => s.remainder()),+ }
            }

            /// Triangles that look like it, in the geometry's space, for raster previews.
            pub fn tessellate(&self, detail: &Detail) -> Tessellation {
                match self { $(Self::$type(s) => s.tessellate(detail)),+ }
            }

            /// A box around it, in the geometry's space.
            pub fn bounds(&self) -> Bounds3 {
                match self { $(Self::$type(s) => s.bounds()),+ }
            }

            /// Number of primitives that the kernels see.
            pub fn primitives(&self) -> usize {
                match self { $(Self::$type(s) => s.primitives()),+ }
            }
        }
    };
}

shapes! {
    sphere::Sphere,
    quad::Quad,
    disk::Disk,
    mesh::Mesh,
}
