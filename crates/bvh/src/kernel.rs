//! Picks the instruction set. The only unsafe code of the crate lies here and in the modules below.
//!
//! The same source is compiled three times: for any processor, for AVX2 with FMA, and for AVX-512VL. It asks a
//! [`crate::lanes::Machine`] for what the compiler does not find by itself. What decides hits is plain IEEE
//! arithmetic, so all give the same bits; the tests of boxes only have to be safe and may round as they like.
//!
//! Whatever a version calls must be inlined into it, or it is compiled for the baseline: functions are
//! `#[inline(always)]`, and closures stay out of hot places.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(all(test, target_arch = "x86_64"))]
mod tests;

use crate::lanes::Baseline;
use crate::{Bvh, Hit, Ray, traverse};

/// A compiled version of the traversal. The field is private, so that only what looks at the processor makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kernel(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kernel {
    /// All that this processor runs, the fastest last.
    pub(crate) fn all() -> Vec<Self> {
        let mut all = vec![Self(Set::Portable)];
        #[cfg(target_arch = "x86_64")]
        if has_avx2() {
            all.push(Self(Set::Avx2));
            if has_avx512() {
                all.push(Self(Set::Avx512));
            }
        }
        all
    }

    /// The fastest that this processor runs.
    pub(crate) fn best() -> Self {
        Self::all().pop().unwrap_or(Self(Set::Portable))
    }

    #[inline]
    pub(crate) fn closest(self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        match self.0 {
            Set::Portable => closest_portable(bvh, rays, hits),
            // SAFETY: `all` found the processor to have what the function is compiled for.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { closest_avx2(bvh, rays, hits) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { closest_avx512(bvh, rays, hits) },
        }
    }

    #[inline]
    pub(crate) fn occluded(self, bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
        match self.0 {
            Set::Portable => occluded_portable(bvh, rays, blocked),
            // SAFETY: `all` found the processor to have what the function is compiled for.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { occluded_avx2(bvh, rays, blocked) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { occluded_avx512(bvh, rays, blocked) },
        }
    }
}

/// AVX2 and what came with it.
#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    use std::is_x86_feature_detected as has;
    has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt")
}

/// AVX-512VL.
#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    use std::is_x86_feature_detected as has;
    has!("avx512f") && has!("avx512vl")
}

/// An entry of a list by an index that the builder made for it.
#[inline(always)]
pub(crate) fn item<T>(list: &[T], index: usize) -> &T {
    debug_assert!(index < list.len());
    // SAFETY: references in nodes are made by the builder together with what they lead to, and neither changes
    // afterwards; a hierarchy always has a root.
    unsafe { list.get_unchecked(index) }
}

#[inline(never)]
fn closest_portable(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<Baseline>(bvh, rays, hits);
}

#[inline(never)]
fn occluded_portable(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<Baseline>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn closest_avx2(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<avx2::Avx2>(bvh, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn occluded_avx2(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<avx2::Avx2>(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl")]
#[inline(never)]
fn closest_avx512(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest::<avx512::Avx512>(bvh, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl")]
#[inline(never)]
fn occluded_avx512(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded::<avx512::Avx512>(bvh, rays, blocked);
}
