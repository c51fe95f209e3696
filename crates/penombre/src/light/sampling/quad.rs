//! Directions to parallelograms.

use super::flat::{ByArea, Flat, Sides};
use super::rectangle::Rectangle;
use super::triangle::TriangleMap;
use super::{DirectionSample, DirectionSampler, FAR, THIN, inside_unit_square, sample_at, uniform_density};
use penombre_math::{DVec2, DVec3, Vec2, Vec3};

/// Sides count as at a right angle if the cosine between them is below this: what `f32` leaves of a turned
/// rectangle.
const RIGHT_ANGLE: f64 = 1e-6;

/// A parallelogram of a scene: what directions to it have in common from all points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    plane: Sides,
    /// Unit vectors along the sides, and the lengths of these.
    along: [DVec3; 2],
    lengths: [f64; 2],
    is_rectangle: bool,
    /// Square of half of the longer diagonal.
    radius_square: f64,
}

impl Parallelogram {
    /// Unit vector along `sides[0]` × `sides[1]`.
    pub fn normal(&self) -> Vec3 {
        self.plane.normal.as_vec3()
    }

    /// The points `origin` + x·`sides[0]` + y·`sides[1]`, x and y in 0..1; `None` if they have no area.
    pub fn new(origin: Vec3, sides: [Vec3; 2]) -> Option<Self> {
        let plane = Sides::new(origin, sides.map(Vec3::as_dvec3))?;
        let [a, b] = plane.sides;
        let skew = a.dot(b);
        let squares = plane.squares;
        Some(Self {
            plane,
            along: [a, b].map(DVec3::normalize_or_zero),
            lengths: squares.map(f64::sqrt),
            is_rectangle: skew * skew <= RIGHT_ANGLE * RIGHT_ANGLE * squares[0] * squares[1],
            radius_square: 0.25 * (squares[0] + squares[1] + 2.0 * skew.abs()),
        })
    }

    /// True if a point is on the side of `sides[0]` × `sides[1]`.
    #[inline(always)]
    pub fn faces(&self, reference: Vec3) -> bool {
        self.plane.height_of(reference.as_dvec3()) > 0.0
    }

    /// The shares of the sides at a point of it, in 0..=1.
    pub fn shares(&self, point: Vec3) -> [f32; 2] {
        let inside = point.as_dvec3() - self.plane.corner;
        let Sides { sides: [a, b], normal, area, .. } = self.plane;
        let share = |across: DVec3| (across.dot(normal) / area).clamp(0.0, 1.0) as f32;
        [share(inside.cross(b)), share(a.cross(inside))]
    }

    /// m²
    pub fn area(&self) -> f32 {
        self.plane.area as f32
    }

    /// Seen from a point; `None` if the plane goes through it.
    #[inline(always)]
    pub fn seen_from(&self, reference: Vec3) -> Option<SphericalQuad> {
        let flat = self.plane.seen_from(reference)?;
        let middle_square = flat.at(DVec2::splat(0.5)).length_squared();
        let mut near = None;
        if self.radius_square >= middle_square * (FAR * FAR) {
            let (way, solid_angle) = match self.rectangle(&flat) {
                Some(map) => (Way::Rectangle(map, self.along), map.solid_angle),
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
                let (by_area, solid_angle) = flat.by_area(flat.area, middle_square, self.radius_square)?;
                (Way::Area(by_area), solid_angle)
            }
        };
        Some(SphericalQuad { flat, way, solid_angle, density: uniform_density(solid_angle)? })
    }

    /// A direction from a point: [`SphericalQuad::sample`] in one go.
    #[inline(always)]
    pub fn sample_from(&self, reference: Vec3, u: Vec2) -> Option<DirectionSample> {
        Some(self.seen_from(reference)?.sample(u))
    }

    /// Density of a direction from a point that meets the parallelogram at `distance` metres, 1/sr; 0 if the plane goes
    /// through that point.
    #[inline]
    pub fn pdf_from(&self, reference: Vec3, distance: f32) -> f32 {
        self.seen_from(reference).map_or(0.0, |seen| seen.pdf_of_hit(Vec3::ZERO, distance))
    }

    #[inline(always)]
    fn rectangle(&self, flat: &Flat) -> Option<Rectangle> {
        let corner =
            DVec3::new(flat.corner.dot(self.along[0]), flat.corner.dot(self.along[1]), flat.height.abs());
        if self.is_rectangle { Rectangle::new(corner, self.lengths) } else { None }
    }
}

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
    /// The map, and the axes of its frame.
    Rectangle(Rectangle, [DVec3; 2]),
    Triangles([TriangleMap; 2]),
}

impl SphericalQuad {
    /// The points `origin` + x·`sides[0]` + y·`sides[1]`, x and y in 0..1, seen from `reference`; `None` if they
    /// have no area or their plane goes through that point. For many points of view see [`Parallelogram`].
    pub fn new(reference: Vec3, origin: Vec3, sides: [Vec3; 2]) -> Option<Self> {
        Parallelogram::new(origin, sides)?.seen_from(reference)
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
    #[inline(always)]
    fn sample(&self, u: Vec2) -> DirectionSample {
        let u = inside_unit_square(u);
        let to = match &self.way {
            Way::Area(_) => self.flat.at(u),
            Way::Rectangle(map, along) => {
                let DVec2 { x, y } = map.point(u);
                along[0] * x + along[1] * y + self.flat.normal * self.flat.height
            }
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

    #[inline(always)]
    fn pdf_of_hit(&self, _: Vec3, distance: f32) -> f32 {
        match &self.way {
            Way::Area(by_area) => by_area.pdf(distance),
            Way::Rectangle(..) | Way::Triangles(_) => self.density,
        }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let Some(to) = self.flat.meet(wi.as_dvec3()) else { return 0.0 };
        let shares = self.flat.shares(to);
        let hit = shares.min_element() >= 0.0 && shares.max_element() <= 1.0;
        if hit { self.pdf_of_hit(wi, to.length() as f32) } else { 0.0 }
    }
}
