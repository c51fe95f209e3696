//! The shapes of a scene, where they stand: what depends on nothing but the shapes and instances of a description.
//!
//! To build them takes most of the time of building a scene. They do not change, and scenes whose descriptions differ
//! in other things share them.

use super::emitters::NO_EMITTER;
use super::{Hierarchy, Named};
use crate::shape::AnyShape;
use penombre_bvh::{Bvh, Geometry, Instance};
use penombre_math::{Bounds3, DAffine3, Transform};
use penombre_scene::assets::Assets;
use penombre_scene::{Diagnostics, MeshFile, Node, NodeId, Role, SceneDescription, Span};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Weak};

/// Shapes in their acceleration structure.
#[derive(Debug)]
pub(super) struct Shapes {
    pub bvh: Bvh,
    pub hierarchy: Hierarchy,
    /// In file order, then the surfaces of lights.
    pub list: Vec<Named<AnyShape>>,
    /// By geometry of the acceleration structure's upper level; the surfaces of lights come last.
    pub placed: Vec<Placed>,
    /// For each surface of a light, the light's index.
    pub lights: Vec<u32>,
    /// A box around all of them, world space.
    pub bounds: Bounds3,
    origins: Vec<Origin>,
}

/// One appearance of a shape: a geometry of the acceleration structure's upper level.
#[derive(Debug)]
pub(super) struct Placed {
    /// Index into the shapes.
    pub shape: u32,
    /// The map from the geometry's space, or none if that is world space.
    pub to_world: Option<Transform>,
}

/// Further appearances: the shape's index and the map from its own place.
pub(super) struct Appearance {
    pub shape: u32,
    pub map: DAffine3,
    pub span: Span,
}

/// What a shape or an instance was built from.
#[derive(Debug)]
struct Origin {
    node: Arc<Node>,
    /// The file of a mesh. It is not kept: its address, which stays taken, tells it apart.
    mesh: Option<Weak<MeshFile>>,
}

impl Origin {
    fn is(&self, node: &Arc<Node>, mesh: Option<&Arc<MeshFile>>) -> bool {
        let same_mesh = self.mesh.as_ref().map(Weak::as_ptr) == mesh.map(Arc::as_ptr);
        same_mesh && (Arc::ptr_eq(&self.node, node) || self.node.says_the_same(node))
    }
}

/// The nodes from which shapes are built, with the files of meshes.
fn sources<'a>(
    description: &'a SceneDescription,
    assets: &'a Assets,
) -> impl Iterator<Item = (&'a Arc<Node>, Option<&'a Arc<MeshFile>>)> {
    let ids = [Role::Shape, Role::Instance].into_iter().flat_map(|role| description.of_role(role));
    ids.map(|(id, _): (NodeId, _)| (description.shared(id), assets.mesh(id)))
}

impl Shapes {
    /// Puts all appearances of all shapes into one acceleration structure. The shapes and instances are those of
    /// `description` and `assets`; the last of the shapes are the surfaces of those `lights`.
    pub fn place(
        list: Vec<Named<AnyShape>>,
        instances: &[Appearance],
        lights: Vec<u32>,
        (description, assets): (&SceneDescription, &Assets),
        out: &mut Diagnostics,
    ) -> Option<Self> {
        let nested = nested(&list, instances, out)?;
        let still = |shape| Appearance { shape, map: DAffine3::IDENTITY, span: Span::NONE };
        let first_light = (list.len() - lights.len()) as u32;
        let own = (0..first_light).map(still);
        let surfaces = (first_light..list.len() as u32).map(still);
        let mut placed = Vec::new();
        let mut geometries = Vec::new();
        for appearance in own.chain(instances.iter().map(|i| Appearance { ..*i })).chain(surfaces) {
            let shape = &list[appearance.shape as usize];
            let Some(bvh) = nested.get(&appearance.shape) else {
                geometries.push(shape.value.geometry());
                placed.push(Placed { shape: appearance.shape, to_world: None });
                continue;
            };
            let map = appearance.map * shape.value.remainder().unwrap_or(DAffine3::IDENTITY);
            let Some(to_world) = Transform::new(map) else {
                let message = format!(
                    "the transform of an instance of `shape.{}` overflows or is singular",
                    shape.name
                );
                out.error("scene::transform", appearance.span, message).help =
                    "scales must not be zero, and coordinates must stay below 3.4e38".to_owned();
                continue;
            };
            geometries.push(Geometry::Instance(Instance { bvh: bvh.clone(), to_world }));
            placed.push(Placed { shape: appearance.shape, to_world: Some(to_world) });
        }
        if out.has_errors() {
            return None;
        }
        let bvh = build_bvh(geometries, out)?;
        let origin = |(node, mesh): (&Arc<Node>, Option<&Arc<MeshFile>>)| Origin {
            node: node.clone(),
            mesh: mesh.map(Arc::downgrade),
        };
        let origins = sources(description, assets).map(origin).collect();
        let hierarchy = Hierarchy::of(&bvh, &nested);
        Some(Self { bounds: bvh.bounds(), bvh, hierarchy, list, placed, lights, origins })
    }

