//! One work unit: the pure function at the bottom of every render.

use super::{Job, Render, WorkUnit};
use crate::film::PixelSum;
use crate::integrator::{AnyIntegrator, CameraSample, PathRecord, Worker};
use crate::sampler::{Dimension, Sampler};
use crate::scene::Scene;
use penombre_math::{Spectrum, Vec2};
use std::cell::Cell;

/// Camera samples that are traced together.
const BATCH: usize = 1024;

/// Dropped samples that a unit names; the rest is only counted.
const MOST_NAMED: usize = 8;

/// A sample that was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedSample {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// Index of the sample.
    pub sample: u32,
}

/// What came out of a work unit.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitResult {
    /// The unit.
    pub unit: WorkUnit,
    /// Sums per pixel, row by row.
    pub sums: Vec<PixelSum>,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Number of samples that were not finite; they are in no sum.
    pub non_finite: u64,
    /// The first few of them.
    pub dropped: Vec<DroppedSample>,
}

impl Render {
    /// Computes a unit. A pure function of its arguments: threads, machines, resumed runs and inspectors get the
    /// same bits.
    pub fn unit(scene: &Scene, integrator: &dyn AnyIntegrator, job: &Job, unit: WorkUnit) -> UnitResult {
        Self::unit_unless(scene, integrator, job, unit, &|| false).expect("nobody stops it")
    }

    /// The same, given up (`None`) once `stop` says true. It is asked every few thousand rays, within units however
    /// slow.
    pub fn unit_unless(
        scene: &Scene,
        integrator: &dyn AnyIntegrator,
        job: &Job,
        unit: WorkUnit,
        stop: &dyn Fn() -> bool,
    ) -> Option<UnitResult> {
        // What was given up in the middle stays so, even if `stop` should change its mind.
        let stopped = Cell::new(false);
        let stop = &|| {
            stopped.set(stopped.get() || stop());
            stopped.get()
        };
        let mut worker = integrator.worker(scene);
        let pixels: Vec<[u32; 2]> = unit.tile.iter().collect();
        let mut result = UnitResult {
            unit,
            sums: vec![PixelSum::default(); pixels.len()],
            rays: 0,
            non_finite: 0,
            dropped: Vec::new(),
        };
        let mut batch = Batch::default();
        let per_pixel = (0..unit.count).map(|i| unit.first_sample + i);
        for (slot, pixel) in pixels.iter().enumerate() {
            for index in per_pixel.clone() {
                batch.push(slot, *pixel, index, camera_sample(scene, job, *pixel, index));
                if batch.samples.len() == BATCH {
                    batch.finish(&mut *worker, &mut result, stop)?;
                }
            }
        }
        batch.finish(&mut *worker, &mut result, stop)?;
        Some(result)
    }
}

/// Follows one sample of one pixel and tells every vertex of its path.
pub fn record(
    scene: &Scene,
    integrator: &dyn AnyIntegrator,
    job: &Job,
    pixel: [u32; 2],
    index: u32,
) -> PathRecord {
    match camera_sample(scene, job, pixel, index) {
        Some(sample) => integrator.worker(scene).record(&sample),
        None => PathRecord::default(),
    }
}

/// The camera ray of a sample; `None` where the camera sees nothing.
fn camera_sample(scene: &Scene, job: &Job, pixel: [u32; 2], index: u32) -> Option<CameraSample> {
    let sampler = Sampler::new(job.sampler, job.seed, pixel, index);
    let inside = if job.pixel_jitter { sampler.get_2d(Dimension::FILM) } else { Vec2::splat(0.5) };
    let [w, h] = job.size.map(|v| v as f32);
    let (u, v) = ((pixel[0] as f32 + inside.x) / w, (pixel[1] as f32 + inside.y) / h);
    let screen = Vec2::new((2.0 * u - 1.0) * (w / h), 1.0 - 2.0 * v);
    let camera = &scene.cameras()[job.camera as usize].value;
    camera.ray(screen).map(|c| CameraSample { ray: c.ray, sampler })
}

/// Samples on their way through the integrator.
#[derive(Default)]
struct Batch {
    samples: Vec<CameraSample>,
    /// Where each sample belongs: slot of the pixel in the tile, pixel, index.
    owners: Vec<(usize, DroppedSample)>,
    radiance: Vec<Spectrum>,
}

impl Batch {
    fn push(&mut self, slot: usize, pixel: [u32; 2], sample: u32, camera: Option<CameraSample>) {
        if let Some(camera) = camera {
            self.samples.push(camera);
            self.owners.push((slot, DroppedSample { pixel, sample }));
        }
    }

    /// Traces the samples and adds them to the result; `None` if it was stopped.
    fn finish(
        &mut self,
        worker: &mut (dyn Worker + '_),
        result: &mut UnitResult,
        stop: &dyn Fn() -> bool,
    ) -> Option<()> {
        self.radiance.clear();
        self.radiance.resize(self.samples.len(), Spectrum::BLACK);
        result.rays += worker.trace(&self.samples, &mut self.radiance, stop);
        if stop() {
            return None;
        }
        self.drain_into(result);
        Some(())
    }

    /// Adds the results to the sums of their pixels, in order, and begins anew.
    fn drain_into(&mut self, result: &mut UnitResult) {
        for ((slot, owner), radiance) in self.owners.drain(..).zip(&self.radiance) {
            if radiance.is_finite() {
                result.sums[slot].add(*radiance);
            } else {
                result.non_finite += 1;
                if result.dropped.len() < MOST_NAMED {
                    result.dropped.push(owner);
                }
            }
        }
        self.samples.clear();
    }
}
