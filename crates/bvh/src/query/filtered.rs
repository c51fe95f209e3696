//! What a traversal looks for where not every hit counts.
//!
//! Every candidate takes the exact test ([`Query::visit`] as it is), for the filter wants complete hits. Nothing here is on the way of rays that
//! have no filter.

use super::{Any, Closest, Query};
use crate::bvh::Tree;
use crate::filter::Filter;
use crate::kernel::item;
use crate::lanes::Machine;
use crate::prepared::PreparedRay;
use crate::primitive::{Key, Meeting};
use crate::{Hit, Ray};

/// Rays and the filter of their hits.
#[derive(Clone, Copy)]
pub(crate) struct Filtered<'f> {
    pub(crate) rays: &'f [Ray],
    pub(crate) filter: &'f dyn Filter,
}

/// The filter as one ray sees it.
#[derive(Clone, Copy)]
struct Judge<'f> {
    all: Filtered<'f>,
    /// Place of the ray.
    index: usize,
}

impl Judge<'_> {
    #[inline(always)]
    fn accepts(&self, hit: &Hit) -> bool {
        self.all.filter.accepts(self.index, item(self.all.rays, self.index), hit)
    }
}

/// The closest hit that counts.
#[derive(Clone, Copy)]
pub(crate) struct ClosestWhere<'f> {
    best: Closest,
    judge: Judge<'f>,
}

/// Any hit that counts.
#[derive(Clone, Copy)]
pub(crate) struct AnyWhere<'f> {
    any: Any,
    judge: Judge<'f>,
}

impl<'f> Query for ClosestWhere<'f> {
    type Shared = Filtered<'f>;
    const NEAREST_FIRST: bool = true;
    const SEVERAL: bool = true;

    #[inline(always)]
    fn new(all: Filtered<'f>, index: usize, ray: &Ray) -> Self {
        Self { best: Closest::until(ray.t_max), judge: Judge { all, index } }
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.best.limit
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool {
        if self.best.yields_to(&at, key, instance) && self.judge.accepts(&at.hit(key, instance)) {
            self.best.take(at, key, instance);
        }
        false
    }

    fn offer_twins(&mut self, tree: &Tree, at: Meeting, number: u32, instance: u32) -> bool {
        for twin in tree.twins_of(number) {
            let key = Key::numbered(twin.number, &tree.starts);
            // One that counts wins against all that follow.
            if !self.best.yields_to(&at, key, instance) {
                break;
            }
            self.offer(at, key, instance);
        }
        false
    }

    type Answer = Hit;
    const NOTHING: Hit = Hit::MISS;

    #[inline(always)]
    fn answer<M: Machine>(&self, _tree: &Tree, _ray: &PreparedRay, _instance: u32) -> Hit {
        self.best.hit
    }
}

impl<'f> Query for AnyWhere<'f> {
    type Shared = Filtered<'f>;
    const NEAREST_FIRST: bool = false;
    const SEVERAL: bool = true;

    #[inline(always)]
    fn new(all: Filtered<'f>, index: usize, ray: &Ray) -> Self {
        Self { any: Any { t_max: ray.t_max, found: false }, judge: Judge { all, index } }
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.any.t_max
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool {
        self.any.found = self.judge.accepts(&at.hit(key, instance));
        self.any.found
    }

    fn offer_twins(&mut self, tree: &Tree, at: Meeting, number: u32, instance: u32) -> bool {
        let mut twins = tree.twins_of(number).iter();
        twins.any(|twin| self.offer(at, Key::numbered(twin.number, &tree.starts), instance))
    }

    type Answer = bool;
    const NOTHING: bool = false;

    #[inline(always)]
    fn answer<M: Machine>(&self, _tree: &Tree, _ray: &PreparedRay, _instance: u32) -> bool {
        self.any.found
    }
}
