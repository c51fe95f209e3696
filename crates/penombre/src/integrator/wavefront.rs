//! The wavefront executor: many paths, one round of bounces at a time.
//!
//! Within a sample, light is added breadth first over its ray tree, in the order in which each step asks for it.
//! That order does not depend on which samples share a batch, so neither do the bits of the image.

use super::shadow::{SoftShadow, SoftShadows};
use super::{AnyIntegrator, CameraSample, Integrator, LightRecord, PathRecord, VertexRecord, Worker};
use crate::sampler::Sampler;
use crate::scene::{Scene, SurfacePoint};
use penombre_bvh::{Hit, Ray};
use penombre_math::Spectrum;
use std::fmt::Debug;

/// Shadow rays gathered before they are traced, and traced together: 64 KiB of rays stay in the second-level cache.
const SHADOW_BATCH: usize = 2048;

/// More paths in flight than this are split by samples, to bound memory where paths branch.
const MOST_PATHS: usize = 16_384;

/// Paths that are shaded together.
const TOGETHER: usize = 128;

/// A path in flight: its state, its ray, the sample that it belongs to.
#[derive(Clone, Copy, Debug)]
struct Active<P> {
    path: P,
    ray: Ray,
    sample: u32,
}

/// Light that waits for its shadow rays.
#[derive(Clone, Copy, Debug)]
struct Pending {
    radiance: Spectrum,
    sample: u32,
    /// The next so many shadow rays of the queue decide which share of `radiance` arrives; 0: all of it.
    shadow_rays: u32,
    /// True if nothing arrives unless all of them meet nothing.
    all: bool,
    /// Index of the vertex in the record.
    vertex: u32,
}

/// What a step may ask for.
#[derive(Debug)]
pub struct Step<'a, P> {
    shadow_rays: &'a mut Vec<Ray>,
    soft: &'a mut SoftShadows,
    pending: &'a mut Vec<Pending>,
    next: &'a mut Vec<Active<P>>,
    sample: u32,
    vertex: u32,
}

impl<P: Copy> Step<'_, P> {
    /// Adds radiance to the sample.
    pub fn add(&mut self, radiance: Spectrum) {
        self.wait_for(radiance, 0);
    }

    /// Adds the share of `radiance` that arrives: the fraction of the rays pushed by `rays` that meet nothing.
    pub fn add_if_visible(&mut self, radiance: Spectrum, rays: impl FnOnce(&mut Vec<Ray>)) {
        let before = self.shadow_rays.len();
        rays(self.shadow_rays);
        let count = self.shadow_rays.len() - before;
        if count > 0 {
            self.wait_for(radiance, count as u32);
        }
    }

    /// Adds `radiance` if none of the rays meets anything.
    pub fn add_if_all_visible(&mut self, radiance: Spectrum, rays: impl Iterator<Item = Ray>) {
        let before = self.shadow_rays.len();
        self.shadow_rays.extend(rays);
        let shadow_rays = (self.shadow_rays.len() - before) as u32;
        let (sample, vertex) = (self.sample, self.vertex);
        self.pending.push(Pending { radiance, sample, shadow_rays, all: true, vertex });
    }

    /// Adds the share of `radiance` that arrives from a light with an extent.
    pub fn add_softly(&mut self, radiance: Spectrum, soft: SoftShadow) {
        if soft.count > 0 {
            self.soft.push(soft, self.shadow_rays);
            self.wait_for(radiance, soft.count);
        }
    }

    /// Continues the path with a ray. A path may branch.
    pub fn follow(&mut self, path: P, ray: Ray) {
        self.next.push(Active { path, ray, sample: self.sample });
    }

    fn wait_for(&mut self, radiance: Spectrum, shadow_rays: u32) {
        let (sample, vertex) = (self.sample, self.vertex);
        self.pending.push(Pending { radiance, sample, shadow_rays, all: false, vertex });
    }
}

/// Buffers of one round, kept between rounds.
#[derive(Debug)]
struct Wavefront<'a, I: Integrator> {
    integrator: &'a I,
    scene: &'a Scene,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    shadow_rays: Vec<Ray>,
    soft: SoftShadows,
    blocked: Vec<bool>,
    pending: Vec<Pending>,
    surfaces: Vec<Option<SurfacePoint>>,
    memory: I::Memory,
    traced: u64,
}

/// Paths whose rays have met something or left the scene, all of one round.
#[derive(Debug)]
pub struct Arrivals<'a, P> {
    active: &'a [Active<P>],
    surfaces: &'a [Option<SurfacePoint>],
    samples: &'a [CameraSample],
    first_vertex: u32,
}

