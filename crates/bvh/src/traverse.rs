//! The way of rays through the trees.
//!
//! A [`Walker`] is a ray on its way; each step visits a node or a leaf. One ray alone is walked to its end; of many,
//! some are in flight at once and take turns, so that what one of them needs is on its way from memory while the
//! others are at work. In each round those at nodes go first and those at leaves afterwards (measured: 13 % faster than
//! one after the other, for the branch between the two cannot be foretold).

use crate::bvh::Tree;
use crate::kernel::item;
use crate::lanes::Machine;
use crate::node::{BoxRay, ChildRef, Kind, Node};
use crate::prepared::PreparedRay;
use crate::primitive::{Key, Meeting};
use crate::query::{Any, Closest, Query};
use crate::{Bvh, Hit, Ray, few};

/// Rays in flight. Measured on AVX-512: 32 and 64 are alike, 16 is 3 to 4 % slower.
const IN_FLIGHT: usize = 32;
/// Fewer rays are walked one after the other.
const WORTH_FLYING: usize = 4;
/// Entries of a stack that need no memory of their own; enough for trees of 16 levels.
const INLINE: usize = 128;

/// What still has to be visited: references and where the ray enters them.
struct Stack<'a> {
    refs: &'a mut [u32],
    entries: &'a mut [f32],
    len: usize,
}

impl Stack<'_> {
    /// Room for eight more.
    #[inline(always)]
    fn room(&mut self) -> (&mut [u32; 8], &mut [f32; 8]) {
        let refs =
            self.refs[self.len..].first_chunk_mut().expect("a stack is made for the depth of its tree");
        let entries = self.entries[self.len..].first_chunk_mut().expect("both lists are of one length");
        (refs, entries)
    }
}

/// A ray on its way.
struct Walker<'a, Q> {
    tree: &'a Tree,
    ray: PreparedRay,
    boxes: BoxRay,
    query: Q,
    /// The query's limit in the units of `boxes`.
    limit: f32,
    current: ChildRef,
    instance: u32,
    stack: Stack<'a>,
    /// While in an instance: where it came from.
    outer: Option<Outer<'a>>,
}

struct Outer<'a> {
    tree: &'a Tree,
    ray: PreparedRay,
    boxes: BoxRay,
}

impl<'a, Q: Query> Walker<'a, Q> {
    #[inline(always)]
    fn new(tree: &'a Tree, ray: PreparedRay, query: Q, stack: Stack<'a>) -> Self {
        let boxes = BoxRay::new(&ray, tree.extent, tree.aside);
        let limit = boxes.limit(query.limit());
        let (current, instance) = (ChildRef::ROOT, Hit::NO_INSTANCE);
        Self { tree, ray, boxes, query, limit, current, instance, stack, outer: None }
    }

    /// The same for another ray.
    #[inline(always)]
    fn restart(&mut self, tree: &'a Tree, ray: PreparedRay, query: Q) {
        self.tree = tree;
        self.boxes = BoxRay::new(&ray, tree.extent, tree.aside);
        self.limit = self.boxes.limit(query.limit());
        (self.ray, self.query) = (ray, query);
        (self.current, self.instance, self.outer) = (ChildRef::ROOT, Hit::NO_INSTANCE, None);
        self.stack.len = 0;
    }

    /// Visits a node or a leaf; true at the end of the way.
    #[inline(always)]
    fn step<M: Machine>(&mut self) -> bool {
        if !self.current.is_node() {
            return self.visit_leaf::<M>() || self.pop();
        }
        let node = item(&self.tree.nodes, self.current.index());
        let (mask, entry) = node.cross::<M>(&self.boxes, self.limit);
        if mask == 0 {
            return self.pop();
        }
        if mask & (mask - 1) == 0 {
            self.current = node.child(mask.trailing_zeros());
            return false;
        }
        self.put_aside::<M>(node, mask, entry);
        self.stack.len -= 1;
        self.current = ChildRef(self.stack.refs[self.stack.len]);
        false
    }

    /// Visits a node, the same way for any number of children; true at the end of the way.
    #[inline(always)]
    fn visit_node<M: Machine>(&mut self) -> bool {
        let node = item(&self.tree.nodes, self.current.index());
        let (mask, entry) = node.cross::<M>(&self.boxes, self.limit);
        self.put_aside::<M>(node, mask, entry);
        self.pop()
    }

    /// Puts the children in `mask` on the stack, the nearest last if that matters.
    #[inline(always)]
    fn put_aside<M: Machine>(&mut self, node: &Node, mask: u32, entry: M::Eight) {
        let octant = self.boxes.octant;
        let (refs, entries) = self.stack.room();
        if Q::NEAREST_FIRST {
            M::arrange(mask, node.order(octant), node.children(), entry, refs, entries);
        } else {
            M::compress(mask, node.children(), refs);
        }
        self.stack.len += mask.count_ones() as usize;
    }

