//! The course's virtual trackball: a mouse drag becomes a rotation.
//!
//! A point of the window is lifted onto a surface over it: a sphere of radius 0.8 around the window's middle,
//! continued outside by a hyperbolic sheet; the ball is that of \[Chen1988\], the sheet is Gavin Bell's. A drag from one lifted point to the other turns about
//! the axis that is perpendicular to both. All in `f32`, as the course's program computes.
//!
//! The sign convention is the classic one and easy to get wrong. The axis is p₂ × p₁ (*not* p₁ × p₂), and the
//! quaternion's matrix is handed to the graphics library row by row where columns are expected, which
//! transposes it. Together the scene turns about p₁ × p₂: its front follows the mouse. [`Turn`] keeps the
//! program's quaternion; [`Turn::rotation`] gives the matrix as it acts on the scene.

use penombre_math::{DMat3, Vec2, Vec3, float};

/// Radius of the ball in window coordinates.
const RADIUS: f32 = 0.8;
/// 1/√2: the part of the radius where the sphere goes over into the sheet, at equal heights and slopes.
const JOINT: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Rotations that are composed before the quaternion gets unit length again.
const RENORMALISE_AFTER: u32 = 97;

/// A composed rotation, kept as the course's program keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Axis times the sine of half the angle.
    vector: Vec3,
    /// Cosine of half the angle.
    scalar: f32,
    /// Drags since the length was last made 1.
    added: u32,
}

impl Default for Turn {
    fn default() -> Self {
        Self { vector: Vec3::ZERO, scalar: 1.0, added: 0 }
    }
}

impl Turn {
    /// The rotation of one drag between points of the window, both in \[−1, 1\]², x to the right and y up. Points
    /// outside (the mouse has left the window) are fine; no movement is no rotation.
    pub fn of_drag(from: Vec2, to: Vec2) -> Self {
        let (p1, p2) = (from.extend(height(from)), to.extend(height(to)));
        let axis = p2.cross(p1);
        let length = axis.length();
        if from == to || !(length > 0.0 && length.is_finite()) {
            return Self::default();
        }
        // Half the angle is the arc sine of half the chord over the radius.
        let half = float::asin(((p1 - p2).length() / (2.0 * RADIUS)).clamp(-1.0, 1.0));
        let (sine, cosine) = float::sin_cos(half);
        Self { vector: axis * (sine / length), scalar: cosine, added: 0 }
    }

    /// This rotation followed by that of a drag.
    #[must_use]
    pub fn then(self, drag: Self) -> Self {
        // The transposed matrices multiply in the reverse order, so here the old rotation stands first.
        let vector = self.vector * drag.scalar + drag.vector * self.scalar + self.vector.cross(drag.vector);
        let scalar = self.scalar * drag.scalar - self.vector.dot(drag.vector);
        let next = Self { vector, scalar, added: self.added + 1 };
        if next.added > RENORMALISE_AFTER { next.normalised() } else { next }
    }

    fn normalised(self) -> Self {
        let length = (self.vector.length_squared() + self.scalar * self.scalar).sqrt();
        Self { vector: self.vector / length, scalar: self.scalar / length, added: 0 }
    }

    /// The quaternion (x, y, z, w) as the course's program stores it; about the axis p₂ × p₁.
    pub fn quaternion(self) -> [f32; 4] {
        [self.vector.x, self.vector.y, self.vector.z, self.scalar]
    }

    /// The rotation as it acts on the scene, world to eye: the transpose of the quaternion's own matrix.
    pub fn rotation(self) -> DMat3 {
        let [x, y, z, w] = self.quaternion().map(f64::from);
        // Not quite of unit length between normalisations: divided out, so that the result is a rotation.
        let s = 2.0 / (x * x + y * y + z * z + w * w);
        DMat3::from_cols_array(&[
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (z * x + y * w),
            s * (x * y + z * w),
            1.0 - s * (z * z + x * x),
            s * (y * z - x * w),
            s * (z * x - y * w),
            s * (y * z + x * w),
            1.0 - s * (y * y + x * x),
        ])
    }
}

/// Height of the ball, or of the sheet around it, over a point of the window.
fn height(at: Vec2) -> f32 {
    let d = at.length();
    if d < RADIUS * JOINT {
        (RADIUS * RADIUS - d * d).sqrt()
    } else {
        let t = RADIUS * JOINT;
        t * t / d
    }
}

