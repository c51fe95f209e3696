//! Many directions to a rectangle at once, in single precision, where that is accurate enough.

use penombre_math::{DVec3, Vec2, Vec3, quick};
use std::f32::consts::TAU;

/// A rectangle, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuickRectangle {
    origin: Vec3,
    /// Unit vectors along the sides and across them.
    axes: [Vec3; 3],
    lengths: [f32; 2],
    /// The first two in double precision, for the points: they lie on the plane but for one rounding.
    along: [DVec3; 2],
}

/// Where to look from and which direction to take. Plain arrays, for loops over all.
#[derive(Clone, Debug, Default)]
pub struct Requests {
    from: [Vec<f32>; 3],
    u: [Vec<f32>; 2],
}

/// Directions in the order of the requests.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    wi: [Vec<f32>; 3],
    distance: Vec<f32>,
    /// Shares of the sides.
    shares: [Vec<f32>; 2],
    solid_angle: Vec<f32>,
}

/// Below this solid angle, in sr, single precision is not accurate enough: the error of a direction's share is
/// about 2·10⁻⁷ of it.
const LEAST: f32 = 0.02;

/// Nor where the rectangle is seen from beside it at more than this ratio of the distances along and above its plane:
/// the error is about 10⁻⁷·ratio².
const GRAZING: f32 = 16.0;

impl Requests {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.from.iter_mut().chain(&mut self.u).for_each(Vec::clear);
    }

    /// Adds one.
    #[inline]
    pub fn push(&mut self, from: Vec3, u: Vec2) {
        for (list, v) in self.from.iter_mut().zip(from.to_array()) {
            list.push(v);
        }
        for (list, v) in self.u.iter_mut().zip(u.to_array()) {
            list.push(v);
        }
    }

    fn len(&self) -> usize {
        self.u[1].len()
    }
}

/// One direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuickDirection {
    /// Unit.
    pub wi: Vec3,
    /// A point of the rectangle, world space, metres.
    pub point: Vec3,
    /// Distance of that point, metres.
    pub distance: f32,
    /// Density of the direction per solid angle, 1/sr.
    pub pdf: f32,
}

impl Directions {
    /// True if the request came from behind the rectangle.
    #[inline]
    pub fn is_behind(&self, index: usize) -> bool {
        self.solid_angle[index] < 0.0
    }

    /// The direction of a request; `None` where it takes double precision or another way, or the rectangle is seen from
    /// behind.
    #[inline]
    pub fn get(&self, rectangle: &QuickRectangle, index: usize) -> Option<QuickDirection> {
        let solid_angle = self.solid_angle[index];
        let [x, y] = [0, 1].map(|axis| f64::from(self.shares[axis][index]));
        let [a, b] = rectangle.along;
        (solid_angle > 0.0).then(|| QuickDirection {
            wi: Vec3::from_array([0, 1, 2].map(|axis| self.wi[axis][index])),
            point: (rectangle.origin.as_dvec3() + a * x + b * y).as_vec3(),
            distance: self.distance[index],
            pdf: 1.0 / solid_angle,
        })
    }
}

/// One direction as the loop computes it.
struct Computed {
    wi: [f32; 3],
    distance: f32,
    /// Metres along the sides.
    along: [f32; 2],
    /// 0 where the rest is of no use, below 0 behind the rectangle.
    solid_angle: f32,
}

impl QuickRectangle {
    /// Unit vector along sides\[0\] × sides\[1\].
    pub fn normal(&self) -> Vec3 {
        self.axes[2]
    }

    /// The points `origin` + x·`sides[0]` + y·`sides[1]`, x and y in 0..1. `None` if the angle between the sides is not
    /// a right one, or they are too short or long.
    pub fn new(origin: Vec3, sides: [Vec3; 2]) -> Option<Self> {
        let [a, b] = sides.map(Vec3::as_dvec3);
        let (la, lb) = (a.length(), b.length());
        let right = a.dot(b).abs() <= 1e-6 * la * lb;
        let usual = |l: f64| l > 1e-12 && l < 1e12;
        let along = [a / la, b / lb];
        let axes = [along[0], along[1], a.cross(b).normalize_or_zero()].map(|v| v.as_vec3());
        let lengths = [la as f32, lb as f32];
        (right && usual(la) && usual(lb)).then_some(Self { origin, axes, lengths, along })
    }

    /// All directions. Inlined, to be compiled for the caller's instruction set; the loop has no branches.
    #[inline(always)]
    pub fn sample_all(&self, requests: &Requests, out: &mut Directions) {
        let n = requests.len();
        let all = out.wi.iter_mut().chain(&mut out.shares);
        all.chain([&mut out.distance, &mut out.solid_angle]).for_each(|list| list.resize(n, 0.0));
        let ([px, py, pz], [u, v]) = (&requests.from, &requests.u);
        let (px, py, pz, u, v) = (&px[..n], &py[..n], &pz[..n], &u[..n], &v[..n]);
        let ([wx, wy, wz], [sx, sy]) = (&mut out.wi, &mut out.shares);
        let (wx, wy, wz, sx, sy) = (&mut wx[..n], &mut wy[..n], &mut wz[..n], &mut sx[..n], &mut sy[..n]);
        let (distance, solid_angle) = (&mut out.distance[..n], &mut out.solid_angle[..n]);
        for i in 0..n {
            let c = self.direction([px[i], py[i], pz[i]], u[i], v[i]);
            [wx[i], wy[i], wz[i]] = c.wi;
            [sx[i], sy[i]] = c.along;
            distance[i] = c.distance;
            solid_angle[i] = c.solid_angle;
        }
    }

