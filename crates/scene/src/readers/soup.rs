//! Polygons as files list them, and the mesh that they become.

use super::faults::{Faults, Tally};
use super::lexer::Token;
use super::polygon::{ALWAYS_CUT, Cut, Triangulator};
use super::smoothing::{self, Group};
use crate::mesh::TriangleMesh;
use penombre_math::{Vec2, Vec3};
use std::ops::Range;

/// No attribute at this corner.
pub(super) const NONE: u32 = u32::MAX;

/// Indices of one corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
}

/// The index of an attribute at each corner. Most files say one thing for all, which takes no room.
#[derive(Debug, Default)]
struct Indices {
    /// By corner.
    own: Option<Vec<u32>>,
    /// Without `own`: whether all corners have the index of their position; else none has any.
    follow: bool,
}

impl Indices {
    /// Adds the index of a corner behind those at `positions`.
    #[inline]
    fn push(&mut self, index: u32, position: u32, positions: &[u32]) {
        match &mut self.own {
            Some(list) => list.push(index),
            None if index == if self.follow { position } else { NONE } => {}
            None => self.diverge(index, position, positions),
        }
    }

    #[cold]
    fn diverge(&mut self, index: u32, position: u32, positions: &[u32]) {
        if positions.is_empty() && index == position {
            self.follow = true;
        } else {
            self.list(positions).push(index);
        }
    }

    /// The list by corner, made if it is not there.
    fn list(&mut self, positions: &[u32]) -> &mut Vec<u32> {
        let all = || if self.follow { positions.to_vec() } else { vec![NONE; positions.len()] };
        self.own.get_or_insert_with(all)
    }

    /// True if all corners have the index of their position, without a list that says so.
    fn is_shared(&self) -> bool {
        self.follow && self.own.is_none()
    }

    fn get(&self, corner: usize, position: u32) -> u32 {
        match &self.own {
            Some(list) => list[corner],
            None => {
                if self.follow {
                    position
                } else {
                    NONE
                }
            }
        }
    }

    /// Shortens the list to so many corners.
    fn truncate(&mut self, corners: usize) {
        if let Some(list) = &mut self.own {
            list.truncate(corners);
        }
    }

    /// True if every index but `NONE` is below a limit.
    fn are_below(&self, limit: usize, positions: &[u32]) -> bool {
        let list = match &self.own {
            Some(list) => list,
            None if self.follow => positions,
            None => return true,
        };
        // Without a branch for each: 1 more than `NONE` is 0.
        list.iter().fold(0, |most, i| most.max(i.wrapping_add(1))) as usize <= limit
    }

    /// Takes away those indices that are not wanted.
    fn retain(&mut self, positions: &[u32], is_wanted: impl Fn(u32) -> bool) {
        if self.follow || self.own.is_some() {
            self.list(positions).iter_mut().for_each(|i| *i = if is_wanted(*i) { *i } else { NONE });
        }
    }

    /// Adds those of corners behind its own.
    fn append(&mut self, mut other: Self, positions: &[u32], others: &[u32]) {
        if positions.is_empty() {
            *self = other;
        } else if !others.is_empty()
            && (self.own.is_some() || other.own.is_some() || self.follow != other.follow)
        {
            self.list(positions).append(other.list(others));
        }
    }
}

/// Polygons behind each other that are alike.
#[derive(Clone, Copy, Debug)]
struct Run {
    polygons: usize,
    /// Corners of each.
    corners: u32,
    slot: u32,
    group: Group,
}

/// Places in ascending order, of which each but a few takes four bytes.
#[derive(Debug, Default)]
struct Places {
    low: Vec<u32>,
    /// Indices from which on the next higher 32 bits hold.
    steps: Vec<usize>,
}

impl Places {
    fn push(&mut self, place: usize) {
        while self.steps.len() < place >> 32 {
            self.steps.push(self.low.len());
        }
        self.low.push(place as u32);
    }

    fn get(&self, index: usize) -> usize {
        let high = self.steps.partition_point(|first| *first <= index);
        high << 32 | self.low[index] as usize
    }

