//! Embree's rays as it lays them out in memory: one ray, and 16 rays of which each value stands side by side.
//!
//! What Embree appends for nested instances depends on how it was compiled; `room` is more than any build needs.

use penombre_bvh::{Hit, Ray};

/// Embree's number for "nothing".
const NOTHING: u32 = u32::MAX;

/// Embree's `RTCRayHit`; begins with its `RTCRay`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Default)]
pub struct Single {
    origin: [f32; 3],
    near: f32,
    dir: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    prim: u32,
    geometry: u32,
    room: [u32; 17],
}

impl Single {
    /// A ray that has met nothing yet.
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            near: ray.t_min,
            dir: ray.dir.to_array(),
            far: ray.t_max,
            mask: u32::MAX,
            geometry: NOTHING,
            ..Self::default()
        }
    }

    /// What a closest-hit call left.
    pub fn hit(&self) -> Hit {
        if self.geometry == NOTHING {
            return Hit::MISS;
        }
        Hit { t: self.far, u: self.u, v: self.v, geometry: 0, prim: self.prim, instance: Hit::NO_INSTANCE }
    }

    /// What an any-hit call left: a far end of −∞.
    pub fn is_blocked(&self) -> bool {
        self.far < 0.0
    }
}

/// Rays in one packet.
pub const WIDTH: usize = 16;

/// Which lanes of a packet hold rays: −1 yes, 0 no.
#[repr(C, align(64))]
pub struct Lanes([i32; WIDTH]);

impl Lanes {
    /// The first `count` lanes.
    pub fn first(count: usize) -> Self {
        Self(std::array::from_fn(|lane| if lane < count { -1 } else { 0 }))
    }
}

/// Embree's `RTCRayHit16`; begins with its `RTCRay16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct Packet {
    origin: [[f32; WIDTH]; 3],
    near: [f32; WIDTH],
    dir: [[f32; WIDTH]; 3],
    time: [f32; WIDTH],
    far: [f32; WIDTH],
    mask: [u32; WIDTH],
    id: [u32; WIDTH],
    flags: [u32; WIDTH],
    normal: [[f32; WIDTH]; 3],
    u: [f32; WIDTH],
    v: [f32; WIDTH],
    prim: [u32; WIDTH],
    geometry: [u32; WIDTH],
    room: [[u32; WIDTH]; 17],
}

impl Packet {
    /// A packet without rays, to be filled again and again.
    pub fn empty() -> Self {
        let (zero, none) = ([0.0; WIDTH], [0; WIDTH]);
        Self {
            origin: [zero; 3],
            near: zero,
            dir: [zero; 3],
            time: zero,
            far: zero,
            mask: [u32::MAX; WIDTH],
            id: none,
            flags: none,
            normal: [zero; 3],
            u: zero,
            v: zero,
            prim: none,
            geometry: [NOTHING; WIDTH],
            room: [none; 17],
        }
    }

    /// Puts up to 16 rays into the first lanes.
    pub fn load(&mut self, rays: &[Ray]) {
        self.geometry = [NOTHING; WIDTH];
        for (lane, ray) in rays.iter().take(WIDTH).enumerate() {
            for axis in 0..3 {
                self.origin[axis][lane] = ray.origin[axis];
                self.dir[axis][lane] = ray.dir[axis];
            }
            self.near[lane] = ray.t_min;
            self.far[lane] = ray.t_max;
        }
    }

    /// What a closest-hit call left in one lane.
    pub fn hit(&self, lane: usize) -> Hit {
        if self.geometry[lane] == NOTHING {
            return Hit::MISS;
        }
        let (t, u, v, prim) = (self.far[lane], self.u[lane], self.v[lane], self.prim[lane]);
        Hit { t, u, v, geometry: 0, prim, instance: Hit::NO_INSTANCE }
    }

    /// What an any-hit call left in one lane.
    pub fn is_blocked(&self, lane: usize) -> bool {
        self.far[lane] < 0.0
    }
}
