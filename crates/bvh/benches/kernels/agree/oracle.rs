//! What a ray truly meets: exact signs, distances to the last digits of double precision, and by how much it is so.

use super::exact::{Exact, cross, dot};
use crate::meshes::Mesh;
use penombre_bvh::{BuildOptions, Bvh, Geometry, Hit, Ray, Triangles};
use penombre_math::{DVec3, Vec3};

/// The unit of margins, as a share of the distance from the ray's origin to the farthest corner: half a unit in the
/// last place of the coordinates that single precision works with.
pub const UNIT: f64 = 1.0 / (1u64 << 24) as f64;
/// Triangles with an edge nearer than this to the ray, in [`UNIT`]s, are kept as near misses.
const NEAR: f64 = 64.0;

/// Where a ray meets the plane of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub prim: u32,
    /// Distance in lengths of the ray's direction.
    pub t: f64,
    /// Whether the ray's line goes through the closed triangle.
    pub through: bool,
    /// Whether `t` lies in the ray's range.
    pub in_range: bool,
    /// From the line to the nearest edge, in [`UNIT`]s.
    pub edge: f64,
    /// From the nearer end of the ray to the plane, in [`UNIT`]s.
    pub end: f64,
    /// By how many [`UNIT`]s a point of the ray moves away from the plane for each 1 of `t`.
    pub pace: f64,
}

impl Crossing {
    /// Whether this is a hit.
    pub fn is_hit(&self) -> bool {
        self.through && self.in_range
    }

    /// How far the ray is from being no hit if it is one, or from being one if it is not; in [`UNIT`]s.
    pub fn margin(&self) -> f64 {
        match (self.through, self.in_range) {
            (true, true) => self.edge.min(self.end),
            (true, false) => self.end,
            (false, true) => self.edge,
            (false, false) => self.edge.max(self.end),
        }
    }
}

/// The truth about one mesh.
pub struct Oracle<'a> {
    pub mesh: &'a Mesh,
}

impl Oracle<'_> {
    fn corners(&self, prim: u32) -> [Vec3; 3] {
        self.mesh.indices[prim as usize].map(|i| self.mesh.positions[i as usize])
    }

    /// Whether two triangles have a corner in the same place.
    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.corners(a), self.corners(b));
        a.iter().any(|p| b.contains(p))
    }

    /// All triangles that the ray goes through or barely misses, nearest first, by a search of all.
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let all = 0..self.mesh.indices.len() as u32;
        let near = all.filter(|&prim| may_meet(self.corners(prim), ray));
        let mut found: Vec<Crossing> = near.filter_map(|prim| self.crossing(prim, ray)).collect();
        found.retain(|c| c.through || c.edge <= NEAR);
        found.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.prim.cmp(&b.prim)));
        found
    }

    /// One triangle; `None` if the ray is parallel to it.
    pub fn crossing(&self, prim: u32, ray: &Ray) -> Option<Crossing> {
        let corners = self.corners(prim);
        let from = corners.map(|p| [0, 1, 2].map(|i| Exact::difference(p[i], ray.origin[i])));
        let dir = [0, 1, 2].map(|i| Exact::of(ray.dir[i]));
        let edge = |i: usize| dot(&dir, &cross(&from[i], &from[(i + 1) % 3]));
        let edges = [0, 1, 2].map(edge);
        // The edge functions sum up to the triangle's normal along the direction.
        let slope = edges[0].clone().plus(&edges[1]).plus(&edges[2]);
        if slope.sign() == 0 {
            return None;
        }
        let height = dot(&from[0], &cross(&from[1], &from[2]));
        let t = height.value() / slope.value();
        let signs = edges.map(|e| e.sign());
        let through = !(signs.contains(&-1) && signs.contains(&1));
        let in_range = f64::from(ray.t_min) < t && t < f64::from(ray.t_max);
        let (edge, pace) = margins(corners, ray);
        let end = [ray.t_min, ray.t_max].map(|end| (t - f64::from(end)).abs() * pace);
        Some(Crossing { prim, t, through, in_range, edge, end: end[0].min(end[1]), pace })
    }

    /// The hit that a loop over these triangles gives, each asked alone in a hierarchy of its own.
    pub fn alone(&self, crossings: &[Crossing], ray: &Ray) -> Hit {
        let mut best = Hit::MISS;
        for crossing in crossings {
            let triangle =
                Triangles { positions: self.corners(crossing.prim).into(), indices: [[0, 1, 2]].into() };
            let bvh = Bvh::build(vec![Geometry::Triangles(triangle)], &BuildOptions::default());
            let hit = bvh.map_or(Hit::MISS, |bvh| bvh.closest(ray));
            if hit.is_hit() && (hit.t, crossing.prim) < (best.t, best.prim) {
                best = Hit { prim: crossing.prim, ..hit };
            }
        }
        best
    }
}

/// Rejects in double precision what is farther from the ray than [`NEAR`], and little else is kept.
fn may_meet(corners: [Vec3; 3], ray: &Ray) -> bool {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let from = corners.map(|p| p.as_dvec3() - origin);
    let (mut above, mut below) = (false, false);
    for i in 0..3 {
        let (a, b) = (from[i], from[(i + 1) % 3]);
        let edge = dir.dot(a.cross(b));
        let unsure = NEAR * UNIT * reach(&from) * (dir.length() * (b - a).length());
        above |= edge > unsure;
        below |= edge < -unsure;
    }
    !(above && below)
}

/// The largest distance of a corner.
fn reach(from: &[DVec3; 3]) -> f64 {
    from.iter().map(|p| p.length_squared()).fold(0.0, f64::max).sqrt()
}

/// [`Crossing::edge`] and [`Crossing::pace`].
fn margins(corners: [Vec3; 3], ray: &Ray) -> (f64, f64) {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let from = corners.map(|p| p.as_dvec3() - origin);
    let unit = UNIT * reach(&from);
    // As seen along the ray.
    let flat = from.map(|p| p - dir * (p.dot(dir) / dir.length_squared()));
    let edge = (0..3).map(|i| distance_to_segment(flat[i], flat[(i + 1) % 3])).fold(f64::INFINITY, f64::min);
    let normal = (from[1] - from[0]).cross(from[2] - from[0]);
    let pace = (normal.dot(dir) / normal.length()).abs();
    (edge / unit, pace / unit)
}

/// From the origin.
fn distance_to_segment(a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let share = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if share.is_nan() { a.length() } else { (a + along * share).length() }
}
