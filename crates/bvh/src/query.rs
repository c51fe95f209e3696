//! What a traversal looks for.

mod filtered;

pub(crate) use filtered::{AnyWhere, ClosestWhere, Filtered};

use crate::bvh::Tree;
use crate::kernel::item;
use crate::lanes::{Eight, Machine};
use crate::prepared::PreparedRay;
use crate::primitive::{Key, Meeting, Span};
use crate::{Hit, Ray};

/// Takes the hits that a traversal finds, in any order.
pub(crate) trait Query: Copy {
    /// What all rays of a batch have in common.
    type Shared: Copy;
    /// What is asked of a ray, which is the one at `index` of its batch.
    fn new(shared: Self::Shared, index: usize, ray: &Ray) -> Self;
    /// May a later hit with a primitive count where the first one does not?
    const SEVERAL: bool = false;
    /// Does it pay to visit near boxes first?
    const NEAREST_FIRST: bool;
    /// Boxes entered strictly beyond this distance are of no interest.
    fn limit(&self) -> f32;
    /// Takes a hit; true ends the traversal.
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool;
    /// Takes the hits with the twins of a triangle that was hit, where [`Query::SEVERAL`]; true ends the traversal.
    #[inline(always)]
    fn offer_twins(&mut self, _tree: &Tree, _at: Meeting, _number: u32, _instance: u32) -> bool {
        false
    }
    /// Takes the hits with a block of triangles; true ends the traversal. What single precision leaves open takes the
    /// exact test.
    #[inline(always)]
    fn visit<M: Machine>(&mut self, tree: &Tree, index: usize, ray: &PreparedRay, instance: u32) -> bool {
        let block = item(&tree.blocks, index);
        let open = block.met_before::<M>(&ray.turned, self.limit());
        self.visit_exactly::<M>(tree, index, open, ray, instance)
    }

    /// Takes a hit with a triangle by its number, if it `counts`: without branches, where that pays. True once, where it
    /// ends the traversal.
    #[inline(always)]
    fn offer_evenly<M: Machine>(
        &mut self,
        tree: &Tree,
        at: Meeting,
        counts: bool,
        number: u32,
        instance: u32,
    ) -> bool {
        counts
            && at.t <= self.limit()
            && (self.offer(at, Key::numbered(number, &tree.starts), instance)
                || (Self::SEVERAL && self.offer_twins(tree, at, number, instance)))
    }
    /// What is answered.
    type Answer: Copy;
    /// The answer where there is nothing to hit.
    const NOTHING: Self::Answer;
    /// The answer at the end.
    fn answer<M: Machine>(&self, tree: &Tree, ray: &PreparedRay, instance: u32) -> Self::Answer;
    /// To be called before the ray, the blocks or the instance change.
    #[inline(always)]
    fn settle<M: Machine>(&mut self, _tree: &Tree, _ray: &PreparedRay, _instance: u32) {}

    /// The exact test of some triangles.
    #[inline(always)]
    fn visit_exactly<M: Machine>(
        &mut self,
        tree: &Tree,
        index: usize,
        lanes: u32,
        ray: &PreparedRay,
        instance: u32,
    ) -> bool {
        let block = item(&tree.blocks, index);
        let mut open = lanes;
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            if let Some(meeting) = block.meet::<M>(lane, ray)
                && meeting.t <= self.limit()
                && (self.offer(meeting, Key::numbered(block.number(lane), &tree.starts), instance)
                    || (Self::SEVERAL && self.offer_twins(tree, meeting, block.number(lane), instance)))
            {
                return true;
            }
        }
        false
    }
}

/// The triangles of a block that a ray may meet before `limit`.
#[inline(always)]
fn before<M: Machine>(span: &Span<M>, limit: f32, behind: f32) -> u32 {
    let limit = if limit > 0.0 { limit } else { 0.0 };
    span.met
        & span.from.not_above(M::Eight::splat(limit + f32::MIN_POSITIVE))
        & !span.to.below(M::Eight::splat(behind))
}

/// The triangles that lie between what single precision can tell and `end`, as bits.
#[inline(always)]
fn within<M: Machine>(span: &Span<M>, ray: &PreparedRay, end: f32) -> u32 {
    M::Eight::splat(ray.turned.beyond).below(span.from) & span.to.below(M::Eight::splat(end))
}

/// The closest hit, the smallest id among equals.
///
/// The exact distance of a hit is computed when it is needed: to tell it from another one close by, and at the end.
#[derive(Clone, Copy)]
pub(crate) struct Closest {
    pub(crate) hit: Hit,
    /// The best distance so far is not below this …
    first: f32,
    /// … and not above this.
    limit: f32,
    /// The block whose hit is the best one, if `hit` is not.
    block: u32,
    lane: u32,
}

/// No block.
const NONE: u32 = u32::MAX;

impl Closest {
    #[inline(always)]
    pub(crate) fn until(t_max: f32) -> Self {
        Self { hit: Hit::MISS, first: t_max, limit: t_max, block: NONE, lane: 0 }
    }

    /// Whether a hit comes before the best one so far.
    #[inline(always)]
    fn yields_to(&self, at: &Meeting, key: Key, instance: u32) -> bool {
        yields(&self.hit, self.limit, at, key, instance)
    }

    #[inline(always)]
    fn take(&mut self, at: Meeting, key: Key, instance: u32) {
        (self.first, self.limit) = (at.t, at.t);
        self.hit = at.hit(key, instance);
    }
}

/// Whether a hit comes before `old`, or before `limit` if there is none.
#[inline(always)]
fn yields(old: &Hit, limit: f32, at: &Meeting, key: Key, instance: u32) -> bool {
    at.t < limit
        || (at.t == limit
            && rank(key.geometry, key.prim, instance) < rank(old.geometry, old.prim, old.instance))
}

