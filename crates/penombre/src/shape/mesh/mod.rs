//! `mesh`: triangles from a file or given in place.
//!
//! A mesh without a `material` takes the materials of its file. Vertex normals of a file without them are the
//! normalised sum of the unit normals of the faces around a vertex, as far as they differ by less than
//! `crease_angle` from the face in question.
//!
//! ```toml
//! [shape.bunny]
//! type = "mesh"
//! file = "bunny.obj"
//! material = "floor"
//! transform = [{ scale = 10 }, { rotate = [0, 1, 0], angle = 30 }, { translate = [0, -2, 0] }]
//! ```

mod inline;
mod normals;
mod smooth;

use super::common::{MATERIAL, TRANSFORM, on_plane, rounded, too_far};
use super::tessellation::Corners;
use super::{Detail, Shape, ShapePoint, Tessellation};
use crate::registry::Context;
use penombre_bvh::{Geometry, Hit, Ray, Triangles};
use penombre_math::rounding::gamma;
use penombre_math::{Bounds3, DAffine3, DVec3, Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range, TriangleMesh};
use smooth::Patch;
use std::sync::Arc;

/// No attribute at this corner.
const NONE: u32 = u32::MAX;

/// Triangles in world space with their attributes.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Arc<[Vec3]>,
    indices: Arc<[[u32; 3]]>,
    normals: Indexed<Vec3>,
    uvs: Indexed<Vec2>,
    colors: Vec<[f32; 3]>,
    face_colors: Vec<[f32; 3]>,
    slots: Vec<u32>,
}

/// Attribute values and, where they are not indexed as the positions are, their own indices.
#[derive(Clone, Debug, Default)]
struct Indexed<T> {
    values: Vec<T>,
    indices: Vec<[u32; 3]>,
}

impl<T: Copy> Indexed<T> {
    /// The values at the corners of a triangle, if all three have one.
    fn corners(&self, triangle: usize, positions: &[[u32; 3]]) -> Option<[T; 3]> {
        if self.values.is_empty() {
            return None;
        }
        let own = if self.indices.is_empty() { positions } else { &self.indices };
        let at = own.get(triangle)?;
        if at.contains(&NONE) {
            return None;
        }
        Some(at.map(|i| self.values[i as usize]))
    }
}

impl Shape for Mesh {
    const TYPE_NAME: &'static str = "mesh";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::optional("file", Kind::File, "A mesh file (OBJ, OFF, PLY, STL); instead of `positions` and `faces`."),
        ParamSpec::optional("positions", Kind::Vec3List, "Vertices of a mesh given in place.").unit("m"),
        ParamSpec::optional("faces", Kind::Faces, "Its triangles or convex polygons: vertex indices from 0."),
        ParamSpec::optional("normals", Kind::Vec3List, "A normal for each vertex."),
        ParamSpec::optional("uvs", Kind::Vec2List, "Texture coordinates for each vertex."),
        ParamSpec::optional("colors", Kind::ColorList, "A colour for each vertex."),
        ParamSpec::with_default(
            "crease_angle",
            Kind::Float(Range::closed(0.0, 180.0)),
            ParamDefault::Float(180.0),
            "Where a mesh has no normals: faces that meet at more than this angle keep a sharp edge. 0: all edges.",
        )
        .unit("degrees"),
        MATERIAL,
        TRANSFORM,
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        let inline;
        let source = match (p.is_given("file"), p.is_given("positions") || p.is_given("faces")) {
            // A file that could not be read was reported when the assets were loaded.
            (true, false) => &*context.assets.mesh(context.node)?.mesh.clone(),
            (false, true) => {
                inline = inline::read(p, context)?;
                &inline
            }
            (both, _) => {
                let path = context.description.node(context.node).path();
                let found = if both { "both `file` and" } else { "neither `file` nor" };
                let message = format!("`{path}` has {found} `positions`, expected one of them");
                context.out.error("scene::mesh-source", p.span("file"), message).help =
                    "give `file = \"mesh.obj\"`, or `positions` and `faces`".to_owned();
                return None;
            }
        };
        Self::place(source, &p.transform("transform"), p.f32("crease_angle")).or_else(|| {
            too_far(p, context);
            None
        })
    }

    fn geometry(&self) -> Geometry {
        Geometry::Triangles(Triangles { positions: self.positions.clone(), indices: self.indices.clone() })
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> ShapePoint {
        let triangle = hit.prim as usize;
        let corners = self.indices[triangle].map(|i| self.positions[i as usize]);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let face_normal = normal.as_vec3();
        let own = mix([a, b, c], weights.map(f64::from));
        let extent = (b - a).abs().max((c - a).abs()).max_element();
        let p = on_plane(ray, hit.t, a, normal, extent, own);
        let (p, rounding) = rounded(p, a.abs().max_element() + extent);
        let normals = self.normals.corners(triangle, &self.indices);
        let ns = normals.map_or(Vec3::ZERO, |n| mix(n, weights).normalize_or_zero());
        let ns = if ns == Vec3::ZERO { face_normal } else { ns };
        let ng = if ns.dot(face_normal) < 0.0 { -face_normal } else { face_normal };
        let (uv, slot) = self.coordinates(ray, hit);
        ShapePoint {
            p,
            p_error: rounding + Vec3::splat(test_error(corners, p)),
            ng,
            ns,
            rise: 0.0,
            bulge: [0.0; 2],
            uv,
            color: self.color(triangle, weights),
            slot,
        }
    }

    fn smooth(&self, ray: &Ray, hit: &Hit, at: &mut ShapePoint) {
        let triangle = hit.prim as usize;
        let Some(normals) = self.normals.corners(triangle, &self.indices) else { return };
        let corners = self.indices[triangle].map(|i| self.positions[i as usize]);
        let [a, b, c] = corners;
        let face = (b - a).cross(c - a).normalize_or_zero();
        Patch { corners, normals, face }.smooth(ray.dir, [1.0 - hit.u - hit.v, hit.u, hit.v], at);
    }

    fn coordinates(&self, _: &Ray, hit: &Hit) -> (Vec2, u32) {
        let triangle = hit.prim as usize;
        let uv = match self.uvs.corners(triangle, &self.indices) {
            Some(uv) => mix(uv, [1.0 - hit.u - hit.v, hit.u, hit.v]),
            None => Vec2::new(hit.u + hit.v, hit.v),
        };
        (uv, self.slots.get(triangle).copied().unwrap_or(0))
    }

    fn tessellate(&self, detail: &Detail) -> Tessellation {
        let step = self.indices.len().div_ceil(detail.most.max(1)).max(1);
        let mut corners = Corners::new(self.positions.len());
        for triangle in (0..self.indices.len()).step_by(step) {
            let corner =
                |u, v| Hit { t: 0.0, u, v, geometry: 0, prim: triangle as u32, instance: Hit::NO_INSTANCE };
            let ray = Ray::new(Vec3::ZERO, Vec3::Z, 0.0, 0.0);
            let points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(u, v)| self.point(&ray, &corner(u, v)));
            let indices = self.indices[triangle];
            let vertex =
                |i: usize| corners.vertex(indices[i], self.positions[indices[i] as usize], &points[i]);
            let vertices = [0, 1, 2].map(vertex);
            corners.result.triangles.push(vertices);
            corners.result.slots.extend(self.slots.get(triangle));
        }
        let left_out = self.indices.len() - corners.result.triangles.len();
        Tessellation { left_out, ..corners.result }
    }

    fn bounds(&self) -> Bounds3 {
        let corners = self.indices.iter().flatten().map(|i| self.positions[*i as usize]);
        Bounds3::of_points(corners.filter(|p| p.is_finite()))
    }

    fn primitives(&self) -> usize {
        self.indices.len()
    }
}

