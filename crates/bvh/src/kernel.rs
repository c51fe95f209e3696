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
pub(crate) mod pages;
#[cfg(target_arch = "x86_64")]
mod sixteen;
#[cfg(all(test, target_arch = "x86_64"))]
mod tests;
#[cfg(target_arch = "x86_64")]
mod wide;

use crate::query::Filtered;
use crate::traverse::ReadyRay;
use crate::{Bvh, Filter, Hit, InstructionSet, Ray};
use std::mem::MaybeUninit;

/// A compiled version of the traversal. The field is private, so that only what looks at the processor makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kernel(InstructionSet);

/// Calls the version of a function for the kernel's instruction set.
macro_rules! dispatch {
    ($kernel:expr, $function:ident, $($argument:expr),*) => {
        match $kernel.0 {
            // SAFETY: `new` found the processor to have what the function is compiled for.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe { for_avx2::$function($($argument),*) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe { for_avx512::$function($($argument),*) },
            _ => portable::$function($($argument),*),
        }
    };
}

impl Kernel {
    /// The fastest that this processor runs, up to a set of instructions.
    pub(crate) fn new(limit: InstructionSet) -> Self {
        let allowed = InstructionSet::available().into_iter().rfind(|set| *set <= limit);
        Self(allowed.unwrap_or(InstructionSet::Portable))
    }

    /// What it is compiled for.
    pub(crate) fn instructions(self) -> InstructionSet {
        self.0
    }

    #[inline]
    pub(crate) fn closest(self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        dispatch!(self, closest, bvh, rays, hits)
    }

    #[inline]
    pub(crate) fn occluded(self, bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
        dispatch!(self, occluded, bvh, rays, blocked)
    }

    #[inline]
    pub(crate) fn closest_one(self, bvh: &Bvh, ray: &Ray, hit: &mut Hit) {
        dispatch!(self, closest_one, bvh, ray, hit)
    }

    #[inline]
    pub(crate) fn occluded_one(self, bvh: &Bvh, ray: &Ray) -> bool {
        dispatch!(self, occluded_one, bvh, ray)
    }

    #[inline]
    pub(crate) fn closest_where(self, bvh: &Bvh, all: Filtered<'_>, hits: &mut [Hit]) {
        dispatch!(self, closest_where, bvh, all, hits)
    }

    #[inline]
    pub(crate) fn occluded_where(self, bvh: &Bvh, all: Filtered<'_>, blocked: &mut [bool]) {
        dispatch!(self, occluded_where, bvh, all, blocked)
    }

    #[inline]
    pub(crate) fn closest_one_where(self, bvh: &Bvh, ray: &Ray, filter: &dyn Filter, hit: &mut Hit) {
        dispatch!(self, closest_one_where, bvh, ray, filter, hit)
    }

    #[inline]
    pub(crate) fn occluded_one_where(self, bvh: &Bvh, ray: &Ray, filter: &dyn Filter) -> bool {
        dispatch!(self, occluded_one_where, bvh, ray, filter)
    }
}

/// An entry of a list by an index that the builder made for it.
#[inline(always)]
pub(crate) fn item<T>(list: &[T], index: usize) -> &T {
    debug_assert!(index < list.len());
    // SAFETY: references in nodes are made by the builder together with what they lead to, and neither changes
    // afterwards; a hierarchy always has a root.
    unsafe { list.get_unchecked(index) }
}

/// The same to be changed.
#[inline(always)]
pub(crate) fn item_mut<T>(list: &mut [T], index: usize) -> &mut T {
    debug_assert!(index < list.len());
    // SAFETY: as for `item`; and indices of slots are those of slots.
    unsafe { list.get_unchecked_mut(index) }
}

/// Eight numbers that lie that many bytes behind the beginning of something that consists of rows of eight numbers.
#[inline(always)]
pub(crate) fn row_at<T: Rows>(rows: &T, bytes: u32) -> &[f32; 8] {
    debug_assert!(bytes.is_multiple_of(ROW) && (bytes as usize) < size_of::<T>());
    // SAFETY: offsets of rows are only made as multiples of the size of a row, and within.
    unsafe { &*std::ptr::from_ref(rows).byte_add(bytes as usize).cast() }
}

/// Consists of rows of eight words.
pub(crate) trait Rows {}

impl Rows for [[f32; 8]; 3] {}
impl Rows for [[u32; 8]; 8] {}

/// Size of a row.
pub(crate) const ROW: u32 = size_of::<[f32; 8]>() as u32;

