//! One work unit: the pure function at the bottom of every render.

use super::{Job, Render, WorkUnit};
use crate::camera::AnyCamera;
use crate::film::{FilterTable, TileSums};
use crate::integrator::{AnyIntegrator, CameraSample, Gatherer, PathRecord, Worker};
use crate::sampler::{self, Dimension, Sampler};
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
    pub sums: TileSums,
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
            sums: TileSums::new(pixels.len(), job.estimate, job.features),
            rays: 0,
            non_finite: 0,
            dropped: Vec::new(),
        };
        let mut batch = Batch::default();
        let halves = Halves::of(job, unit);
        let film = FilmSamples::new(job, &halves, &pixels);
        let camera = &scene.cameras()[job.camera as usize].value;
        for (slot, pixel) in pixels.iter().enumerate() {
            let samplers = halves.samplers(job, *pixel);
            for index in unit.first_sample..unit.first_sample + unit.count {
                let (half, i) = halves.place(index);
                let sampler = samplers[half].of_sample(halves.first[half] + i);
                let sample = camera_sample(camera, job, *pixel, film.inside(slot, half, i), sampler);
                batch.push(slot, *pixel, index, sample);
                if batch.samples.len() == BATCH {
                    batch.gather(scene, camera, &mut result);
                    batch.finish(&mut *worker, &mut result, stop)?;
                }
            }
        }
        batch.gather(scene, camera, &mut result);
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
    let sampler = job.sampler_of(pixel, index);
    let inside = if job.pixel_jitter {
        FilterTable::new(job.filter).place(sampler.get_2d(Dimension::FILM))
    } else {
        PIXEL_CENTER
    };
    let camera = &scene.cameras()[job.camera as usize].value;
    match camera_sample(camera, job, pixel, inside, sampler) {
        Some(sample) => integrator.worker(scene).record(&sample),
        None => PathRecord::default(),
    }
}

/// Where rays go without jitter.
const PIXEL_CENTER: Vec2 = Vec2::splat(0.5);

/// The samples of a unit in the sequences that they come from: one, or one for those of even and one for those of odd
/// index, which have scramblings of their own.
struct Halves {
    /// Sequences.
    number: u32,
    /// First sample of each, counted in the sequence.
    first: [u32; 2],
    /// Samples of each.
    count: [u32; 2],
}

impl Halves {
    fn of(job: &Job, unit: WorkUnit) -> Self {
        let end = unit.first_sample + unit.count;
        if !job.estimate {
            return Self { number: 1, first: [unit.first_sample, 0], count: [unit.count, 0] };
        }
        let first = [unit.first_sample.div_ceil(2), unit.first_sample / 2];
        Self { number: 2, first, count: [end.div_ceil(2) - first[0], end / 2 - first[1]] }
    }

    /// The sequence of a sample, and its place among those of the unit in it.
    #[inline]
    fn place(&self, index: u32) -> (usize, u32) {
        let half = (index % self.number) as usize;
        (half, index / self.number - self.first[half])
    }

    /// The sequences of a pixel.
    #[inline]
    fn samplers(&self, job: &Job, pixel: [u32; 2]) -> [Sampler; 2] {
        let even = Sampler::new(job.sampler, job.seed, pixel, 0);
        [even, if self.number == 1 { even } else { even.rescrambled() }]
    }
}

/// Where the samples of a unit lie around their pixels: all computed at once, which takes a fraction of the time of
/// one after the other.
struct FilmSamples {
    points: Vec<[f32; 2]>,
    /// Points of a pixel before those of each sequence, and of both.
    starts: [usize; 3],
}

impl FilmSamples {
    fn new(job: &Job, halves: &Halves, pixels: &[[u32; 2]]) -> Self {
        let mut points = Vec::new();
        if job.pixel_jitter {
            let series = |pixel: &[u32; 2]| {
                let samplers = halves.samplers(job, *pixel);
                let run = move |half: usize| {
                    let first = samplers[half].of_sample(halves.first[half]);
                    (first.series(Dimension::FILM, 1), halves.count[half])
                };
                (0..halves.number as usize).map(run)
            };
            let all: Vec<_> = pixels.iter().flat_map(series).collect();
            sampler::fill(&all, &mut points);
            if !job.filter.is_pixel() {
                let table = FilterTable::new(job.filter);
                points.iter_mut().for_each(|p| *p = table.place(Vec2::from(*p)).to_array());
            }
        }
        let [even, odd] = halves.count.map(|n| n as usize);
        Self { points, starts: [0, even, even + odd] }
    }

    /// Of sample `i` of one of the sequences of a pixel.
    #[inline]
    fn inside(&self, slot: usize, half: usize, i: u32) -> Vec2 {
        let index = slot * self.starts[2] + self.starts[half] + i as usize;
        self.points.get(index).map_or(PIXEL_CENTER, |p| Vec2::from(*p))
    }
}

/// The ray of a sample at a place inside its pixel; `None` where the camera sees nothing.
#[inline]
fn camera_sample(
    camera: &AnyCamera,
    job: &Job,
    pixel: [u32; 2],
    inside: Vec2,
    sampler: Sampler,
) -> Option<CameraSample> {
    let [w, h] = job.size.map(|v| v as f32);
    let (u, v) = ((pixel[0] as f32 + inside.x) / w, (pixel[1] as f32 + inside.y) / h);
    let screen = Vec2::new((2.0 * u - 1.0) * (w / h), 1.0 - 2.0 * v);
    camera.ray(screen).map(|c| CameraSample { ray: c.ray, sampler })
}

/// Samples on their way through the integrator.
#[derive(Default)]
struct Batch {
    samples: Vec<CameraSample>,
    /// Where each sample belongs: slot of the pixel in the tile, pixel, index.
    owners: Vec<(usize, DroppedSample)>,
    radiance: Vec<Spectrum>,
    gatherer: Gatherer,
}

impl Batch {
    fn push(&mut self, slot: usize, pixel: [u32; 2], sample: u32, camera: Option<CameraSample>) {
        if let Some(camera) = camera {
            self.samples.push(camera);
            self.owners.push((slot, DroppedSample { pixel, sample }));
        }
    }

    /// Adds the features of the samples to the result, if it wants them.
    fn gather(&mut self, scene: &Scene, camera: &AnyCamera, result: &mut UnitResult) {
        if result.sums.features.is_empty() {
            return;
        }
        result.rays += self.samples.len() as u64;
        let features = self.gatherer.features(scene, camera.view(), &self.samples);
        for ((slot, _), feature) in self.owners.iter().zip(features) {
            result.sums.features[*slot].add(feature.as_ref());
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
        let TileSums { color, odd, .. } = &mut result.sums;
        for ((slot, owner), radiance) in self.owners.drain(..).zip(&self.radiance) {
            if radiance.is_finite() {
                let half = if owner.sample % 2 == 1 && !odd.is_empty() { &mut *odd } else { &mut *color };
                half[slot].add(*radiance);
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
