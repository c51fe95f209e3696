//! What a path did, for people to read.

use super::PathPlace;
use crate::scene::SurfacePoint;
use penombre_bvh::Ray;
use penombre_math::Spectrum;

/// Light that arrived at a vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct LightRecord {
    /// What the vertex would add to the pixel if nothing were in the way.
    pub unoccluded: Spectrum,
    /// Shadow rays sent; 0 for light that needs none.
    pub shadow_rays: u32,
    /// Shadow rays that met nothing.
    pub visible: u32,
    /// What it added to the pixel.
    pub added: Spectrum,
}

/// One ray of a path and what it met.
#[derive(Clone, Debug)]
pub struct VertexRecord {
    /// Where it stands in the ray tree.
    pub place: PathPlace,
    /// The ray.
    pub ray: Ray,
    /// The surface; `None` if the ray left the scene.
    pub surface: Option<SurfacePoint>,
    /// Light that was gathered here.
    pub lights: Vec<LightRecord>,
}

/// One sample's path, breadth first.
#[derive(Clone, Debug, Default)]
pub struct PathRecord {
    /// All rays of the sample.
    pub vertices: Vec<VertexRecord>,
    /// Their sum: the sample's radiance.
    pub radiance: Spectrum,
    /// Rays traced, shadow rays included.
    pub rays: u64,
}
