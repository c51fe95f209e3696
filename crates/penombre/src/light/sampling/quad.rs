//! Directions to parallelograms.

use super::flat::{ByArea, Flat};
use super::rectangle::Rectangle;
use super::triangle::TriangleMap;
use super::{DirectionSample, DirectionSampler, FAR, THIN, inside_unit_square, sample_at, uniform_density};
use penombre_math::{DVec2, Vec2, Vec3};

/// Sides count as at a right angle if the cosine between them is below this: what `f32` leaves of a turned
/// rectangle.
const RIGHT_ANGLE: f64 = 1e-6;

/// A parallelogram seen from a point: uniform in solid angle if it is near, else by area.
///
/// Rectangles use the map of \[Urena2013\]. Other parallelograms, and rectangles seen at a grazing angle, are two
/// spherical triangles \[Arvo1995\], \[Peters2021\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalQuad {
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
    Rectangle(Rectangle),
    Triangles([TriangleMap; 2]),
}

impl SphericalQuad {
    /// The points `origin` + x·`sides[0]` + y·`sides[1]`, x and y in 0..1, seen from `reference`; `None` if they
    /// have no area or their plane goes through that point.
    pub fn new(reference: Vec3, origin: Vec3, sides: [Vec3; 2]) -> Option<Self> {
        let flat = Flat::new(reference, origin, sides.map(|s| s.as_dvec3()))?;
        let [a, b] = flat.sides;
        let height = flat.height.abs();
        let skew = a.dot(b);
        let squares = [a.length_squared(), b.length_squared()];
        let middle_square = flat.at(DVec2::splat(0.5)).length_squared();
        // Of half of the longer diagonal.
        let radius_square = 0.25 * (squares[0] + squares[1] + 2.0 * skew.abs());
        let mut near = None;
        if radius_square >= middle_square * (FAR * FAR) {
            let right = skew * skew <= RIGHT_ANGLE * RIGHT_ANGLE * squares[0] * squares[1];
            let rectangle = if right { Rectangle::new(flat.corner, flat.sides, height) } else { None };
            let (way, solid_angle) = match rectangle {
                Some(map) => (Way::Rectangle(map), map.solid_angle),
                None => {
                    let maps = triangles(&flat);
                    (Way::Triangles(maps), maps[0].solid_angle + maps[1].solid_angle)
                }
            };
            near = (solid_angle >= THIN).then_some((way, solid_angle));
        }
        let (way, solid_angle) = match near {
            Some(near) => near,
            None => {
                let (by_area, solid_angle) = flat.by_area(flat.area, middle_square, radius_square)?;
                (Way::Area(by_area), solid_angle)
            }
        };
        Some(Self { flat, way, solid_angle, density: uniform_density(solid_angle)? })
    }

    /// True if the reference point is on the side of `sides[0]` × `sides[1]`.
    pub fn is_in_front(&self) -> bool {
        self.flat.height < 0.0
    }

    /// The solid angle, in (0, 2π) sr: as accurate as `f32` where samples are uniform in it, within a thousandth
    /// for what is far away, and only its size for near slivers below 10⁻⁹ sr.
    pub fn solid_angle(&self) -> f32 {
        self.solid_angle as f32
    }
}

/// The halves on either side of the diagonal from the corner.
fn triangles(flat: &Flat) -> [TriangleMap; 2] {
    let [first, right, far, up] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|shares| flat.at(shares));
    let volume = flat.height.abs() * flat.area;
    [[first, right, far], [first, up, far]].map(|corners| TriangleMap::new(corners, volume))
}

impl DirectionSampler for SphericalQuad {
    fn sample(&self, u: Vec2) -> DirectionSample {
        let u = inside_unit_square(u);
        let to = match &self.way {
            Way::Area(_) => self.flat.at(u),
            Way::Rectangle(map) => self.flat.at(map.shares(u)),
            Way::Triangles(maps) => {
                let share = maps[0].solid_angle / self.solid_angle;
                let (map, x) = if u.x < share {
                    (&maps[0], u.x / share)
                } else {
                    (&maps[1], (u.x - share) / (1.0 - share))
                };
                self.flat.meet_inside(map.direction(DVec2::new(x, u.y)))
            }
        };
        let sample = sample_at(self.flat.reference, to);
        DirectionSample { pdf: self.pdf_of_hit(sample.wi, sample.distance), ..sample }
    }

    fn pdf_of_hit(&self, _: Vec3, distance: f32) -> f32 {
        match &self.way {
            Way::Area(by_area) => by_area.pdf(distance),
            Way::Rectangle(_) | Way::Triangles(_) => self.density,
        }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let Some(to) = self.flat.meet(wi.as_dvec3()) else { return 0.0 };
        let shares = self.flat.shares(to);
        let hit = shares.min_element() >= 0.0 && shares.max_element() <= 1.0;
        if hit { self.pdf_of_hit(wi, to.length() as f32) } else { 0.0 }
    }
}
