//! Memory for large lists.

use crate::node::Node;
use crate::primitive::TriangleBlock;
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

/// Consists of words that may be 0.
pub(crate) trait Words: Copy {}

impl Words for Node {}
impl Words for TriangleBlock {}

/// A list of fixed length. Large ones lie in memory of their own, on Linux in huge pages if the system has them: large
/// trees gain 8 to 13 % (measured at 1 M and 4 M triangles).
pub(crate) struct Pages<T> {
    start: NonNull<T>,
    len: usize,
    _owner: Owner<T>,
}

/// Frees the memory.
struct Owner<T> {
    _list: Vec<T>,
    #[cfg(target_os = "linux")]
    _mapping: Option<mapping::Mapping>,
}

// SAFETY: it owns its items, as a list does.
unsafe impl<T: Send> Send for Pages<T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Sync for Pages<T> {}

impl<T: Words> Pages<T> {
    /// `len` items whose bits are all 0, if many in memory that no thread has touched yet: those that fill it do.
    pub(crate) fn zeroed(len: usize) -> Self {
        #[cfg(target_os = "linux")]
        if let Some(mapping) = mapping::Mapping::new(len.saturating_mul(size_of::<T>())) {
            // It is as large as the items, aligned to more than they ask for, and 0.
            let start = mapping.start().cast();
            let owner = Owner { _list: Vec::new(), _mapping: Some(mapping) };
            return Self { start, len, _owner: owner };
        }
        // SAFETY: items whose bits are 0 are items.
        Self::from(vec![unsafe { std::mem::zeroed() }; len])
    }
}

impl<T> From<Vec<T>> for Pages<T> {
    fn from(mut list: Vec<T>) -> Self {
        // The list is never touched again, so that its items stay where they are.
        let start = NonNull::new(list.as_mut_ptr()).unwrap_or(NonNull::dangling());
        let len = list.len();
        let owner = Owner {
            _list: list,
            #[cfg(target_os = "linux")]
            _mapping: None,
        };
        Self { start, len, _owner: owner }
    }
}

impl<T> Default for Pages<T> {
    fn default() -> Self {
        Self::from(Vec::new())
    }
}

impl<T: Words> Clone for Pages<T> {
    fn clone(&self) -> Self {
        Self::from(self.to_vec())
    }
}

impl<T: fmt::Debug> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the owner holds so many items there.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.len) }
    }
}

impl<T> DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: the owner holds so many items there, and nobody else has access.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.len) }
    }
}

#[cfg(target_os = "linux")]
mod mapping {
    use std::ptr::{NonNull, null_mut};

    /// Size of a huge page. Smaller memory is left to the allocator.
    const HUGE: usize = 2 << 20;

    /// Memory straight from the system.
    pub(super) struct Mapping {
        all: NonNull<libc::c_void>,
        size: usize,
    }

    impl Mapping {
        /// At least `size` bytes of 0 from [`Mapping::start`] on; `None` if that is little, or the system refuses.
        pub(super) fn new(size: usize) -> Option<Self> {
            if size < HUGE {
                return None;
            }
            let size = size.checked_add(HUGE)?;
            let (access, kind) =
                (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
            // SAFETY: asks for new memory, wherever.
            let all = unsafe { libc::mmap(null_mut(), size, access, kind, -1, 0) };
            if all == libc::MAP_FAILED {
                return None;
            }
            let mapping = Self { all: NonNull::new(all)?, size };
            // SAFETY: the memory is ours. Whether the system has huge pages does not matter.
            let _ = unsafe { libc::madvise(mapping.start().as_ptr(), size - HUGE, libc::MADV_HUGEPAGE) };
            Some(mapping)
        }

        /// On the boundary of a huge page.
        pub(super) fn start(&self) -> NonNull<libc::c_void> {
            let skipped = self.all.addr().get().next_multiple_of(HUGE) - self.all.addr().get();
            // SAFETY: one huge page more than asked for was mapped.
            unsafe { self.all.byte_add(skipped) }
        }
    }

    impl Drop for Mapping {
        fn drop(&mut self) {
            // SAFETY: it was mapped in that size, and nobody refers to it any more.
            let _ = unsafe { libc::munmap(self.all.as_ptr(), self.size) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_lists_behave_alike() {
        for len in [0, 1, 1000, 10_000] {
            let mut list: Pages<Node> = Pages::zeroed(len);
            assert_eq!(list.len(), len);
            assert!(list.iter().all(|node| node.children() == &[0; 8]));
            list.iter_mut().for_each(|node| *node = Node::EMPTY);
            let copy = list.clone();
            drop(list);
            assert!(copy.len() == len && copy.iter().all(|node| node.children() == Node::EMPTY.children()));
        }
    }
}
