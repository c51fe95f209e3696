//! A few primitives without a tree: several rays at once are tested against each, which costs less than boxes.

use crate::bvh::Tree;
use crate::lanes::Lanes;
use crate::prepared::Line;
use crate::primitive::{Key, Meetings};
use crate::query::{Closest, Query};
use crate::{Hit, Ray};

/// Up to this many primitives. Batches gain up to about 40 over the nodes, single rays up to about 16 (measured
/// with random rays on AVX2).
const FEW: usize = 16;

/// Are all primitives simple, and few?
pub(crate) fn suits(tree: &Tree) -> bool {
    let others = tree.blocks.len() + tree.instances.len() + tree.users.len();
    others == 0 && tree.spheres.len() + tree.quads.len() + tree.disks.len() <= FEW
}

/// The closest hit of every ray. `V` is the fastest way to compute `N` numbers; returns how many rays were left over.
#[inline(always)]
pub(crate) fn closest<const N: usize, V: Lanes<N>>(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) -> usize {
    let (packs, rest) = rays.as_chunks::<N>();
    let (hit_packs, _) = hits.as_chunks_mut::<N>();
    for (rays, hits) in packs.iter().zip(hit_packs) {
        *hits = closest_of::<N, V>(tree, rays);
    }
    rest.len()
}

/// Whether each ray hits anything; returns how many rays were left over.
#[inline(always)]
pub(crate) fn occluded<const N: usize, V: Lanes<N>>(
    tree: &Tree,
    rays: &[Ray],
    blocked: &mut [bool],
) -> usize {
    let (packs, rest) = rays.as_chunks::<N>();
    let (blocked_packs, _) = blocked.as_chunks_mut::<N>();
    for (rays, blocked) in packs.iter().zip(blocked_packs) {
        let found = occluded_of::<N, V>(tree, rays);
        *blocked = std::array::from_fn(|lane| found >> lane & 1 == 1);
    }
    rest.len()
}

#[inline(always)]
fn closest_of<const N: usize, V: Lanes<N>>(tree: &Tree, rays: &[Ray; N]) -> [Hit; N] {
    let (line, sane) = Line::<V>::new(rays);
    let limits = line.t_max.store();
    let mut search =
        Search { line, sane, queries: rays.each_ref().map(|ray| Closest::until(ray.t_max)), limits };
    for sphere in &tree.spheres {
        search.take(&sphere.meet(&search.line), sphere.key);
    }
    for quad in &tree.quads {
        search.take(&quad.meet(&search.line), quad.key);
    }
    for disk in &tree.disks {
        search.take(&disk.meet(&search.line), disk.key);
    }
    search.queries.map(|query| query.hit)
}

/// The state of `N` searches for the closest hit.
struct Search<const N: usize, V> {
    line: Line<V>,
    sane: u32,
    queries: [Closest; N],
    /// Exclusive ends of the ranges of interest: beyond the best hit, but not beyond an equal one.
    limits: [f64; N],
}

impl<const N: usize, V: Lanes<N>> Search<N, V> {
    #[inline(always)]
    fn take(&mut self, met: &Meetings<N>, key: Key) {
        let mut open = met.open & self.sane;
        if open == 0 {
            return;
        }
        while open != 0 {
            let lane = open.trailing_zeros() as usize % N;
            open &= open - 1;
            let meeting = met.at(lane);
            self.limits[lane] = f64::from(meeting.t).next_up();
            self.queries[lane].offer(meeting, key, Hit::NO_INSTANCE);
        }
        self.line.t_max = V::load(&self.limits);
    }
}

/// The rays that hit anything, as bits.
#[inline(always)]
fn occluded_of<const N: usize, V: Lanes<N>>(tree: &Tree, rays: &[Ray; N]) -> u32 {
    let (line, sane) = Line::<V>::new(rays);
    let mut waiting = sane;
    for sphere in &tree.spheres {
        waiting &= !sphere.meet(&line).open;
    }
    if waiting == 0 {
        return sane;
    }
    for quad in &tree.quads {
        waiting &= !quad.meet(&line).open;
    }
    for disk in &tree.disks {
        waiting &= !disk.meet(&line).open;
    }
    sane & !waiting
}
