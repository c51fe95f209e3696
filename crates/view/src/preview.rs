//! What a rasteriser draws: triangles, materials and lights of a scene as buffers for a graphics card.
//!
//! All shapes are tessellated into world space, so that one draw call per material shows everything. Memory is
//! bounded by [`Limits`]: what goes beyond is thinned out or shown as boxes, and [`PreviewMesh::note`] says so.
//! The ray tracer always shows all.

mod material;

use penombre::Scene;
use penombre::scene::Placement;
use penombre::shape::{Detail, Tessellation};
use penombre_math::{Bounds3, Spectrum, Transform, Vec2, Vec3};
use std::collections::BTreeMap;
use std::ops::Range;

pub use material::{PreviewMaterial, PreviewTexture};

/// Most lights of a preview, as in `preview.wgsl`.
pub const MOST_LIGHTS: usize = 64;
/// Triangles of a box.
const BOX_TRIANGLES: usize = 12;
/// Vertices of a box.
const BOX_VERTICES: usize = 24;

/// How much a preview may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most triangles, 12 bytes each and 4 for the object.
    pub triangles: usize,
    /// Most vertices, 48 bytes each.
    pub vertices: usize,
    /// Most triangles of a curved shape.
    pub curved: usize,
    /// Most bytes of all textures together.
    pub texture_bytes: usize,
}

impl Limits {
    /// For wireframes: curved shapes as coarse as in the course, whose spheres are grids of 20 × 20.
    pub fn wireframe() -> Self {
        Self { curved: 400, texture_bytes: 0, ..Self::default() }
    }
}

impl Default for Limits {
    /// Two million triangles, and vertices and textures that fit the buffers that every graphics card has.
    fn default() -> Self {
        Self { triangles: 2_000_000, vertices: 4_000_000, curved: usize::MAX, texture_bytes: 64 << 20 }
    }
}

/// A corner of triangles; 48 bytes without gaps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Vertex {
    /// World space, metres.
    pub position: [f32; 3],
    /// Unit shading normal; surfaces are drawn from both sides.
    pub normal: [f32; 3],
    /// Texture coordinates, as [`PreviewTexture`] takes them.
    pub uv: [f32; 2],
    /// Linear colour, a factor of the diffuse colour; the last is 1.
    pub color: [f32; 4],
}

impl Vertex {
    /// Bytes from one vertex to the next.
    pub const STRIDE: usize = 48;

    /// The numbers in the order of the fields.
    pub fn to_array(&self) -> [f32; 12] {
        let ([a, b, c], [d, e, f], [g, h], [i, j, k, l]) = (self.position, self.normal, self.uv, self.color);
        [a, b, c, d, e, f, g, h, i, j, k, l]
    }
}

/// Triangles of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Index into [`PreviewMesh::materials`].
    pub material: u32,
    /// Their part of [`PreviewMesh::indices`].
    pub indices: Range<u32>,
}

/// A light as a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewLight {
    /// Its middle, world space, metres.
    pub center: [f32; 3],
    /// Linear colour.
    pub color: [f32; 3],
}

/// A scene for a rasteriser.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PreviewMesh {
    /// All vertices.
    pub vertices: Vec<Vertex>,
    /// Three for each triangle, sorted by material.
    pub indices: Vec<u32>,
    /// For each triangle the index of its shape in the scene.
    pub objects: Vec<u32>,
    /// What to draw with which material.
    pub groups: Vec<Group>,
    /// The scene's materials, with the scene's indices.
    pub materials: Vec<PreviewMaterial>,
    /// The scene's first lights, at most [`MOST_LIGHTS`].
    pub lights: Vec<PreviewLight>,
    /// What is not shown in full, for a person; none if all is.
    pub note: Option<String>,
}

