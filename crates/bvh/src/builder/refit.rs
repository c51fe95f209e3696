//! Moves a tree along with its primitives: the same nodes and leaves around new positions.

use super::box4::Reference as _;
use super::collect::{Collected, corners, triangle_bounds};
use super::parallel::{self, take};
use super::twins::bits;
use super::wide::half_area;
use super::{BuildError, Shape};
use crate::Geometry;
use crate::bvh::Tree;
use crate::node::{ChildRef, Kind, Node, WIDTH};
use crate::primitive::{BLOCK, DiskRecord, Key, QuadRecord, SphereRecord, TriangleBlock, UserRecord};
use penombre_math::{Bounds3, Vec3};

/// Why a hierarchy could not be moved. It is as it was then; build a new one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RefitError {
    /// The geometries are faulty.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Other kinds or numbers of primitives than those that the hierarchy was built from.
    #[error(
        "geometry {geometry} differs in kind or number of primitives from what the hierarchy was built from"
    )]
    Different {
        /// The first such geometry; the number of geometries if there are more or fewer.
        geometry: usize,
    },
    /// A primitive can be hit that could not when the hierarchy was built, so that it has no place in it.
    #[error(
        "geometry {geometry}: primitive {primitive} could not be hit when the hierarchy was built, and now can"
    )]
    Appeared {
        /// Index in the list of geometries.
        geometry: usize,
        /// Index in its geometry.
        primitive: usize,
    },
    /// A triangle lay upon an earlier one, corner on corner, when the hierarchy was built, and no longer does, so that it
    /// has no place in it.
    #[error(
        "geometry {geometry}: triangle {primitive} lay upon an earlier one when the hierarchy was built, and no longer does"
    )]
    Parted {
        /// Index in the list of geometries.
        geometry: usize,
        /// Index in its geometry.
        primitive: usize,
    },
    /// A primitive other than a triangle can no longer be hit. Triangles may.
    #[error("geometry {geometry}: primitive {primitive} can no longer be hit; only triangles may vanish")]
    Vanished {
        /// Index in the list of geometries; the first such primitive is named.
        geometry: usize,
        /// Index in its geometry.
        primitive: usize,
    },
}

/// A triangle that has a place in the tree, but cannot be hit at present.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dormant {
    block: u32,
    key: Key,
}

/// Blocks that one thread moves at a time.
const CHUNK: usize = 1 << 11;

/// Moves everything. `shape` is that of the tree; the new one is returned, with the number of triangles that can be hit.
pub(crate) fn refit(
    tree: &mut Tree,
    shape: &Shape,
    new: Collected<'_>,
    threads: usize,
) -> Result<(Shape, usize), RefitError> {
    let triangles = check(tree, &new)?;
    let boxes = move_blocks(tree, new.geometries, threads);
    move_others(tree, new.geometries);
    tree.instances = new.instances;
    let (bounds, area) = move_nodes(tree, &boxes, new.geometries);
    let sah_cost = area / half_area(&bounds).max(f64::MIN_POSITIVE);
    tree.extent = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
    tree.bounds = bounds;
    tree.finish();
    Ok((Shape { sah_cost, ..*shape }, triangles))
}

/// Every primitive that can be hit has a place in the tree, and all of them but triangles still can. Returns the number of
/// triangles that can be hit.
fn check(tree: &Tree, new: &Collected<'_>) -> Result<usize, RefitError> {
    let mut starts = vec![0];
    for geometry in new.geometries {
        starts.push(starts[starts.len() - 1] + super::collect::len(geometry));
    }
    let number = |key: Key| starts[key.geometry as usize] + key.prim as usize;
    let mut placed = vec![false; starts[new.geometries.len()]];
    let lanes = |block: &TriangleBlock| (0..block.len()).map(|lane| block.number(lane)).collect::<Vec<_>>();
    tree.blocks.iter().flat_map(lanes).for_each(|number| placed[number as usize] = true);
    tree.dormant.iter().for_each(|dormant| placed[number(dormant.key)] = true);
    check_twins(tree, new.geometries)?;
    tree.twins.iter().for_each(|twin| placed[twin.number as usize] = true);
    let others = tree.spheres.iter().map(|s| s.key).chain(tree.quads.iter().map(|q| q.key));
    let others = others.chain(tree.disks.iter().map(|d| d.key)).chain(tree.users.iter().map(|u| u.key));
    let others: Vec<Key> =
        others.chain(tree.instances.iter().map(|i| Key { geometry: i.index, prim: 0 })).collect();
    others.iter().for_each(|key| placed[number(*key)] = true);
    let mut alive = vec![false; placed.len()];
    let mut triangles = 0;
    for key in new.refs.iter().map(|r| r.key()) {
        if !placed[number(key)] {
            return Err(RefitError::Appeared {
                geometry: key.geometry as usize,
                primitive: key.prim as usize,
            });
        }
        alive[number(key)] = true;
        triangles += usize::from(matches!(new.geometries[key.geometry as usize], Geometry::Triangles(_)));
    }
    let gone = others.into_iter().filter(|key| !alive[number(*key)]);
    match gone.min_by_key(|key| (key.geometry, key.prim)) {
        Some(Key { geometry, prim }) => {
            Err(RefitError::Vanished { geometry: geometry as usize, primitive: prim as usize })
        }
        None => Ok(triangles),
    }
}