    /// Goes on with what was put aside last; true if there is nothing.
    #[inline(always)]
    fn pop(&mut self) -> bool {
        while self.stack.len > 0 {
            self.stack.len -= 1;
            let next = ChildRef(self.stack.refs[self.stack.len]);
            if next == ChildRef::RETURN {
                self.leave();
            } else if !Q::NEAREST_FIRST || self.reaches(self.stack.entries[self.stack.len]) {
                self.current = next;
                return false;
            }
        }
        true
    }

    /// Whether a box that is entered there may hold something of interest; NaN decides nothing.
    #[inline(always)]
    fn reaches(&self, entry: f32) -> bool {
        let beyond = entry > self.limit;
        !beyond
    }

    /// True if the query is content.
    #[inline(always)]
    fn visit_leaf<M: Machine>(&mut self) -> bool {
        let (tree, index) = (self.tree, self.current.index());
        match self.current.kind() {
            Kind::Triangles => {
                let block = item(&tree.blocks, index);
                let mut open = block.candidates::<M>(&self.ray);
                while open != 0 {
                    let lane = open.trailing_zeros() as usize % 8;
                    open &= open - 1;
                    if let Some(meeting) = block.meet(lane, &self.ray)
                        && self.offer(meeting, block.key(lane))
                    {
                        return true;
                    }
                }
                false
            }
            Kind::Sphere => {
                let sphere = item(&tree.spheres, index);
                sphere.meet(&self.ray.line()).single().is_some_and(|at| self.offer(at, sphere.key))
            }
            Kind::Quad => {
                let quad = item(&tree.quads, index);
                quad.meet(&self.ray.line()).single().is_some_and(|at| self.offer(at, quad.key))
            }
            Kind::Disk => {
                let disk = item(&tree.disks, index);
                disk.meet(&self.ray.line()).single().is_some_and(|at| self.offer(at, disk.key))
            }
            Kind::Instance => {
                self.enter(index);
                false
            }
            Kind::Node | Kind::Return => false,
        }
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key) -> bool {
        let content = self.query.offer(at, key, self.instance);
        self.limit = self.boxes.limit(self.query.limit());
        content
    }

    /// Goes into an instance, if the ray can be followed there: its root waits next, and below it the way back.
    fn enter(&mut self, index: usize) {
        let record = item(&self.tree.instances, index);
        let Some(local) = record.local_ray(&self.ray) else { return };
        let inner = &record.bvh.tree;
        let boxes = BoxRay::new(&local, inner.extent, inner.aside);
        self.limit = boxes.limit(self.query.limit());
        let (refs, entries) = self.stack.room();
        (refs[0], refs[1]) = (ChildRef::RETURN.0, ChildRef::ROOT.0);
        (entries[0], entries[1]) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        self.stack.len += 2;
        let outer = Outer {
            tree: std::mem::replace(&mut self.tree, inner),
            ray: std::mem::replace(&mut self.ray, local),
            boxes: std::mem::replace(&mut self.boxes, boxes),
        };
        (self.outer, self.instance) = (Some(outer), record.index);
    }

    /// Comes back from an instance.
    fn leave(&mut self) {
        let Some(outer) = self.outer.take() else { return };
        (self.tree, self.ray, self.boxes) = (outer.tree, outer.ray, outer.boxes);
        self.instance = Hit::NO_INSTANCE;
        self.limit = self.boxes.limit(self.query.limit());
    }

    /// Says what the next step will read.
    #[inline(always)]
    fn prefetch<M: Machine>(&self) {
        let index = self.current.index();
        if self.current.is_node() {
            M::prefetch(item(&self.tree.nodes, index));
        } else if self.current.kind() == Kind::Triangles {
            M::prefetch(item(&self.tree.blocks, index));
        }
    }
}

/// The closest hit of every ray. `M` is the processor it runs on.
#[inline(always)]
pub(crate) fn closest<M: Machine>(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    if bvh.tree.few {
        return few::closest::<M::Four>(&bvh.tree, rays, hits);
    }
    let mut put = |i: usize, query: Closest| hits[i] = query.hit;
    trace::<M, Closest>(bvh, rays, &mut put);
}

/// Whether each ray hits anything.
#[inline(always)]
pub(crate) fn occluded<M: Machine>(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    if bvh.tree.few {
        return few::occluded::<M::Four>(&bvh.tree, rays, blocked);
    }
    let mut put = |i: usize, query: Any| blocked[i] = query.found;
    trace::<M, Any>(bvh, rays, &mut put);
}

