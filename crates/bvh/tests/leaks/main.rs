//! No ray leaves a closed mesh unseen: rays from inside, most of them aimed at vertices and edges.
//!
//! The normal run traces some hundred thousand rays, `PENOMBRE_SLOW=1` a hundred million (`cargo xtask test --slow`).

use bodies::Body;
use meshes::{Mesh, direction};
use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Quality, Ray, Triangles};
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

mod bodies;
#[path = "../../src/tests/meshes.rs"]
mod meshes;

/// Rays of one task and of one call.
const BATCH: usize = 4096;
/// One of so many rays is also traced alone.
const SINGLE: usize = 16;

fn rays_asked_for() -> usize {
    let slow = std::env::var_os("PENOMBRE_SLOW").is_some_and(|v| v == "1");
    if slow { 100_000_000 } else { 400_000 }
}

/// What was traced, and what went through.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    batch: usize,
    alone: usize,
    closest: usize,
    occluded: usize,
    alone_closest: usize,
    alone_occluded: usize,
    first_leak: Option<Ray>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.batch += other.batch;
        self.alone += other.alone;
        self.closest += other.closest;
        self.occluded += other.occluded;
        self.alone_closest += other.alone_closest;
        self.alone_occluded += other.alone_occluded;
        self.first_leak = self.first_leak.or(other.first_leak);
    }

    fn leaks(&self) -> usize {
        self.closest + self.occluded + self.alone_closest + self.alone_occluded
    }
}

/// A vertex, a point of an edge, the middle of an edge or a point of a face.
fn target(rng: &mut Pcg32, mesh: &Mesh) -> Vec3 {
    let triangle = mesh.indices[rng.below(mesh.indices.len() as u32) as usize];
    let turn = rng.below(3) as usize;
    let corner = |i: usize| mesh.positions[triangle[(turn + i) % 3] as usize];
    let (a, b, c) = (corner(0), corner(1), corner(2));
    match rng.below(4) {
        0 => a,
        1 => a + (b - a) * rng.next_f32(),
        2 => (a + b) * 0.5,
        _ => {
            let share = rng.next_f32();
            a + (b - a) * share + (c - a) * ((1.0 - share) * rng.next_f32())
        }
    }
}

/// From inside; one of eight in any direction, the others aimed.
fn ray(rng: &mut Pcg32, body: &Body) -> Ray {
    let origin = body.inside(rng);
    let dir = if rng.below(8) == 0 { direction(rng) } else { target(rng, &body.mesh) - origin };
    Ray::new(origin, dir, 0.0, f32::INFINITY)
}

/// Traces rays of one task in all ways.
fn trace(body: &Body, bvh: &Bvh, task: usize) -> Tally {
    let mut rng = Pcg32::with_stream(2013, task as u64);
    let rays: Vec<Ray> = (0..BATCH).map(|_| ray(&mut rng, body)).collect();
    let (mut hits, mut blocked) = (vec![Hit::MISS; BATCH], vec![false; BATCH]);
    bvh.closest_batch(&rays, &mut hits);
    bvh.occluded_batch(&rays, &mut blocked);
    let mut tally = Tally { batch: BATCH, ..Tally::default() };
    for (i, ray) in rays.iter().enumerate() {
        let alone = i % SINGLE == task % SINGLE;
        tally.alone += usize::from(alone);
        tally.closest += usize::from(!hits[i].is_hit());
        tally.occluded += usize::from(!blocked[i]);
        tally.alone_closest += usize::from(alone && !bvh.closest(ray).is_hit());
        tally.alone_occluded += usize::from(alone && !bvh.occluded(ray));
        if tally.leaks() > 0 && tally.first_leak.is_none() {
            tally.first_leak = Some(*ray);
        }
    }
    tally
}

fn build(body: &Body, quality: Quality) -> Bvh {
    Bvh::build(vec![body.mesh.geometry()], &BuildOptions::with_quality(quality)).expect("valid mesh")
}

/// Every edge borders two triangles, in opposite directions or not.
fn is_closed(mesh: &Mesh) -> bool {
    let mut edges = std::collections::HashMap::new();
    for triangle in &mesh.indices {
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    edges.values().all(|&n| n == 2)
}

/// Traces on all threads. Which rays there are does not depend on their number.
fn trace_all(bodies: &[Body], trees: &[[Bvh; 2]], tasks: usize) -> Vec<Tally> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (next, total) = (AtomicUsize::new(0), Mutex::new(vec![Tally::default(); bodies.len()]));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let task = next.fetch_add(1, Ordering::Relaxed);
                    if task >= tasks {
                        return;
                    }
                    let (body, tree) = (task % bodies.len(), task / bodies.len() % 2);
                    let tally = trace(&bodies[body], &trees[body][tree], task);
                    total.lock().expect("no thread panicked")[body].add(tally);
                }
            });
        }
    });
    total.into_inner().expect("no thread panicked")
}

#[test]
fn closed_meshes_do_not_leak() {
    let bodies = bodies::all();
    for body in &bodies {
        assert!(is_closed(&body.mesh), "{} is not closed", body.name);
    }
    let trees: Vec<[Bvh; 2]> =
        bodies.iter().map(|body| [Quality::Fast, Quality::High].map(|q| build(body, q))).collect();
    for (body, trees) in bodies.iter().zip(&trees) {
        assert!(trees.iter().all(|t| t.stats().skipped == 0), "{} has triangles without area", body.name);
    }
    let (tasks, start) = (rays_asked_for().div_ceil(BATCH), Instant::now());
    let tallies = trace_all(&bodies, &trees, tasks);
    let mut all = Tally::default();
    for (body, tally) in bodies.iter().zip(&tallies) {
        eprintln!("{:24}{:>12} rays, {} leaks", body.name, tally.batch, tally.leaks());
        if let Some(ray) = tally.first_leak {
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            eprintln!("  LEAK: origin bits {:#x?}, dir bits {:#x?}", bits(ray.origin), bits(ray.dir));
        }
        all.add(*tally);
    }
    eprintln!(
        "{} rays from inside {} closed meshes, {:.1} s: leaks {} of closest_batch, {} of occluded_batch; of {} rays \
         traced alone {} of closest, {} of occluded",
        all.batch,
        bodies.len(),
        start.elapsed().as_secs_f64(),
        all.closest,
        all.occluded,
        all.alone,
        all.alone_closest,
        all.alone_occluded,
    );
    assert!(all.batch >= rays_asked_for());
    assert_eq!(all.leaks(), 0);
}

/// The test would see a leak: a triangle of twenty is taken out.
#[test]
fn an_open_mesh_leaks() {
    let mut body = bodies::all().remove(0);
    body.mesh.indices.pop();
    assert!(!is_closed(&body.mesh));
    let tally = trace(&body, &build(&body, Quality::Fast), 0);
    assert!(tally.closest > BATCH / 100 && tally.closest == tally.occluded, "{tally:?}");
    assert!(tally.alone_closest > 0 && tally.alone_closest == tally.alone_occluded, "{tally:?}");
}