/// All twins still are.
fn check_twins(tree: &Tree, geometries: &[Geometry]) -> Result<(), RefitError> {
    let corners_of = |key: Key| match &geometries[key.geometry as usize] {
        Geometry::Triangles(mesh) => Some(bits(corners(mesh, key.prim as usize))),
        _ => None,
    };
    for twin in &tree.twins {
        let [first, key] = [twin.first, twin.number].map(|number| Key::numbered(number, &tree.starts));
        if corners_of(first) != corners_of(key) {
            let (geometry, primitive) = (key.geometry as usize, key.prim as usize);
            return Err(RefitError::Parted { geometry, primitive });
        }
    }
    Ok(())
}

/// Fills all blocks anew. Returns their boxes.
fn move_blocks(tree: &mut Tree, geometries: &[Geometry], threads: usize) -> Vec<Bounds3> {
    let (dormant, starts) = (std::mem::take(&mut tree.dormant), &tree.starts);
    let mut boxes = vec![Bounds3::EMPTY; tree.blocks.len()];
    let (mut rest, mut jobs) = (&mut *boxes, Vec::new());
    for (i, blocks) in tree.blocks.chunks_mut(CHUNK).enumerate() {
        let end = ((i + 1) * CHUNK) as u32;
        let from = dormant.partition_point(|d| d.block < (i * CHUNK) as u32);
        let to = dormant.partition_point(|d| d.block < end);
        jobs.push((i * CHUNK, take(&mut rest, blocks.len()), blocks, &dormant[from..to]));
    }
    let found = parallel::map(threads, jobs, |(first, boxes, blocks, dormant)| {
        let mut asleep = Vec::new();
        for (i, (block, bounds)) in blocks.iter_mut().zip(boxes).enumerate() {
            let number = (first + i) as u32;
            let sleeping = dormant.iter().filter(|d| d.block == number).map(|d| d.key);
            (*block, *bounds) = moved(block, sleeping, geometries, starts, |key| {
                asleep.push(Dormant { block: number, key });
            });
        }
        asleep
    });
    tree.dormant = found.into_iter().flatten().collect();
    boxes
}

/// A block of the same triangles and of those that slept there, and its box. `sleeps` is told of those that cannot be hit.
fn moved(
    block: &TriangleBlock,
    sleeping: impl Iterator<Item = Key>,
    geometries: &[Geometry],
    starts: &[u32],
    mut sleeps: impl FnMut(Key),
) -> (TriangleBlock, Bounds3) {
    let (mut new, mut bounds) = (TriangleBlock::EMPTY, Bounds3::EMPTY);
    let awake = (0..block.len().min(BLOCK)).map(|lane| Key::numbered(block.number(lane), starts));
    for key in awake.chain(sleeping) {
        let Geometry::Triangles(mesh) = &geometries[key.geometry as usize] else { continue };
        let corners = corners(mesh, key.prim as usize);
        match triangle_bounds(corners) {
            Some(all) => {
                bounds = bounds.union(all);
                new.push(corners, starts[key.geometry as usize] + key.prim);
            }
            None => sleeps(key),
        }
    }
    (new, bounds)
}