impl PreviewMesh {
    /// Makes the buffers of a scene.
    pub fn new(scene: &Scene, limits: &Limits) -> Self {
        let mut by_shape: BTreeMap<u32, Vec<Placement>> = BTreeMap::new();
        for placement in scene.placements() {
            by_shape.entry(placement.shape).or_default().push(placement);
        }
        let count: usize = by_shape.values().map(Vec::len).sum();
        let mut builder = Builder::new(limits, count);
        // What is curved shares the triangles evenly; a mesh may take what is left.
        let curved = limits.curved.min(limits.triangles / count.max(1) / 2);
        for (shape, placements) in &by_shape {
            let detail = Detail { curved, most: builder.room.triangles };
            builder.shape(&scene.tessellate(*shape, &detail), scene.shape_materials(*shape), placements);
        }
        let mut mesh = builder.finish();
        mesh.materials = material::all(scene, limits.texture_bytes);
        let light =
            |center: Vec3, color: Spectrum| PreviewLight { center: center.to_array(), color: color.to_rgb() };
        let lights = scene.lights().iter().map(|l| light(l.value.center(), l.value.classic_color()));
        mesh.lights = lights.take(MOST_LIGHTS).collect();
        if scene.lights().len() > MOST_LIGHTS {
            let all = scene.lights().len();
            let lights = format!("of {all} lights the preview shows {MOST_LIGHTS}; rendering shows all");
            mesh.note = Some(mesh.note.map_or(lights.clone(), |note| format!("{note}\n{lights}")));
        }
        mesh
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// A box around all vertices, world space, metres.
    pub fn bounds(&self) -> Bounds3 {
        Bounds3::of_points(self.vertices.iter().map(|v| Vec3::from(v.position)))
    }

    /// The vertices as bytes, little endian.
    pub fn vertex_bytes(&self) -> Vec<u8> {
        self.vertices.iter().flat_map(Vertex::to_array).flat_map(f32::to_le_bytes).collect()
    }

    /// The indices as bytes, little endian.
    pub fn index_bytes(&self) -> Vec<u8> {
        self.indices.iter().flat_map(|i| i.to_le_bytes()).collect()
    }

    /// The edges of all triangles, each once for each material: for wireframes. Costs a sort.
    pub fn edges(&self) -> Edges {
        let mut edges = Edges::default();
        for group in &self.groups {
            let own = &self.indices[group.indices.start as usize..group.indices.end as usize];
            let start = edges.indices.len() as u32;
            edges.indices.extend(edges_of(own));
            edges.groups.push(Group { indices: start..edges.indices.len() as u32, ..*group });
        }
        edges
    }
}

/// Lines of a scene for a rasteriser.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edges {
    /// Two vertices for each line, sorted by material.
    pub indices: Vec<u32>,
    /// What to draw with which material.
    pub groups: Vec<Group>,
}

/// The edges of triangles, each once, as pairs of vertex indices.
fn edges_of(triangles: &[u32]) -> impl Iterator<Item = u32> {
    let edge = |a: u32, b: u32| (u64::from(a.min(b)) << 32) | u64::from(a.max(b));
    let triangles = triangles.chunks_exact(3);
    let mut keys: Vec<u64> =
        triangles.flat_map(|t| [edge(t[0], t[1]), edge(t[1], t[2]), edge(t[2], t[0])]).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.into_iter().flat_map(|k| [(k >> 32) as u32, k as u32])
}

/// Collects triangles within the limits.
struct Builder {
    vertices: Vec<Vertex>,
    /// Indices and objects by material.
    by_material: BTreeMap<u32, (Vec<u32>, Vec<u32>)>,
    triangles: usize,
    /// What may still be used by shapes in full; boxes have a reserve.
    room: Limits,
    /// Boxes that may still be drawn.
    boxes_left: usize,
    told: Told,
}

/// What is not shown in full.
#[derive(Default)]
struct Told {
    appearances: usize,
    thinned: usize,
    boxes: usize,
    left_out: usize,
}

impl Builder {
    fn new(limits: &Limits, appearances: usize) -> Self {
        let most = (limits.triangles / BOX_TRIANGLES).min(limits.vertices / BOX_VERTICES);
        let boxes_left = appearances.min(most / 4);
        let room = Limits {
            triangles: limits.triangles - boxes_left * BOX_TRIANGLES,
            vertices: limits.vertices - boxes_left * BOX_VERTICES,
            ..*limits
        };
        let told = Told { appearances, ..Told::default() };
        Self { vertices: Vec::new(), by_material: BTreeMap::new(), triangles: 0, room, boxes_left, told }
    }

    /// Adds all appearances of a shape.
    fn shape(&mut self, shape: &Tessellation, materials: &[u32], placements: &[Placement]) {
        let whole = self.room;
        for (i, placement) in placements.iter().enumerate() {
            if self.fits(shape) {
                self.spend(shape);
                self.add(shape, materials, placement);
                self.told.thinned += usize::from(shape.left_out > 0);
            } else if i == 0 && whole.triangles >= BOX_TRIANGLES && !shape.triangles.is_empty() {
                // The shape itself is too large: a part of its triangles still looks like it.
                let thinned = thin(shape, &whole);
                self.spend(&thinned);
                self.add(&thinned, materials, placement);
                self.told.thinned += 1;
            } else if self.boxes_left > 0 {
                self.boxes_left -= 1;
                self.told.boxes += 1;
                self.add(&box_around(shape), materials, placement);
            } else {
                self.told.left_out += 1;
            }
        }
    }