    /// The map of \[Urena2013\], in the form that [`super::SphericalQuad`] documents.
    #[inline(always)]
    fn direction(&self, from: [f32; 3], u: f32, v: f32) -> Computed {
        let [ax, ay, n] = self.axes;
        let d = [self.origin.x - from[0], self.origin.y - from[1], self.origin.z - from[2]];
        let along = |axis: Vec3| d[0] * axis.x + d[1] * axis.y + d[2] * axis.z;
        let z = -along(n);
        let x0 = along(ax);
        let y0 = along(ay);
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        let zz = z * z;
        let (by0, by1) = (y0 * y0 + zz, y1 * y1 + zz);
        let (i0, i1) = (1.0 / by0.sqrt(), 1.0 / by1.sqrt());
        // F(x, y₁) − F(x, y₀) as a point of the unit circle.
        let difference = |x: f32| {
            let xx = x * x;
            let (s1, c1) = (x * y1, z * (xx + by1).sqrt());
            let (s0, c0) = (x * y0, z * (xx + by0).sqrt());
            let unit = i0 * i1 / (xx + zz);
            ((s1 * c0 - c1 * s0) * unit, (c1 * c0 + s1 * s0) * unit)
        };
        let (start_sin, start_cos) = difference(x0);
        let (end_sin, end_cos) = difference(x1);
        let whole_sin = end_sin * start_cos - end_cos * start_sin;
        let whole_cos = end_cos * start_cos + end_sin * start_sin;
        let angle = quick::atan2(whole_sin, whole_cos);
        let angle = if angle < 0.0 { angle + TAU } else { angle };
        let (sin, cos) = quick::sin_cos(u * angle);
        let d_sin = start_sin * cos + start_cos * sin;
        let d_cos = start_cos * cos - start_sin * sin;
        let (b0, b1) = (y0 * i0, y1 * i1);
        let product = b0 * b1;
        // sin²D/s² with terms of one sign.
        let side = if product > 0.0 { 1.0f32 } else { -1.0 };
        let gap = b1 - side * b0;
        let toward = side * d_cos;
        let less_cosine = if toward > 0.0 { d_sin * d_sin / (1.0 + toward) } else { 1.0 - toward };
        let square = gap * gap + 2.0 * product * side * less_cosine;
        let root = (square - d_sin * d_sin).max(0.0).sqrt();
        let x = z * d_sin / root.max(1e-30);
        let x = if x > x0 { if x < x1 { x } else { x1 } } else { x0 };
        let across = x * x + zz;
        let (h0, h1) = (y0 / (y0 * y0 + across).sqrt(), y1 / (y1 * y1 + across).sqrt());
        let h = h0 + v * (h1 - h0);
        let y = h * (across / ((1.0 - h) * (1.0 + h)).max(1e-30)).sqrt();
        let y = if y > y0 { if y < y1 { y } else { y1 } } else { y0 };
        let distance = (across + y * y).sqrt();
        let inverse = 1.0 / distance;
        let world = |x_axis: f32, y_axis: f32, n: f32| (x_axis * x + y_axis * y - n * z) * inverse;
        let beside = x0.max(-x1).max(y0).max(-y1);
        let sound = beside < GRAZING * z && angle > LEAST && angle < TAU;
        Computed {
            wi: [world(ax.x, ay.x, n.x), world(ax.y, ay.y, n.y), world(ax.z, ay.z, n.z)],
            distance,
            along: [x - x0, y - y0],
            solid_angle: if z > 0.0 { if sound { angle } else { 0.0 } } else { -1.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DirectionSampler, SphericalQuad};
    use super::*;
    use penombre_math::hash::{combine, unit_f32};

    /// Random rectangles and points: the quick way takes the directions of the exact one.
    #[test]
    fn quick_directions_are_those_of_double_precision() {
        let (mut compared, mut out) = (0, Directions::default());
        for trial in 0..2000 {
            let number = |k| unit_f32(combine(trial, k)) * 2.0 - 1.0;
            let vector = |k| Vec3::new(number(k), number(k + 1), number(k + 2));
            let a = vector(0);
            let b = a.cross(vector(3)).normalize_or(Vec3::X) * number(6).abs();
            let origin = vector(7) * 2.0;
            let Some(rectangle) = QuickRectangle::new(origin, [a, b]) else { continue };
            let mut requests = Requests::default();
            let wanted: Vec<(Vec3, Vec2)> = (0..16)
                .map(|k| (vector(10 + 5 * k) * 2.0, Vec2::new(number(13 + 5 * k), number(14 + 5 * k)).abs()))
                .collect();
            wanted.iter().for_each(|(from, u)| requests.push(*from, *u));
            rectangle.sample_all(&requests, &mut out);
            for (index, (from, u)) in wanted.iter().enumerate() {
                let exact = SphericalQuad::new(*from, origin, [a, b]);
                let Some(quick) = out.get(&rectangle, index) else { continue };
                let exact = exact.unwrap();
                assert!(exact.is_in_front());
                let sample = exact.sample(*u);
                assert!((quick.pdf / sample.pdf - 1.0).abs() < 1e-4, "{trial}: {quick:?} {sample:?}");
                assert!(quick.wi.distance(sample.wi) < 1e-3, "{trial}: {quick:?} {sample:?}");
                assert!(quick.point.distance(sample.point) < 2e-3 * (1.0 + sample.distance));
                assert!((quick.wi.length() - 1.0).abs() < 1e-5);
                compared += 1;
            }
        }
        assert!(compared > 5000, "{compared}");
    }
}
