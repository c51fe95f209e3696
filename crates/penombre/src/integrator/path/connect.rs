//! Ways from one point to another by way of a sphere: mirrored by its outside, or straight through it.
//!
//! Both are problems of a plane, the one that contains the two points and the centre.

use penombre_math::{DVec3, float};
use std::sync::LazyLock;

/// Where a light is: a point, or the unit direction towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// World space, metres.
    Point(DVec3),
    /// At infinity.
    Direction(DVec3),
}

/// The plane of two points and the centre of a sphere, in units of its radius: the centre is the origin, the first point lies
/// at (−distance, 0).
struct Plane {
    x: DVec3,
    y: DVec3,
    distance: f64,
    /// The target, or its direction.
    target: [f64; 2],
    is_direction: bool,
}

impl Plane {
    /// `None` from within the sphere, or to a target within it.
    #[inline(always)]
    fn new(from: DVec3, target: Target, center: DVec3, radius: f64) -> Option<Self> {
        let to_center = (center - from) / radius;
        let distance = to_center.length();
        let x = to_center / distance;
        let (to, is_direction) = match target {
            Target::Point(p) => ((p - center) / radius, false),
            Target::Direction(d) => (d, true),
        };
        let along = to.dot(x);
        let beside = to - x * along;
        let height = beside.length();
        let y = if height > 0.0 { beside / height } else { x.any_orthonormal_vector() };
        let outside = distance > 1.0 + 1e-6 && (is_direction || to.length_squared() > 1.0 + 1e-6);
        outside.then_some(Self { x, y, distance, target: [along, height], is_direction })
    }

    /// By how much rays that meet the ball at each angle that is tried miss the target, and the slopes of that over the angle:
    /// in single precision, all at once.
    #[inline(always)]
    fn misses(&self, ior: f64) -> [[f32; TRIES]; 2] {
        let [sines, cosines] = &*SINES;
        let (most, distance, index) = (ior.min(1.0) as f32, 1.0 / self.distance as f32, 1.0 / ior as f32);
        let [tx, ty] = self.target.map(|v| v as f32);
        let beside = if self.is_direction { 0.0 } else { 1.0f32 };
        let (mut misses, mut slopes) = ([0.0; TRIES], [0.0; TRIES]);
        for i in 0..TRIES {
            let sin = sines[i] * most;
            let cos = if most < 1.0 { (1.0 - sin * sin).max(0.0).sqrt() } else { cosines[i] };
            let sin_a = sin * distance;
            let cos_a = (1.0 - sin_a * sin_a).max(0.0).sqrt();
            let sin_t = sin * index;
            let cos_t = (1.0 - sin_t * sin_t).max(0.0).sqrt();
            let (s, c) = (sin * cos_t - cos * sin_t, cos * cos_t + sin * sin_t);
            let (s2, c2) = (2.0 * s * c, c * c - s * s);
            let (x, y) = (cos_a * c2 + sin_a * s2, sin_a * c2 - cos_a * s2);
            misses[i] = x * ty - y * tx - beside * sin;
            let sin_slope = most * cosines[i];
            let first = if most < 1.0 { sin_slope / cos.max(1e-9) } else { 1.0 };
            let second = if most < 1.0 { 1.0 } else { sin_slope * index / cos_t };
            let turned = sin_slope * distance / cos_a.max(1e-9) - 2.0 * (first - second);
            slopes[i] = -(x * tx + y * ty) * turned - beside * sin_slope;
        }
        [misses, slopes]
    }

    /// By how much a ray misses the target, in radii, or as a sine if that is a direction.
    #[inline(always)]
    fn miss(&self, p: &Passage) -> f64 {
        let across = p.behind[0] * self.target[1] - p.behind[1] * self.target[0];
        if self.is_direction { across } else { across - p.beside }
    }

    /// By how much a ray misses the target, and the slope of that over the angle whose point of the circle is `angle`.
    #[inline(always)]
    fn miss_and_slope(&self, p: &Passage, [_, cos]: [f64; 2], most: f64, ior: f64) -> (f64, f64) {
        let [tx, ty] = self.target;
        let ahead = p.behind[0] * tx + p.behind[1] * ty;
        let sin_slope = most * cos;
        let slope_of = |sin: f64| sin_slope / (1.0 - sin * sin).max(1e-18).sqrt();
        let before = slope_of(p.before[1]) / self.distance;
        // One of the two sines is that of the angle itself.
        let first = if most < 1.0 { slope_of(p.beside) } else { 1.0 };
        let second = if most < 1.0 { 1.0 } else { slope_of(p.beside / ior) / ior };
        let turned = before - 2.0 * (first - second);
        let aside = if self.is_direction { 0.0 } else { sin_slope };
        (self.miss(p), -ahead * turned - aside)
    }