    fn fits(&self, shape: &Tessellation) -> bool {
        shape.triangles.len() <= self.room.triangles && shape.positions.len() <= self.room.vertices
    }

    fn spend(&mut self, shape: &Tessellation) {
        self.room.triangles = self.room.triangles.saturating_sub(shape.triangles.len());
        self.room.vertices = self.room.vertices.saturating_sub(shape.positions.len());
    }

    fn add(&mut self, shape: &Tessellation, materials: &[u32], placement: &Placement) {
        let first = self.vertices.len() as u32;
        let map = placement.to_world.as_ref();
        self.vertices.extend((0..shape.positions.len()).map(|i| vertex(shape, i, map)));
        for (i, corners) in shape.triangles.iter().enumerate() {
            let slot = shape.slots.get(i).map_or(0, |slot| *slot as usize);
            let (indices, objects) =
                self.by_material.entry(materials[slot.min(materials.len() - 1)]).or_default();
            indices.extend(corners.map(|corner| first + corner));
            objects.push(placement.shape);
        }
        self.triangles += shape.triangles.len();
    }

    fn finish(self) -> PreviewMesh {
        let mut mesh = PreviewMesh { note: self.told.note(), vertices: self.vertices, ..Default::default() };
        for (material, (indices, objects)) in self.by_material {
            let start = mesh.indices.len() as u32;
            mesh.indices.extend(indices);
            mesh.objects.extend(objects);
            mesh.groups.push(Group { material, indices: start..mesh.indices.len() as u32 });
        }
        mesh
    }
}

impl Told {
    fn note(&self) -> Option<String> {
        let mut parts = Vec::new();
        let mut say = |count: usize, what: &str| {
            if count > 0 {
                parts.push(format!("{count} {what}"));
            }
        };
        say(self.thinned, "with a part of their triangles");
        say(self.boxes, "as boxes");
        say(self.left_out, "not at all");
        (!parts.is_empty()).then(|| {
            format!(
                "the scene is large: of {} objects the preview shows {}; rendering shows all",
                self.appearances,
                parts.join(", ")
            )
        })
    }
}

fn vertex(shape: &Tessellation, i: usize, map: Option<&Transform>) -> Vertex {
    let (p, n) = (shape.positions[i], shape.normals[i]);
    let (p, n) = match map {
        Some(map) => (map.point(p), map.normal(n).normalize_or(Vec3::Z)),
        None => (p, n),
    };
    let [r, g, b] = shape.colors[i].to_rgb();
    Vertex {
        position: p.to_array(),
        normal: n.to_array(),
        uv: shape.uvs[i].to_array(),
        color: [r, g, b, 1.0],
    }
}

/// Every k-th triangle, with k such that the rest fits.
fn thin(shape: &Tessellation, room: &Limits) -> Tessellation {
    // Three vertices of its own for each triangle at worst.
    let most = room.triangles.min(room.vertices / 3).max(1);
    let step = shape.triangles.len().div_ceil(most).max(1);
    let mut known = vec![u32::MAX; shape.positions.len()];
    let mut result = Tessellation::default();
    for (i, corners) in shape.triangles.iter().enumerate().step_by(step) {
        let corners = corners.map(|corner| {
            let old = corner as usize;
            if known[old] == u32::MAX {
                known[old] =
                    result.push(shape.positions[old], shape.normals[old], shape.uvs[old], shape.colors[old]);
            }
            known[old]
        });
        result.triangles.push(corners);
        result.slots.extend(shape.slots.get(i));
    }
    result
}

/// The box around a shape, in the shape's space.
fn box_around(shape: &Tessellation) -> Tessellation {
    let bounds = Bounds3::of_points(shape.positions.iter().copied());
    let (center, half) = (bounds.center(), bounds.size() * 0.5);
    let mut result = Tessellation::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let along = |axis: usize| Vec3::AXES[axis % 3];
            let (n, u, v) = (along(axis) * sign, along(axis + 1), along(axis + 2));
            let corner = |a: f32, b: f32| center + (n + u * a + v * b) * half;
            let first = result.positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                result.push(corner(a, b), n, Vec2::ZERO, Spectrum::WHITE);
            }
            result.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    result
}

#[cfg(test)]
mod tests;
