//! Checks geometries and gathers the boxes of what can be hit.

use super::{BuildError, MAX_PRIMITIVES};
use crate::primitive::{DiskRecord, InstanceRecord, Key, QuadRecord, SphereRecord, has_area};
use crate::{Geometry, Triangles};
use penombre_math::{Bounds3, Vec3};

/// The box of one primitive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrimRef {
    pub(crate) bounds: Bounds3,
    pub(crate) key: Key,
}

impl PrimRef {
    pub(crate) fn centroid(&self) -> Vec3 {
        self.bounds.center()
    }
}

/// All primitives of one level that can be hit, in the order of their ids.
pub(crate) struct Collected<'a> {
    pub(crate) geometries: &'a [Geometry],
    pub(crate) refs: Vec<PrimRef>,
    pub(crate) instances: Vec<InstanceRecord>,
    pub(crate) skipped: usize,
}

/// The corners of a triangle whose indices were checked.
pub(crate) fn corners(mesh: &Triangles, triangle: usize) -> [Vec3; 3] {
    mesh.indices[triangle].map(|index| mesh.positions[index as usize])
}

/// Checks everything before anything is built.
pub(crate) fn collect(geometries: &[Geometry]) -> Result<Collected<'_>, BuildError> {
    let total = geometries.iter().map(len).fold(geometries.len(), usize::max);
    let total = geometries.iter().map(len).fold(0, usize::saturating_add).max(total);
    if total > MAX_PRIMITIVES {
        return Err(BuildError::TooManyPrimitives { found: total, limit: MAX_PRIMITIVES });
    }
    let mut all =
        Collected { geometries, refs: Vec::with_capacity(total), instances: Vec::new(), skipped: 0 };
    for (index, geometry) in geometries.iter().enumerate() {
        all.add(index, geometry)?;
    }
    Ok(all)
}

fn len(geometry: &Geometry) -> usize {
    match geometry {
        Geometry::Triangles(mesh) => mesh.indices.len(),
        Geometry::Spheres(spheres) => spheres.len(),
        Geometry::Quads(quads) => quads.len(),
        Geometry::Disks(disks) => disks.len(),
        Geometry::Instance(_) => 1,
    }
}

impl Collected<'_> {
    fn add(&mut self, index: usize, geometry: &Geometry) -> Result<(), BuildError> {
        match geometry {
            Geometry::Triangles(mesh) => {
                check_indices(index, mesh)?;
                self.extend(index, (0..mesh.indices.len()).map(|i| triangle_bounds(corners(mesh, i))));
            }
            Geometry::Spheres(spheres) => self.extend(index, spheres.iter().map(SphereRecord::bounds)),
            Geometry::Quads(quads) => self.extend(index, quads.iter().map(QuadRecord::bounds)),
            Geometry::Disks(disks) => self.extend(index, disks.iter().map(DiskRecord::bounds)),
            Geometry::Instance(instance) => {
                if instance.bvh.holds_instances() {
                    return Err(BuildError::NestedInstances { geometry: index });
                }
                let record = InstanceRecord::new(instance, index as u32);
                self.extend(index, std::iter::once(record.as_ref().map(|r| r.bounds)));
                self.instances.extend(record);
            }
        }
        Ok(())
    }

    fn extend(&mut self, geometry: usize, bounds: impl Iterator<Item = Option<Bounds3>>) {
        for (prim, bounds) in bounds.enumerate() {
            match bounds {
                Some(bounds) => {
                    let key = Key { geometry: geometry as u32, prim: prim as u32 };
                    self.refs.push(PrimRef { bounds, key });
                }
                None => self.skipped += 1,
            }
        }
    }
}

fn triangle_bounds(corners: [Vec3; 3]) -> Option<Bounds3> {
    has_area(corners).then(|| Bounds3::of_points(corners))
}

fn check_indices(geometry: usize, mesh: &Triangles) -> Result<(), BuildError> {
    let vertices = mesh.positions.len();
    for (triangle, indices) in mesh.indices.iter().enumerate() {
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(BuildError::IndexOutOfRange { geometry, triangle, index, vertices });
        }
    }
    Ok(())
}