    /// The points at which a ray enters and leaves, if the target lies behind.
    fn through(&self, p: &Passage) -> Option<Through> {
        let half_chord = (1.0 - p.beside * p.beside).max(0.0).sqrt();
        let ahead = self.target[0] * p.behind[0] + self.target[1] * p.behind[1];
        let least = if self.is_direction { 0.0 } else { half_chord };
        if ahead <= least || half_chord < 1e-3 {
            return None;
        }
        let point = |d: [f64; 2], along: f64| {
            self.direction([along * d[0] - p.beside * d[1], along * d[1] + p.beside * d[0]])
        };
        Some(Through { entry: point(p.before, -half_chord), exit: point(p.behind, half_chord) })
    }

    /// A direction of the plane, or a point of the sphere as seen from its centre.
    fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        self.x * x + self.y * y
    }
}

/// The point of the outside of a sphere that mirrors `from` to the target, as the unit vector from the centre. There is at most
/// one: of the arc between the two points as seen from the centre, where the angles of incidence and reflection agree.
/// Newton's method within brackets; the difference of the sines of both angles falls along the arc.
#[inline(always)]
pub fn mirror_point(from: DVec3, target: Target, center: DVec3, radius: f64) -> Option<DVec3> {
    let plane = Plane::new(from, target, center, radius)?;
    // In this plane the point is at (distance, 0) and the target above: x is turned round.
    let d = plane.distance;
    let [tx, ty] = [-plane.target[0], plane.target[1]];
    let length = (tx * tx + ty * ty).sqrt();
    let end = [tx / length, ty / length];
    // The sought normal's direction lies between `low` and `high`.
    let (mut low, mut high) = ([1.0, 0.0], end);
    let mut n = normalized([1.0 + end[0], end[1]])?;
    for _ in 0..12 {
        let t = [-n[1], n[0]];
        let seen = |to: [f64; 2]| {
            let l = (to[0] * to[0] + to[1] * to[1]).sqrt();
            let (s, c) = ((t[0] * to[0] + t[1] * to[1]) / l, (n[0] * to[0] + n[1] * to[1]) / l);
            (s, c, l)
        };
        let (s0, c0, l0) = seen([d - n[0], -n[1]]);
        let (s1, c1, l1) = seen(if plane.is_direction { [tx, ty] } else { [tx - n[0], ty - n[1]] });
        let bend1 = if plane.is_direction { 0.0 } else { c1 * c1 / l1 };
        let value = s0 + s1;
        let slope = -(c0 + c0 * c0 / l0 + c1 + bend1);
        if value > 0.0 {
            low = n
        } else {
            high = n
        }
        let step = -value / slope;
        // The next error is about the square of this one.
        if step.abs() < 1e-4 {
            let n = normalized([n[0] + step * t[0], n[1] + step * t[1]])?;
            return (c0 > 1e-4 && c1 > 1e-4).then(|| plane.direction([-n[0], n[1]]));
        }
        let moved = normalized([n[0] + step * t[0], n[1] + step * t[1]])?;
        let between = cross(low, moved) >= 0.0 && cross(moved, high) >= 0.0 && step.abs() < 1.0;
        n = if between { moved } else { normalized([low[0] + high[0], low[1] + high[1]])? };
    }
    None
}

