//! Many rays at once.
//!
//! Some rays are in flight and take turns, so that what one of them needs is on its way from memory while the others are
//! at work. In each round those at nodes go first, then those at triangles, then the others. A visit is the same
//! sequence of instructions whatever it finds, but for rare cases: where a processor has to guess which way a ray goes,
//! a wrong guess ends the work on all rays that it has begun (measured: a third of the time).
//!
//! Triangles are visited in two steps. Single precision tells which of a block's eight may be met; those, one or two for
//! each ray on all its way, are then met exactly, also in turns. (Measured against distances of all eight in single precision
//! and one exact hit at the end, as one ray alone does it: 5 to 50 % faster, most where few triangles of a block are met.)

use crate::bvh::Tree;
use crate::kernel::{eight_of, item, item_mut};
use crate::lanes::Machine;
use crate::node::ChildRef;
use crate::prepared::{PreparedRay, TurnedRay};
use crate::primitive::TriangleBlock;
use crate::query::Query;
use crate::traverse::{ReadyRay, Stack, Walker, room};
use crate::{Ray, ready};

/// Rays in flight: a multiple of eight, 64 at most. (Measured against 32: shadow rays 5 to 9 % faster, others up to 6 %; 64 are
/// no faster.)
const IN_FLIGHT: usize = 48;

/// Some of the slots, as bits.
type Places = u64;

/// A ray in flight.
struct Slot<'a, Q> {
    walker: Walker<'a>,
    query: Q,
    /// Its place among the rays.
    index: usize,
    /// Where its part of the stack begins.
    bottom: usize,
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
    let stack = Stack { refs: room(&mut refs, count * need), entries: room(&mut entries, count * need) };
    let rest = Rest { tree, rays, shared, next: 0, ready: [ReadyRay::EMPTY; 8], sane: 0, put };
    let mut flight: Flight<'_, Q, _> = Flight {
        rest,
        slots: Vec::with_capacity(count),
        stack,
        lens: [0; IN_FLIGHT],
        limits: [0.0; IN_FLIGHT],
        nexts: [0; IN_FLIGHT],
        open: [0; IN_FLIGHT],
    };
    for place in 0..count {
        let bottom = place * need;
        flight.stack.lay_ends(bottom);
        let walker = Walker::new(tree, ReadyRay::EMPTY);
        flight.slots.push(Slot { walker, query: Q::new(shared, 0, first), index: 0, bottom });
        if !flight.begin::<M>(place) {
            flight.slots.pop();
            break;
        }
    }
    while !flight.slots.is_empty() {
        let mut landed = flight.round::<M>();
        while landed != 0 {
            // The last first, so that what is taken out moves none that is still to come.
            let place = landed.ilog2();
            flight.take_out(place as usize);
            landed ^= 1 << place;
        }
    }
}

/// Rays in flight.
struct Flight<'a, Q: Query, P> {
    rest: Rest<'a, Q, P>,
    slots: Vec<Slot<'a, Q>>,
    /// What waits for all of them.
    stack: Stack<'a>,
    /// For each slot where the free part of the stack begins, …
    lens: [usize; IN_FLIGHT],
    /// … and how far its ray looks, in units of boxes.
    limits: [f32; IN_FLIGHT],
    /// What is next for each, as [`ChildRef`].
    nexts: [u32; IN_FLIGHT],
    /// Triangles that may be met there, as bits.
    open: [Places; IN_FLIGHT],
}

impl<'a, Q: Query, P: FnMut(usize, Q::Answer)> Flight<'a, Q, P> {
    /// A step of each ray. Returns the slots that are empty afterwards, as bits.
    #[inline(always)]
    fn round<M: Machine>(&mut self) -> Places {
        let [nodes, triangles, ends] = self.take_turns::<M>();
        let others = !(nodes | triangles | ends) & self.occupied();
        self.visit_nodes::<M>(nodes);
        let (mut met, mut content) = (self.visit_triangles::<M>(triangles), 0);
        while met != 0 {
            met = self.meet_triangles::<M>(met, &mut content);
        }
        self.visit_others(others, &mut content);
        self.end::<M>(ends | content)
    }

    /// Finds out what is next for each ray; returns the slots where that is a node, triangles, the end.
    #[inline(always)]
    fn take_turns<M: Machine>(&mut self) -> [Places; 3] {
        let large = self.rest.tree.large;
        for place in 0..self.slots.len() {
            let (len, limit) = (item_mut(&mut self.lens, place), *item(&self.limits, place));
            let next = self.stack.pop_evenly::<M, Q>(len, limit);
            if large {
                item(&self.slots, place).walker.prefetch::<M>(next);
            }
            *item_mut(&mut self.nexts, place) = next.0;
        }
        let all = self.occupied();
        let mut kinds = [0; 3];
        let mut group = 0;
        while group < IN_FLIGHT / 8 {
            let found = M::kinds(eight_of(&self.nexts, 8 * group));
            kinds[0] |= Places::from(found[0]) << (8 * group) & all;
            kinds[1] |= Places::from(found[1]) << (8 * group) & all;
            kinds[2] |= Places::from(found[2]) << (8 * group) & all;
            group += 1;
        }
        kinds
    }

    /// The slots that hold a ray; there is one at least.
    #[inline(always)]
    fn occupied(&self) -> Places {
        Places::MAX >> (Places::BITS as usize - self.slots.len())
    }

