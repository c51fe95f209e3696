//! From description to scene.

use super::{BuiltShape, Named, Placed, Scene};
use crate::camera::AnyCamera;
use crate::light::AnyLight;
use crate::material::AnyMaterial;
use crate::registry::Context;
use crate::shape::AnyShape;
use crate::texture::AnyTexture;
use penombre_bvh::{Bvh, Geometry, Instance};
use penombre_math::{Bounds3, DAffine3, Transform};
use penombre_scene::assets::Assets;
use penombre_scene::{Diagnostics, Kind, Node, NodeId, ParamSpec, Role, SceneDescription, Span};
use std::collections::HashMap;
use std::sync::Arc;

/// Parameters of `[instance.NAME]`.
pub const INSTANCE_SCHEMA: &[ParamSpec] = &[
    ParamSpec::required("of", Kind::Reference(Role::Shape), "The shape that appears once more."),
    ParamSpec::optional(
        "transform",
        Kind::Transform,
        "Where it stands: steps applied after the shape's own.",
    ),
    ParamSpec::optional("transforms", Kind::Transforms, "Many places at once: a list of transforms."),
];

impl Scene {
    /// Builds a scene. All faults go to `out`; `None` if any of them is an error.
    ///
    /// `aspect` is width over height of the image; it matters only for the camera that a scene without one gets.
    pub fn build(
        description: &SceneDescription,
        assets: &Assets,
        aspect: f32,
        out: &mut Diagnostics,
    ) -> Option<Arc<Self>> {
        let mut builder = Builder { description, assets, out };
        let textures = builder.all(Role::Texture, AnyTexture::build);
        let mut materials = builder.all(Role::Material, AnyMaterial::build);
        let shapes = builder.all(Role::Shape, AnyShape::build);
        let lights = builder.all(Role::Light, AnyLight::build);
        let cameras = builder.all(Role::Camera, AnyCamera::build);
        let instances = builder.instances();
        if builder.out.has_errors() {
            return None;
        }
        let default = materials.len() as u32;
        materials.push(Named { name: String::new(), value: AnyMaterial::default() });
        let shapes = builder.with_materials(shapes, default);
        let (placed, bvh) = builder.place(&shapes, &instances)?;
        let bounds = bvh.bounds();
        let mut scene = Self {
            bvh,
            shapes,
            placed,
            materials,
            textures: textures.into_iter().map(|t| t.value).collect(),
            lights,
            cameras,
            bounds,
        };
        builder.complete(&mut scene, aspect);
        (!builder.out.has_errors()).then(|| Arc::new(scene))
    }
}

/// A shape's node and what was built from it.
type BuiltNode<T> = Named<T>;

/// Further appearances: the shape's index and the map from its own place.
struct Appearance {
    shape: u32,
    map: DAffine3,
    span: Span,
}

struct Builder<'a, 'd> {
    description: &'a SceneDescription,
    assets: &'a Assets,
    out: &'d mut Diagnostics,
}

impl Builder<'_, '_> {
    /// Builds every node of a role. After a fault the list is short, and `out` has an error.
    fn all<T>(
        &mut self,
        role: Role,
        build: impl Fn(&Node, &mut Context<'_, '_>) -> Option<T>,
    ) -> Vec<BuiltNode<T>> {
        let mut built = Vec::new();
        for (id, node) in self.description.of_role(role) {
            let mut context = self.context(id);
            if let Some(value) = build(node, &mut context) {
                built.push(Named { name: node.name.clone(), value });
            }
        }
        built
    }

    fn context(&mut self, node: NodeId) -> Context<'_, '_> {
        Context { description: self.description, assets: self.assets, out: self.out, node }
    }

    /// Decodes all instance nodes.
    fn instances(&mut self) -> Vec<Appearance> {
        let mut found = Vec::new();
        for (id, node) in self.description.of_role(Role::Instance) {
            let mut context = self.context(id);
            let p = context.decode(node, INSTANCE_SCHEMA);
            let Some(of) = p.reference("of") else { continue };
            let shape = context.position(of);
            let own = p.transform("transform");
            let several = p.transforms("transforms");
            let maps = if p.is_given("transforms") {
                several.iter().map(|map| *map * own).collect()
            } else {
                vec![own]
            };
            found.extend(maps.into_iter().map(|map| Appearance { shape, map, span: node.span }));
        }
        found
    }