    fn append(&mut self, other: &Self) {
        (0..other.low.len()).for_each(|i| self.push(other.get(i)));
    }
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
    /// The positions of all corners.
    corners: Vec<u32>,
    corner_uvs: Indices,
    corner_normals: Indices,
    /// Number of corners of all polygons that are finished.
    finished: usize,
    runs: Vec<Run>,
    /// Offsets of the polygons' lines in the file.
    lines: Places,
}

impl<'a> Soup<'a> {
    /// Adds a corner to the polygon that [`Soup::finish_polygon`] ends.
    #[inline]
    pub fn corner(&mut self, corner: Corner) {
        let Corner { position, uv, normal } = corner;
        self.corner_uvs.push(uv, position, &self.corners);
        self.corner_normals.push(normal, position, &self.corners);
        self.corners.push(position);
    }

    /// Number of corners since the last polygon.
    pub fn open_corners(&self) -> usize {
        self.corners.len() - self.finished
    }

    /// Takes back the corners since the last polygon.
    pub fn drop_corners(&mut self) {
        self.corners.truncate(self.finished);
        self.corner_uvs.truncate(self.finished);
        self.corner_normals.truncate(self.finished);
    }

    /// Makes a polygon of the corners since the last one. `at`: offset of its line.
    #[inline]
    pub fn finish_polygon(&mut self, at: usize, slot: u32) {
        let corners = self.open_corners() as u32;
        self.finished = self.corners.len();
        self.lines.push(at);
        self.add_run(Run { polygons: 1, corners, slot, group: self.group });
    }

    #[inline]
    fn add_run(&mut self, run: Run) {
        match self.runs.last_mut() {
            Some(last) if (last.corners, last.slot, last.group) == (run.corners, run.slot, run.group) => {
                last.polygons += run.polygons;
            }
            _ => self.runs.push(run),
        }
    }

    /// Adds what stands behind it in the file. `slots`: what its slots are called here. Its first polygons are of the
    /// group that holds here unless it says one.
    pub fn append(&mut self, mut other: Self, slots: &[u32]) {
        let group = |own: Group, here: Group| if own == Group::INHERITED { here } else { own };
        self.corner_uvs.append(other.corner_uvs, &self.corners, &other.corners);
        self.corner_normals.append(other.corner_normals, &self.corners, &other.corners);
        self.positions.append(&mut other.positions);
        self.normals.append(&mut other.normals);
        self.uvs.append(&mut other.uvs);
        self.corners.append(&mut other.corners);
        self.finished += other.finished;
        self.lines.append(&other.lines);
        for run in other.runs {
            self.add_run(Run { slot: slots[run.slot as usize], group: group(run.group, self.group), ..run });
        }
        self.group = group(other.group, self.group);
    }

    /// True if every index is one of the lists, or none where there may be none.
    pub fn is_tame(&self) -> bool {
        let positions = self.positions.len();
        self.corners.iter().all(|i| (*i as usize) < positions)
            && self.corner_uvs.are_below(self.uvs.len(), &self.corners)
            && self.corner_normals.are_below(self.normals.len(), &self.corners)
    }

    /// The polygons: their line and their corners.
    pub fn polygons(&self) -> impl Iterator<Item = (usize, impl Iterator<Item = Corner>)> {
        let ranges = self.ranges().map(|(_, range)| range);
        ranges.enumerate().map(|(i, range)| (self.lines.get(i), range.map(|c| self.corner_at(c))))
    }

    /// The polygons: what they share with others, and where their corners stand.
    fn ranges(&self) -> impl Iterator<Item = (&Run, Range<usize>)> {
        let runs = self.runs.iter().flat_map(|run| std::iter::repeat_n(run, run.polygons));
        runs.scan(0, |end, run| {
            let start = *end;
            *end += run.corners as usize;
            Some((run, start..*end))
        })
    }

    fn corner_at(&self, index: usize) -> Corner {
        let position = self.corners[index];
        let (uv, normal) = (self.corner_uvs.get(index, position), self.corner_normals.get(index, position));
        Corner { position, uv, normal }
    }

