//! A few spheres and parallelograms without a tree: four are tested at once, which costs less than their boxes.

use crate::bvh::Tree;
use crate::lanes::Lanes;
use crate::prepared::Line;
use crate::primitive::{Key, Meetings, QuadRecord, Quads, SphereRecord, Spheres};
use crate::query::{Any, Closest, Query};
use crate::{Hit, Ray};

/// Primitives tested at once: numbers in a vector of 256 bits.
const LANES: usize = 4;

/// Up to this many primitives.
const FEW: usize = 16;

/// Primitives of one kind and their ids.
#[derive(Clone, Copy, Debug)]
struct Group<P> {
    lanes: P,
    keys: [Key; LANES],
}

/// All primitives of a tree.
#[derive(Clone, Debug)]
pub(crate) struct Flat {
    spheres: Vec<Group<Spheres<LANES>>>,
    quads: Vec<Group<Quads<LANES>>>,
}

impl Flat {
    /// `None` if there are too many primitives, or others.
    pub(crate) fn new(tree: &Tree) -> Option<Self> {
        let others = tree.blocks.len() + tree.disks.len() + tree.instances.len();
        (others == 0 && tree.spheres.len() + tree.quads.len() <= FEW).then(|| Self {
            spheres: tree.spheres.chunks(LANES).map(spheres).collect(),
            quads: tree.quads.chunks(LANES).map(quads).collect(),
        })
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.spheres) + size_of_val(&*self.quads)
    }

    /// The closest hit of every ray.
    #[inline(always)]
    pub(crate) fn closest<V: Lanes<LANES>>(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let mut query = Closest::new(ray.t_max);
            self.follow::<V, _>(ray, &mut query);
            *hit = query.hit;
        }
    }

    /// Whether each ray hits anything.
    #[inline(always)]
    pub(crate) fn occluded<V: Lanes<LANES>>(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            let mut query = Any { t_max: ray.t_max, found: false };
            self.follow::<V, _>(ray, &mut query);
            *blocked = query.found;
        }
    }

    /// Offers all hits to the query, until it is content.
    #[inline(always)]
    fn follow<V: Lanes<LANES>, Q: Query>(&self, ray: &Ray, query: &mut Q) {
        let Some(line) = Line::new(ray) else { return };
        for group in &self.spheres {
            if offer(&group.lanes.meet::<V>(&line), &group.keys, query) {
                return;
            }
        }
        for group in &self.quads {
            if offer(&group.lanes.meet::<V>(&line), &group.keys, query) {
                return;
            }
        }
    }
}

#[inline(always)]
fn offer<Q: Query>(met: &Meetings<LANES>, keys: &[Key; LANES], query: &mut Q) -> bool {
    let mut open = met.open;
    while open != 0 {
        let lane = open.trailing_zeros() as usize % LANES;
        open &= open - 1;
        if query.offer(met.at(lane), keys[lane], Hit::NO_INSTANCE) {
            return true;
        }
    }
    false
}

const NO_KEY: Key = Key { geometry: u32::MAX, prim: u32::MAX };

fn spheres(records: &[SphereRecord]) -> Group<Spheres<LANES>> {
    let mut group = Group { lanes: Spheres::NONE, keys: [NO_KEY; LANES] };
    for (lane, record) in records.iter().enumerate() {
        group.lanes.set(lane, record);
        group.keys[lane] = record.key;
    }
    group
}

fn quads(records: &[QuadRecord]) -> Group<Quads<LANES>> {
    let mut group = Group { lanes: Quads::NONE, keys: [NO_KEY; LANES] };
    for (lane, record) in records.iter().enumerate() {
        group.lanes.set(lane, record);
        group.keys[lane] = record.key;
    }
    group
}
