//! Integrators: how the light along a camera ray is computed.
//!
//! An integrator is a step function over small path states. The wavefront executor keeps a few hundred paths in
//! flight, hands their rays to the kernels in batches and adds up what the steps ask for, in an order that
//! depends on nothing but the ray tree of each sample.

pub mod ao;
pub mod aov;
pub mod classic;
pub mod direct;
pub mod path;

mod features;
mod probe;
mod shadow;
mod wavefront;

use crate::sampler::Sampler;
use crate::scene::Scene;
use penombre_bvh::Ray;
use penombre_math::Spectrum;
use penombre_scene::ParamSpec;
use std::fmt::Debug;

pub use ao::AmbientOcclusion;
pub use aov::FeatureImage;
pub use classic::Classic;
pub use direct::Direct;
pub(crate) use features::Gatherer;
pub use path::PathTracer;
pub use probe::{LightRecord, PathRecord, VertexRecord};
pub use wavefront::{Arrival, Arrivals, Step};

/// The integrators of this version with their parameters, in the order in which messages list them.
pub const TYPES: &[(&str, &[ParamSpec])] = &[
    (Classic::NAME, Classic::SCHEMA),
    (PathTracer::NAME, PathTracer::SCHEMA),
    (Direct::NAME, Direct::SCHEMA),
    (AmbientOcclusion::NAME, AmbientOcclusion::SCHEMA),
    (FeatureImage::NAME, FeatureImage::SCHEMA),
];

/// Where a path state stands in the ray tree of its sample, for inspectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlace {
    /// Bounces since the camera.
    pub depth: u32,
    /// Number of the node: the camera ray is 1, the continuations of node n are 2n and 2n + 1.
    pub node: u32,
    /// Share of the node's light that reaches the camera.
    pub weight: Spectrum,
    /// What made the ray: `camera`, `reflection`, `refraction`.
    pub origin: &'static str,
}

/// How light is computed, one bounce at a time.
pub trait Integrator: Send + Sync {
    /// What one path remembers between bounces.
    type Path: Copy + Send + Sync;

    /// Lists that shading fills anew each time, kept for their memory.
    type Memory: Default + Debug;

    /// True if flat triangles are shaded as the smooth surface that their normals tell of.
    const SMOOTH: bool = true;

    /// The state of a path that begins at the camera.
    fn start(&self) -> Self::Path;

    /// Shades what rays met: adds light, asks for shadow rays, names the rays that go on.
    fn shade(
        &self,
        scene: &Scene,
        arrivals: &Arrivals<'_, Self::Path>,
        memory: &mut Self::Memory,
        out: &mut Step<'_, Self::Path>,
    );

    /// The radiance to which light is limited, against bright specks; `None`: to none, nothing is left out.
    fn clamp(&self) -> Option<f32> {
        None
    }

    /// Where the state stands in the ray tree.
    fn place(&self, path: &Self::Path) -> PathPlace;
}

/// One camera sample: the ray and the numbers of its path.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// The ray.
    pub ray: Ray,
    /// The sample's numbers.
    pub sampler: Sampler,
}

/// An integrator whose path type is forgotten: called once per batch, never per step.
pub trait AnyIntegrator: Send + Sync + Debug {
    /// Its name in scene files.
    fn name(&self) -> &'static str;

    /// See [`Integrator::clamp`].
    fn clamp(&self) -> Option<f32> {
        None
    }

    /// Something that traces batches one after the other, with memory of its own.
    fn worker<'a>(&'a self, scene: &'a Scene) -> Box<dyn Worker + 'a>;
}

/// Traces batches of camera samples.
pub trait Worker {
    /// Writes the radiance along each sample's ray into `radiance` (same length) and returns the number of rays
    /// that were traced. `stop` is asked every few thousand rays; once it says true the rest is left out and the result
    /// is worth nothing.
    fn trace(&mut self, samples: &[CameraSample], radiance: &mut [Spectrum], stop: &dyn Fn() -> bool) -> u64;

    /// Traces one sample and tells every vertex of its path.
    fn record(&mut self, sample: &CameraSample) -> PathRecord;
}

#[cfg(test)]
mod tests;