/// Follows all rays and hands each query to `put`.
#[inline(always)]
fn trace<M: Machine, Q: Query>(bvh: &Bvh, rays: &[Ray], put: &mut impl FnMut(usize, Q)) {
    let need = bvh.tree.stack;
    if rays.len() >= WORTH_FLYING {
        return fly::<M, Q>(bvh, rays, need, put);
    }
    let (mut refs, mut entries) = ([0; INLINE], [0.0; INLINE]);
    let (mut more_refs, mut more_entries) = (Vec::new(), Vec::new());
    let (mut refs, mut entries) = (&mut refs[..], &mut entries[..]);
    if need > INLINE {
        more_refs.resize(need, 0);
        more_entries.resize(need, 0.0);
        (refs, entries) = (&mut more_refs[..], &mut more_entries[..]);
    }
    for (i, ray) in rays.iter().enumerate() {
        let query = Q::new(ray);
        let Some(ray) = PreparedRay::new(ray) else {
            put(i, query);
            continue;
        };
        let stack = Stack { refs: &mut *refs, entries: &mut *entries, len: 0 };
        let mut walker = Walker::new(&bvh.tree, ray, query, stack);
        while !walker.step::<M>() {}
        put(i, walker.query);
    }
}

/// The next ray that may hit anything; the others are done at once.
#[inline(always)]
fn next_ray<Q: Query>(
    rays: &[Ray],
    next: &mut usize,
    put: &mut impl FnMut(usize, Q),
) -> Option<(usize, PreparedRay, Q)> {
    while let Some(ray) = rays.get(*next) {
        let (index, query) = (*next, Q::new(ray));
        *next += 1;
        match PreparedRay::new(ray) {
            Some(prepared) => return Some((index, prepared, query)),
            None => put(index, query),
        }
    }
    None
}

/// Several rays in flight.
#[inline(always)]
fn fly<M: Machine, Q: Query>(bvh: &Bvh, rays: &[Ray], need: usize, put: &mut impl FnMut(usize, Q)) {
    let count = rays.len().min(IN_FLIGHT);
    let (mut refs, mut entries) = (vec![0; count * need], vec![0.0; count * need]);
    let stacks = refs.chunks_exact_mut(need).zip(entries.chunks_exact_mut(need));
    let mut next = 0;
    let mut slots = Vec::with_capacity(count);
    for (refs, entries) in stacks {
        let Some((index, ray, query)) = next_ray(rays, &mut next, put) else { break };
        slots.push((index, Walker::new(&bvh.tree, ray, query, Stack { refs, entries, len: 0 })));
    }
    let mut ended = Chosen::new();
    while !slots.is_empty() {
        round::<M, Q>(&mut slots, &mut ended);
        // The last first, so that what is taken out moves none that is still to come.
        for &i in ended.list().iter().rev() {
            let (index, walker) = &mut slots[i];
            put(*index, walker.query);
            match next_ray(rays, &mut next, put) {
                Some((new, ray, query)) => {
                    *index = new;
                    walker.restart(&bvh.tree, ray, query);
                }
                None => drop(slots.swap_remove(i)),
            }
        }
    }
}

/// Slots chosen one after the other, without branches.
struct Chosen {
    slots: [usize; IN_FLIGHT],
    count: usize,
}

impl Chosen {
    #[inline(always)]
    fn new() -> Self {
        Self { slots: [0; IN_FLIGHT], count: 0 }
    }

    #[inline(always)]
    fn add_if(&mut self, slot: usize, chosen: bool) {
        self.slots[self.count % IN_FLIGHT] = slot;
        self.count += usize::from(chosen);
    }

    #[inline(always)]
    fn list(&self) -> &[usize] {
        &self.slots[..self.count.min(IN_FLIGHT)]
    }
}

/// A step of each ray: first those at nodes, then those at leaves, so that the processor foretells which it is.
#[inline(always)]
fn round<M: Machine, Q: Query>(slots: &mut [(usize, Walker<'_, Q>)], ended: &mut Chosen) {
    let (mut at_nodes, mut at_leaves) = (Chosen::new(), Chosen::new());
    for (i, (_, walker)) in slots.iter().enumerate() {
        let is_node = walker.current.is_node();
        at_nodes.add_if(i, is_node);
        at_leaves.add_if(i, !is_node);
    }
    ended.count = 0;
    for &i in at_nodes.list() {
        let walker = &mut slots[i].1;
        let over = walker.visit_node::<M>();
        ended.add_if(i, over);
        if !over {
            walker.prefetch::<M>();
        }
    }
    for &i in at_leaves.list() {
        let walker = &mut slots[i].1;
        let over = walker.visit_leaf::<M>() || walker.pop();
        ended.add_if(i, over);
        if !over {
            walker.prefetch::<M>();
        }
    }
    let count = ended.count.min(IN_FLIGHT);
    ended.slots[..count].sort_unstable();
}