fn normalized([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let length = (x * x + y * y).sqrt();
    (length > 1e-12).then(|| [x / length, y / length])
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// A way straight through a sphere: unit vectors from the centre to where it enters and leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Through {
    pub entry: DVec3,
    pub exit: DVec3,
}

/// Angles at which ways are tried: evenly from −90° to 90°.
const TRIES: usize = 32;

/// Most ways that are told.
const MOST_WAYS: usize = 4;

/// A ray of the plane through the sphere.
struct Passage {
    /// Direction before and behind.
    before: [f64; 2],
    behind: [f64; 2],
    /// Distance at which it passes the centre, on its left.
    beside: f64,
}

impl Passage {
    /// From sine and cosine of the angle of incidence. A ray and the way that it takes behind the sphere pass the centre at
    /// the same distance; it is turned by twice the difference of the angles before and behind the boundary.
    #[inline(always)]
    fn new(sin: f64, cos: f64, distance: f64, ior: f64) -> Self {
        let sin_a = sin / distance;
        let cos_a = (1.0 - sin_a * sin_a).max(0.0).sqrt();
        let sin_t = sin / ior;
        let cos_t = (1.0 - sin_t * sin_t).max(0.0).sqrt();
        // The turn at one boundary, then at both.
        let (s, c) = (sin * cos_t - cos * sin_t, cos * cos_t + sin * sin_t);
        let (s2, c2) = (2.0 * s * c, c * c - s * s);
        let behind = [cos_a * c2 + sin_a * s2, sin_a * c2 - cos_a * s2];
        Self { before: [cos_a, sin_a], behind, beside: sin }
    }
}

/// All ways from a point through a sphere of glass to a target, as [`Through`]; `ior` is the index of the inside.
#[inline(always)]
pub fn ways_through(from: DVec3, target: Target, center: DVec3, radius: f64, ior: f64) -> Ways {
    let mut found = Ways::default();
    let Some(plane) = Plane::new(from, target, center, radius) else { return found };
    // Beyond this sine rays are reflected totally.
    let most = ior.min(1.0);
    let miss = |p: &Passage| plane.miss(p);
    let at = |[sin, cos]: [f64; 2]| {
        let sin = sin * most;
        let cos = if most < 1.0 { (1.0 - sin * sin).max(0.0).sqrt() } else { cos };
        Passage::new(sin, cos, plane.distance, ior)
    };
    let [misses, slopes] = plane.misses(ior);
    let angle = |i: usize| [SINES[0][i], SINES[1][i]].map(f64::from);
    let value_and_slope = |angle: [f64; 2]| plane.miss_and_slope(&at(angle), angle, most, ior);
    let mut tell = |ends: [[f64; 2]; 2], values: [f64; 2]| {
        let p = at(refine(ends, values, value_and_slope));
        if let Some(way) = plane.through(&p)
            && found.count < MOST_WAYS
        {
            found.list[found.count] = way;
            found.count += 1;
        }
    };
    for i in 0..TRIES - 1 {
        let (near, far) = (misses[i], misses[i + 1]);
        if (near < 0.0) != (far < 0.0) {
            let ends = [angle(i), angle(i + 1)];
            tell(ends, ends.map(|a| miss(&at(a))));
        } else if near * slopes[i] < 0.0 && far * slopes[i + 1] > 0.0 {
            // Near a focus two ways may lie close together.
            let ends = [angle(i), angle(i + 1)];
            let values = ends.map(|a| miss(&at(a)));
            if let Some((middle, value)) = dip(ends, value_and_slope) {
                tell([ends[0], middle], [values[0], value]);
                tell([middle, ends[1]], [value, values[1]]);
            }
        }
    }
    found
}

/// A few ways.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ways {
    list: [Through; MOST_WAYS],
    count: usize,
}

impl IntoIterator for Ways {
    type Item = Through;
    type IntoIter = std::iter::Take<std::array::IntoIter<Through, MOST_WAYS>>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter().take(self.count)
    }
}

/// Where a function of a point on the circle, given with its slope, that comes closer to 0 from both of two points has the other
/// sign between them, and its value there: looked for at the minimum of the cubic through both \[Nocedal2006\], as long as
/// the tangents cross 0, below which a convex function does not fall.
fn dip(mut ends: [[f64; 2]; 2], f: impl Fn([f64; 2]) -> (f64, f64)) -> Option<([f64; 2], f64)> {
    let [first, last] = ends.map(&f);
    let sign = first.0.signum();
    let [mut a, mut b] = [first, last].map(|(value, slope)| (value * sign, slope * sign));
    for _ in 0..8 {
        // A chord stands for its angle.
        let width = chord(ends[0], ends[1]);
        let bend = b.1 - a.1;
        let lowest = a.0 + a.1 * (a.0 - b.0 + b.1 * width) / bend;
        if !(a.0 > 0.0 && b.0 > 0.0 && a.1 < 0.0 && b.1 > 0.0 && lowest < 0.0) {
            return None;
        }
        let mean = a.1 + b.1 - 3.0 * (b.0 - a.0) / width;
        let root = (mean * mean - a.1 * b.1).sqrt();
        let share = 1.0 - (b.1 + root - mean) / (bend + 2.0 * root);
        let middle = normalized([0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) * share))?;
        let (value, slope) = f(middle);
        if value * sign < 0.0 {
            return Some((middle, value));
        }
        let found = (value * sign, slope * sign);
        if found.1 < 0.0 { (ends[0], a) = (middle, found) } else { (ends[1], b) = (middle, found) }
    }
    None
}

