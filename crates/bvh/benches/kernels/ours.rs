//! Our kernels as this bench calls them: the one place to change when the library's interface does.

use crate::measure::Kernel;
use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Quality, Ray};

/// Rays in one call of the batch interface, as many as the renderer gathers of shadow rays.
const BATCH: usize = 2048;

/// The build for previews.
pub fn build_fast(geometry: Geometry) -> Result<Bvh, String> {
    build(geometry, Quality::Fast)
}

/// The build for final pictures.
pub fn build_high(geometry: Geometry) -> Result<Bvh, String> {
    build(geometry, Quality::High)
}

fn build(geometry: Geometry, quality: Quality) -> Result<Bvh, String> {
    Bvh::build(vec![geometry], &BuildOptions::with_quality(quality)).map_err(|e| e.to_string())
}

/// One ray a call.
pub struct One<'a>(pub &'a Bvh);

/// [`BATCH`] rays a call.
pub struct Batch<'a>(pub &'a Bvh);

impl Kernel for One<'_> {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.0.closest(ray);
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = self.0.occluded(ray);
        }
    }
}

impl Kernel for Batch<'_> {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (rays, hits) in rays.chunks(BATCH).zip(hits.chunks_mut(BATCH)) {
            self.0.closest_batch(rays, hits);
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (rays, blocked) in rays.chunks(BATCH).zip(blocked.chunks_mut(BATCH)) {
            self.0.occluded_batch(rays, blocked);
        }
    }
}
