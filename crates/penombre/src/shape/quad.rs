//! `quad`: a parallelogram.
//!
//! The points `origin` + u·`sides[0]` + v·`sides[1]` with u, v in 0..1, which are its surface coordinates. The
//! normal is that of sides\[0\] × sides\[1\].
//!
//! ```toml
//! [shape.left-wall]
//! type = "quad"
//! origin = [-2, -2, -2]
//! sides = [[0, 0, 4], [0, 4, 0]]
//! material = "red"
//! ```

use super::common::{MATERIAL, TRANSFORM, on_plane, place, rounded, too_far};
use super::{Detail, Shape, ShapePoint, Tessellation};
use crate::registry::Context;
use penombre_bvh::{Geometry, Hit, Ray};
use penombre_math::{Bounds3, DVec3, Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamSpec};

/// A parallelogram in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Quad {
    origin: Vec3,
    sides: [Vec3; 2],
    normal: Vec3,
    exact: Exact,
}

/// The same in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exact {
    origin: DVec3,
    sides: [DVec3; 2],
    normal: DVec3,
    /// The largest coordinate of the diagonal, without signs.
    extent: f64,
    /// No coordinate is larger.
    reach: f64,
}

impl Exact {
    fn new(origin: Vec3, sides: [Vec3; 2]) -> Self {
        let (origin, [a, b]) = (origin.as_dvec3(), sides.map(Vec3::as_dvec3));
        let extent = (a.abs() + b.abs()).max_element();
        let reach = origin.abs().max_element() + extent;
        Self { origin, sides: [a, b], normal: a.cross(b).normalize_or(DVec3::Z), extent, reach }
    }
}

impl Quad {
    /// The points `origin` + u·`sides[0]` + v·`sides[1]` with u, v in 0..1; the outside is that of sides\[0\] ×
    /// sides\[1\]. `None` if they have no area or leave the range of single precision.
    pub fn new(origin: Vec3, sides: [Vec3; 2]) -> Option<Self> {
        Self::with_normal(origin, sides.map(Vec3::as_dvec3))
    }

    fn with_normal(origin: Vec3, sides: [DVec3; 2]) -> Option<Self> {
        let normal = sides[0].cross(sides[1]).normalize_or_zero().as_vec3();
        let sides = sides.map(|s| s.as_vec3());
        let corners = [origin + sides[0], origin + sides[1], origin + sides[0] + sides[1]];
        let sound = normal.length_squared() > 0.0 && corners.iter().all(|c| c.is_finite());
        sound.then(|| Self { origin, sides, normal, exact: Exact::new(origin, sides) })
    }
}

impl Shape for Quad {
    const TYPE_NAME: &'static str = "quad";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("origin", Kind::Vec3, "One corner.").unit("m"),
        ParamSpec::required("sides", Kind::Sides, "The two edges that leave that corner.").unit("m"),
        MATERIAL,
        TRANSFORM,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let map = p.transform("transform");
        let origin = place(&map, p.vec3("origin"), p, context)?;
        let sides = p.sides("sides").map(|s| map.transform_vector3(s.as_dvec3()));
        let quad = Self::with_normal(origin, sides);
        if quad.is_none() {
            too_far(p, context);
        }
        quad
    }

    fn geometry(&self) -> Geometry {
        Geometry::Quads(vec![penombre_bvh::Quad { origin: self.origin, sides: self.sides }])
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint {
        let Exact { origin, sides: [a, b], normal, extent, reach } = self.exact;
        let own = origin + a * f64::from(hit.u) + b * f64::from(hit.v);
        let p = on_plane(ray, hit.t, origin, normal, extent, own);
        let (p, p_error) = rounded(p, reach);
        ShapePoint {
            p,
            p_error,
            ng: self.normal,
            ns: self.normal,
            rise: 0.0,
            bulge: [0.0; 2],
            uv: Vec2::new(hit.u, hit.v),
            color: Spectrum::WHITE,
            slot: 0,
        }
    }

    fn coordinates(&self, _: &Ray, hit: &Hit) -> (Vec2, u32) {
        (Vec2::new(hit.u, hit.v), 0)
    }

    fn tessellate(&self, _: &Detail) -> Tessellation {
        Tessellation::grid(1, 1, |uv| {
            (self.origin + self.sides[0] * uv.x + self.sides[1] * uv.y, self.normal)
        })
    }

    fn bounds(&self) -> Bounds3 {
        let [a, b] = self.sides;
        Bounds3::of_points([self.origin, self.origin + a, self.origin + b, self.origin + a + b])
    }
}
