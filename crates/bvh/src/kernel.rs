//! Picks the instruction set. The only unsafe code of the crate.
//!
//! The same source is compiled twice, for the baseline and for AVX2 (without fused multiply-add). All
//! arithmetic is plain IEEE, so both give the same bits; a test compares them.
#![allow(unsafe_code)]

use crate::{Bvh, Hit, Ray, traverse};

/// A compiled version of the traversal. Private fields, so that only [`Kernel::best`] makes the fast one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kernel {
    avx2: bool,
}

impl Kernel {
    /// For any processor.
    pub(crate) const PORTABLE: Self = Self { avx2: false };

    /// The fastest that this processor runs.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            return Self { avx2: true };
        }
        Self::PORTABLE
    }

    #[inline]
    pub(crate) fn closest(self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        #[cfg(target_arch = "x86_64")]
        if self.avx2 {
            // SAFETY: `avx2` is set by `best` alone, which found the processor to have AVX2.
            return unsafe { closest_avx2(bvh, rays, hits) };
        }
        closest_portable(bvh, rays, hits);
    }

    #[inline]
    pub(crate) fn occluded(self, bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
        #[cfg(target_arch = "x86_64")]
        if self.avx2 {
            // SAFETY: `avx2` is set by `best` alone, which found the processor to have AVX2.
            return unsafe { occluded_avx2(bvh, rays, blocked) };
        }
        occluded_portable(bvh, rays, blocked);
    }
}

#[inline(never)]
fn closest_portable(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest(bvh, rays, hits);
}

#[inline(never)]
fn occluded_portable(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded(bvh, rays, blocked);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn closest_avx2(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest(bvh, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn occluded_avx2(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
    traverse::occluded(bvh, rays, blocked);
}