/// Eight entries of a list by an index that leaves room for them.
#[inline(always)]
pub(crate) fn eight<T>(list: &mut [T], index: usize) -> &mut [T; 8] {
    debug_assert!(index + 8 <= list.len());
    // SAFETY: lists of what waits are as long as the tree's depth can ask for: seven entries for each level and eight
    // that are written at once.
    unsafe { &mut *list.as_mut_ptr().add(index).cast::<[T; 8]>() }
}

/// Eight entries of a list that were written before.
#[inline(always)]
pub(crate) fn eight_written<T: Copy>(list: &[MaybeUninit<T>], index: usize) -> &[T; 8] {
    debug_assert!(index + 8 <= list.len());
    // SAFETY: what waits is taken from where it was written.
    unsafe { &*list.as_ptr().add(index).cast::<[T; 8]>() }
}

/// An entry of a list that was written before.
#[inline(always)]
pub(crate) fn written<T: Copy>(list: &[MaybeUninit<T>], index: usize) -> T {
    // SAFETY: what waits is taken from where it was written.
    unsafe { item(list, index).assume_init() }
}

/// Words of a ray made ready.
pub(crate) const READY_WORDS: usize = size_of::<ReadyRay>() / size_of::<f32>();

/// The words that a ray made ready consists of.
#[inline(always)]
pub(crate) fn words_of(ready: &ReadyRay) -> &[f32; READY_WORDS] {
    // SAFETY: all fields are words of 32 bits that may have any value, and there is nothing between them.
    unsafe { &*std::ptr::from_ref(ready).cast() }
}

/// The same to be changed.
#[inline(always)]
pub(crate) fn words_of_mut(ready: &mut ReadyRay) -> &mut [f32; READY_WORDS] {
    // SAFETY: as for `words_of`.
    unsafe { &mut *std::ptr::from_mut(ready).cast() }
}

/// Eight entries of a list.
#[inline(always)]
pub(crate) fn eight_of<T>(list: &[T], index: usize) -> &[T; 8] {
    debug_assert!(index + 8 <= list.len());
    // SAFETY: lists for slots are as long as there may be slots, a multiple of eight.
    unsafe { &*list.as_ptr().add(index).cast::<[T; 8]>() }
}

/// A ray as eight numbers: origin, `t_min`, direction, `t_max`.
#[inline(always)]
pub(crate) fn numbers_of(ray: &Ray) -> &[f32; 8] {
    // SAFETY: these are its fields, in the order of C.
    unsafe { &*std::ptr::from_ref(ray).cast() }
}

/// The functions for one instruction set.
macro_rules! compiled {
    ($name:ident, $machine:ty $(, $features:literal)?) => {
        mod $name {
            use crate::query::Filtered;
            use crate::{Bvh, Filter, Hit, Ray, traverse};

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn closest(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
                traverse::closest::<$machine>(bvh, rays, hits);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn occluded(bvh: &Bvh, rays: &[Ray], blocked: &mut [bool]) {
                traverse::occluded::<$machine>(bvh, rays, blocked);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn closest_one(bvh: &Bvh, ray: &Ray, hit: &mut Hit) {
                traverse::closest_one::<$machine>(bvh, ray, hit);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn occluded_one(bvh: &Bvh, ray: &Ray) -> bool {
                traverse::occluded_one::<$machine>(bvh, ray)
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn closest_where(bvh: &Bvh, all: Filtered<'_>, hits: &mut [Hit]) {
                traverse::closest_where::<$machine>(bvh, all, hits);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn occluded_where(bvh: &Bvh, all: Filtered<'_>, blocked: &mut [bool]) {
                traverse::occluded_where::<$machine>(bvh, all, blocked);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn closest_one_where(bvh: &Bvh, ray: &Ray, filter: &dyn Filter, hit: &mut Hit) {
                traverse::closest_one_where::<$machine>(bvh, ray, filter, hit);
            }

            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            pub(super) fn occluded_one_where(bvh: &Bvh, ray: &Ray, filter: &dyn Filter) -> bool {
                traverse::occluded_one_where::<$machine>(bvh, ray, filter)
            }
        }
    };
}

compiled!(portable, crate::lanes::Baseline);
#[cfg(target_arch = "x86_64")]
compiled!(for_avx2, crate::kernel::avx2::Avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt");
#[cfg(target_arch = "x86_64")]
compiled!(for_avx512, crate::kernel::avx512::Avx512, "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl");
