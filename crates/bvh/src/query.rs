//! What a traversal looks for.

use crate::{Hit, Ray, primitive::Key, primitive::Meeting};

/// Takes the hits that a traversal finds, in any order.
pub(crate) trait Query: Copy {
    /// What is asked of a ray.
    fn new(ray: &Ray) -> Self;
    /// Does it pay to visit near boxes first?
    const NEAREST_FIRST: bool;
    /// Boxes entered strictly beyond this distance are of no interest.
    fn limit(&self) -> f32;
    /// Takes a hit; true ends the traversal.
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool;
}

/// The closest hit, the smallest id among equals.
#[derive(Clone, Copy)]
pub(crate) struct Closest {
    pub(crate) hit: Hit,
    limit: f32,
}

impl Closest {
    #[inline(always)]
    pub(crate) fn until(t_max: f32) -> Self {
        Self { hit: Hit::MISS, limit: t_max }
    }
}

/// Order among equal distances: place in the top-level list, then geometry, then primitive.
#[inline(always)]
fn rank(geometry: u32, prim: u32, instance: u32) -> (u32, u32, u32) {
    (if instance == Hit::NO_INSTANCE { geometry } else { instance }, geometry, prim)
}

impl Query for Closest {
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self::until(ray.t_max)
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn offer(&mut self, at: Meeting, key: Key, instance: u32) -> bool {
        let old = &self.hit;
        let wins = at.t < self.limit
            || (at.t == self.limit
                && rank(key.geometry, key.prim, instance) < rank(old.geometry, old.prim, old.instance));
        if wins {
            self.limit = at.t;
            self.hit = Hit { t: at.t, u: at.u, v: at.v, geometry: key.geometry, prim: key.prim, instance };
        }
        false
    }
}

/// Any hit at all.
#[derive(Clone, Copy)]
pub(crate) struct Any {
    pub(crate) t_max: f32,
    pub(crate) found: bool,
}

impl Query for Any {
    const NEAREST_FIRST: bool = false;

    #[inline(always)]
    fn new(ray: &Ray) -> Self {
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
}
