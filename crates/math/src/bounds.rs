//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box. Empty if `min > max` on any axis; [`Bounds3::EMPTY`] is the neutral element of union.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds3 {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Default for Bounds3 {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds3 {
    /// The box of no points.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box of one point.
    pub fn of_point(p: Vec3) -> Self {
        Self { min: p, max: p }
    }

    /// The smallest box around the points; empty for none. NaN coordinates are passed over.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }

    /// This box grown to hold `p`. NaN coordinates are passed over.
    pub fn with_point(self, p: Vec3) -> Self {
        // The order matters: glam's comparison keeps the second operand if one is NaN.
        Self { min: p.min(self.min), max: p.max(self.max) }
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self { min: other.min.min(self.min), max: other.max.max(self.max) }
    }

    /// True if the box holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// True if both corners are finite.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Edge lengths; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The middle; zero for an empty box.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min * 0.5 + self.max * 0.5 }
    }

    /// Half the surface area, the measure of the surface area heuristic; zero for an empty box.
    pub fn half_area(&self) -> f32 {
        let d = self.size();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
            Vec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Bounds3 = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };

    #[test]
    fn empty_is_neutral_and_measures_nothing() {
        assert!(Bounds3::EMPTY.is_empty() && !Bounds3::EMPTY.is_finite());
        assert_eq!(Bounds3::EMPTY.union(UNIT), UNIT);
        assert_eq!(UNIT.union(Bounds3::EMPTY), UNIT);
        assert_eq!(Bounds3::of_points([]), Bounds3::default());
        assert_eq!((Bounds3::EMPTY.size(), Bounds3::EMPTY.center()), (Vec3::ZERO, Vec3::ZERO));
        assert_eq!(Bounds3::EMPTY.half_area(), 0.0);
        // Empty on one axis is empty.
        assert!(Bounds3 { min: Vec3::ZERO, max: Vec3::new(1.0, -1.0, 1.0) }.is_empty());
    }

    #[test]
    fn a_box_of_its_corners_is_itself() {
        let b = Bounds3 { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(4.0, 5.0, 7.0) };
        let corners = b.corners();
        assert_eq!(Bounds3::of_points(corners), b);
        for (i, c) in corners.iter().enumerate() {
            assert!(corners[..i].iter().all(|d| d != c), "corners differ");
        }
        assert_eq!((b.size(), b.center()), (Vec3::new(5.0, 3.0, 4.0), Vec3::new(1.5, 3.5, 5.0)));
        assert_eq!(b.half_area(), 15.0 + 12.0 + 20.0);
    }

    #[test]
    fn points_are_boxes() {
        let b = Bounds3::of_point(Vec3::splat(3.0));
        assert!(!b.is_empty() && b.is_finite());
        assert_eq!((b.size(), b.center()), (Vec3::ZERO, Vec3::splat(3.0)));
    }

    #[test]
    fn nan_coordinates_are_passed_over() {
        let odd = Vec3::new(f32::NAN, 2.0, -1.0);
        let expected = Bounds3 { min: Vec3::new(0.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
        assert_eq!(UNIT.with_point(odd), expected);
        assert_eq!(Bounds3::of_points([odd, Vec3::ZERO, Vec3::ONE]), expected);
    }

    #[test]
    fn the_middle_of_huge_boxes_is_finite() {
        let b = Bounds3 { min: Vec3::splat(-f32::MAX), max: Vec3::splat(f32::MAX) };
        assert_eq!(b.center(), Vec3::ZERO);
    }
}
