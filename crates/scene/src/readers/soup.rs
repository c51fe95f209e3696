//! Polygons as files list them, and the mesh that they become.

use super::faults::{Faults, Tally};
use super::lexer::Token;
use super::polygon::{ALWAYS_CUT, Cut, Triangulator};
use super::smoothing::{self, Group};
use crate::mesh::TriangleMesh;
use penombre_math::{Vec2, Vec3};

/// No attribute at this corner.
pub(super) const NONE: u32 = u32::MAX;

/// Indices of one corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
}

/// One polygon: its corners end where `end` says, and begin where those of the one before end.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    end: usize,
    /// Offset of its line in the file.
    at: usize,
    slot: u32,
    group: Group,
}

/// All that a file says about a surface.
#[derive(Debug, Default)]
pub(super) struct Soup<'a> {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// Linear Rec. 709, one per position or none.
    pub colors: Vec<[f32; 3]>,
    /// Linear Rec. 709, one per polygon or none.
    pub face_colors: Vec<[f32; 3]>,
    /// Positions that are no finite numbers, as pairs of index and place in ascending order.
    pub broken: Vec<(u32, Token<'a>)>,
    /// Smoothing group of the polygons from here on.
    pub group: Group,
    corners: Vec<Corner>,
    polygons: Vec<Polygon>,
}

impl<'a> Soup<'a> {
    /// Adds a corner to the polygon that [`Soup::finish_polygon`] ends.
    #[inline]
    pub fn corner(&mut self, corner: Corner) {
        self.corners.push(corner);
    }

    /// Number of corners since the last polygon.
    pub fn open_corners(&self) -> usize {
        self.corners.len() - self.polygons.last().map_or(0, |p| p.end)
    }

    /// Takes back the corners since the last polygon.
    pub fn drop_corners(&mut self) {
        self.corners.truncate(self.polygons.last().map_or(0, |p| p.end));
    }

    /// Makes a polygon of the corners since the last one. `at`: offset of its line.
    pub fn finish_polygon(&mut self, at: usize, slot: u32) {
        self.polygons.push(Polygon { end: self.corners.len(), at, slot, group: self.group });
    }

    /// The corners of all polygons.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The polygons with their line and corners.
    pub fn polygons(&self) -> impl Iterator<Item = (usize, &[Corner])> {
        let starts = std::iter::once(0).chain(self.polygons.iter().map(|p| p.end));
        starts.zip(&self.polygons).map(|(start, p)| (p.at, &self.corners[start..p.end]))
    }

    /// Removes normal and texture indices beyond the lists.
    pub fn drop_wild_attributes(&mut self) {
        let (normals, uvs) = (self.normals.len() as u32, self.uvs.len() as u32);
        for c in &mut self.corners {
            c.normal = if c.normal < normals { c.normal } else { NONE };
            c.uv = if c.uv < uvs { c.uv } else { NONE };
        }
    }

    /// Removes the indices of normals that are zero.
    pub fn drop_zero_normals(&mut self) {
        for c in &mut self.corners {
            let normal = self.normals.get(c.normal as usize);
            c.normal = if normal == Some(&Vec3::ZERO) { NONE } else { c.normal };
        }
    }

