//! From description to scene.

use super::emitters::Emitters;
use super::shapes::{Appearance, Shapes};
use super::specular::SpecularSpheres;
use super::{Named, Scene};
use crate::camera::AnyCamera;
use crate::light::AnyLight;
use crate::material::AnyMaterial;
use crate::material::emissive::Emissive;
use crate::registry::Context;
use crate::shape::AnyShape;
use crate::texture::AnyTexture;
use penombre_math::Bounds3;
use penombre_scene::assets::Assets;
use penombre_scene::auto;
use penombre_scene::{Diagnostics, Kind, Node, NodeId, ParamSpec, Role, SceneDescription, Span, ValueKind};
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
    /// `aspect` is width over height of the image; it matters only for the camera that a scene without one gets. Lights
    /// with an extent are surfaces of the scene if `solid_lights` says so.
    pub fn build(
        description: &SceneDescription,
        assets: &Assets,
        (aspect, solid_lights): (f32, bool),
        out: &mut Diagnostics,
    ) -> Option<Arc<Self>> {
        Builder { description, assets, out, solid_lights }.scene(None, aspect)
    }

    /// The same, faster where the shapes and instances of the description are those from which `previous` was built:
    /// its shapes and their acceleration structure are taken over, and all else is built. The scene is, to the last
    /// bit, that of [`Scene::build`], and so are the errors. Nodes that the description shares with that of
    /// `previous`, as copies do, are compared in no time.
    ///
    /// What building a shape remarked without being an error was told when it was built, and is not told again.
    pub fn update(
        previous: &Self,
        description: &SceneDescription,
        assets: &Assets,
        (aspect, solid_lights): (f32, bool),
        out: &mut Diagnostics,
    ) -> Option<Arc<Self>> {
        Builder { description, assets, out, solid_lights }.scene(Some(&previous.shapes), aspect)
    }

    /// True if both scenes hold the same shapes in memory, so that what was derived from the shapes of one holds for
    /// the other.
    pub fn shares_shapes(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shapes, &other.shapes)
    }
}

struct Builder<'a, 'd> {
    description: &'a SceneDescription,
    assets: &'a Assets,
    out: &'d mut Diagnostics,
    solid_lights: bool,
}

impl Builder<'_, '_> {
    /// Builds everything, but for `known` shapes that are the description's.
    fn scene(&mut self, known: Option<&Arc<Shapes>>, aspect: f32) -> Option<Arc<Scene>> {
        let slots = self.slots();
        // A shape whose material is not there is built, so that it says so.
        let known = known.filter(|s| slots.is_some() && s.are_of(self.description, self.assets));
        let textures = self.all(Role::Texture, AnyTexture::build);
        let mut materials = self.all(Role::Material, AnyMaterial::build);
        let lights = self.all(Role::Light, AnyLight::build);
        let surfaces = if self.solid_lights { surfaces_of(&lights) } else { Vec::new() };
        let known = known.filter(|s| s.have_surfaces(&surfaces));
        let mut shapes = if known.is_none() { self.all(Role::Shape, AnyShape::build) } else { Vec::new() };
        let cameras = self.all(Role::Camera, AnyCamera::build);
        let instances = if known.is_none() { self.instances() } else { Vec::new() };
        if self.out.has_errors() {
            return None;
        }
        materials.push(Named { name: String::new(), value: AnyMaterial::default() });
        let mut slots = slots?;
        if !surfaces.is_empty() {
            slots.extend(surfaces.iter().map(|_| vec![materials.len() as u32]));
            materials.push(Named { name: String::new(), value: AnyMaterial::Emissive(Emissive::OF_LIGHTS) });
        }
        let shapes = match known {
            Some(shapes) => shapes.clone(),
            None => {
                let source = (self.description, self.assets);
                let lights = surfaces.iter().map(|(light, _)| *light).collect();
                shapes.extend(surfaces.into_iter().map(|(_, surface)| surface));
                Arc::new(Shapes::place(shapes, &instances, lights, source, self.out)?)
            }
        };
        let mut scene = Scene {
            shapes,
            slots,
            materials,
            textures: textures.into_iter().map(|t| t.value).collect(),
            lights,
            cameras,
            emitters: Emitters::default(),
            specular: SpecularSpheres::default(),
            cut_outs: Vec::new(),
            has_mixes: false,
        };
        scene.emitters = Emitters::of(&scene, self.solid_lights);
        scene.specular = SpecularSpheres::of(&scene);
        scene.has_mixes = scene.materials.iter().any(|m| matches!(m.value, AnyMaterial::Mix(_)));
        scene.cut_outs = scene.find_cut_outs();
        self.complete(&mut scene, aspect);
        (!self.out.has_errors()).then(|| Arc::new(scene))
    }