/// A point in pixels (x to the right, y down, from the upper left corner) in window coordinates.
pub fn window_point(pixel: Vec2, window: Vec2) -> Vec2 {
    let window = window.max(Vec2::ONE);
    Vec2::new((2.0 * pixel.x - window.x) / window.x, (window.y - 2.0 * pixel.y) / window.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_math::DVec3;

    #[test]
    fn the_surface_is_a_sphere_inside_and_a_sheet_outside() {
        assert_eq!(height(Vec2::ZERO), 0.8);
        // Inside: points have the ball's radius. Outside: z = 0.32 / d.
        for d in [0.1f32, 0.3, 0.5, 0.56] {
            let p = Vec2::new(d * 0.6, d * 0.8);
            assert!((p.extend(height(p)).length() - 0.8).abs() < 1e-6);
        }
        for d in [0.57f32, 0.8, 1.0, 1.4] {
            assert!((height(Vec2::new(0.0, d)) - 0.32 / d).abs() < 1e-6);
        }
        // They meet without a step.
        let edge = 0.8 * std::f32::consts::FRAC_1_SQRT_2;
        assert!((height(Vec2::new(edge - 1e-5, 0.0)) - height(Vec2::new(edge + 1e-5, 0.0))).abs() < 1e-4);
    }

    #[test]
    fn dragging_right_turns_the_front_to_the_right_and_up_turns_it_up() {
        let front = DVec3::Z;
        let right = Turn::of_drag(Vec2::ZERO, Vec2::new(0.2, 0.0)).rotation() * front;
        assert!(right.x > 0.2 && right.y.abs() < 1e-7, "{right}");
        let up = Turn::of_drag(Vec2::ZERO, Vec2::new(0.0, 0.2)).rotation() * front;
        assert!(up.y > 0.2 && up.x.abs() < 1e-7, "{up}");
        // And the angle is 2·asin(chord / 1.6), which inside the ball is the angle between the two points.
        assert!((right.x - 0.2 / 0.8).abs() < 1e-6);
        // The stored quaternion is about p2 × p1, here −y.
        assert!(Turn::of_drag(Vec2::ZERO, Vec2::new(0.2, 0.0)).quaternion()[1] < 0.0);
    }

    /// The angle of any drag, outside the ball too, from the formula in double precision.
    #[test]
    fn angles_are_those_of_the_formula() {
        let lift = |x: f64, y: f64| {
            let d = (x * x + y * y).sqrt();
            DVec3::new(x, y, if d < 0.8 / 2f64.sqrt() { (0.64 - d * d).sqrt() } else { 0.32 / d })
        };
        for (a, b) in [([0.1, 0.2], [0.3, -0.1]), ([0.7, 0.7], [-0.2, 0.9]), ([-0.9, 0.0], [0.9, 0.0])] {
            let chord = (lift(a[0], a[1]) - lift(b[0], b[1])).length();
            let angle = 2.0 * (chord / 1.6).clamp(-1.0, 1.0).asin();
            let turn = Turn::of_drag(Vec2::from(a.map(|v| v as f32)), Vec2::from(b.map(|v| v as f32)));
            let trace = turn.rotation().to_cols_array();
            let found = ((trace[0] + trace[4] + trace[8] - 1.0) / 2.0).clamp(-1.0, 1.0).acos();
            assert!((found - angle).abs() < 2e-3 * angle.max(0.1), "{found} {angle}");
        }
        // The chord between far opposite points is longer than the diameter: clamped to half a turn.
        let wide = Turn::of_drag(Vec2::new(-1.0, 0.0), Vec2::new(1.0, 0.0));
        assert!(wide.quaternion()[3].abs() < 1e-6);
    }

    #[test]
    fn no_movement_and_odd_points_turn_nothing() {
        let p = Vec2::new(0.3, 0.4);
        assert_eq!(Turn::of_drag(p, p), Turn::default());
        assert_eq!(Turn::of_drag(Vec2::splat(f32::NAN), p), Turn::default());
        assert_eq!(Turn::of_drag(Vec2::splat(f32::INFINITY), p), Turn::default());
    }

    #[test]
    fn drags_compose_in_eye_space() {
        let (a, b) = (
            Turn::of_drag(Vec2::new(0.1, -0.2), Vec2::new(0.4, 0.3)),
            Turn::of_drag(Vec2::new(-0.5, 0.2), Vec2::new(0.1, 0.6)),
        );
        let expected = b.rotation() * a.rotation();
        let found = a.then(b).rotation();
        assert!((expected - found).to_cols_array().iter().all(|v| v.abs() < 1e-6));
    }

    #[test]
    fn length_is_made_one_after_97_additions() {
        let drag = Turn::of_drag(Vec2::ZERO, Vec2::new(0.31, 0.17));
        // A quaternion that is 1 % too long shows when it is corrected.
        let mut turn = Turn { scalar: 1.01, ..Turn::default() };
        let norm = |t: Turn| t.quaternion().map(|v| v * v).iter().sum::<f32>().sqrt();
        for _ in 0..97 {
            turn = turn.then(drag);
            assert!((norm(turn) - 1.01).abs() < 1e-4);
        }
        turn = turn.then(drag);
        assert!((norm(turn) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn pixels_become_window_points() {
        let window = Vec2::new(480.0, 240.0);
        assert_eq!(window_point(Vec2::ZERO, window), Vec2::new(-1.0, 1.0));
        assert_eq!(window_point(Vec2::new(480.0, 240.0), window), Vec2::new(1.0, -1.0));
        assert_eq!(window_point(Vec2::new(240.0, 120.0), window), Vec2::ZERO);
        assert!(window_point(Vec2::ONE, Vec2::ZERO).is_finite());
    }
}
