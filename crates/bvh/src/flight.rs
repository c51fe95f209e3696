//! Many rays at once.
//!
//! Some rays are in flight and take turns, so that what one of them needs is on its way from memory while the others are
//! at work. In each round those at nodes go first, then those at triangles, then the others. A visit is the same
//! sequence of instructions whatever it finds, but for rare cases: where a processor has to guess which way a ray goes,
//! a wrong guess ends the work on all rays that it has begun (measured: a third of the time).

use crate::bvh::Tree;
use crate::kernel::{item, item_mut};
use crate::lanes::Machine;
use crate::node::ChildRef;
use crate::prepared::PreparedRay;
use crate::query::Query;
use crate::traverse::{ReadyRay, Stack, Walker, room};
use crate::{Ray, ready};

/// Rays in flight.
const IN_FLIGHT: usize = 32;

/// A ray in flight.
struct Slot<'a, Q> {
    walker: Walker<'a>,
    query: Q,
    /// Its place among the rays.
    index: usize,
}

/// What a slot's ray visits next: slot and reference in one word.
#[derive(Clone, Copy)]
struct Turn(u64);

impl Turn {
    #[inline(always)]
    fn new(slot: usize, next: ChildRef) -> Self {
        Self((slot as u64) << 32 | u64::from(next.0))
    }

    #[inline(always)]
    fn parts(self) -> (usize, ChildRef) {
        ((self.0 >> 32) as usize, ChildRef(self.0 as u32))
    }
}

/// The rays that have not begun.
struct Rest<'a, Q: Query, P> {
    tree: &'a Tree,
    rays: &'a [Ray],
    shared: Q::Shared,
    next: usize,
    /// Eight rays, those made ready as bits.
    ready: [ReadyRay; 8],
    sane: u32,
    /// What to do with an answer.
    put: P,
}

impl<Q: Query, P: FnMut(usize, Q::Answer)> Rest<'_, Q, P> {
    /// The next ray that may hit anything; the others are done at once.
    #[inline(always)]
    fn pull<M: Machine>(&mut self) -> Option<usize> {
        while self.next < self.rays.len() {
            let index = self.next;
            self.next += 1;
            if index.is_multiple_of(8) {
                self.sane = match self.rays[index..].first_chunk() {
                    Some(rays) => ready::eight::<M>(rays, self.tree, &mut self.ready),
                    None => 0,
                };
            }
            if self.sane >> (index % 8) & 1 == 1 {
                return Some(index);
            }
            let ray = &self.rays[index];
            let query = Q::new(self.shared, index, ray);
            match PreparedRay::new(ray, self.tree.extent) {
                Some(prepared) => {
                    self.ready[index % 8] = ReadyRay::new(prepared, self.tree, query.limit());
                    return Some(index);
                }
                None => (self.put)(index, Q::NOTHING),
            }
        }
        None
    }
}

/// Follows all rays and hands each query to `put`.
#[inline(always)]
pub(crate) fn fly<M: Machine, Q: Query>(
    tree: &Tree,
    rays: &[Ray],
    shared: Q::Shared,
    put: impl FnMut(usize, Q::Answer),
) {
    let Some(first) = rays.first() else { return };
    let (count, need) = (rays.len().min(IN_FLIGHT), tree.stack + Stack::ENDS);
    let (mut refs, mut entries) = (Vec::new(), Vec::new());
    let (refs, entries) = (room(&mut refs, count * need), room(&mut entries, count * need));
    let mut slots = Vec::with_capacity(count);
    let mut rest: Rest<'_, Q, _> =
        Rest { tree, rays, shared, next: 0, ready: [ReadyRay::EMPTY; 8], sane: 0, put };
    for (refs, entries) in refs.chunks_exact_mut(need).zip(entries.chunks_exact_mut(need)) {
        let mut stack = Stack { refs, entries };
        stack.lay_ends();
        let walker = Walker::new(tree, ReadyRay::EMPTY, stack);
        let mut slot = Slot { walker, query: Q::new(shared, 0, first), index: 0 };
        if !begin::<M, Q, _>(&mut slot, &mut rest) {
            break;
        }
        slots.push(slot);
    }
    while !slots.is_empty() {
        let mut landed = round::<M, Q, _>(&mut slots, &mut rest);
        while landed != 0 {
            // The last first, so that what is taken out moves none that is still to come.
            let slot = landed.ilog2();
            slots.swap_remove(slot as usize);
            landed ^= 1 << slot;
        }
    }
}

/// A step of each ray. Returns the slots that are empty afterwards, as bits.
#[inline(always)]
fn round<'a, M: Machine, Q: Query, P: FnMut(usize, Q::Answer)>(
    slots: &mut [Slot<'a, Q>],
    rest: &mut Rest<'a, Q, P>,
) -> u32 {
    let count = slots.len();
    // Nodes from the front, the others from the back: both are written, and one of them stays.
    let mut turns = [Turn(0); IN_FLIGHT];
    let large = rest.tree.large;
    let (mut front, mut back) = (0, count);
    for slot in 0..count {
        let walker = &mut item_mut(slots, slot).walker;
        let next = walker.next_evenly::<M, Q>();
        if large {
            walker.prefetch::<M>(next);
        }
        let turn = Turn::new(slot, next);
        *item_mut(&mut turns, front) = turn;
        *item_mut(&mut turns, back - 1) = turn;
        let is_node = usize::from(next.is_node());
        front += is_node;
        back -= 1 - is_node;
    }
    for k in 0..front {
        let (slot, next) = item(&turns, k).parts();
        item_mut(slots, slot).walker.visit_node::<M, Q>(next);
    }
    let mut landed = 0;
    for k in front..count {
        let (place, next) = item(&turns, k).parts();
        let slot = item_mut(slots, place);
        let over = if next.is_triangles() {
            slot.walker.visit_triangles::<M, Q>(next, &mut slot.query)
        } else {
            slot.walker.ends_at(next) || slot.walker.visit_other(next, &mut slot.query)
        };
        if over && !next_ray::<M, Q, P>(slot, rest) {
            landed |= 1 << place;
        }
    }
    landed
}

/// Hands an answer over and begins with another ray, if there is one.
#[inline(always)]
fn next_ray<'a, M: Machine, Q: Query, P: FnMut(usize, Q::Answer)>(
    slot: &mut Slot<'a, Q>,
    rest: &mut Rest<'a, Q, P>,
) -> bool {
    (rest.put)(slot.index, slot.walker.answer::<M, Q>(&slot.query));
    begin::<M, Q, P>(slot, rest)
}

/// Begins with another ray, if there is one.
#[inline(always)]
fn begin<'a, M: Machine, Q: Query, P: FnMut(usize, Q::Answer)>(
    slot: &mut Slot<'a, Q>,
    rest: &mut Rest<'a, Q, P>,
) -> bool {
    let Some(index) = rest.pull::<M>() else { return false };
    slot.walker.restart(rest.tree, &rest.ready[index % 8]);
    (slot.index, slot.query) = (index, Q::new(rest.shared, index, item(rest.rays, index)));
    true
}