    /// What is next in that slot.
    #[inline(always)]
    fn next(&self, place: usize) -> ChildRef {
        ChildRef(*item(&self.nexts, place))
    }

    #[inline(always)]
    fn visit_nodes<M: Machine>(&mut self, places: Places) {
        let mut rest = places;
        while rest != 0 {
            let place = take(&mut rest);
            let (walker, next) = (&item(&self.slots, place).walker, self.next(place));
            walker.visit_node::<M, Q>(next, &mut self.stack, item_mut(&mut self.lens, place));
        }
    }

    /// The block of triangles that is next in that slot, the ray, and how far that looks.
    #[inline(always)]
    fn block(&self, place: usize) -> (&TriangleBlock, &TurnedRay, f32) {
        let slot = item(&self.slots, place);
        let (block, ray) = slot.walker.block(self.next(place));
        (block, ray, slot.query.limit())
    }

    /// Finds out which triangles may be met; returns the slots where there are any.
    #[inline(always)]
    fn visit_triangles<M: Machine>(&mut self, places: Places) -> Places {
        let (mut rest, mut met) = (places, 0);
        while rest & rest.wrapping_sub(1) != 0 {
            let places = [take(&mut rest), take(&mut rest)];
            let [(b0, r0, l0), (b1, r1, l1)] = [self.block(places[0]), self.block(places[1])];
            let [o0, o1] = M::met_by_two([b0, b1], [r0, r1], [l0, l1]);
            *item_mut(&mut self.open, places[0]) = o0.into();
            *item_mut(&mut self.open, places[1]) = o1.into();
            met |= Places::from(o0 != 0) << places[0] | Places::from(o1 != 0) << places[1];
        }
        if rest != 0 {
            let place = take(&mut rest);
            let (block, ray, limit) = self.block(place);
            let open = block.met_before::<M>(ray, limit);
            *item_mut(&mut self.open, place) = open.into();
            met |= Places::from(open != 0) << place;
        }
        met
    }

    /// Meets one triangle in each of these slots. Returns those where there are more.
    #[inline(always)]
    fn meet_triangles<M: Machine>(&mut self, places: Places, content: &mut Places) -> Places {
        let (mut rest, mut more) = (places, 0);
        while rest != 0 {
            let place = take(&mut rest);
            let next = self.next(place);
            let (slot, open) = (item_mut(&mut self.slots, place), item_mut(&mut self.open, place));
            let lane = take(open);
            more |= Places::from(*open != 0) << place;
            let over = slot.walker.meet_triangle::<M, Q>(next, lane, &mut slot.query);
            *item_mut(&mut self.limits, place) = slot.walker.limit();
            *content |= Places::from(over) << place;
        }
        more & !*content
    }

    /// Visits what is neither node nor triangles nor the end of a tree.
    #[inline(always)]
    fn visit_others(&mut self, places: Places, content: &mut Places) {
        let mut rest = places;
        while rest != 0 {
            let place = take(&mut rest);
            *content |= Places::from(self.visit_other(place)) << place;
        }
    }

    /// Visits what is next in that slot, and is no node and no triangles; true if the ray is content with that.
    #[inline(always)]
    fn visit_other(&mut self, place: usize) -> bool {
        let next = self.next(place);
        let (slot, len) = (item_mut(&mut self.slots, place), item_mut(&mut self.lens, place));
        let over = slot.walker.visit_other(next, &mut slot.query, &mut self.stack, len);
        *item_mut(&mut self.limits, place) = slot.walker.limit();
        over
    }

    /// Ends rays, unless they only leave an instance; others begin in their places. Returns the slots where none did.
    #[inline(always)]
    fn end<M: Machine>(&mut self, places: Places) -> Places {
        let (mut rest, mut landed) = (places, 0);
        while rest != 0 {
            let place = take(&mut rest);
            let slot = item(&self.slots, place);
            if self.next(place) == ChildRef::RETURN && !slot.walker.ends_at(ChildRef::RETURN) {
                self.visit_other(place);
                continue;
            }
            (self.rest.put)(slot.index, slot.walker.answer::<M, Q>(&slot.query));
            landed |= Places::from(!self.begin::<M>(place)) << place;
        }
        landed
    }

    /// Begins with another ray in that slot, if there is one: the root waits above the ends on the stack. (Visited at once, it
    /// would be read before what was just written is there: measured, 3 to 7 % slower.)
    #[inline(always)]
    fn begin<M: Machine>(&mut self, place: usize) -> bool {
        let Some(index) = self.rest.pull::<M>() else { return false };
        let slot = item_mut(&mut self.slots, place);
        slot.walker.restart::<M>(self.rest.tree, &self.rest.ready[index % 8]);
        (slot.index, slot.query) = (index, Q::new(self.rest.shared, index, item(self.rest.rays, index)));
        let root = slot.bottom + Stack::ENDS;
        self.stack.lay(root, ChildRef::ROOT);
        *item_mut(&mut self.lens, place) = root + 1;
        *item_mut(&mut self.limits, place) = slot.walker.limit();
        true
    }

    /// Gives a slot up.
    fn take_out(&mut self, place: usize) {
        self.slots.swap_remove(place);
        let last = self.slots.len();
        (self.lens[place], self.limits[place]) = (self.lens[last], self.limits[last]);
    }
}

/// Takes the lowest bit out of several; returns its place.
#[inline(always)]
fn take(bits: &mut Places) -> usize {
    let place = bits.trailing_zeros();
    *bits &= bits.wrapping_sub(1);
    place as usize
}
