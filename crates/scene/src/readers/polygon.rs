//! Polygons into triangles.

use penombre_math::{DVec3, Vec3};

mod sweep;

/// Cutting ears takes, at worst, time in the square of the number of corners. This bounds the sum of those squares
/// over a file: a spiral takes about 50 ns a unit, so the worst file about 2 s.
const MOST_WORK: u64 = 40_000_000;
/// Polygons of up to this many corners are cut at their ears, and spend nothing: at worst a few microseconds a corner.
/// Larger ones are cut by a sweep if they are simple; ears are for those that it cannot cut.
pub(super) const ALWAYS_CUT: usize = 64;

/// How a polygon was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// Its surface is covered.
    Covered,
    /// Large, and not simple: it is left out.
    TooLarge,
}

/// Cuts polygons into triangles; keeps its memory between polygons.
#[derive(Default)]
pub(super) struct Triangulator {
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    earcut: earcut::Earcut<f64>,
    work: u64,
}

impl Triangulator {
    /// Appends triangles, as numbers of corners, with the polygon's orientation.
    ///
    /// Triangles stay as they are. Polygons that are convex, seen along their Newell normal \[Sutherland1974\], and
    /// those without a surface become a fan from the first corner; all others are cut at their ears or, if they are
    /// large, by a sweep.
    pub fn cut(&mut self, corners: &[Vec3], triangles: &mut Vec<[u32; 3]>) -> Cut {
        let n = corners.len();
        if n <= 3 || !self.flatten(corners) || is_convex(&self.flat) {
            return fan(n, triangles);
        }
        if n > ALWAYS_CUT {
            if sweep::triangulate(&self.flat, triangles) {
                return Cut::Covered;
            }
            let work = (n as u64).saturating_mul(n as u64);
            if self.work.saturating_add(work) > MOST_WORK {
                let is_round = is_nearly_covered_by_fan(&self.flat);
                return if is_round { fan(n, triangles) } else { Cut::TooLarge };
            }
            self.work = self.work.saturating_add(work);
        }
        self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
        if self.ears.is_empty() {
            fan(n, triangles);
        }
        for ear in self.ears.chunks_exact(3) {
            let [a, b, c] = [ear[0], ear[1], ear[2]];
            let clockwise = turn(self.flat[a as usize], self.flat[b as usize], self.flat[c as usize]) < 0.0;
            triangles.push(if clockwise { [a, c, b] } else { [a, b, c] });
        }
        Cut::Covered
    }

    /// Projects the corners along the axis nearest to the Newell normal, so that the polygon turns to the left.
    /// False if it has no surface.
    fn flatten(&mut self, corners: &[Vec3]) -> bool {
        let normal = newell_normal(corners);
        let size = normal.abs();
        if !normal.is_finite() || size.max_element() == 0.0 {
            return false;
        }
        let (u, v, w) = match size {
            s if s.x > s.y && s.x > s.z => (1, 2, 0),
            s if s.y > s.z => (2, 0, 1),
            _ => (0, 1, 2),
        };
        let (u, v) = if normal[w] < 0.0 { (v, u) } else { (u, v) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|p| [f64::from(p[u]), f64::from(p[v])]));
        true
    }
}

/// Twice the area vector of a polygon. Taken about the first corner, for polygons far from the origin.
fn newell_normal(corners: &[Vec3]) -> DVec3 {
    let first = corners[0].as_dvec3();
    let edges = corners[1..].windows(2);
    edges.map(|e| (e[0].as_dvec3() - first).cross(e[1].as_dvec3() - first)).sum()
}

fn fan(corners: usize, triangles: &mut Vec<[u32; 3]>) -> Cut {
    triangles.extend((2..corners as u32).map(|i| [0, i - 1, i]));
    Cut::Covered
}

/// Twice the surface of a polygon, negative if it turns to the right.
fn signed_area(flat: &[[f64; 2]]) -> f64 {
    flat[1..].windows(2).map(|w| turn(flat[0], w[0], w[1])).sum()
}

/// Twice the signed area of a triangle: positive if it turns to the left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// True if a polygon that turns to the left nowhere turns to the right and winds round only once, which is so if its
/// edges change their direction along an axis only twice.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    let at = |i: usize| flat[i % n];
    let turns_left = (0..n).all(|i| turn(at(i), at(i + 1), at(i + 2)) >= 0.0);
    turns_left && (0..2).all(|axis| reversals(flat, axis) <= 2)
}