    /// Removes normal and texture indices beyond the lists.
    pub fn drop_wild_attributes(&mut self) {
        let (normals, uvs) = (self.normals.len(), self.uvs.len());
        if !self.corner_normals.are_below(normals, &self.corners) {
            self.corner_normals.retain(&self.corners, |i| (i as usize) < normals);
        }
        if !self.corner_uvs.are_below(uvs, &self.corners) {
            self.corner_uvs.retain(&self.corners, |i| (i as usize) < uvs);
        }
    }

    /// Removes the indices of normals that are zero.
    pub fn drop_zero_normals(&mut self) {
        let normals = &self.normals;
        self.corner_normals.retain(&self.corners, |i| normals.get(i as usize) != Some(&Vec3::ZERO));
    }

    /// Cuts the polygons into triangles. Position indices must be in range. Polygons with a corner that is no
    /// finite point are left out with a warning.
    pub fn into_mesh(mut self, faults: &mut Faults<'_>, line: impl Fn(usize) -> Token<'a>) -> TriangleMesh {
        let mut cut = Cutting::new(&self);
        let (mut dropped, mut tangled) = (Tally::default(), Tally::default());
        let (mut start, mut index) = (0, 0);
        for run in &self.runs {
            let size = run.corners as usize;
            if size == 3 && self.broken.is_empty() {
                cut.triangles(&self, start..start + 3 * run.polygons, index..index + run.polygons, run);
                (start, index) = (start + 3 * run.polygons, index + run.polygons);
                continue;
            }
            for _ in 0..run.polygons {
                if let Some(at) = self.broken_corner(&self.corners[start..start + size]) {
                    dropped.add(at);
                } else if cut.polygon(&self, start..start + size, index, run) == Cut::TooLarge {
                    tangled.add(line(self.lines.get(index)));
                }
                (start, index) = (start + size, index + 1);
            }
        }
        let message = "a vertex is not a finite point: the faces that use it are left out";
        faults.tally("mesh::not-finite", &dropped, message, "expected three finite numbers");
        let message = "a polygon with very many corners crosses or touches itself: it is left out";
        let help = "cut it into triangles in the program that wrote the file";
        faults.tally("mesh::large-polygon", &tangled, message, help);
        for (index, _) in &self.broken {
            self.positions[*index as usize] = Vec3::ZERO;
        }
        let Cutting { mut mesh, groups, .. } = cut;
        self.attributes(&mut mesh);
        if let Some(groups) = groups {
            smoothing::apply(&mut mesh, &groups);
        }
        mesh
    }

    /// The place of the first vertex among the corners that is not finite.
    fn broken_corner(&self, corners: &[u32]) -> Option<Token<'a>> {
        if self.broken.is_empty() {
            return None;
        }
        let find = |c: &u32| self.broken.binary_search_by_key(c, |(index, _)| *index).ok();
        corners.iter().find_map(find).map(|i| self.broken[i].1)
    }

    /// Moves the attribute lists over, without those that say nothing.
    fn attributes(self, mesh: &mut TriangleMesh) {
        mesh.positions = self.positions;
        mesh.colors = self.colors;
        let (normals, uvs) = (&self.corner_normals, &self.corner_uvs);
        let own = std::mem::take(&mut mesh.normal_indices);
        (mesh.normals, mesh.normal_indices) = tidied(self.normals, own, normals.is_shared(), &mesh.indices);
        let own = std::mem::take(&mut mesh.uv_indices);
        (mesh.uvs, mesh.uv_indices) = tidied(self.uvs, own, uvs.is_shared(), &mesh.indices);
        if mesh.slots.iter().all(|s| *s == 0) {
            mesh.slots = Vec::new();
        }
    }
}

/// Triangles on their way into a mesh.
struct Cutting {
    mesh: TriangleMesh,
    /// By triangle, if they matter.
    groups: Option<Vec<Group>>,
    has_slots: bool,
    triangulator: Triangulator,
    points: Vec<Vec3>,
    found: Vec<[u32; 3]>,
}

