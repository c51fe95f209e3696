//! Vertex normals from smoothing groups, for faces of OBJ files that have none of their own.
//!
//! Within a group the normal at a vertex is the normalised sum of the unit normals of the group's faces around it; faces
//! outside of all groups are flat. A file that never says `s`, or says one group for all, leaves it to the mesh's crease
//! angle where to smooth.

use super::soup::NONE;
use crate::mesh::TriangleMesh;
use penombre_math::Vec3;
use std::collections::HashMap;

/// What an `s` line says: 0 before the first one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Group(u32);

impl Group {
    /// `s off`.
    pub const OFF: Self = Self(1);
    /// In a piece of a file that is read apart: as the piece before it ends.
    pub const INHERITED: Self = Self(u32::MAX);

    /// `s N`; 0 and less are off.
    pub fn number(n: i64) -> Self {
        match u32::try_from(n) {
            Ok(n) => Self(n.saturating_add(1).min(u32::MAX - 1)),
            Err(_) if n < 0 => Self::OFF,
            Err(_) => Self(u32::MAX - 1),
        }
    }

    fn is_said(self) -> bool {
        self.0 > 0
    }

    fn is_on(self) -> bool {
        self.0 > 1
    }
}

/// Whether anything must be done for polygons of these groups.
pub(super) fn is_needed(groups: impl Iterator<Item = Group> + Clone) -> bool {
    let mut all = groups.clone();
    let Some(first) = all.next() else { return false };
    groups.clone().any(Group::is_said) && !(first.is_on() && all.all(|g| g == first))
}

/// Gives triangles without normals those of their groups, one per triangle.
pub(super) fn apply(mesh: &mut TriangleMesh, groups: &[Group]) {
    if !mesh.normals.is_empty() && mesh.normal_indices.is_empty() {
        return;
    }
    if mesh.normals.is_empty() {
        mesh.normal_indices = vec![[NONE; 3]; mesh.indices.len()];
    }
    let own = mesh.normals.len();
    let mut vertices = Vertices { latest: vec![(0, 0); mesh.positions.len()], others: HashMap::new() };
    for (triangle, group) in groups.iter().enumerate() {
        if !group.is_on() || !mesh.normal_indices[triangle].contains(&NONE) {
            continue;
        }
        let corners = mesh.indices[triangle];
        let normal = face_normal(&mesh.positions, corners);
        for (k, position) in corners.into_iter().enumerate() {
            let index = vertices.normal(position, *group, mesh.normals.len() as u32);
            if index as usize == mesh.normals.len() {
                mesh.normals.push(Vec3::ZERO);
            }
            mesh.normals[index as usize] += normal;
            mesh.normal_indices[triangle][k] = index;
        }
    }
    for sum in &mut mesh.normals[own..] {
        *sum = sum.as_dvec3().normalize_or_zero().as_vec3();
    }
    if mesh.normals.is_empty() {
        // Not smoothed at all: a mesh without any normals would be.
        mesh.normals.push(Vec3::Z);
    }
}

/// The normals of vertices by group.
struct Vertices {
    /// By position the group that it was last in, 0 for none, and the index of its normal there.
    latest: Vec<(u32, u32)>,
    /// Those in other groups: few, for most faces follow others of their group.
    others: HashMap<(u32, u32), u32>,
}

impl Vertices {
    /// The index of a vertex's normal in a group: `next` if it has none yet.
    fn normal(&mut self, position: u32, group: Group, next: u32) -> u32 {
        let latest = &mut self.latest[position as usize];
        if latest.0 != group.0 {
            if latest.0 != 0 {
                self.others.insert((position, latest.0), latest.1);
            }
            *latest = (group.0, self.others.get(&(position, group.0)).copied().unwrap_or(next));
        }
        latest.1
    }
}

fn face_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