    /// Builds every node of a role. After a fault the list is short, and `out` has an error.
    fn all<T>(
        &mut self,
        role: Role,
        build: impl Fn(&Node, &mut Context<'_, '_>) -> Option<T>,
    ) -> Vec<Named<T>> {
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

    /// The materials of the slots of each shape; for a shape without any the default material, which follows all
    /// others. `None` if a shape names a material that is not there.
    fn slots(&self) -> Option<Vec<Vec<u32>>> {
        let description = self.description;
        let default = description.of_role(Role::Material).count() as u32;
        let of_shape = |(id, node): (NodeId, &Node)| {
            if let Some(name) = material_of(node) {
                return Some(vec![description.rank(description.find(Role::Material, name)?)]);
            }
            let slots = self.assets.slot_materials(id).iter();
            let slots: Vec<u32> = slots.map(|material| description.rank(*material)).collect();
            Some(if slots.is_empty() { vec![default] } else { slots })
        };
        description.of_role(Role::Shape).map(of_shape).collect()
    }

    /// Gives a scene without a camera one, and says what is missing.
    fn complete(&mut self, scene: &mut Scene, aspect: f32) {
        if scene.cameras.is_empty() {
            let mut description = SceneDescription::default();
            let bounds = if scene.bounds().is_empty() { unit_box() } else { scene.bounds() };
            let camera = auto::camera_for(&bounds, aspect);
            if !auto::is_in_range(&camera) {
                self.tell_farthest(scene);
                return;
            }
            let id = description.add(camera);
            let mut context =
                Context { description: &description, assets: self.assets, out: self.out, node: id };
            if let Some(value) = AnyCamera::build(description.node(id), &mut context) {
                scene.cameras.push(Named { name: String::new(), value });
            }
            let message = "the scene has no camera: looking at all of it from the front right";
            self.out.advice("scene::no-camera", Span::NONE, message).help =
                "add [camera.main] with type = \"perspective\", position and target".to_owned();
        }
        if scene.shapes.own() == 0 {
            let message = "the scene has no shape: the image is background";
            self.out.warning("scene::no-shape", Span::NONE, message).help =
                "add [shape.NAME] with type = \"sphere\", \"quad\", \"disk\" or \"mesh\"".to_owned();
        } else if scene.lights.is_empty() && !scene.has_emissive_shapes() {
            let message = "the scene has no light: only ambient light is seen";
            self.out.warning("scene::no-light", Span::NONE, message).help =
                "add [light.NAME] with type = \"point\" and position".to_owned();
        }
    }
}

impl Builder<'_, '_> {
    /// Names the shape that reaches farthest: around all of them there is no place for a camera.
    fn tell_farthest(&mut self, scene: &Scene) {
        let reach = |b: &Bounds3| b.min.abs().max(b.max.abs()).max_element();
        let shapes = self.description.of_role(Role::Shape).zip(&scene.shapes.list);
        let bounds = shapes.map(|((_, node), shape)| (node, shape.value.bounds()));
        let Some((node, bounds)) = bounds.max_by(|a, b| reach(&a.1).total_cmp(&reach(&b.1))) else { return };
        let file = match node.param("file").map(|p| &p.value) {
            Some(penombre_scene::Value { kind: ValueKind::String(file), .. }) => format!(" (`{file}`)"),
            _ => String::new(),
        };
        let message = format!("`{}`{file}: {}", node.path(), auto::too_far(&bounds));
        self.out.error("scene::too-far", node.span, message).help = auto::TOO_FAR_HELP.to_owned();
    }
}

/// The surfaces of lights with an extent: index of the light and its shape.
fn surfaces_of(lights: &[Named<AnyLight>]) -> Vec<(u32, Named<AnyShape>)> {
    let surface = |(light, index): (&Named<AnyLight>, u32)| {
        Some((index, Named { name: light.name.clone(), value: light.value.surface()? }))
    };
    lights.iter().zip(0..).filter_map(surface).collect()
}

fn unit_box() -> Bounds3 {
    Bounds3 { min: penombre_math::Vec3::NEG_ONE, max: penombre_math::Vec3::ONE }
}

/// Name of the material that a shape's node names.
fn material_of(node: &Node) -> Option<&str> {
    match &node.param("material")?.value.kind {
        ValueKind::String(name) => Some(name),
        _ => None,
    }
}