/// True if the fan from the first corner covers the polygon but for a millionth of its surface: so it is with round
/// polygons whose corners were rounded to a few digits. All corners must lie before the first one, as seen from it
/// towards their mean, none of them at it, and the triangles must have room in the box around the corners: then the fan
/// does not wind round again and again.
fn is_nearly_covered_by_fan(flat: &[[f64; 2]]) -> bool {
    let first = flat[0];
    let from_first = |p: &[f64; 2]| [p[0] - first[0], p[1] - first[1]];
    let mean = flat.iter().map(from_first).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
    let least = -1e-6 * (mean[0] * mean[0] + mean[1] * mean[1]) / flat.len() as f64;
    let before = flat.iter().map(from_first).all(|p| p[0] * mean[0] + p[1] * mean[1] >= least);
    let areas = || flat.windows(2).map(|w| turn(first, w[0], w[1]));
    let back: f64 = areas().map(|a| (-a).max(0.0)).sum();
    let none_at_first = flat[1..].iter().all(|p| *p != first);
    let extent = |axis: usize| {
        let [low, high] =
            flat.iter().fold([f64::MAX, f64::MIN], |[l, h], p| [l.min(p[axis]), h.max(p[axis])]);
        high - low
    };
    let twice = areas().sum::<f64>();
    before && none_at_first && back <= 1e-6 * twice && twice <= 2.0 * extent(0) * extent(1)
}