    /// Joins shapes with the materials of their slots.
    fn with_materials(&mut self, shapes: Vec<BuiltNode<AnyShape>>, default: u32) -> Vec<BuiltShape> {
        let ids: Vec<NodeId> = self.description.of_role(Role::Shape).map(|(id, _)| id).collect();
        let mut result = Vec::with_capacity(shapes.len());
        for (id, built) in ids.into_iter().zip(shapes) {
            let context = self.context(id);
            let node = context.description.node(id);
            let named = node.param("material").and_then(|p| match &p.value.kind {
                penombre_scene::ValueKind::String(name) => context.description.find(Role::Material, name),
                _ => None,
            });
            let slots: Vec<NodeId> = match named {
                Some(material) => vec![material],
                None => context.assets.slot_materials(id).to_vec(),
            };
            let mut materials: Vec<u32> = slots.into_iter().map(|m| context.position(m)).collect();
            if materials.is_empty() {
                materials.push(default);
            }
            result.push(BuiltShape { name: built.name, shape: built.value, materials });
        }
        result
    }

    /// Puts all appearances of all shapes into one acceleration structure.
    fn place(&mut self, shapes: &[BuiltShape], instances: &[Appearance]) -> Option<(Vec<Placed>, Bvh)> {
        let mut nested: HashMap<u32, Arc<Bvh>> = HashMap::new();
        let shared = instances.iter().map(|i| i.shape);
        let odd = shapes.iter().enumerate().filter(|(_, s)| s.shape.remainder().is_some());
        for index in shared.chain(odd.map(|(i, _)| i as u32)) {
            if let std::collections::hash_map::Entry::Vacant(slot) = nested.entry(index) {
                let bvh = build_bvh(vec![shapes[index as usize].shape.geometry()], self.out)?;
                slot.insert(Arc::new(bvh));
            }
        }
        let mut placed = Vec::new();
        let mut geometries = Vec::new();
        let own = (0..shapes.len() as u32).map(|shape| Appearance {
            shape,
            map: DAffine3::IDENTITY,
            span: Span::NONE,
        });
        for appearance in own.chain(instances.iter().map(|i| Appearance { ..*i })) {
            let shape = &shapes[appearance.shape as usize];
            let Some(bvh) = nested.get(&appearance.shape) else {
                geometries.push(shape.shape.geometry());
                placed.push(Placed { shape: appearance.shape, to_world: None });
                continue;
            };
            let map = appearance.map * shape.shape.remainder().unwrap_or(DAffine3::IDENTITY);
            let Some(to_world) = Transform::new(map) else {
                let message = format!(
                    "the transform of an instance of `shape.{}` overflows or is singular",
                    shape.name
                );
                self.out.error("scene::transform", appearance.span, message).help =
                    "scales must not be zero, and coordinates must stay below 3.4e38".to_owned();
                continue;
            };
            geometries.push(Geometry::Instance(Instance { bvh: bvh.clone(), to_world }));
            placed.push(Placed { shape: appearance.shape, to_world: Some(to_world) });
        }
        if self.out.has_errors() {
            return None;
        }
        Some((placed, build_bvh(geometries, self.out)?))
    }

    /// Gives a scene without a camera one, and says what is missing.
    fn complete(&mut self, scene: &mut Scene, aspect: f32) {
        if scene.cameras.is_empty() {
            let mut description = SceneDescription::default();
            let bounds = if scene.bounds.is_empty() { unit_box() } else { scene.bounds };
            let id = description.add(penombre_scene::auto::camera_for(&bounds, aspect));
            let mut context =
                Context { description: &description, assets: self.assets, out: self.out, node: id };
            if let Some(value) = AnyCamera::build(description.node(id), &mut context) {
                scene.cameras.push(Named { name: String::new(), value });
            }
            let message = "the scene has no camera: looking at all of it from the front right";
            self.out.advice("scene::no-camera", Span::NONE, message).help =
                "add [camera.main] with type = \"perspective\", position and target".to_owned();
        }
        if scene.shapes.is_empty() {
            let message = "the scene has no shape: the image is background";
            self.out.warning("scene::no-shape", Span::NONE, message).help =
                "add [shape.NAME] with type = \"sphere\", \"quad\", \"disk\" or \"mesh\"".to_owned();
        } else if scene.lights.is_empty() {
            let message = "the scene has no light: only ambient light is seen";
            self.out.warning("scene::no-light", Span::NONE, message).help =
                "add [light.NAME] with type = \"point\" and position".to_owned();
        }
    }
}

fn unit_box() -> Bounds3 {
    Bounds3 { min: penombre_math::Vec3::NEG_ONE, max: penombre_math::Vec3::ONE }
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