/// One of them.
#[derive(Debug)]
pub struct Arrival<'a, P> {
    /// What the path remembers.
    pub path: &'a P,
    /// Its ray.
    pub ray: &'a Ray,
    /// What the ray met; `None` where it left the scene.
    pub at: Option<&'a SurfacePoint>,
    /// The sample's numbers.
    pub sampler: &'a Sampler,
}

impl<P> Arrivals<'_, P> {
    /// Path and sample of one of them.
    #[inline]
    pub fn origin(&self, index: usize) -> (&P, &Sampler) {
        let a = &self.active[index];
        (&a.path, &self.samples[a.sample as usize].sampler)
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.active.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.active.is_empty()
    }

    /// One of them; what is asked of `out` from now on belongs to it.
    #[inline]
    pub fn get(&self, index: usize, out: &mut Step<'_, P>) -> Arrival<'_, P> {
        let a = &self.active[index];
        out.sample = a.sample;
        out.vertex = self.first_vertex + index as u32;
        Arrival {
            path: &a.path,
            ray: &a.ray,
            at: self.surfaces[index].as_ref(),
            sampler: &self.samples[a.sample as usize].sampler,
        }
    }
}

/// Where a round's light goes, and what else wants to know.
struct Sink<'s> {
    radiance: &'s mut [Spectrum],
    record: Option<&'s mut PathRecord>,
}

impl<I: Integrator> Wavefront<'_, I> {
    /// Runs the paths to their ends.
    fn run(
        &mut self,
        samples: &[CameraSample],
        mut active: Vec<Active<I::Path>>,
        sink: &mut Sink<'_>,
        stop: &dyn Fn() -> bool,
    ) {
        let mut next = Vec::with_capacity(active.len());
        while !active.is_empty() && !stop() {
            if active.len() > MOST_PATHS && active[0].sample != active[active.len() - 1].sample {
                return self.run_halves(samples, active, sink, stop);
            }
            self.round(samples, &active, &mut next, sink, stop);
            std::mem::swap(&mut active, &mut next);
            next.clear();
        }
    }

    /// Splits the paths by samples: those of one sample stay together, so its order of sums stays as it is.
    fn run_halves(
        &mut self,
        samples: &[CameraSample],
        mut first: Vec<Active<I::Path>>,
        sink: &mut Sink<'_>,
        stop: &dyn Fn() -> bool,
    ) {
        let middle = first[first.len() / 2].sample.max(first[0].sample + 1);
        let cut = first.partition_point(|a| a.sample < middle);
        let second = first.split_off(cut);
        self.run(samples, first, sink, stop);
        self.run(samples, second, sink, stop);
    }

    /// One bounce of all paths.
    fn round(
        &mut self,
        samples: &[CameraSample],
        active: &[Active<I::Path>],
        next: &mut Vec<Active<I::Path>>,
        sink: &mut Sink<'_>,
        stop: &dyn Fn() -> bool,
    ) {
        self.rays.clear();
        self.rays.extend(active.iter().map(|a| a.ray));
        self.hits.clear();
        self.hits.resize(active.len(), Hit::MISS);
        self.scene.closest_batch(&self.rays, &mut self.hits);
        self.traced += active.len() as u64;
        for (active, first) in active.chunks(TOGETHER).zip((0..).step_by(TOGETHER)) {
            let hits = active.iter().zip(&self.hits[first..]);
            self.surfaces.clear();
            if I::SMOOTH {
                self.surfaces.extend(hits.map(|(a, hit)| self.scene.smooth_surface(&a.ray, hit)));
            } else {
                self.surfaces.extend(hits.map(|(a, hit)| self.scene.surface(&a.ray, hit)));
            }
            let first_vertex = self.tell_vertices(active, sink);
            let mut step = Step {
                shadow_rays: &mut self.shadow_rays,
                soft: &mut self.soft,
                pending: &mut self.pending,
                next,
                sample: 0,
                vertex: 0,
            };
            let arrivals = Arrivals { active, surfaces: &self.surfaces, samples, first_vertex };
            self.integrator.shade(self.scene, &arrivals, &mut self.memory, &mut step);
            if self.shadow_rays.len() >= SHADOW_BATCH {
                self.gather(sink, stop);
                if stop() {
                    return;
                }
            }
        }
        self.gather(sink, stop);
    }

    /// Adds rays and what they met to the record, if there is one. Returns the index of the first.
    fn tell_vertices(&self, active: &[Active<I::Path>], sink: &mut Sink<'_>) -> u32 {
        let Some(record) = &mut sink.record else { return 0 };
        let first = record.vertices.len() as u32;
        record.vertices.extend(active.iter().zip(&self.surfaces).map(|(a, surface)| VertexRecord {
            place: self.integrator.place(&a.path),
            ray: a.ray,
            surface: *surface,
            lights: Vec::new(),
        }));
        first
    }

    /// Traces the shadow rays and adds the light that arrives, in the order in which it was asked for. A single step
    /// may have asked for very many: stopped, the rest of them count as blocked.
    fn gather(&mut self, sink: &mut Sink<'_>, stop: &dyn Fn() -> bool) {
        self.soft.make(self.scene, &mut self.shadow_rays);
        self.blocked.clear();
        self.blocked.resize(self.shadow_rays.len(), true);
        let rays = self.shadow_rays.chunks(SHADOW_BATCH);
        for (rays, blocked) in rays.zip(self.blocked.chunks_mut(SHADOW_BATCH)) {
            self.scene.occluded_batch(rays, blocked);
            self.traced += rays.len() as u64;
            if stop() {
                break;
            }
        }
        let mut answers = self.blocked.as_slice();
        for p in self.pending.drain(..) {
            let (own, rest) = answers.split_at(p.shadow_rays as usize);
            let open = p.shadow_rays - blocked_of(own);
            answers = rest;
            let added = match p.shadow_rays {
                0 => p.radiance,
                n if open == n => p.radiance,
                _ if p.all => Spectrum::BLACK,
                n => p.radiance * (open as f32 / n as f32),
            };
            sink.radiance[p.sample as usize] += added;
            if let Some(record) = &mut sink.record {
                record.vertices[p.vertex as usize].lights.push(LightRecord {
                    unoccluded: p.radiance,
                    shadow_rays: p.shadow_rays,
                    visible: open,
                    added,
                });
            }
        }
        self.shadow_rays.clear();
    }

    fn begin(&self, samples: &[CameraSample]) -> Vec<Active<I::Path>> {
        let start = |(i, s): (usize, &CameraSample)| Active {
            path: self.integrator.start(),
            ray: s.ray,
            sample: i as u32,
        };
        samples.iter().enumerate().map(start).collect()
    }
}

