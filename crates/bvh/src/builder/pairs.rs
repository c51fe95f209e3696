//! Joins triangles that are neighbours in the list and in space to one reference, before a tree is built: whatever is
//! done with references then is done half as often. Meshes that come from quadrilaterals or strips consist of such
//! pairs.

use super::box4::{NO_REF, PrimRef, Reference as _};
use super::parallel::{self, take};

/// References that one thread looks at in one job.
const CHUNK: usize = 1 << 14;

/// Joins what may share a leaf, each reference with the next one or none. Returns a list that is not needed any more, for
/// other use.
pub(super) fn join(refs: &mut Vec<PrimRef>, shares: &[bool], threads: usize) -> Vec<PrimRef> {
    let lengths = parallel::map(threads, refs.chunks_mut(CHUNK).collect(), |chunk| join_in(chunk, shares));
    let count = lengths.iter().sum();
    if count == refs.len() {
        return Vec::new();
    }
    let mut joined = vec![NO_REF; count];
    let (mut places, mut jobs) = (&mut *joined, Vec::with_capacity(lengths.len()));
    for (chunk, length) in refs.chunks(CHUNK).zip(lengths) {
        jobs.push((&chunk[..length], take(&mut places, length)));
    }
    parallel::map(threads, jobs, |(from, to)| to.copy_from_slice(from));
    std::mem::replace(refs, joined)
}

/// Joins within a chunk and moves the rest up. Returns how many references are left.
fn join_in(refs: &mut [PrimRef], shares: &[bool]) -> usize {
    let (mut from, mut to) = (0, 0);
    while from < refs.len() {
        let first = refs[from];
        let second = refs.get(from + 1).filter(|second| are_close(&first, second, shares));
        (refs[to], from) = match second {
            Some(second) => (first.with_next(second), from + 2),
            None => (first, from + 1),
        };
        to += 1;
    }
    to
}

/// Whether the box around both is no larger than both boxes together.
fn are_close(a: &PrimRef, b: &PrimRef, shares: &[bool]) -> bool {
    let (first, second) = (a.key(), b.key());
    let follows = first.geometry == second.geometry && first.prim + 1 == second.prim;
    let both = a.extent().union(b.extent());
    let scale = both.area_scale();
    let apart = a.extent().area(scale) + b.extent().area(scale);
    follows && shares[first.geometry as usize] && both.area(scale) <= apart
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::Key;
    use penombre_math::{Bounds3, Vec3};

    /// A reference to a primitive of the first or second geometry, a unit cube.
    fn cube(geometry: u32, prim: u32, x: f32) -> PrimRef {
        let min = Vec3::new(x, 0.0, 0.0);
        PrimRef::new(&Bounds3 { min, max: min + 1.0 }, Key { geometry, prim })
    }

    #[test]
    fn neighbours_of_the_same_mesh_become_pairs() {
        let x = [0.0, 0.5, 1.0, 9.0, 9.0, 0.0];
        let mut refs: Vec<PrimRef> = (0..6).map(|i| cube(0, i, x[i as usize])).collect();
        // One that was skipped, another mesh, and one that keeps to itself.
        refs.extend([cube(0, 7, 0.0), cube(1, 8, 0.0), cube(1, 9, 0.0), cube(2, 0, 0.0), cube(2, 1, 0.0)]);
        join(&mut refs, &[true, true, false], 1);
        let found: Vec<_> = refs.iter().map(|r| (r.key().geometry, r.key().prim, r.count())).collect();
        let pairs = [(0, 0, 2), (0, 2, 1), (0, 3, 2), (0, 5, 1), (0, 7, 1), (1, 8, 2), (2, 0, 1), (2, 1, 1)];
        assert_eq!(found, pairs);
        assert_eq!(refs[0].bounds(), Bounds3 { min: Vec3::ZERO, max: Vec3::new(1.5, 1.0, 1.0) });
    }

    #[test]
    fn each_primitive_is_there_once_on_any_number_of_threads() {
        let all: Vec<PrimRef> = (0..50_001).map(|i| cube(0, i, (i / 3) as f32 * 5.0)).collect();
        let joined = [1, 3].map(|threads| {
            let mut refs = all.clone();
            join(&mut refs, &[true], threads);
            refs.iter().map(|r| (r.key().prim, r.count())).collect::<Vec<_>>()
        });
        assert_eq!(joined[0], joined[1]);
        let prims = joined[0].iter().flat_map(|&(prim, count)| prim..prim + count);
        assert!(prims.eq(0..50_001));
        assert!(joined[0].len() < 34_000);
    }
}
