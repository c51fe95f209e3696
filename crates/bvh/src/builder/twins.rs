//! Twins: triangles that lie upon an earlier one, corner on corner. Only the first takes part in the tree.
//!
//! A ray that meets one of them meets all, at the same distance and coordinates to the last bit, and the first wins the
//! tie; so nobody misses the others but a filter that refuses the first ([`crate::bvh::Tree::twins_of`]). Alike are the
//! same corners in the same order, bit for bit: in another order the sums of the test may round to another distance.
//!
//! Usual meshes have none and pay for a look at a few thousand triangles at most.

use super::box4::{PrimRef, Reference as _};
use super::collect::corners;
use crate::Geometry;
use crate::bvh::Twin;
use crate::primitive::Key;
use penombre_math::Vec3;
use penombre_math::hash::{hash_words, mix64};

/// Triangles that are looked at to find out whether many are alike.
const SAMPLE: usize = 2048;

/// One of so many is looked at in small meshes.
const SPARSE: usize = 16;

/// Among fewer no ray has much to do.
const FEW: usize = 1024;

/// So many that are alike in the sample are worth a look at all.
const ENOUGH: usize = 3;

/// Takes twins out of `refs`, which are whole primitives in the order of their ids, if there are many. `starts` are the
/// numbers of the first primitives of the geometries. The twins returned are in order.
pub(super) fn take_out(refs: &mut Vec<PrimRef>, geometries: &[Geometry], starts: &[u32]) -> Vec<Twin> {
    if !are_many(refs, geometries) {
        return Vec::new();
    }
    let digest = |(place, r): (usize, &PrimRef)| Some((digest(&corners_of(r, geometries)?), place as u32));
    let mut all: Vec<(u64, u32)> = refs.iter().enumerate().filter_map(digest).collect();
    all.sort_unstable();
    let bits = |place: u32| corners_of(&refs[place as usize], geometries).map(bits);
    let number = |place: u32| {
        let Key { geometry, prim } = refs[place as usize].key();
        starts[geometry as usize] + prim
    };
    let (mut twins, mut leaves) = (Vec::new(), vec![false; refs.len()]);
    for alike in all.chunk_by(|a, b| a.0 == b.0) {
        let [(_, first), others @ ..] = alike else { continue };
        let corners = bits(*first);
        // What has the same digest by chance stays.
        for (_, place) in others.iter().filter(|(_, place)| bits(*place) == corners) {
            leaves[*place as usize] = true;
            twins.push(Twin { first: number(*first), number: number(*place) });
        }
    }
    let mut leaves = leaves.into_iter();
    refs.retain(|_| leaves.next() == Some(false));
    twins.sort_unstable();
    twins
}

/// Whether some of a sample are alike.
fn are_many(refs: &[PrimRef], geometries: &[Geometry]) -> bool {
    if refs.len() < FEW {
        return false;
    }
    let count = SAMPLE.min(refs.len() / SPARSE);
    let step = refs.len() / count;
    // One out of each step, anywhere, lest what is repeated in a rhythm be missed.
    let places = (0..count).map(|i| i * step + mix64(i as u64) as usize % step);
    let digests = places.filter_map(|place| corners_of(&refs[place], geometries)).map(|c| digest(&c));
    let mut digests: Vec<u64> = digests.collect();
    digests.sort_unstable();
    digests.windows(2).filter(|pair| pair[0] == pair[1]).count() >= ENOUGH
}

/// The corners of a triangle; `None` for other primitives.
#[inline]
fn corners_of(r: &PrimRef, geometries: &[Geometry]) -> Option<[Vec3; 3]> {
    let Key { geometry, prim } = r.key();
    match &geometries[geometry as usize] {
        Geometry::Triangles(mesh) => Some(corners(mesh, prim as usize)),
        _ => None,
    }
}

/// Corners as what is compared.
pub(super) fn bits(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    corners.map(|corner| corner.to_array().map(f32::to_bits))
}

fn digest(corners: &[Vec3; 3]) -> u64 {
    hash_words(bits(*corners).as_flattened())
}