/// How often the edges change their direction along an axis, once round.
fn reversals(flat: &[[f64; 2]], axis: usize) -> usize {
    let next = flat.iter().cycle().skip(1);
    let steps = flat.iter().zip(next).map(|(a, b)| b[axis] - a[axis]).filter(|d| *d != 0.0);
    let rising: Vec<bool> = steps.map(|d| d > 0.0).collect();
    (0..rising.len()).filter(|i| rising[*i] != rising[(i + 1) % rising.len()]).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_math::Vec2;

    fn cut(corners: &[Vec3]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        assert_eq!(Triangulator::default().cut(corners, &mut triangles), Cut::Covered);
        triangles
    }

    fn lifted(flat: &[[f32; 2]]) -> Vec<Vec3> {
        // A plane of no special position.
        let (x, y) = (Vec3::new(0.6, 0.3, -0.5), Vec3::new(-0.1, 0.8, 0.4));
        flat.iter().map(|p| x * p[0] + y * p[1] + Vec3::new(3.0, -2.0, 1.0)).collect()
    }

    /// Area vectors of the polygon and of its triangles, and the sum of the triangles' areas.
    fn areas(corners: &[Vec3], triangles: &[[u32; 3]]) -> (DVec3, DVec3, f64) {
        let normal = |t: &[u32; 3]| newell_normal(&t.map(|i| corners[i as usize]));
        (
            newell_normal(corners),
            triangles.iter().map(normal).sum(),
            triangles.iter().map(|t| normal(t).length()).sum(),
        )
    }

    fn assert_covers(corners: &[Vec3]) {
        let triangles = cut(corners);
        let (whole, sum, total) = areas(corners, &triangles);
        let tolerance = 1e-5 * whole.length();
        assert!((whole - sum).length() < tolerance, "{whole} {sum}");
        // No overlap and no triangle upside down, else the areas would add to more.
        assert!((whole.length() - total).abs() < tolerance, "{} {total}", whole.length());
    }

    #[test]
    fn triangles_and_convex_polygons_become_fans() {
        let quad = lifted(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(cut(&quad[..3]), [[0, 1, 2]]);
        assert_eq!(cut(&quad), [[0, 1, 2], [0, 2, 3]]);
        let reversed: Vec<Vec3> = quad.iter().rev().copied().collect();
        assert_eq!(cut(&reversed), [[0, 1, 2], [0, 2, 3]]);
        let line = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0];
        assert_eq!(cut(&line), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&[Vec3::ONE; 5]).len(), 3);
    }

    #[test]
    fn concave_polygons_keep_their_surface() {
        let shapes: [&[[f32; 2]]; 3] = [
            &[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]],
            &[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]],
            &[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 2.0], [4.0, 2.0], [4.0, 3.0], [0.0, 3.0]],
        ];
        for shape in shapes {
            for start in 0..shape.len() {
                let mut corners = lifted(shape);
                corners.rotate_left(start);
                assert_covers(&corners);
                corners.reverse();
                assert_covers(&corners);
            }
        }
    }

    #[test]
    fn random_star_shaped_polygons_keep_their_surface() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        for n in 4..200 {
            let flat: Vec<[f32; 2]> = (0..n)
                .map(|i| {
                    let angle = i as f32 / n as f32 * std::f32::consts::TAU;
                    let at = Vec2::new(penombre_math::float::cos(angle), penombre_math::float::sin(angle));
                    (at * (0.2 + random())).to_array()
                })
                .collect();
            assert_covers(&lifted(&flat));
        }
    }

    #[test]
    fn a_pentagram_is_not_convex() {
        // It turns to the left at every corner, but winds round twice.
        let flat = [[1.0, 0.0], [-0.809, 0.588], [0.309, -0.951], [0.309, 0.951], [-0.809, -0.588]];
        assert!(!is_convex(&flat));
        assert!(is_convex(&[[1.0, 0.0], [0.309, 0.951], [-0.809, 0.588], [-0.809, -0.588], [0.309, -0.951]]));
    }

    /// A comb whose teeth stand close.
    fn comb(n: usize) -> Vec<Vec3> {
        let low = (0..n).map(|i| Vec3::new(i as f32, (i % 2) as f32 * 5.0, 0.0));
        let high = (0..n).rev().map(|i| Vec3::new(i as f32, 1.0 + (i % 2) as f32 * 5.0, 0.0));
        low.chain(high).collect()
    }

    /// A band of `n` corners that winds `turns` times round: few of its corners are ears.
    fn spiral(n: usize, turns: f32) -> Vec<Vec3> {
        let half = n / 2;
        let at = |i: usize, width: f32| {
            let angle = i as f32 / half as f32 * turns * std::f32::consts::TAU;
            let direction =
                Vec3::new(penombre_math::float::cos(angle), penombre_math::float::sin(angle), 0.0);
            direction * (1.0 + angle + width)
        };
        (0..half).map(|i| at(i, 1.0)).chain((0..half).rev().map(|i| at(i, 0.0))).collect()
    }

    #[test]
    fn large_polygons_keep_their_surface_in_less_than_quadratic_time() {
        let spiky = |i: u32| {
            let angle = i as f32 / 1e5 * std::f32::consts::TAU;
            let [x, y] = [penombre_math::float::cos(angle), penombre_math::float::sin(angle)];
            Vec3::new(x, y, 0.0) * (1 + i % 2) as f32
        };
        // Spikes of many lengths below and above.
        let height = |i: usize| (i * 7919 % 1000) as f32;
        let lower = |i: usize| Vec3::new(i as f32, if i.is_multiple_of(2) { -height(i) } else { 5.0 }, 0.0);
        let upper =
            |i: usize| Vec3::new(i as f32, if i.is_multiple_of(2) { 9.0 + height(i) } else { 6.0 }, 0.0);
        let spikes = (0..60_001).map(lower).chain((0..60_001).rev().map(upper)).collect();
        let begin = std::time::Instant::now();
        for mut corners in [comb(50_000), spiral(40_000, 40.0), (0..100_000).map(spiky).collect(), spikes] {
            for turn in [0.0, 0.3, 1.9, 4.0] {
                let (s, c) = (penombre_math::float::sin(turn), penombre_math::float::cos(turn));
                let turned = |p: &Vec3| Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, 0.0);
                let turned: Vec<Vec3> = corners.iter().map(turned).collect();
                assert_covers(&turned);
                assert_eq!(cut(&turned).len(), corners.len() - 2);
                corners.rotate_left(1234);
                corners.reverse();
            }
        }
        assert!(begin.elapsed().as_secs_f32() < 60.0, "{:?}", begin.elapsed());
    }

    #[test]
    fn the_sweep_cuts_small_polygons_as_well() {
        let mut state = 3u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        for n in 3..300u32 {
            let point = |i: u32, r: f64| {
                let angle = i as f32 / n as f32 * std::f32::consts::TAU;
                [
                    f64::from(penombre_math::float::cos(angle)) * r,
                    f64::from(penombre_math::float::sin(angle)) * r,
                ]
            };
            let flat: Vec<[f64; 2]> = (0..n).map(|i| point(i, 0.1 + random())).collect();
            let mut triangles = Vec::new();
            assert!(sweep::triangulate(&flat, &mut triangles), "{n}");
            assert_eq!(triangles.len(), n as usize - 2);
        }
        // Corners in line, edges along the axes, and a hole that is joined with the outside by a bridge.
        let cross =
            [[1, 0], [2, 0], [2, 1], [3, 1], [3, 2], [2, 2], [2, 3], [1, 3], [1, 2], [0, 2], [0, 1], [1, 1]];
        let line =
            [[0, 0], [1, 0], [2, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3], [0, 2], [0, 1]];
        let hole = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1]];
        for flat in [&cross[..], &line, &hole] {
            let flat: Vec<[f64; 2]> = flat.iter().map(|p| p.map(f64::from)).collect();
            let mut triangles = Vec::new();
            assert!(sweep::triangulate(&flat, &mut triangles), "{flat:?}");
            assert_eq!(triangles.len(), flat.len() - 2);
        }
        // What crosses itself is found out, and nothing is left of it.
        let mut triangles = vec![[7, 8, 9]];
        let crossed = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [1.0, -1.0], [0.0, 3.0]];
        assert!(!sweep::triangulate(&crossed, &mut triangles));
        assert_eq!(triangles, [[7, 8, 9]]);
    }

    #[test]
    fn the_sweep_answers_whatever_the_polygon() {
        // Few places, so that corners and edges meet, overlap and turn back on themselves.
        let mut state = 11u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % n
        };
        let mut cut = 0;
        for round in 0..20_000 {
            let (corners, places) = (3 + below(if round % 10 == 0 { 2000 } else { 12 }), 2 + below(6));
            let flat: Vec<[f64; 2]> =
                (0..corners).map(|_| [below(places) as f64, below(places) as f64]).collect();
            let mut triangles = Vec::new();
            let is_whole = sweep::triangulate(&flat, &mut triangles);
            assert!(is_whole || triangles.is_empty());
            let area = |t: &[u32; 3]| t.map(|i| flat[i as usize]);
            let covered: f64 = triangles.iter().map(area).map(|[a, b, c]| turn(a, b, c).abs()).sum();
            assert!(!is_whole || (covered - signed_area(&flat)).abs() < 1e-6 * covered.max(1.0));
            cut += usize::from(is_whole);
        }
        assert!(cut > 1000, "{cut}");
    }

    /// Corners anywhere: nearly every edge crosses thousands of others.
    fn scattered(n: u64) -> Vec<Vec3> {
        let at = |i: u64, k: u64| (i.wrapping_mul(k) >> 40) as f32;
        let corner = |i| Vec3::new(at(i, 0x9E37_79B9_7F4A_7C15), at(i, 0xD1B5_4A32_D192_ED03), 0.0);
        (0..n).map(corner).collect()
    }

    #[test]
    fn polygons_that_cross_themselves_take_bounded_work_over_a_file() {
        let (mut triangulator, mut triangles) = (Triangulator::default(), Vec::new());
        let begin = std::time::Instant::now();
        assert_eq!(triangulator.cut(&scattered(200_000), &mut triangles), Cut::TooLarge);
        assert_eq!(triangles.len(), 0);
        // A triangle that is gone round a hundred thousand times.
        let round: Vec<Vec3> = (0..300_000).map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y][i % 3]).collect();
        assert_eq!(triangulator.cut(&round, &mut triangles), Cut::TooLarge);
        assert_eq!(triangulator.cut(&round[1..299_999], &mut triangles), Cut::TooLarge);
        // What was too large has spent nothing: 4e7 are 40 polygons of 1000 corners.
        let large = scattered(1000);
        let cuts: Vec<Cut> = (0..42).map(|_| triangulator.cut(&large, &mut triangles)).collect();
        assert_eq!(cuts.iter().position(|c| *c == Cut::TooLarge), Some(40));
        assert_eq!(triangulator.cut(&scattered(ALWAYS_CUT as u64), &mut triangles), Cut::Covered);
        assert_eq!(triangulator.cut(&spiral(1000, 1.5), &mut triangles), Cut::Covered);
        assert!(begin.elapsed().as_secs_f32() < 20.0, "{:?}", begin.elapsed());
    }

    #[test]
    fn round_polygons_of_rounded_corners_keep_their_surface() {
        let (mut triangulator, mut triangles) = (Triangulator::default(), Vec::new());
        // Rounded to six digits a circle is not quite convex.
        let circle = |i: i32| {
            let angle = i as f32 / 20_000.0 * std::f32::consts::TAU;
            let [x, y] = [penombre_math::float::cos(angle), penombre_math::float::sin(angle)];
            Vec3::new((x * 1e6).round() / 1e6, (y * 1e6).round() / 1e6, 0.0)
        };
        let circle: Vec<Vec3> = (0..20_000).map(circle).collect();
        triangles.clear();
        assert_eq!(triangulator.cut(&circle, &mut triangles), Cut::Covered);
        let (whole, _, total) = areas(&circle, &triangles);
        assert!((total / whole.length() - 1.0).abs() < 3e-6, "{total} {whole}");
        // A square with many corners on its sides is convex, and exact whatever its size.
        let side = |x: f32, y: f32, dx: f32, dy: f32| {
            (0..25_000).map(move |i| Vec3::new(x + i as f32 * dx, y + i as f32 * dy, 0.0))
        };
        let lower = side(0.0, 0.0, 1.0, 0.0).chain(side(25e3, 0.0, 0.0, 1.0));
        let upper = side(25e3, 25e3, -1.0, 0.0).chain(side(0.0, 25e3, 0.0, -1.0));
        triangles.clear();
        let square: Vec<Vec3> = lower.chain(upper).collect();
        assert_eq!(triangulator.cut(&square, &mut triangles), Cut::Covered);
        assert_eq!(triangles.len(), 99_998);
    }
}