/// Order among equal distances: place in the top-level list, then geometry, then primitive.
#[inline(always)]
fn rank(geometry: u32, prim: u32, instance: u32) -> (u32, u32, u32) {
    (if instance == Hit::NO_INSTANCE { geometry } else { instance }, geometry, prim)
}

impl Query for Closest {
    type Shared = ();
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn new((): (), _index: usize, ray: &Ray) -> Self {
        Self::until(ray.t_max)
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool {
        if self.yields_to(&at, key, instance) {
            self.take(at, key, instance);
        }
        false
    }

    #[inline(always)]
    fn visit<M: Machine>(&mut self, tree: &Tree, index: usize, ray: &PreparedRay, instance: u32) -> bool {
        let block = item(&tree.blocks, index);
        let Some(span) = block.span::<M>(&ray.turned, self.limit) else { return false };
        let open = before(&span, self.limit, ray.turned.behind);
        if open == 0 {
            return false;
        }
        let inside = within(&span, ray, self.first);
        if open & (open - 1) == 0 && open & span.sure & inside != 0 {
            let lane = open.trailing_zeros();
            (self.block, self.lane) = (index as u32, lane);
            (self.first, self.limit) = (span.from.lane(lane as usize), span.to.lane(lane as usize));
            return false;
        }
        self.settle::<M>(tree, ray, instance);
        self.visit_exactly::<M>(tree, index, open, ray, instance)
    }

    type Answer = Hit;
    const NOTHING: Hit = Hit::MISS;

    #[inline(always)]
    fn answer<M: Machine>(&self, tree: &Tree, ray: &PreparedRay, instance: u32) -> Hit {
        if self.block == NONE {
            return self.hit;
        }
        let (block, lane) = (item(&tree.blocks, self.block as usize), self.lane as usize);
        let meeting = block.meet_surely::<M>(lane, &ray.turned);
        meeting.hit(Key::numbered(block.number(lane), &tree.starts), instance)
    }

    #[inline(always)]
    fn settle<M: Machine>(&mut self, tree: &Tree, ray: &PreparedRay, instance: u32) {
        if self.block != NONE {
            self.hit = self.answer::<M>(tree, ray, instance);
            (self.first, self.limit, self.block) = (self.hit.t, self.hit.t, NONE);
        }
    }
}

/// The closest hit, each computed at once to the last digit.
#[derive(Clone, Copy)]
pub(crate) struct Nearest {
    /// Until there is one: a miss at the limit. While `geometry` is [`NONE`], `prim` is a number among all.
    hit: Hit,
    /// The last that was not nearer: hits are written in any case, without a branch.
    farther: Hit,
}

impl Query for Nearest {
    type Shared = ();
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn new((): (), _index: usize, ray: &Ray) -> Self {
        Self { hit: Hit { t: ray.t_max, ..Hit::MISS }, farther: Hit::MISS }
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.hit.t
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool {
        if yields(&self.hit, self.hit.t, &at, key, instance) {
            self.hit = at.hit(key, instance);
        }
        false
    }

    #[inline(always)]
    fn offer_evenly<M: Machine>(
        &mut self,
        tree: &Tree,
        at: Meeting,
        counts: bool,
        number: u32,
        instance: u32,
    ) -> bool {
        if counts & (at.t == self.hit.t) {
            self.complete(tree);
            return self.offer(at, Key::numbered(number, &tree.starts), instance);
        }
        let nearer = counts & (at.t < self.hit.t);
        let to = std::hint::select_unpredictable(nearer, &mut self.hit, &mut self.farther);
        M::put(at.hit(Key { geometry: NONE, prim: number }, instance), to);
        false
    }

    type Answer = Hit;
    const NOTHING: Hit = Hit::MISS;

    #[inline(always)]
    fn answer<M: Machine>(&self, tree: &Tree, _ray: &PreparedRay, _instance: u32) -> Hit {
        let mut done = *self;
        done.complete(tree);
        if done.hit.is_hit() { done.hit } else { Hit::MISS }
    }

    #[inline(always)]
    fn settle<M: Machine>(&mut self, tree: &Tree, _ray: &PreparedRay, _instance: u32) {
        self.complete(tree);
    }
}

impl Nearest {
    /// Finds out geometry and primitive.
    #[inline(always)]
    fn complete(&mut self, tree: &Tree) {
        if self.hit.geometry == NONE && self.hit.is_hit() {
            let key = Key::numbered(self.hit.prim, &tree.starts);
            (self.hit.geometry, self.hit.prim) = (key.geometry, key.prim);
        }
    }
}

/// Any hit at all.
#[derive(Clone, Copy)]
pub(crate) struct Any {
    pub(crate) t_max: f32,
    pub(crate) found: bool,
}

impl Query for Any {
    type Shared = ();
    const NEAREST_FIRST: bool = false;

    #[inline(always)]
    fn new((): (), _index: usize, ray: &Ray) -> Self {
        Self { t_max: ray.t_max, found: false }
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn offer(&mut self, _at: Meeting, _key: Key, _instance: u32) -> bool {
        self.found = true;
        true
    }

    #[inline(always)]
    fn offer_evenly<M: Machine>(
        &mut self,
        _tree: &Tree,
        _at: Meeting,
        counts: bool,
        _number: u32,
        _instance: u32,
    ) -> bool {
        let first = counts & !self.found;
        self.found |= counts;
        first
    }

    type Answer = bool;
    const NOTHING: bool = false;

    #[inline(always)]
    fn answer<M: Machine>(&self, _tree: &Tree, _ray: &PreparedRay, _instance: u32) -> bool {
        self.found
    }
}
