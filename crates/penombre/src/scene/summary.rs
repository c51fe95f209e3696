//! What is inside a scene, counted.

use super::{Named, Scene};
use crate::shape::AnyShape;
use penombre_math::Bounds3;

/// How many things of one type there are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Count {
    /// The type's name.
    pub type_name: &'static str,
    /// Number of things.
    pub count: usize,
}

/// What is inside a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Shapes by type.
    pub shapes: Vec<Count>,
    /// Materials by type, the default material left out.
    pub materials: Vec<Count>,
    /// Textures by type.
    pub textures: Vec<Count>,
    /// Lights by type.
    pub lights: Vec<Count>,
    /// Names of the cameras.
    pub cameras: Vec<String>,
    /// Triangles, each shape counted once however often it appears.
    pub triangles: usize,
    /// Appearances of shapes through instances.
    pub instances: usize,
    /// A box around all, world space, metres.
    pub bounds: Bounds3,
    /// Bytes of the acceleration structure, the geometry in it included.
    pub bvh_bytes: usize,
}

impl Scene {
    fn own_shapes(&self) -> &[Named<AnyShape>] {
        &self.shapes.list[..self.shapes.own()]
    }

    /// Counts what is inside.
    pub fn summary(&self) -> Summary {
        let triangles = self.own_shapes().iter().filter(|s| s.value.type_name() == "mesh");
        Summary {
            shapes: counts(self.own_shapes().iter().map(|s| s.value.type_name())),
            materials: counts(given(&self.materials).map(|m| m.value.type_name())),
            textures: counts(self.textures.iter().map(|t| t.type_name())),
            lights: counts(self.lights.iter().map(|l| l.value.type_name())),
            cameras: self.cameras.iter().map(|c| c.name.clone()).collect(),
            triangles: triangles.map(|s| s.value.primitives()).sum(),
            instances: self.shapes.placed_shapes().iter().filter(|p| p.to_world.is_some()).count(),
            bounds: self.bounds(),
            bvh_bytes: self.shapes.bvh.stats().bytes,
        }
    }
}

/// Those that stand in the scene file.
fn given<T>(list: &[Named<T>]) -> impl Iterator<Item = &Named<T>> {
    list.iter().filter(|n| !n.name.is_empty())
}

fn counts(names: impl Iterator<Item = &'static str>) -> Vec<Count> {
    let mut result: Vec<Count> = Vec::new();
    for type_name in names {
        match result.iter_mut().find(|c| c.type_name == type_name) {
            Some(c) => c.count += 1,
            None => result.push(Count { type_name, count: 1 }),
        }
    }
    result
}