fn chord(a: [f64; 2], b: [f64; 2]) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()
}

/// Where a function of a point on the circle, given with its slope, is 0 between two of them: Newton's method within brackets,
/// from where the chord is 0.
fn refine(mut ends: [[f64; 2]; 2], values: [f64; 2], f: impl Fn([f64; 2]) -> (f64, f64)) -> [f64; 2] {
    let between = |ends: &[[f64; 2]; 2], share: f64| {
        normalized([0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) * share)).unwrap_or(ends[0])
    };
    let mut root = between(&ends, values[0] / (values[0] - values[1]));
    for _ in 0..16 {
        let (value, slope) = f(root);
        ends[usize::from((value < 0.0) == (values[1] < 0.0))] = root;
        let step = -value / slope;
        let [sin, cos] = root;
        let moved = normalized([sin + cos * step, cos - sin * step]).unwrap_or(root);
        // The sines grow from end to end.
        let inside = step.abs() < 0.5 && moved[0] >= ends[0][0] && moved[0] <= ends[1][0];
        root = if inside { moved } else { between(&ends, 0.5) };
        // The next error is about the square of this one.
        if inside && step.abs() < 1e-5 {
            break;
        }
    }
    root
}

/// Sines and cosines of the angles that are tried.
static SINES: LazyLock<[[f32; TRIES]; 2]> = LazyLock::new(|| {
    let at = |i: usize| float::sin_cos_degrees(180.0 * (i as f64 / (TRIES - 1) as f64 - 0.5));
    [std::array::from_fn(|i| at(i).0 as f32), std::array::from_fn(|i| at(i).1.max(0.0) as f32)]
});

#[cfg(test)]
mod tests {
    use super::super::tube::Tube;
    use super::*;
    use penombre_math::hash::{combine, unit_f32};

    const CENTER: DVec3 = DVec3::new(0.3, -0.2, 0.5);
    const RADIUS: f64 = 0.8;

    fn vector(trial: u32, k: u32) -> DVec3 {
        let number = |k| f64::from(unit_f32(combine(trial, k))) * 2.0 - 1.0;
        DVec3::new(number(k), number(k + 1), number(k + 2))
    }

    fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
        let cos = -d.dot(n);
        let square = 1.0 - (1.0 - cos * cos) / (eta * eta);
        (square > 0.0).then(|| d / eta + n * (cos / eta - square.sqrt()))
    }

    /// Where a ray from `from` first meets the ball, as the normal.
    fn meet(from: DVec3, d: DVec3) -> Option<DVec3> {
        let to = from - CENTER;
        let b = to.dot(d);
        let square = b * b - to.length_squared() + RADIUS * RADIUS;
        (square > 0.0).then(|| (to + d * (-b - square.sqrt())) / RADIUS)
    }

    /// The ray behind the ball after a reflection, and the lengths and cosines on the way.
    fn mirror(from: DVec3, d: DVec3) -> Option<(DVec3, DVec3)> {
        let n = meet(from, d)?;
        Some((CENTER + n * RADIUS, d - n * (2.0 * d.dot(n))))
    }

    /// The same after two refractions.
    fn pass(from: DVec3, d: DVec3, ior: f64) -> Option<(DVec3, DVec3, [f64; 5])> {
        let n = meet(from, d)?;
        let inside = refract(d, n, ior)?;
        let chord = -2.0 * RADIUS * n.dot(inside);
        let m = (n * RADIUS + inside * chord) / RADIUS;
        let out = refract(inside, -m, 1.0 / ior)?;
        let cosines = [-d.dot(n), -inside.dot(n), inside.dot(m), out.dot(m)];
        Some((CENTER + m * RADIUS, out, [cosines[0], cosines[1], cosines[2], cosines[3], chord]))
    }

    #[test]
    fn mirror_points_mirror_the_target() {
        let mut found = 0;
        for trial in 0..3000 {
            let (from, to) = (vector(trial, 0) * 3.0, vector(trial, 3) * 4.0);
            let is_direction = trial % 3 == 0;
            let target = if is_direction { Target::Direction(to.normalize()) } else { Target::Point(to) };
            let Some(n) = mirror_point(from, target, CENTER, RADIUS) else { continue };
            let p = CENTER + n * RADIUS;
            let (q, out) = mirror(from, (p - from).normalize()).unwrap();
            let toward = if is_direction { to.normalize() } else { (to - p).normalize() };
            assert!(q.distance(p) < 1e-6 && out.distance(toward) < 1e-6, "{trial}");
            found += 1;
        }
        assert!(found > 1500, "{found}");
    }

    /// Rays in all directions through the ball: the way to a point behind it is found.
    #[test]
    fn all_ways_through_are_found() {
        let (mut passed, mut missed) = (0, 0);
        for trial in 0..20_000 {
            let from = CENTER + vector(trial, 0).normalize() * (1.0 + 3.0 * f64::from(trial % 17) / 16.0);
            let ior = [1.5, 1.33, 2.4, 0.7][trial as usize % 4];
            let aim = CENTER + vector(trial, 3) * RADIUS;
            let d = (aim - from).normalize();
            let Some((q, out, cosines)) = pass(from, d, ior) else { continue };
            if from.distance(CENTER) < RADIUS * 1.01 || cosines.iter().any(|c| *c < 0.05) {
                continue;
            }
            let to = q + out * (0.1 + 4.0 * f64::from(trial % 5));
            let target = if trial % 3 == 0 { Target::Direction(out) } else { Target::Point(to) };
            let entry = meet(from, d).unwrap();
            let ways = ways_through(from, target, CENTER, RADIUS, ior);
            passed += 1;
            let hit = ways.into_iter().any(|w| w.entry.distance(entry) < 1e-5);
            missed += i32::from(!hit);
        }
        // Where two ways are almost one, rounding decides.
        assert!(passed > 8000 && missed * 4000 < passed, "{missed} of {passed}");
    }

    /// The widening of the bundle is that of two rays side by side.
    #[test]
    fn tubes_widen_as_their_rays_do() {
        let mut compared = 0;
        for trial in 0..3000 {
            let from = CENTER + vector(trial, 0).normalize() * 2.5;
            let d = (CENTER + vector(trial, 3) * 0.7 - from).normalize();
            let far = 3.0;
            let ior = 1.5;
            let is_mirror = trial % 2 == 0;
            let end = |d: DVec3| {
                let (q, out) = if is_mirror {
                    mirror(from, d)?
                } else {
                    let (q, out, _) = pass(from, d, ior)?;
                    (q, out)
                };
                Some((q, out))
            };
            let Some((q, out)) = end(d) else { continue };
            let n = meet(from, d).unwrap();
            let (distance, cos) = ((CENTER + n * RADIUS).distance(from), -d.dot(n));
            if cos < 0.15 {
                continue;
            }
            let tube = if is_mirror {
                Tube::start(distance as f32).mirrored(cos as f32, RADIUS as f32)
            } else {
                let (_, _, c) = pass(from, d, ior).unwrap();
                let c = c.map(|v| v as f32);
                Tube::start(distance as f32)
                    .refracted(c[0], c[1], ior as f32, RADIUS as f32)
                    .advance(c[4])
                    .refracted(c[2], c[3], 1.0 / ior as f32, -RADIUS as f32)
            };
            let plane = q + out * far;
            let (a, b) = d.any_orthonormal_pair();
            let step = 1e-5;
            let hit = |offset: DVec3| {
                let (q, o) = end((d + offset * step).normalize())?;
                Some((q + o * ((plane - q).dot(out) / o.dot(out)) - plane, o - out))
            };
            let (Some((pa, oa)), Some((pb, ob))) = (hit(a), hit(b)) else { continue };
            let area = pa.cross(pb).length() / (step * step);
            let angle = (oa - out * oa.dot(out)).cross(ob - out * ob.dot(out)).length() / (step * step);
            let ours = f64::from(tube.advance(far as f32).area());
            assert!((ours - area).abs() < 2e-2 * area + 5e-3, "{trial} {is_mirror}: {ours} {area}");
            let ours = f64::from(tube.solid_angle());
            assert!((ours - angle).abs() < 2e-2 * angle + 5e-3, "{trial} {is_mirror}: {ours} {angle}");
            compared += 1;
        }
        assert!(compared > 1500, "{compared}");
    }
}
