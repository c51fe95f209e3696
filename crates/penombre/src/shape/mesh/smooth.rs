//! The smooth surface that vertex normals tell of.
//!
//! Flat triangles lie beneath the surface they stand for: what is seen on them lies elsewhere, their normals belong to
//! neighbouring places, and near the terminator and the outline, where small turns count, it shows. The height of the
//! surface over a point of a triangle is half the mean distance of the planes at the corners, the height of planes over
//! a sphere being twice that of the sphere \[Hanika2021\]; from there a ray is followed to the surface as if it were a
//! parabola, with the curvature of the normals along the ray. For triangles on a sphere the result is exact to third
//! order.

use super::super::ShapePoint;
use super::mix;
use penombre_math::Vec3;
use penombre_math::rounding::gamma;

/// Corner normals that turn from the triangle's less than this (cosine: 25°) tell of a smooth surface.
const SMOOTH: f32 = 0.906_307_8;
/// Those that turn by more than this (cosine: 40°) are for looks, as on a box with round shading: there is no such surface.
const SHARP: f32 = 0.766_044_4;

/// A triangle with its normals.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub corners: [Vec3; 3],
    pub normals: [Vec3; 3],
    /// Unit normal of the triangle.
    pub face: Vec3,
}

impl Patch {
    /// Moves what a ray met at `weights` of the corners to the smooth surface: its point if that is on the side where
    /// the ray comes from, and its normal. Says how far planes at the corners lie beyond it.
    pub fn smooth(&self, dir: Vec3, weights: [f32; 3], at: &mut ShapePoint) {
        at.bulge = self.bulge(weights, at.p);
        let height = 0.5 * self.share() * (at.bulge[0] - at.bulge[1]);
        if height == 0.0 {
            return;
        }
        // Toward where the surface lies, along the ray's line.
        let normal = at.ns * height.signum();
        let face = if self.face.dot(normal) < 0.0 { -self.face } else { self.face };
        let from = -dir.normalize();
        let is_seen = from.dot(face) > 0.0;
        let along = if is_seen { from } else { -from };
        let Some((reach, slope)) = self.reach(along, (normal, face), height.abs()) else { return };
        let turned = mix(self.normals, add(weights, slope.map(|d| d * reach))).normalize_or(at.ns);
        if is_seen {
            at.rise = reach;
            at.p += along * reach;
            at.p_error += (at.p.abs() + Vec3::splat(reach)) * gamma(3);
            let here = usize::from(height < 0.0);
            at.bulge[here] = (at.bulge[here] - height.abs()).max(0.0);
        }
        at.ns = turned;
    }

    /// How far the smooth surface lies beyond a point of the triangle, on the normals' side and on the other: the mean of
    /// the distances below, or above, the planes at the corners.
    fn bulge(&self, weights: [f32; 3], p: Vec3) -> [f32; 2] {
        let mut both = [0.0; 2];
        for ((corner, normal), weight) in self.corners.into_iter().zip(self.normals).zip(weights) {
            let below = (corner - p).dot(normal) * weight;
            both[usize::from(below < 0.0)] += below.abs();
        }
        both
    }

    /// How much the normals tell of a smooth surface, in [0, 1].
    fn share(&self) -> f32 {
        let least = self.normals.map(|n| n.dot(self.face).abs()).into_iter().fold(1.0, f32::min);
        ((least - SHARP) / (SMOOTH - SHARP)).clamp(0.0, 1.0)
    }

    /// Distance along a line to the surface, and how the weights of the corners change by distance. `None` if the line does
    /// not meet it near the triangle.
    fn reach(&self, along: Vec3, (normal, face): (Vec3, Vec3), height: f32) -> Option<(f32, [f32; 3])> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        // The line's shadow on the triangle, cast along the normal.
        let shadow = along - normal * (along.dot(face) / normal.dot(face));
        let (d00, d01, d11) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
        let (d20, d21) = (shadow.dot(ab), shadow.dot(ac));
        let inverse = 1.0 / (d00 * d11 - d01 * d01);
        let (v, w) = ((d11 * d20 - d01 * d21) * inverse, (d00 * d21 - d01 * d20) * inverse);
        let slope = [-v - w, v, w];
        let bend = mix(self.normals, slope).dot(shadow) * normal.dot(self.normals[0]).signum();
        // The line climbs by cos and the surface falls by half the square times the curvature.
        let cos = along.dot(normal);
        let reach = 2.0 * height / (cos + (cos * cos + 2.0 * bend * height).max(0.0).sqrt());
        let shift = slope.map(|d| (d * reach).abs()).into_iter().fold(0.0, f32::max);
        (reach > 0.0 && shift <= 1.0).then_some((reach, slope))
    }
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
