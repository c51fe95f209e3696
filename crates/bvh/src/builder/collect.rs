//! Checks geometries and gathers the boxes of what can be hit.

use super::box4::{NO_REF, PrimRef, Reference as _};
use super::parallel::{self, take};
use super::{BuildError, MAX_PRIMITIVES};
use crate::primitive::{DiskRecord, InstanceRecord, Key, QuadRecord, SphereRecord, UserRecord, has_area};
use crate::{Geometry, Triangles};
use penombre_math::{Bounds3, Vec3};
use std::ops::Range;

/// Primitives that are looked at in one job.
const CHUNK: usize = 1 << 14;

/// All primitives of one level that can be hit, in the order of their ids.
pub(crate) struct Collected<'a> {
    pub(crate) geometries: &'a [Geometry],
    pub(super) refs: Vec<PrimRef>,
    pub(crate) instances: Vec<InstanceRecord>,
    pub(crate) skipped: usize,
}

/// The corners of a triangle whose indices were checked.
#[inline(always)]
pub(crate) fn corners(mesh: &Triangles, triangle: usize) -> [Vec3; 3] {
    mesh.indices[triangle].map(|index| mesh.positions[index as usize])
}

impl Collected<'_> {
    /// How many triangles there are among them.
    pub(crate) fn triangles(&self) -> usize {
        let is_mesh: Vec<bool> =
            self.geometries.iter().map(|g| matches!(g, Geometry::Triangles(_))).collect();
        if is_mesh.iter().all(|&mesh| mesh) {
            return self.refs.len();
        }
        self.refs.iter().filter(|r| is_mesh[r.key().geometry as usize]).count()
    }
}

/// A part of one geometry and the places for its boxes.
struct Job<'a> {
    geometry: usize,
    prims: Range<usize>,
    places: &'a mut [PrimRef],
}

/// What was found in it.
#[derive(Default)]
struct Found {
    skipped: usize,
    instance: Option<InstanceRecord>,
}

/// Checks everything before anything is built.
pub(crate) fn collect(geometries: &[Geometry], threads: usize) -> Result<Collected<'_>, BuildError> {
    let total = geometries.iter().map(len).fold(geometries.len(), usize::max);
    let total = geometries.iter().map(len).fold(0, usize::saturating_add).max(total);
    if total > MAX_PRIMITIVES {
        return Err(BuildError::TooManyPrimitives { found: total, limit: MAX_PRIMITIVES });
    }
    let mut refs = vec![NO_REF; geometries.iter().map(len).sum()];
    let threads = if refs.len() > CHUNK { threads } else { 1 };
    let found = parallel::map(threads, jobs(geometries, &mut refs), |job| job.run(geometries));
    let (mut skipped, mut instances) = (0, Vec::new());
    for found in found {
        let found = found?;
        skipped += found.skipped;
        instances.extend(found.instance);
    }
    if skipped > 0 {
        refs.retain(|r| !r.is_none());
    }
    Ok(Collected { geometries, refs, instances, skipped })
}

fn jobs<'a>(geometries: &[Geometry], refs: &'a mut [PrimRef]) -> Vec<Job<'a>> {
    let mut left = refs;
    let mut jobs = Vec::new();
    for (geometry, content) in geometries.iter().enumerate() {
        let len = len(content);
        for start in (0..len).step_by(CHUNK) {
            let prims = start..len.min(start + CHUNK);
            let places = take(&mut left, prims.len());
            jobs.push(Job { geometry, prims, places });
        }
    }
    jobs
}

/// How many primitives a geometry has, whether they can be hit or not.
pub(super) fn len(geometry: &Geometry) -> usize {
    match geometry {
        Geometry::Triangles(mesh) => mesh.indices.len(),
        Geometry::Spheres(spheres) => spheres.len(),
        Geometry::Quads(quads) => quads.len(),
        Geometry::Disks(disks) => disks.len(),
        Geometry::Instance(_) => 1,
        Geometry::User(list) => list.len(),
    }
}

impl Job<'_> {
    fn run(self, geometries: &[Geometry]) -> Result<Found, BuildError> {
        let prims = self.prims.clone();
        match &geometries[self.geometry] {
            Geometry::Triangles(mesh) => {
                check_indices(self.geometry, mesh, &prims)?;
                Ok(self.fill(prims.map(|i| triangle_bounds(corners(mesh, i)))))
            }
            Geometry::Spheres(spheres) => Ok(self.fill(spheres[prims].iter().map(SphereRecord::bounds))),
            Geometry::Quads(quads) => Ok(self.fill(quads[prims].iter().map(QuadRecord::bounds))),
            Geometry::Disks(disks) => Ok(self.fill(disks[prims].iter().map(DiskRecord::bounds))),
            Geometry::User(list) => Ok(self.fill(prims.map(|i| UserRecord::bounds(&**list, i)))),
            Geometry::Instance(instance) => {
                if instance.bvh.holds_instances() {
                    return Err(BuildError::NestedInstances { geometry: self.geometry });
                }
                let record = InstanceRecord::new(instance, self.geometry as u32);
                let found = self.fill(std::iter::once(record.as_ref().map(|r| r.bounds)));
                Ok(Found { instance: record, ..found })
            }
        }
    }

    fn fill(self, bounds: impl Iterator<Item = Option<Bounds3>>) -> Found {
        let mut skipped = 0;
        for ((prim, place), bounds) in self.prims.zip(self.places).zip(bounds) {
            match bounds {
                Some(bounds) => {
                    *place = PrimRef::new(&bounds, Key { geometry: self.geometry as u32, prim: prim as u32 });
                }
                None => skipped += 1,
            }
        }
        Found { skipped, instance: None }
    }
}

/// The box of a triangle that can be hit.
#[inline(always)]
pub(super) fn triangle_bounds(corners: [Vec3; 3]) -> Option<Bounds3> {
    let [a, b, c] = corners;
    let bounds = Bounds3 { min: a.min(b).min(c), max: a.max(b).max(c) };
    (has_clear_area(corners) || has_area(corners)).then_some(bounds)
}

/// Whether single precision is enough to tell that a triangle has an area: it has by far more than rounding makes.
#[inline(always)]
fn has_clear_area([a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let square = ab.length_squared() + ac.length_squared();
    let area = ab.cross(ac).abs().max_element();
    // False for what is not finite.
    square > 1e-30 && area > square * 1e-5 && area < f32::INFINITY
}

fn check_indices(geometry: usize, mesh: &Triangles, prims: &Range<usize>) -> Result<(), BuildError> {
    let vertices = mesh.positions.len();
    for (triangle, indices) in prims.clone().zip(&mesh.indices[prims.clone()]) {
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(BuildError::IndexOutOfRange { geometry, triangle, index, vertices });
        }
    }
    Ok(())
}