    /// Number of shapes that are not surfaces of lights.
    pub fn own(&self) -> usize {
        self.list.len() - self.lights.len()
    }

    /// All appearances but those of the surfaces of lights.
    pub fn placed_shapes(&self) -> &[Placed] {
        &self.placed[..self.placed.len() - self.lights.len()]
    }

    /// The emitter of a geometry of the upper level, or [`NO_EMITTER`].
    #[inline]
    pub fn emitter_of(&self, placed: u32) -> u32 {
        let first = self.placed.len() - self.lights.len();
        let light = (placed as usize).checked_sub(first).and_then(|i| self.lights.get(i));
        light.map_or(NO_EMITTER, |light| *light)
    }

    /// True if the surfaces of lights are these: index of the light and its shape.
    pub fn have_surfaces(&self, surfaces: &[(u32, Named<AnyShape>)]) -> bool {
        let own = self.lights.iter().zip(&self.list[self.own()..]);
        own.len() == surfaces.len()
            && own.zip(surfaces).all(|((light, own), (other, surface))| {
                light == other && own.name == surface.name && same_surface(&own.value, &surface.value)
            })
    }

    /// True if building the shapes and instances of a description would give these. Nodes that the description
    /// shares with the one that these were built from are not looked into.
    pub fn are_of(&self, description: &SceneDescription, assets: &Assets) -> bool {
        let mut now = sources(description, assets);
        let mut same = |origin: &Origin| now.next().is_some_and(|(node, mesh)| origin.is(node, mesh));
        self.origins.iter().all(&mut same) && now.next().is_none()
    }
}

/// True for surfaces of lights that are the same.
fn same_surface(a: &AnyShape, b: &AnyShape) -> bool {
    match (a, b) {
        (AnyShape::Quad(a), AnyShape::Quad(b)) => a == b,
        (AnyShape::Disk(a), AnyShape::Disk(b)) => a == b,
        (AnyShape::Sphere(a), AnyShape::Sphere(b)) => a == b,
        _ => false,
    }
}

/// Acceleration structures of the shapes that appear under a map.
fn nested(
    list: &[Named<AnyShape>],
    instances: &[Appearance],
    out: &mut Diagnostics,
) -> Option<HashMap<u32, Arc<Bvh>>> {
    let mut nested = HashMap::new();
    let shared = instances.iter().map(|i| i.shape);
    let odd = list.iter().enumerate().filter(|(_, s)| s.value.remainder().is_some());
    for index in shared.chain(odd.map(|(i, _)| i as u32)) {
        if let Entry::Vacant(slot) = nested.entry(index) {
            let bvh = build_bvh(vec![list[index as usize].value.geometry()], out)?;
            slot.insert(Arc::new(bvh));
        }
    }
    Some(nested)
}

fn build_bvh(geometries: Vec<Geometry>, out: &mut Diagnostics) -> Option<Bvh> {
    match Bvh::build(geometries, &Default::default()) {
        Ok(bvh) => Some(bvh),
        Err(error) => {
            out.error("scene::geometry", Span::NONE, format!("the shapes cannot be traced: {error}")).help =
                "split the scene into smaller parts".to_owned();
            None
        }
    }
}
