//! Directions to triangles.

use super::flat::{ByArea, Flat, Sides};
use super::{
    DirectionSample, DirectionSampler, FAR, THIN, inside_unit_square, sample_at, uniform_density, unit_circle,
};
use penombre_math::{DVec2, DVec3, Vec2, Vec3, float};

/// A triangle seen from a point: uniform in solid angle if it is near, else by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalTriangle {
    flat: Flat,
    way: Way,
    /// Steradians.
    solid_angle: f64,
    /// Its inverse.
    density: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Area(ByArea),
    Angle(TriangleMap),
}

impl SphericalTriangle {
    /// The triangle of three vertices seen from `reference`; `None` if it has no area or its plane goes through
    /// that point.
    pub fn new(reference: Vec3, vertices: [Vec3; 3]) -> Option<Self> {
        let [a, b, c] = vertices;
        // The differences are exact in double precision only.
        let sides = [b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3()];
        let flat = Sides::new(a, sides)?.seen_from(reference)?;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|shares| flat.at(shares));
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let middle_square = middle.length_squared();
        let radius_square = corners.iter().map(|c| (c - middle).length_squared()).fold(0.0, f64::max);
        let mut near = None;
        if radius_square >= middle_square * (FAR * FAR) {
            let map = TriangleMap::new(corners, flat.height.abs() * flat.area);
            near = (map.solid_angle >= THIN).then_some((Way::Angle(map), map.solid_angle));
        }
        let (way, solid_angle) = match near {
            Some(near) => near,
            None => {
                let (by_area, solid_angle) = flat.by_area(flat.area / 2.0, middle_square, radius_square)?;
                (Way::Area(by_area), solid_angle)
            }
        };
        Some(Self { flat, way, solid_angle, density: uniform_density(solid_angle)? })
    }

    /// True if the reference point is on the side from which the vertices run counter-clockwise.
    pub fn is_in_front(&self) -> bool {
        self.flat.height < 0.0
    }

    /// The solid angle, in (0, 2π) sr: as accurate as `f32` where samples are uniform in it, within a thousandth
    /// for what is far away, and only its size for near slivers below 10⁻⁹ sr.
    pub fn solid_angle(&self) -> f32 {
        self.solid_angle as f32
    }
}

impl DirectionSampler for SphericalTriangle {
    fn sample(&self, u: Vec2) -> DirectionSample {
        let u = inside_unit_square(u);
        let to = match &self.way {
            Way::Area(_) => self.flat.at(even_shares(u)),
            Way::Angle(map) => self.flat.meet_inside(map.direction(u)),
        };
        let sample = sample_at(self.flat.reference, to);
        DirectionSample { pdf: self.pdf_of_hit(sample.wi, sample.distance), ..sample }
    }

    fn pdf_of_hit(&self, _: Vec3, distance: f32) -> f32 {
        match &self.way {
            Way::Area(by_area) => by_area.pdf(distance),
            Way::Angle(_) => self.density,
        }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let Some(to) = self.flat.meet(wi.as_dvec3()) else { return 0.0 };
        let DVec2 { x, y } = self.flat.shares(to);
        let hit = x >= 0.0 && y >= 0.0 && x + y <= 1.0;
        if hit { self.pdf_of_hit(wi, to.length() as f32) } else { 0.0 }
    }
}

/// Shares of two sides of a triangle, uniform by area, by the low-distortion map of \[Heitz2019\].
fn even_shares(u: DVec2) -> DVec2 {
    let half = u.min_element() / 2.0;
    if u.x < u.y { DVec2::new(half, u.y - half) } else { DVec2::new(u.x - half, half) }
}

/// Area-preserving map from the unit square to a spherical triangle, after \[Arvo1995\]: `u.x` cuts off a part
/// of that share of the solid angle by an arc from B to a point of the arc AC, `u.y` chooses a point of the cut.
///
/// The cut is found as in \[Peters2021\], without angles: with the unit tangent T of the arc AC at A, the point at
/// angle φ is A·cos φ + T·sin φ, and the formula tan(Ω/2) = det(A, B, C)/(1 + A·B + B·C + C·A) of
/// \[VanOosterom1983\] for the part becomes linear in tan(φ/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleMap {
    a: DVec3,
    b: DVec3,
    /// Unit tangent at A towards C.
    t: DVec3,
    /// 1 + A·B
    one_plus_ab: f64,
    /// |det(A, B, T)|
    det_abt: f64,
    /// B·T
    bt: f64,
    /// Steradians.
    pub solid_angle: f64,
}

impl TriangleMap {
    /// From the vectors to the corners and their determinant (six times the volume of the tetrahedron), which
    /// is above 0.
    pub fn new(corners: [DVec3; 3], volume: f64) -> Self {
        let inverse = corners.map(|c| 1.0 / c.length());
        let [a, b, c] = [0, 1, 2].map(|i| corners[i] * inverse[i]);
        let det = volume * inverse[0] * inverse[1] * inverse[2];
        let ab = a + b;
        let one_plus_ab = 0.5 * ab.length_squared();
        // 1 + A·B + C·(A + B)
        let half = float::atan2(det as f32, (one_plus_ab + c.dot(ab)) as f32);
        // A × C with the length sin AC; the difference of the corners keeps it accurate for small triangles.
        let across = a.cross((corners[2] - corners[0]) * inverse[2]);
        let inverse_sine = 1.0 / across.length().max(f64::MIN_POSITIVE);
        let t = across.cross(a) * inverse_sine;
        let det_abt = det * inverse_sine;
        Self { a, b, t, one_plus_ab, det_abt, bt: b.dot(t), solid_angle: 2.0 * f64::from(half) }
    }

    /// A direction in the triangle, of length 1.
    pub fn direction(&self, u: DVec2) -> DVec3 {
        let (sin, cos) = unit_circle(0.5 * u.x * self.solid_angle);
        let (y, x) = (sin * self.one_plus_ab, cos * self.det_abt - sin * self.bt);
        // (x, y) has the angle φ/2; doubled it is that of (x² − y², 2xy).
        let square = x * x + y * y;
        let (cos, sin) =
            if square > 0.0 { ((x - y) * (x + y) / square, 2.0 * x * y / square) } else { (1.0, 0.0) };
        let cut = self.a * cos + self.t * sin;
        // The share u.y of 1 − cos from B to the cut.
        let full = 0.5 * (cut - self.b).length_squared();
        let less = u.y * full;
        let tangent = (cut - self.b * (1.0 - full)).normalize_or_zero();
        self.b * (1.0 - less) + tangent * (less * (2.0 - less)).max(0.0).sqrt()
    }
}