impl<I: Integrator> Worker for Wavefront<'_, I> {
    fn trace(&mut self, samples: &[CameraSample], radiance: &mut [Spectrum], stop: &dyn Fn() -> bool) -> u64 {
        let before = self.traced;
        radiance.fill(Spectrum::BLACK);
        let active = self.begin(samples);
        self.run(samples, active, &mut Sink { radiance, record: None }, stop);
        self.traced - before
    }

    fn record(&mut self, sample: &CameraSample) -> PathRecord {
        let before = self.traced;
        let mut record = PathRecord::default();
        let mut radiance = [Spectrum::BLACK];
        let samples = [*sample];
        let active = self.begin(&samples);
        let mut sink = Sink { radiance: &mut radiance, record: Some(&mut record) };
        self.run(&samples, active, &mut sink, &|| false);
        record.radiance = radiance[0];
        record.rays = self.traced - before;
        record
    }
}

/// How many are true, four at a time.
#[inline]
fn blocked_of(answers: &[bool]) -> u32 {
    let (fours, rest) = answers.as_chunks();
    let four = |b: &[bool; 4]| u32::from_ne_bytes(b.map(u8::from)).wrapping_mul(0x0101_0101) >> 24;
    fours.iter().map(four).sum::<u32>() + rest.iter().map(|b| u32::from(*b)).sum::<u32>()
}

/// Forgets an integrator's path type.
#[derive(Debug)]
pub struct Batched<I>(pub I, pub &'static str);

impl<I: Integrator + Debug> AnyIntegrator for Batched<I> {
    fn name(&self) -> &'static str {
        self.1
    }

    fn clamp(&self) -> Option<f32> {
        self.0.clamp()
    }

    fn worker<'a>(&'a self, scene: &'a Scene) -> Box<dyn Worker + 'a> {
        Box::new(Wavefront {
            integrator: &self.0,
            scene,
            rays: Vec::new(),
            hits: Vec::new(),
            shadow_rays: Vec::with_capacity(SHADOW_BATCH + 256),
            soft: SoftShadows::default(),
            blocked: Vec::new(),
            pending: Vec::new(),
            surfaces: Vec::new(),
            memory: I::Memory::default(),
            traced: 0,
        })
    }
}
