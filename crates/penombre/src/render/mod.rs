//! Rendering: jobs cut into work units, units into film, film into images.
//!
//! [`Render::unit`] is a pure function of scene, integrator, job and unit. Threads and the path inspector call it
//! or what it calls, and nothing else computes samples.

mod intake;
mod memory;
mod plan;
mod run;
mod settings;
mod unit;

use crate::film::{Film, PixelFilter, SAMPLE_CHUNK, Tile};
use crate::registry::Context;
use crate::sampler::{Sampler, SamplerKind};
use penombre_scene::{Assets, Diagnostics, SceneDescription};

pub use memory::{MemoryEstimate, MemoryPart};
pub use plan::{NODE_SCHEMAS, Plan, SPP_ENTRY, default_tone};
pub use run::{Event, Observer, Outcome, Render, Statistics};
pub use settings::RenderSettings;
pub use unit::{DroppedSample, UnitResult, record};

/// Samples per pixel before which no job ends for its small error.
const FIRST_CHECK: u32 = 32;

/// What is rendered: everything beyond the scene and the integrator that decides the bits of the image, and the
/// size of tiles, which does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub spp: u32,
    /// Seed of all sample points.
    pub seed: u64,
    /// Family of sample points.
    pub sampler: SamplerKind,
    /// Index of the scene's camera.
    pub camera: u32,
    /// True: rays go through random points around the pixel; false: through its centre.
    pub pixel_jitter: bool,
    /// Where around the pixel.
    pub filter: PixelFilter,
    /// True: the samples of even and of odd index are scrambled independently and kept apart, so that the film can
    /// estimate its error. The image has other noise than without.
    pub estimate: bool,
    /// Ends the job at the first check point ([`Job::next_check`]) at which the estimate is surely below: see
    /// [`Estimate::bound`](crate::film::Estimate). 0: all samples are taken.
    pub noise: f32,
    /// True: features of first hits are gathered for layers.
    pub features: bool,
    /// True: passes over the film enter it whole, so that a run that is stopped leaves the image of a smaller number of
    /// samples, unless it is stopped within the first pass.
    pub whole_passes: bool,
    /// Edge of the tiles, pixels.
    pub tile: u32,
    /// True: units hold one sample of each pixel, for pictures that refine sample by sample; false: a whole chunk,
    /// which is faster. The bits are the same.
    pub progressive: bool,
}

/// The smallest piece of a job that is computed at a time: some samples of all pixels of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkUnit {
    /// Number of the tile, row by row.
    pub tile_index: usize,
    /// Its pixels.
    pub tile: Tile,
    /// First sample of each pixel.
    pub first_sample: u32,
    /// Number of samples of each pixel: one, or up to the next multiple of [`SAMPLE_CHUNK`].
    pub count: u32,
}

impl Job {
    /// Tiles in a row.
    fn columns(&self) -> usize {
        self.size[0].div_ceil(self.tile) as usize
    }

    /// Number of tiles.
    pub fn tiles(&self) -> usize {
        self.columns() * self.size[1].div_ceil(self.tile) as usize
    }

    /// Samples per pixel in a full work unit.
    fn step(&self) -> u32 {
        if self.progressive { 1 } else { SAMPLE_CHUNK }
    }

    /// Number of work units.
    pub fn units(&self) -> usize {
        self.units_of(self.spp)
    }

    /// Samples of each pixel in the passes that are whole before that unit.
    fn samples_before(&self, index: usize) -> u32 {
        let passes = (index / self.tiles()) as u32;
        passes.saturating_mul(self.step()).min(self.spp)
    }

    /// Number of units that hold the first so many samples of each pixel, a multiple of those in a pass or all.
    fn units_of(&self, samples: u32) -> usize {
        self.tiles() * samples.min(self.spp).div_ceil(self.step()) as usize
    }

    /// Number of samples of the whole image.
    pub fn samples(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1]) * u64::from(self.spp)
    }

    /// Memory of its film and image, bytes.
    pub fn film_bytes(&self) -> u64 {
        let [width, height] = self.size;
        // Sums that wait until their pass is whole are half of those that the film holds.
        let film = Film::bytes(width, height, self.estimate, self.features);
        if self.whole_passes { film.saturating_add(film / 2) } else { film }
    }

    /// The job that a description asks for, before anything is built; faults are those of [`Plan::new`].
    pub fn planned(description: &SceneDescription) -> Self {
        let (assets, mut out) = (Assets::default(), Diagnostics::default());
        let mut context =
            Context { description, assets: &assets, out: &mut out, node: penombre_scene::NodeId(0) };
        RenderSettings::build(&mut context).job()
    }

    /// The check point after so many samples per pixel: 32, then four to each doubling, at multiples of
    /// [`SAMPLE_CHUNK`]. Fixed, so that where a job ends depends on nothing but its samples. Two or more samples in each
    /// half of a pixel would do for an estimate, 32 leave a chance that rare light was met.
    pub fn next_check(samples: u32) -> u32 {
        if samples < FIRST_CHECK {
            return FIRST_CHECK;
        }
        let octave = 1 << samples.ilog2();
        let step = (octave / 4).max(SAMPLE_CHUNK);
        samples.saturating_add(step - samples % step)
    }

    /// The numbers of a sample.
    pub fn sampler_of(&self, pixel: [u32; 2], index: u32) -> Sampler {
        let sampler = Sampler::new(self.sampler, self.seed, pixel, index);
        match (self.estimate, index % 2) {
            (false, _) => sampler,
            (true, 0) => sampler.of_sample(index / 2),
            (true, _) => sampler.of_sample(index / 2).rescrambled(),
        }
    }

    /// The place of a unit in the fixed order.
    pub(crate) fn index_of(&self, unit: &WorkUnit) -> usize {
        (unit.first_sample / self.step()) as usize * self.tiles() + unit.tile_index
    }

    /// Work unit `index` of the fixed order: all tiles row by row for the first samples, then for the
    /// next.
    pub fn unit(&self, index: usize) -> WorkUnit {
        let (pass, tile_index) = (index / self.tiles(), index % self.tiles());
        let first_sample = pass as u32 * self.step();
        let (column, row) = (tile_index % self.columns(), tile_index / self.columns());
        let (x0, y0) = (column as u32 * self.tile, row as u32 * self.tile);
        let tile = Tile {
            x0,
            y0,
            x1: (x0.saturating_add(self.tile)).min(self.size[0]),
            y1: (y0.saturating_add(self.tile)).min(self.size[1]),
        };
        WorkUnit { tile_index, tile, first_sample, count: self.step().min(self.spp - first_sample) }
    }
}

#[cfg(test)]
mod tests;
