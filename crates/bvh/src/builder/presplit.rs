//! Cuts triangles into parts before a tree is built, those with the most empty space in their boxes first
//! (\[Ganestam2016\]).
//!
//! A part is the same triangle in a smaller box; one triangle may then lie in several leaves. Only triangles are cut that
//! are long where others are small: in a well-shaped mesh leaves of eight triangles are larger than each of them, and
//! parts would only be more to hold.
//!
//! # Why no part's box hides a hit
//!
//! [`crate::node`] shows why boxes around whole triangles hide no hit: the ray meets a triangle whose vertices are moved
//! by 2u of their coordinates relative to the origin of the ray, and by 4u of those along the main axis (u = 2⁻²⁴).
//! The point hit, a mean of the moved vertices, so lies beside the same mean of the true ones, a point P of the triangle
//! and so of one of its parts, by at most 2u and 4u of means of |vertex − origin|. Each of these is at most
//! |P − origin|, of which that proof takes care with the part's own box, plus |vertex − P|, which is at most
//! the longest side of the triangle's box. So boxes of parts are widened by 6u of that side, and
//! by 10u more, which covers the roundings of widening and the double precision in which they are computed.

use super::box4::{PrimRef, Reference as _, extent_of};
use super::collect::corners;
use super::parallel;
use crate::Geometry;
use crate::primitive::rounded_out;
use penombre_math::{Bounds3, DVec3, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// 16 unit roundoffs: what the boxes of parts are widened by, as a share of the longest side of the triangle's box.
const WIDENING: f32 = 1.0 / (1u32 << 20) as f32;

/// Cells per axis of the grid in which triangles are counted.
const CELLS: usize = 32;

/// Triangles of a leaf.
const LEAF: f32 = 8.0;

/// Triangles are cut that are longer than leaves by this factor (measured: with 1, meshes with rough surfaces have a
/// tenth more references and rays gain nothing).
const LONG: f32 = 1.5;

/// A cut must leave less than this share of the area (measured: from 0.65 to 0.75 rays gain the same).
const KEPT: f32 = 0.65;

/// What the first cuts save together must be this share of the area of the scene; otherwise none are made (measured: a few
/// needles at the poles of a ball of a million triangles, a thousandth, cost rays there a twentieth).
const WORTH: f64 = 0.02;

/// References that one thread looks at in one job.
const CHUNK: usize = 1 << 14;

/// Something to be cut, ordered by the area that is saved.
struct Cut {
    gain: f32,
    /// Number of the reference that is replaced. Its parts are found anew when it is its turn: few are cut of many.
    place: u32,
    /// Longest side of the box of the whole triangle.
    side: f32,
}

impl PartialEq for Cut {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cut {}

impl PartialOrd for Cut {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cut {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then_with(|| other.place.cmp(&self.place))
    }
}

/// Cuts until there are `most` references, or nothing is worth it.
pub(super) fn split(refs: &mut Vec<PrimRef>, geometries: &[Geometry], most: usize, threads: usize) {
    let Some(scene) = Scene::new(refs, geometries, threads) else { return };
    let jobs: Vec<(usize, &[PrimRef])> = refs.chunks(CHUNK).enumerate().collect();
    let found = parallel::map(threads, jobs, |(i, chunk)| {
        let cut =
            |(k, r): (usize, &PrimRef)| scene.is_long(r).then(|| scene.cut(r, i * CHUNK + k, longest(r)));
        chunk.iter().enumerate().filter_map(cut).flatten().collect::<Vec<Cut>>()
    });
    let gains: f64 = found.iter().flatten().map(|cut| f64::from(cut.gain)).sum();
    if gains < WORTH * f64::from(scene.area) {
        return;
    }
    let mut heap: BinaryHeap<Cut> = found.into_iter().flatten().collect();
    while refs.len() < most
        && let Some(Cut { place, side, .. }) = heap.pop()
    {
        let place = place as usize;
        let Some((_, parts)) = scene.parted(&refs[place], side) else { continue };
        refs[place] = parts[0];
        refs.push(parts[1]);
        for (place, part) in [(place, parts[0]), (refs.len() - 1, parts[1])] {
            if scene.is_long(&part) {
                heap.extend(scene.cut(&part, place, side));
            }
        }
    }
}

fn longest(r: &PrimRef) -> f32 {
    (r.bounds().max - r.bounds().min).max_element()
}

/// What decides about cuts.
struct Scene<'a> {
    geometries: &'a [Geometry],
    bounds: Bounds3,
    /// Edge of a cell.
    cell: f32,
    /// References by cell.
    counts: Vec<u32>,
    /// Scale of areas.
    scale: f32,
    /// Area of the box of all.
    area: f32,
}

impl<'a> Scene<'a> {
    fn new(refs: &[PrimRef], geometries: &'a [Geometry], threads: usize) -> Option<Self> {
        let extent = extent_of(refs, threads);
        let bounds = extent.bounds();
        let size = bounds.max - bounds.min;
        if !(size.is_finite() && size.max_element() > f32::MIN_POSITIVE * 1e6) {
            return None;
        }
        let cell = size.max_element() / CELLS as f32;
        let scale = extent.area_scale();
        let counts = vec![0; CELLS * CELLS * CELLS];
        let mut scene = Self { geometries, bounds, cell, counts, scale, area: extent.area(scale) };
        for r in refs {
            let cell = scene.cell_of(r);
            scene.counts[cell] += 1;
        }
        Some(scene)
    }

    fn cell_of(&self, r: &PrimRef) -> usize {
        let at = (r.bounds().center() - self.bounds.min) / self.cell;
        let number = |x: f32| (x as usize).min(CELLS - 1);
        (number(at.z) * CELLS + number(at.y)) * CELLS + number(at.x)
    }

    /// Whether a box is longer than leaves where it is.
    fn is_long(&self, r: &PrimRef) -> bool {
        // Triangles of a surface: the share of the cell's side is the root of their number's.
        let count = self.counts[self.cell_of(r)].max(1) as f32;
        longest(r) > self.cell * (LONG * LONG * LEAF / count).sqrt()
    }

    /// The best cut of a triangle's box, if it pays.
    fn cut(&self, r: &PrimRef, place: usize, side: f32) -> Option<Cut> {
        self.parted(r, side).map(|(gain, _)| Cut { gain, place: place as u32, side })
    }

    /// The area that the best cut saves, and the parts, if it pays.
    fn parted(&self, r: &PrimRef, side: f32) -> Option<(f32, [PrimRef; 2])> {
        let key = r.key();
        let Geometry::Triangles(mesh) = &self.geometries[key.geometry as usize] else { return None };
        let triangle = corners(mesh, key.prim as usize);
        let (axis, at) = self.plane(r)?;
        let parts = parts(r, triangle, axis, at, side * WIDENING)?;
        let area = |r: &PrimRef| r.extent().area(self.scale);
        let (whole, apart) = (area(r), area(&parts[0]) + area(&parts[1]));
        (apart < whole * KEPT).then_some((whole - apart, parts))
    }

    /// Where to cut: across the longest side, at the plane nearest to the middle of those that halve the scene most
    /// often, so that the parts of neighbours end together.
    fn plane(&self, r: &PrimRef) -> Option<(usize, f32)> {
        let Bounds3 { min, max } = r.bounds();
        let size = max - min;
        let axis = size.max_position();
        let (low, high) = (min[axis] + 0.25 * size[axis], max[axis] - 0.25 * size[axis]);
        let (start, whole) = (self.bounds.min[axis], self.bounds.max[axis] - self.bounds.min[axis]);
        let mut step = whole;
        while step > size[axis] * 0.25 {
            step *= 0.5;
            let at = start + ((low - start) / step).ceil() * step;
            if at > low && at < high {
                return Some((axis, at));
            }
        }
        None
    }
}

/// Both parts of a box around (a part of) a triangle, cut at a plane, widened by `pad` and rounded outward.
fn parts(r: &PrimRef, triangle: [Vec3; 3], axis: usize, at: f32, pad: f32) -> Option<[PrimRef; 2]> {
    let at = f64::from(at);
    let mut sides = [[DVec3::INFINITY, DVec3::NEG_INFINITY]; 2];
    let add = |[min, max]: &mut [DVec3; 2], point: DVec3| (*min, *max) = (min.min(point), max.max(point));
    let triangle = triangle.map(|corner| corner.as_dvec3());
    for (i, &a) in triangle.iter().enumerate() {
        let b = triangle[(i + 1) % 3];
        for (side, reaches) in sides.iter_mut().zip([a[axis] <= at, a[axis] >= at]) {
            if reaches {
                add(side, a);
            }
        }
        if (a[axis] < at && at < b[axis]) || (b[axis] < at && at < a[axis]) {
            let mut point = a + (b - a) * ((at - a[axis]) / (b[axis] - a[axis]));
            point[axis] = at;
            sides.iter_mut().for_each(|side| add(side, point));
        }
    }
    // Also the box that is cut: if it is the triangle's own, it is not wide enough for parts yet.
    let (whole, pad) = (r.bounds(), DVec3::splat(f64::from(pad)));
    let part = |[min, max]: [DVec3; 2]| {
        let min = min.max(whole.min.as_dvec3()) - pad;
        let max = max.min(whole.max.as_dvec3()) + pad;
        let bounds = rounded_out(min.to_array(), max.to_array()).filter(|b| !b.is_empty())?;
        Some(r.with_bounds(&bounds))
    };
    let [left, right] = sides;
    Some([part(left)?, part(right)?])
}

#[cfg(test)]
mod tests {
    use super::super::collect::collect;
    use super::*;
    use crate::Triangles;
    use penombre_lab::Pcg32;
    use std::sync::Arc;

    fn vector(rng: &mut Pcg32) -> Vec3 {
        Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
    }

    /// Thin triangles of very different lengths around a point.
    fn needles(count: u32, offset: Vec3) -> Vec<Geometry> {
        let mut rng = Pcg32::new(50);
        let mut positions = Vec::new();
        for _ in 0..count {
            let (at, size) = (vector(&mut rng), rng.next_f32());
            let ends = [vector(&mut rng) * (size * size * size), vector(&mut rng) * 0.002];
            positions.extend([at, at + ends[0], at + ends[1]].map(|p| p + offset));
        }
        let indices: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Triangles { positions: Arc::from(positions), indices: Arc::from(indices) };
        vec![Geometry::Triangles(mesh)]
    }

    /// Every point of a triangle lies in one of its parts, deeper than the analysis asks for.
    #[test]
    fn parts_hold_the_whole_triangle() {
        for offset in [Vec3::ZERO, Vec3::new(1e4, -3.0, 40.0)] {
            let geometries = needles(3000, offset);
            let mut refs = collect(&geometries, 1).expect("valid").refs;
            let whole = extent_of(&refs, 1).bounds();
            split(&mut refs, &geometries, 6000, 1);
            assert!(refs.len() > 3500, "{}", refs.len());
            assert!((extent_of(&refs, 1).bounds().max - whole.max).max_element() < 1e-2);
            let Geometry::Triangles(mesh) = &geometries[0] else { unreachable!("made above") };
            let mut parts = vec![Vec::new(); 3000];
            refs.iter().for_each(|r| parts[r.key().prim as usize].push(r.bounds()));
            let mut rng = Pcg32::new(51);
            for (i, parts) in parts.iter().enumerate().filter(|(_, parts)| !parts.is_empty()) {
                let [a, b, c] = corners(mesh, i).map(|corner| corner.as_dvec3());
                let side = (a.max(b).max(c) - a.min(b).min(c)).max_element();
                let pad = DVec3::splat(if parts.len() > 1 { 6.0 / f64::from(1 << 24) * side } else { 0.0 });
                for k in 0..40 {
                    let (u, v) = (f64::from(rng.next_f32()), f64::from(rng.next_f32()));
                    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                    let (u, v) = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].get(k).copied().unwrap_or((u, v));
                    let p = a * (1.0 - u - v) + b * u + c * v;
                    let ulp = DVec3::splat(p.abs().max_element() / f64::from(1u32 << 30) / 1024.0);
                    let holds = |part: &Bounds3| {
                        (part.min.as_dvec3() + pad).cmple(p + ulp).all()
                            && (part.max.as_dvec3() - pad).cmpge(p - ulp).all()
                    };
                    assert!(parts.iter().any(holds), "triangle {i}: {p}");
                }
            }
        }
    }

    /// Triangles that are as large as their neighbours are left alone.
    #[test]
    fn even_meshes_are_not_cut() {
        let mut positions = Vec::new();
        for i in 0..=60u32 {
            for k in 0..=60u32 {
                positions.push(Vec3::new(i as f32, (i * k % 7) as f32 * 0.2, k as f32));
            }
        }
        let quads = (0..60u32).flat_map(|i| (0..60u32).map(move |k| i * 61 + k));
        let indices: Vec<[u32; 3]> = quads.flat_map(|q| [[q, q + 1, q + 62], [q, q + 62, q + 61]]).collect();
        let mesh = Triangles { positions: Arc::from(positions), indices: Arc::from(indices) };
        let geometries = vec![Geometry::Triangles(mesh)];
        let mut refs = collect(&geometries, 1).expect("valid").refs;
        let before = refs.len();
        split(&mut refs, &geometries, 2 * before, 1);
        assert_eq!(refs.len(), before);
    }
}