impl Cutting {
    /// Makes room for the triangles of all polygons.
    fn new(soup: &Soup<'_>) -> Self {
        let polygons: usize = soup.runs.iter().map(|r| r.polygons).sum();
        let most = soup.finished.saturating_sub(2 * polygons);
        let room = |needed: bool| Vec::with_capacity(if needed { most } else { 0 });
        let has_slots = soup.runs.iter().any(|r| r.slot != 0);
        let mesh = TriangleMesh {
            indices: room(true),
            normal_indices: room(soup.corner_normals.own.is_some()),
            uv_indices: room(soup.corner_uvs.own.is_some()),
            slots: Vec::with_capacity(if has_slots { most } else { 0 }),
            ..TriangleMesh::default()
        };
        Self {
            mesh,
            groups: smoothing::is_needed(soup.runs.iter().map(|r| r.group)).then(Vec::new),
            has_slots,
            triangulator: Triangulator::default(),
            points: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Takes polygons that are triangles already.
    fn triangles(&mut self, soup: &Soup<'_>, corners: Range<usize>, polygons: Range<usize>, run: &Run) {
        let triples = |list: &[u32], out: &mut Vec<[u32; 3]>| {
            out.extend_from_slice(list[corners.clone()].as_chunks().0);
        };
        triples(&soup.corners, &mut self.mesh.indices);
        if let Some(list) = &soup.corner_normals.own {
            triples(list, &mut self.mesh.normal_indices);
        }
        if let Some(list) = &soup.corner_uvs.own {
            triples(list, &mut self.mesh.uv_indices);
        }
        self.mesh.face_colors.extend_from_slice(soup.face_colors.get(polygons).unwrap_or(&[]));
        self.mark(run);
    }

    /// Cuts a polygon.
    fn polygon(&mut self, soup: &Soup<'_>, corners: Range<usize>, index: usize, run: &Run) -> Cut {
        self.found.clear();
        let mut cut = Cut::Covered;
        if corners.len() == 3 {
            self.found.push([0, 1, 2]);
        } else if corners.len() > ALWAYS_CUT && corners.len() > 2 * soup.positions.len() {
            // Only those with holes meet vertices twice: this one goes round and round.
            cut = Cut::TooLarge;
        } else {
            self.points.clear();
            let of_corners = soup.corners[corners.clone()].iter();
            self.points.extend(of_corners.map(|i| soup.positions[*i as usize]));
            cut = self.triangulator.cut(&self.points, &mut self.found);
        }
        for triangle in &self.found {
            let of = |list: &[u32]| triangle.map(|k| list[corners.start + k as usize]);
            self.mesh.indices.push(of(&soup.corners));
            self.mesh.normal_indices.extend(soup.corner_normals.own.as_deref().map(of));
            self.mesh.uv_indices.extend(soup.corner_uvs.own.as_deref().map(of));
            self.mesh.face_colors.extend(soup.face_colors.get(index));
        }
        self.mark(run);
        cut
    }

    /// Gives the newest triangles the slot and group of their run.
    fn mark(&mut self, run: &Run) {
        let length = self.mesh.indices.len();
        if self.has_slots {
            self.mesh.slots.resize(length, run.slot);
        }
        if let Some(groups) = &mut self.groups {
            groups.resize(length, run.group);
        }
    }
}

/// Attribute values without indices that equal those of the positions; nothing if no corner uses them. `is_shared`: all
/// have the indices of their positions, and `own` is empty.
fn tidied<T>(
    values: Vec<T>,
    own: Vec<[u32; 3]>,
    is_shared: bool,
    positions: &[[u32; 3]],
) -> (Vec<T>, Vec<[u32; 3]>) {
    let is_used = if is_shared { !positions.is_empty() } else { own.iter().flatten().any(|i| *i != NONE) };
    match is_used {
        false => (Vec::new(), Vec::new()),
        true => (values, if own == positions { Vec::new() } else { own }),
    }
}