impl Mesh {
    /// The mesh moved by `map`; `None` if a finite vertex leaves the range of single precision.
    fn place(source: &TriangleMesh, map: &DAffine3, crease_angle: f32) -> Option<Self> {
        let identity = *map == DAffine3::IDENTITY;
        let mirrored = map.matrix3.determinant() < 0.0;
        let moved = |p: &Vec3| if identity { *p } else { map.transform_point3(p.as_dvec3()).as_vec3() };
        let positions: Arc<[Vec3]> = source.positions.iter().map(moved).collect();
        let lost = |(before, after): (&Vec3, &Vec3)| before.is_finite() && !after.is_finite();
        if source.positions.iter().zip(positions.iter()).any(lost) {
            return None;
        }
        // A mirrored mesh is turned inside out: two corners of each triangle change places.
        let wind = |[a, b, c]: &[u32; 3]| if mirrored { [*a, *c, *b] } else { [*a, *b, *c] };
        let wound = |list: &[[u32; 3]]| list.iter().map(wind).collect::<Vec<_>>();
        let indices: Arc<[[u32; 3]]> = source.indices.iter().map(wind).collect();
        let normals = if source.normals.is_empty() {
            normals::smooth(&positions, &indices, crease_angle)
        } else {
            let turn = map.matrix3.inverse().transpose();
            let turned =
                |n: &Vec3| if identity { *n } else { (turn * n.as_dvec3()).normalize_or_zero().as_vec3() };
            Indexed {
                values: source.normals.iter().map(turned).collect(),
                indices: wound(&source.normal_indices),
            }
        };
        Some(Self {
            positions,
            indices,
            normals,
            uvs: Indexed { values: source.uvs.clone(), indices: wound(&source.uv_indices) },
            colors: source.colors.clone(),
            face_colors: source.face_colors.clone(),
            slots: source.slots.clone(),
        })
    }

    fn color(&self, triangle: usize, weights: [f32; 3]) -> Spectrum {
        let mut color = Spectrum::WHITE;
        if !self.colors.is_empty() {
            let corners = self.indices[triangle].map(|i| Spectrum::from_rgb(self.colors[i as usize]));
            color = mix(corners, weights);
        }
        match self.face_colors.get(triangle) {
            Some(rgb) => color * Spectrum::from_rgb(*rgb),
            None => color,
        }
    }
}

/// The mean of three values with weights that sum to 1.
fn mix<T, W>(values: [T; 3], weights: [W; 3]) -> T
where
    T: std::ops::Mul<W, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = values;
    let [wa, wb, wc] = weights;
    a * wa + b * wb + c * wc
}

/// How far the triangle test's plane may lie from the true one, seen from a point of the triangle: the test
/// works on the corners relative to the ray's origin, each rounded once, with some seven operations after it.
fn test_error(corners: [Vec3; 3], p: Vec3) -> f32 {
    let extent = corners.iter().map(|c| (*c - p).abs().max_element()).fold(0.0, f32::max);
    extent * gamma(8)
}

#[cfg(test)]
mod tests;
