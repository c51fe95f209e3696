//! The way of a ray through the trees.

use crate::bvh::Tree;
use crate::lanes::Machine;
use crate::node::{BoxRay, ChildRef, Crossing, Kind, Node, WIDTH};
use crate::prepared::PreparedRay;
use crate::query::{Any, Closest, Query};
use crate::{Bvh, Hit, Ray, few};

/// A subtree still to visit and where the ray enters it.
#[derive(Clone, Copy)]
struct Waiting {
    entry: f32,
    child: ChildRef,
}

/// Entries kept in place. Seven may wait per level, so most trees need no more; the rest goes to the heap.
const INLINE: usize = 64;

/// What still has to be visited. One serves any number of rays.
pub(crate) struct Stack {
    inline: [Waiting; INLINE],
    len: usize,
    overflow: Vec<Waiting>,
}

impl Stack {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let nothing = Waiting { entry: 0.0, child: ChildRef::ROOT };
        Self { inline: [nothing; INLINE], len: 0, overflow: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, waiting: Waiting) {
        if let Some(slot) = self.inline.get_mut(self.len) {
            *slot = waiting;
            self.len += 1;
        } else {
            self.overflow.push(waiting);
        }
    }

    /// The last one pushed, unless only `base` are left.
    #[inline(always)]
    fn pop(&mut self, base: usize) -> Option<Waiting> {
        if !self.overflow.is_empty() && self.height() > base {
            return self.overflow.pop();
        }
        if self.len <= base {
            return None;
        }
        self.len -= 1;
        self.inline.get(self.len).copied()
    }

    #[inline(always)]
    fn height(&self) -> usize {
        self.len + self.overflow.len()
    }
}

/// The closest hit of every ray. `M` is the processor it runs on.
#[inline(always)]
pub(crate) fn closest<M: Machine>(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    if bvh.tree.few {
        return few::closest::<M::Four>(&bvh.tree, rays, hits);
    }
    let mut stack = Stack::new();
    for (ray, hit) in rays.iter().zip(hits) {
        let mut query = Closest::new(ray.t_max);
        follow::<M, _>(bvh, ray, &mut query, &mut stack);
        *hit = query.hit;
    }
}

/// Whether each ray hits anything.
#[inline(always)]
pub(crate) fn occluded<M: Machine>(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    if bvh.tree.few {
        return few::occluded::<M::Four>(&bvh.tree, rays, blocked);
    }
    let mut stack = Stack::new();
    for (ray, blocked) in rays.iter().zip(blocked) {
        let mut query = Any { t_max: ray.t_max, found: false };
        follow::<M, _>(bvh, ray, &mut query, &mut stack);
        *blocked = query.found;
    }
}

#[inline(always)]
fn follow<M: Machine, Q: Query>(bvh: &Bvh, ray: &Ray, query: &mut Q, stack: &mut Stack) {
    let Some(ray) = PreparedRay::new(ray) else { return };
    stack.len = 0;
    stack.overflow.clear();
    if bvh.tree.instances.is_empty() {
        walk::<M, Q, false>(&bvh.tree, &ray, query, stack, Hit::NO_INSTANCE);
    } else {
        walk::<M, Q, true>(&bvh.tree, &ray, query, stack, Hit::NO_INSTANCE);
    }
}

/// Visits one tree; true if the query is content. `TOP` is for trees with instances.
#[inline(always)]
fn walk<M: Machine, Q: Query, const TOP: bool>(
    tree: &Tree,
    ray: &PreparedRay,
    query: &mut Q,
    stack: &mut Stack,
    instance: u32,
) -> bool {
    let boxes = BoxRay::new::<TOP>(ray, &tree.bounds, tree.aside);
    let base = stack.height();
    let mut current = ChildRef::ROOT;
    loop {
        if current.kind() == Kind::Node {
            let node = &tree.nodes[current.index()];
            let crossing = node.cross::<M, TOP>(&boxes, boxes.limit(query.limit()));
            if crossing.mask != 0 {
                current = spread::<Q>(&crossing, node, stack);
                continue;
            }
        } else if visit_leaf::<M, Q, TOP>(tree, current, ray, query, stack, instance) {
            return true;
        }
        loop {
            let Some(next) = stack.pop(base) else { return false };
            if next.entry <= boxes.limit(query.limit()) {
                current = next.child;
                break;
            }
        }
    }
}

/// Picks the child to visit now (the nearest, if that matters) and pushes the others, the farthest first.
#[inline(always)]
fn spread<Q: Query>(crossing: &Crossing, node: &Node, stack: &mut Stack) -> ChildRef {
    let mut rest = crossing.mask;
    let mut next = || {
        let lane = rest.trailing_zeros() as usize % WIDTH;
        rest &= rest.wrapping_sub(1);
        (Waiting { entry: crossing.entry[lane], child: node.child(lane) }, rest == 0)
    };
    let (mut nearest, mut last) = next();
    let mut far = [nearest; WIDTH];
    let mut count = 0;
    while !last {
        let mut new;
        (new, last) = next();
        if Q::NEAREST_FIRST {
            if new.entry < nearest.entry {
                std::mem::swap(&mut new, &mut nearest);
            }
            let mut place = count;
            while place > 0 && far[(place - 1) % WIDTH].entry < new.entry {
                far[place % WIDTH] = far[(place - 1) % WIDTH];
                place -= 1;
            }
            far[place % WIDTH] = new;
            count += 1;
        } else {
            stack.push(new);
        }
    }
    far[..count.min(WIDTH)].iter().for_each(|&waiting| stack.push(waiting));
    nearest.child
}

#[inline(always)]
fn visit_leaf<M: Machine, Q: Query, const TOP: bool>(
    tree: &Tree,
    leaf: ChildRef,
    ray: &PreparedRay,
    query: &mut Q,
    stack: &mut Stack,
    instance: u32,
) -> bool {
    let (meeting, key) = match leaf.kind() {
        Kind::Triangles => {
            let block = &tree.blocks[leaf.index()];
            let mut open = block.candidates::<M>(ray);
            while open != 0 {
                let lane = open.trailing_zeros() as usize % WIDTH;
                open &= open - 1;
                if let Some(meeting) = block.meet(lane, ray)
                    && query.offer(meeting, block.key(lane), instance)
                {
                    return true;
                }
            }
            return false;
        }
        Kind::Sphere => {
            let sphere = &tree.spheres[leaf.index()];
            (sphere.meet(&ray.line).single(), sphere.key)
        }
        Kind::Quad => {
            let quad = &tree.quads[leaf.index()];
            (quad.meet(&ray.line).single(), quad.key)
        }
        Kind::Disk => {
            let disk = &tree.disks[leaf.index()];
            (disk.meet(&ray.line).single(), disk.key)
        }
        Kind::Node | Kind::Instance => {
            if !TOP {
                return false;
            }
            let record = &tree.instances[leaf.index()];
            // No closure: it would not be compiled for the instruction set chosen.
            let Some(local) = record.local_ray(ray) else { return false };
            return walk_nested::<M, Q>(&record.bvh.tree, &local, query, stack, record.index);
        }
    };
    meeting.is_some_and(|meeting| query.offer(meeting, key, instance))
}

/// A call of its own, so that the compiler sees no endless inlining.
#[inline(always)]
fn walk_nested<M: Machine, Q: Query>(
    tree: &Tree,
    ray: &PreparedRay,
    query: &mut Q,
    stack: &mut Stack,
    instance: u32,
) -> bool {
    walk::<M, Q, false>(tree, ray, query, stack, instance)
}
