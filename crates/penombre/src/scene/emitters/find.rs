//! Finding the shapes that shine.

use super::NO_EMITTER;
use super::shape::{Form, Glow, GlowingMesh, ShapeEmitter};
use crate::light::sampling::{Parallelogram, power};
use crate::scene::shapes::Placed;
use crate::scene::{Scene, SurfacePoint};
use penombre_bvh::{Geometry, Hit, Ray, Triangles};
use penombre_math::distribution::Distribution1D;
use penombre_math::{Frame, Spectrum, Transform, Vec2, Vec3, float};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Places along each coordinate at which a radiance that varies over a shape is looked at: for the choice among emitters
/// alone, which needs its size only.
const GRID: u32 = 16;
/// The same over a triangle of a mesh.
const TRIANGLE_GRID: u32 = 4;
/// A map scales lengths alike if its axes differ by less than this share: what single precision leaves of one that does.
const SIMILAR: f32 = 1e-5;

/// Finds the appearances of shapes that shine, in a scene that is complete but for its emitters.
pub struct Finder<'a> {
    scene: &'a Scene,
    /// Meshes may appear often: their triangles are looked at once.
    meshes: HashMap<u32, Option<Arc<GlowingMesh>>>,
}

/// A place on a surface: the point in the shape's own space, and the coordinates and primitive of a hit there.
struct Place {
    point: Vec3,
    uv: [f32; 2],
    prim: u32,
}

/// What a triangle sends.
#[derive(Default)]
struct TriangleGlow {
    /// Mean over the triangle, both sides together.
    luminance: f32,
    /// To the inside and the outside, at its first corner.
    sides: [Spectrum; 2],
    /// Whether the outside is that of the vertices' order; `None`: here and there.
    as_wound: Option<bool>,
}

