//! What quads and triangles share: a plane with two sides, seen from a point.

use penombre_math::{DVec2, DVec3, Vec3};

/// A corner and two sides: what does not depend on the reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    pub corner: DVec3,
    pub sides: [DVec3; 2],
    /// Unit, along sides\[0\] × sides\[1\].
    pub normal: DVec3,
    /// Area of the parallelogram of the sides, m².
    pub area: f64,
    /// Their lengths, squared.
    pub squares: [f64; 2],
}

impl Sides {
    /// `None` if the sides are parallel or too short or long for `f32`.
    pub fn new(corner: Vec3, sides: [DVec3; 2]) -> Option<Self> {
        let across = sides[0].cross(sides[1]);
        let area = across.length();
        let normal = across * (1.0 / area);
        let squares = sides.map(DVec3::length_squared);
        let sound = area > 0.0 && normal.is_finite() && (squares[0] + squares[1]) < f64::INFINITY;
        sound.then_some(Self { corner: corner.as_dvec3(), sides, normal, area, squares })
    }

    /// Distance of a point from the plane: above 0 on the side of the normal.
    pub fn height_of(&self, reference: DVec3) -> f64 {
        (reference - self.corner).dot(self.normal)
    }

    /// Seen from a point; `None` if the plane goes through it but for rounding, or something is too near or far for `f32`.
    #[inline]
    pub fn seen_from(&self, reference: Vec3) -> Option<Flat> {
        let Self { sides, normal, area, squares, .. } = *self;
        let reference = reference.as_dvec3();
        let corner = self.corner - reference;
        let height = corner.dot(normal);
        // The square of a sum of three lengths is at most three times the sum of their squares.
        let limit_square = 4.0 * (corner.length_squared() + squares[0] + squares[1]);
        // False for NaN, too.
        let sound = height.abs() > slack(reference, self.corner, normal)
            && (LEAST_SQUARE..=MOST_SQUARE).contains(&limit_square);
        sound.then_some(Flat { reference, corner, sides, normal, area, height, limit_square })
    }
}

/// How far a point in a plane through `corner` may seem to lie off it by a few roundings of both to `f32`. On which side, it is
/// by chance: from there a surface does not see itself.
#[inline]
pub fn slack(point: DVec3, corner: DVec3, normal: DVec3) -> f64 {
    (point.abs() + corner.abs()).dot(normal.abs()) * ROUNDINGS
}

/// Of two roundings each.
pub const ROUNDINGS: f64 = 1.0 / (1 << 22) as f64;

/// Squares of the least and the largest normal number of single precision.
const LEAST_SQUARE: f64 = f32::MIN_POSITIVE as f64 * f32::MIN_POSITIVE as f64;
const MOST_SQUARE: f64 = f32::MAX as f64 * f32::MAX as f64;

/// The plane of a corner and two sides, relative to the reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    pub reference: DVec3,
    /// From the reference point to the corner.
    pub corner: DVec3,
    pub sides: [DVec3; 2],
    /// Unit, along sides\[0\] × sides\[1\].
    pub normal: DVec3,
    /// Area of the parallelogram of the sides, m².
    pub area: f64,
    /// `corner` · `normal`: below 0 if the reference point is on the side of the normal.
    pub height: f64,
    /// Above the square of the distance of any point of the parallelogram.
    limit_square: f64,
}

impl Flat {
    /// From the reference point to the point at the shares of the two sides.
    pub fn at(&self, shares: DVec2) -> DVec3 {
        self.corner + self.sides[0] * shares.x + self.sides[1] * shares.y
    }

    /// Where a direction of any length meets the plane, from the reference point; `None` if it leads away.
    pub fn meet(&self, direction: DVec3) -> Option<DVec3> {
        let t = self.height / direction.dot(self.normal);
        (t > 0.0 && t < f64::INFINITY).then(|| direction * t)
    }

    /// Where a direction into the shape meets the plane. One that rounding made parallel to the plane, which is
    /// seen edge-on then, gives the corner.
    pub fn meet_inside(&self, direction: DVec3) -> DVec3 {
        let met = self.meet(direction).filter(|to| to.length_squared() <= self.limit_square);
        met.unwrap_or(self.corner)
    }

    /// The shares of the two sides at a point of the plane.
    pub fn shares(&self, to: DVec3) -> DVec2 {
        let inside = to - self.corner;
        let [a, b] = self.sides;
        let scale = 1.0 / self.area;
        DVec2::new(inside.cross(b).dot(self.normal) * scale, a.cross(inside).dot(self.normal) * scale)
    }

    /// Sampling by area of a shape of this plane with that area, the square of the distance to its middle and
    /// that of its radius; and an estimate of its solid angle, good if it is far away. `None` if the density
    /// between the nearest and the farthest point is no `f32`.
    pub fn by_area(&self, area: f64, middle_square: f64, radius_square: f64) -> Option<(ByArea, f64)> {
        let (distance, radius) = (middle_square.sqrt(), radius_square.sqrt());
        let height = self.height.abs();
        let by_area = ByArea { scale: 1.0 / (height * area) };
        let sound = |distance: f64| {
            let pdf = by_area.pdf(distance as f32);
            pdf > 0.0 && pdf.is_finite()
        };
        let solid_angle = height * area / (distance * middle_square);
        (sound((distance - radius).max(height)) && sound(distance + radius)).then_some((by_area, solid_angle))
    }
}

/// The density per solid angle of points that are uniform by area: distance² / (|cos θ|·area), where
/// |cos θ| is height / distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByArea {
    /// 1/(height·area)
    scale: f64,
}

impl ByArea {
    pub fn pdf(&self, distance: f32) -> f32 {
        let distance = f64::from(distance);
        (distance * distance * distance * self.scale) as f32
    }
}