/// Makes all other leaves anew.
fn move_others(tree: &mut Tree, geometries: &[Geometry]) {
    let of = |key: Key| (&geometries[key.geometry as usize], key.prim as usize);
    for sphere in &mut tree.spheres {
        if let (Geometry::Spheres(list), prim) = of(sphere.key) {
            *sphere = SphereRecord::new(&list[prim], sphere.key);
        }
    }
    for quad in &mut tree.quads {
        if let (Geometry::Quads(list), prim) = of(quad.key)
            && let Some(record) = QuadRecord::new(&list[prim], quad.key)
        {
            *quad = record;
        }
    }
    for disk in &mut tree.disks {
        if let (Geometry::Disks(list), prim) = of(disk.key)
            && let Some(record) = DiskRecord::new(&list[prim], disk.key)
        {
            *disk = record;
        }
    }
    for user in &mut tree.users {
        if let (Geometry::User(list), _) = of(user.key) {
            *user = UserRecord::new(list, user.key);
        }
    }
}

/// Makes all nodes anew, those below first. Returns the box of all and the sum of the areas of nodes and leaves.
fn move_nodes(tree: &mut Tree, blocks: &[Bounds3], geometries: &[Geometry]) -> (Bounds3, f64) {
    let mut boxes = vec![Bounds3::EMPTY; tree.nodes.len()];
    let mut area = 0.0;
    for i in (0..tree.nodes.len()).rev() {
        let mut filled = [(Bounds3::EMPTY, ChildRef::ROOT); WIDTH];
        let mut count = 0;
        let lanes = (0..WIDTH as u32).map(|lane| tree.nodes[i].child(lane));
        for child in lanes.take_while(|&child| child != ChildRef::NOTHING) {
            let bounds = match child.kind() {
                Kind::Node => boxes[child.index()],
                Kind::Triangles => blocks[child.index()],
                _ => other_bounds(tree, child, geometries),
            };
            area += if child.is_node() { 0.0 } else { half_area(&bounds) };
            boxes[i] = boxes[i].union(bounds);
            filled[count] = (bounds, child);
            count += 1;
        }
        area += half_area(&boxes[i]);
        // What holds nothing at present stands anywhere in its node.
        let anywhere = if boxes[i].is_empty() { Vec3::ZERO } else { boxes[i].min };
        for (bounds, _) in filled[..count].iter_mut().filter(|(bounds, _)| bounds.is_empty()) {
            *bounds = Bounds3::of_point(anywhere);
        }
        tree.nodes[i] = Node::new(&filled[..count]);
    }
    (boxes.first().copied().unwrap_or(Bounds3::EMPTY), area)
}

/// The box of a leaf that is no block.
fn other_bounds(tree: &Tree, child: ChildRef, geometries: &[Geometry]) -> Bounds3 {
    let at = child.index();
    let key = match child.kind() {
        Kind::Sphere => tree.spheres[at].key,
        Kind::Quad => tree.quads[at].key,
        Kind::Disk => tree.disks[at].key,
        Kind::User => tree.users[at].key,
        Kind::Instance => return tree.instances[at].bounds,
        _ => return Bounds3::EMPTY,
    };
    let prim = key.prim as usize;
    let bounds = match &geometries[key.geometry as usize] {
        Geometry::Spheres(list) => SphereRecord::bounds(&list[prim]),
        Geometry::Quads(list) => QuadRecord::bounds(&list[prim]),
        Geometry::Disks(list) => DiskRecord::bounds(&list[prim]),
        Geometry::User(list) => UserRecord::bounds(&**list, prim),
        Geometry::Triangles(_) | Geometry::Instance(_) => None,
    };
    bounds.unwrap_or(Bounds3::EMPTY)
}

/// Kind and number of primitives of each geometry.
pub(crate) fn inventory(geometries: &[Geometry]) -> Vec<(u8, usize)> {
    let kind = |geometry: &Geometry| match geometry {
        Geometry::Triangles(_) => 0,
        Geometry::Spheres(_) => 1,
        Geometry::Quads(_) => 2,
        Geometry::Disks(_) => 3,
        Geometry::Instance(_) => 4,
        Geometry::User(_) => 5,
    };
    geometries.iter().map(|g| (kind(g), super::collect::len(g))).collect()
}

/// An error unless both are equal.
pub(crate) fn compare(old: &[(u8, usize)], new: &[(u8, usize)]) -> Result<(), RefitError> {
    if old == new {
        return Ok(());
    }
    let geometry = old.iter().zip(new).position(|(a, b)| a != b).unwrap_or(new.len());
    Err(RefitError::Different { geometry })
}