impl<'a> Finder<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, meshes: HashMap::new() }
    }

    /// The emitters, and for each geometry of the upper level its emitter's place among them or [`NO_EMITTER`]; that list is
    /// empty if there are none.
    pub fn all(mut self) -> (Vec<ShapeEmitter>, Vec<u32>) {
        let (mut found, mut places) = (Vec::new(), Vec::new());
        let all = self.scene.shapes.placed.len();
        for (index, placed) in self.scene.shapes.placed_shapes().iter().enumerate() {
            let mut slots = self.scene.slots[placed.shape as usize].iter();
            if slots.any(|m| self.scene.materials[*m as usize].value.is_emissive()) {
                places.resize(all, NO_EMITTER);
                places[index] = found.len() as u32;
                found.push(self.emitter(index as u32));
            }
        }
        (found, places)
    }

    fn placed(&self, index: u32) -> &'a Placed {
        &self.scene.shapes.placed[index as usize]
    }

    fn emitter(&mut self, placed: u32) -> ShapeEmitter {
        let form = self.form(placed);
        let glow = match &form {
            Form::Mesh { mesh, .. } => mesh.glow,
            _ => self.glow(placed),
        };
        let power = match &form {
            Form::Unsampled => 0.0,
            Form::Mesh { mesh, to_world } => {
                let sum = mesh.sum * to_world.as_ref().map_or(1.0, area_scale);
                power::of_surface(1.0, sum.min(f64::from(f32::MAX)) as f32, false)
            }
            Form::Quad { shape, .. } => {
                power::of_surface(self.luminance(placed, &form, glow), shape.area(), false)
            }
            Form::Disk { radius, .. } => {
                power::of_surface(self.luminance(placed, &form, glow), PI * radius * radius, false)
            }
            Form::Sphere { radius, .. } => power::of_sphere(self.luminance(placed, &form, glow), *radius),
        };
        ShapeEmitter { placed, form, glow, power }
    }

    fn form(&mut self, index: u32) -> Form {
        let &Placed { shape, to_world } = self.placed(index);
        let geometry = self.scene.shapes.list[shape as usize].value.geometry();
        let point = |p: Vec3| to_world.map_or(p, |map| map.point(p));
        let scale = to_world.as_ref().map_or(Some(1.0), similarity);
        let form = match (geometry, scale) {
            (Geometry::Quads(quads), _) => quads.first().and_then(|quad| {
                let sides = quad.sides.map(|side| to_world.map_or(side, |map| map.vector(side)));
                let mirrored = to_world.is_some_and(|map| map.flips_handedness());
                Some(Form::Quad { shape: Parallelogram::new(point(quad.origin), sides)?, mirrored })
            }),
            (Geometry::Triangles(triangles), _) => {
                self.mesh(index, triangles).map(|mesh| Form::Mesh { mesh, to_world })
            }
            (Geometry::Disks(disks), Some(scale)) => disks.first().map(|disk| {
                let normal = to_world.map_or(disk.normal, |map| map.normal(disk.normal));
                let normal = normal.normalize_or(Vec3::Z);
                Form::Disk { center: point(disk.center), normal, radius: disk.radius * scale }
            }),
            (Geometry::Spheres(spheres), Some(scale)) => spheres
                .first()
                .map(|sphere| Form::Sphere { center: point(sphere.center), radius: sphere.radius * scale }),
            _ => None,
        };
        form.unwrap_or(Form::Unsampled)
    }

    /// A mesh with the weights of its triangles; `None` if it has none.
    fn mesh(&mut self, index: u32, triangles: Triangles) -> Option<Arc<GlowingMesh>> {
        let shape = self.placed(index).shape;
        if let Some(known) = self.meshes.get(&shape) {
            return known.clone();
        }
        let mut weights = Vec::with_capacity(triangles.indices.len());
        let mut sum = 0.0;
        let mut glow: Option<TriangleGlow> = None;
        let mut even = !self.varies(shape);
        for (prim, corners) in triangles.indices.iter().enumerate() {
            let corners = corners.map(|i| triangles.positions[i as usize]);
            let own = self.triangle(index, prim as u32, corners);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let weight = 0.5 * (b - a).cross(c - a).length() * f64::from(own.luminance);
            let weight = if weight.is_finite() { weight } else { 0.0 };
            sum += weight;
            weights.push(weight as f32);
            if own.luminance > 0.0 {
                let first = glow.get_or_insert(TriangleGlow { ..own });
                even &= own.sides == first.sides && own.as_wound == first.as_wound && own.as_wound.is_some();
            }
        }
        let glow = glow.unwrap_or_default();
        let mesh = Distribution1D::new(&weights).map(|choice| {
            let as_wound = glow.as_wound.unwrap_or(true);
            let glow = if even { Glow::Even(glow.sides) } else { Glow::Varying };
            Arc::new(GlowingMesh { triangles, choice, glow, as_wound, sum })
        });
        self.meshes.insert(shape, mesh.clone());
        mesh
    }

    /// Looks at a triangle.
    fn triangle(&self, index: u32, prim: u32, [a, b, c]: [Vec3; 3]) -> TriangleGlow {
        let at = |[u, v]: [f32; 2]| Place { point: a + (b - a) * u + (c - a) * v, uv: [u, v], prim };
        let Some(first) = self.look(index, at([0.0, 0.0])) else { return TriangleGlow::default() };
        let material = &self.scene.materials[first.material as usize].value;
        if !material.is_emissive() {
            return TriangleGlow::default();
        }
        let to_world = self.placed(index).to_world;
        let [o, p, q] = [a, b, c].map(|p| to_world.map_or(p, |map| map.point(p)));
        let winding = (p - o).as_dvec3().cross((q - o).as_dvec3());
        let mirrored = to_world.is_some_and(|map| map.flips_handedness());
        let as_wound = |at: &SurfacePoint| (at.ng.as_dvec3().dot(winding) > 0.0) != mirrored;
        // The outside is the side of the interpolated normal, which is between those of the corners.
        let others = [[1.0, 0.0], [0.0, 1.0]].map(|uv| self.look(index, at(uv)).map(|at| as_wound(&at)));
        let agree = others.iter().all(|other| *other == Some(as_wound(&first)));
        let sides = self.sides(&first);
        let luminance = if material.has_textured_emission() {
            let grid = grid(TRIANGLE_GRID).map(|p| if p.x + p.y > 1.0 { Vec2::ONE - p } else { p });
            self.mean(index, grid.map(|p| at(p.to_array())))
        } else {
            luminance(&sides)
        };
        TriangleGlow { luminance, sides, as_wound: agree.then(|| as_wound(&first)) }
    }

    /// True if an emissive material of the shape varies over it.
    fn varies(&self, shape: u32) -> bool {
        let materials =
            self.scene.slots[shape as usize].iter().map(|m| &self.scene.materials[*m as usize].value);
        materials.into_iter().any(|m| m.is_emissive() && m.has_textured_emission())
    }

    /// What a shape that is no mesh sends.
    fn glow(&self, index: u32) -> Glow {
        if self.varies(self.placed(index).shape) {
            return Glow::Varying;
        }
        let anywhere = self.look(index, Place { point: Vec3::ZERO, uv: [0.5; 2], prim: 0 });
        Glow::Even(anywhere.map_or([Spectrum::BLACK; 2], |at| self.sides(&at)))
    }

    /// Mean luminance of both sides together of a shape that is no mesh.
    fn luminance(&self, index: u32, form: &Form, glow: Glow) -> f32 {
        if let Glow::Even(sides) = glow {
            return luminance(&sides);
        }
        let back = self.placed(index).to_world.map(|map| map.inverse());
        let place = |u: Vec2| {
            let (sin, cos) = float::sin_cos(u.y * TAU);
            let point = match form {
                Form::Disk { center, normal, radius } => {
                    let r = radius * u.x.sqrt();
                    *center + Frame::from_z(*normal).to_world(Vec3::new(cos * r, sin * r, 0.0))
                }
                Form::Sphere { center, radius } => {
                    let z = 1.0 - 2.0 * u.x;
                    let across = (1.0 - z * z).sqrt();
                    *center + Vec3::new(across * cos, across * sin, z) * *radius
                }
                _ => Vec3::ZERO,
            };
            Place { point: back.map_or(point, |map| map.point(point)), uv: u.to_array(), prim: 0 }
        };
        self.mean(index, grid(GRID).map(place))
    }

    fn mean(&self, index: u32, places: impl Iterator<Item = Place>) -> f32 {
        let (mut sum, mut count) = (0.0, 0);
        for at in places.filter_map(|place| self.look(index, place)) {
            sum += luminance(&self.sides(&at));
            count += 1;
        }
        sum / count.max(1) as f32
    }

    /// The surface at a place, as if a ray had met it there.
    fn look(&self, index: u32, place: Place) -> Option<SurfacePoint> {
        let Place { point, uv: [u, v], prim } = place;
        let point = self.placed(index).to_world.map_or(point, |map| map.point(point));
        let hit = Hit { t: 0.0, u, v, geometry: index, prim, instance: Hit::NO_INSTANCE };
        self.scene.surface(&Ray::new(point, Vec3::Z, 0.0, f32::INFINITY), &hit)
    }

    /// What the surface sends to the inside and to the outside.
    fn sides(&self, at: &SurfacePoint) -> [Spectrum; 2] {
        [false, true].map(|outside| self.scene.material_emission(at, outside))
    }
}

/// Middles of the cells of the unit square.
fn grid(n: u32) -> impl Iterator<Item = Vec2> {
    (0..n * n).map(move |i| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32)
}

/// Of both sides together.
fn luminance(sides: &[Spectrum; 2]) -> f32 {
    sides[0].luminance() + sides[1].luminance()
}

/// The factor by which the map scales all lengths, or `None` if it does not scale them alike.
fn similarity(map: &Transform) -> Option<f32> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| map.vector(axis));
    let scale = axes[0].length();
    let alike = axes.iter().all(|axis| (axis.length() - scale).abs() <= SIMILAR * scale);
    let dots = [axes[0].dot(axes[1]), axes[0].dot(axes[2]), axes[1].dot(axes[2])];
    (alike && dots.iter().all(|dot| dot.abs() <= SIMILAR * scale * scale)).then_some(scale)
}

/// The factor by which the map scales areas: of all of them if it is a similarity, else the mean of those of three planes.
fn area_scale(map: &Transform) -> f64 {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| map.vector(axis).as_dvec3());
    (x.cross(y).length() + y.cross(z).length() + z.cross(x).length()) / 3.0
}