    /// Cuts the polygons into triangles. Position indices must be in range. Polygons with a corner that is no
    /// finite point are left out with a warning.
    pub fn into_mesh(mut self, faults: &mut Faults<'a>, line: impl Fn(usize) -> Token<'a>) -> TriangleMesh {
        let (mut mesh, parts) = self.room();
        let (mut cutter, mut points, mut triangles) = (Triangulator::default(), Vec::new(), Vec::new());
        let (mut dropped, mut tangled) = (Tally::default(), Tally::default());
        let is_grouped = smoothing::is_needed(self.polygons.iter().map(|p| p.group));
        let mut groups = Vec::new();
        let mut start = 0;
        for (index, polygon) in self.polygons.iter().enumerate() {
            let corners = &self.corners[start..polygon.end];
            start = polygon.end;
            if let Some(at) = self.broken_corner(corners) {
                dropped.add(at);
                continue;
            }
            triangles.clear();
            if corners.len() == 3 {
                triangles.push([0, 1, 2]);
            } else if corners.len() > ALWAYS_CUT && corners.len() > 2 * self.positions.len() {
                // Only those with holes meet vertices twice: this one goes round and round.
                tangled.add(line(polygon.at));
            } else {
                points.clear();
                points.extend(corners.iter().map(|c| self.positions[c.position as usize]));
                if cutter.cut(&points, &mut triangles) == Cut::TooLarge {
                    tangled.add(line(polygon.at));
                }
            }
            let color = self.face_colors.get(index);
            for triangle in &triangles {
                parts.push(&mut mesh, triangle.map(|i| corners[i as usize]), polygon.slot, color);
            }
            if is_grouped {
                groups.resize(mesh.indices.len(), polygon.group);
            }
        }
        let message = "a vertex is not a finite point: the faces that use it are left out";
        faults.tally("mesh::not-finite", &dropped, message, "expected three finite numbers");
        let message = "a polygon with very many corners crosses or touches itself: it is left out";
        faults.tally(
            "mesh::large-polygon",
            &tangled,
            message,
            "cut it into triangles in the program that wrote the file",
        );
        for (index, _) in &self.broken {
            self.positions[*index as usize] = Vec3::ZERO;
        }
        self.attributes(&mut mesh);
        if is_grouped {
            smoothing::apply(&mut mesh, &groups);
        }
        mesh
    }

    /// An empty mesh with room for the triangles, and what they will have.
    fn room(&self) -> (TriangleMesh, Parts) {
        let parts = Parts {
            normals: self.corners.iter().any(|c| c.normal != NONE),
            uvs: self.corners.iter().any(|c| c.uv != NONE),
            slots: self.polygons.iter().any(|p| p.slot != 0),
        };
        let most = self.corners.len().saturating_sub(2 * self.polygons.len());
        let room = |needed: bool| Vec::with_capacity(if needed { most } else { 0 });
        let mesh = TriangleMesh {
            indices: Vec::with_capacity(most),
            normal_indices: room(parts.normals),
            uv_indices: room(parts.uvs),
            slots: Vec::with_capacity(if parts.slots { most } else { 0 }),
            ..TriangleMesh::default()
        };
        (mesh, parts)
    }

    /// The place of the first vertex among the corners that is not finite.
    fn broken_corner(&self, corners: &[Corner]) -> Option<Token<'a>> {
        if self.broken.is_empty() {
            return None;
        }
        let find = |c: &Corner| self.broken.binary_search_by_key(&c.position, |(index, _)| *index).ok();
        corners.iter().find_map(find).map(|i| self.broken[i].1)
    }

    /// Moves the attribute lists over, without those that say nothing.
    fn attributes(self, mesh: &mut TriangleMesh) {
        mesh.positions = self.positions;
        mesh.colors = self.colors;
        let (normals, indices) =
            tidied(self.normals, std::mem::take(&mut mesh.normal_indices), &mesh.indices);
        (mesh.normals, mesh.normal_indices) = (normals, indices);
        let (uvs, indices) = tidied(self.uvs, std::mem::take(&mut mesh.uv_indices), &mesh.indices);
        (mesh.uvs, mesh.uv_indices) = (uvs, indices);
        if mesh.slots.iter().all(|s| *s == 0) {
            mesh.slots = Vec::new();
        }
    }
}

/// What the corners and polygons of a file say besides positions.
#[derive(Clone, Copy)]
struct Parts {
    normals: bool,
    uvs: bool,
    slots: bool,
}

impl Parts {
    /// Adds one triangle.
    #[inline]
    fn push(self, mesh: &mut TriangleMesh, corners: [Corner; 3], slot: u32, color: Option<&[f32; 3]>) {
        mesh.indices.push(corners.map(|c| c.position));
        if self.normals {
            mesh.normal_indices.push(corners.map(|c| c.normal));
        }
        if self.uvs {
            mesh.uv_indices.push(corners.map(|c| c.uv));
        }
        if self.slots {
            mesh.slots.push(slot);
        }
        mesh.face_colors.extend(color);
    }
}

/// Attribute values without indices that equal those of the positions; nothing if no corner uses them.
fn tidied<T>(values: Vec<T>, own: Vec<[u32; 3]>, positions: &[[u32; 3]]) -> (Vec<T>, Vec<[u32; 3]>) {
    if own.iter().flatten().all(|i| *i == NONE) {
        return (Vec::new(), Vec::new());
    }
    let own = if own == positions { Vec::new() } else { own };
    (values, own)
}
