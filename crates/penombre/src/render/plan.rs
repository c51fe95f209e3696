//! From a description to everything that a render needs.

use super::{Job, RenderSettings};
use crate::integrator::{AmbientOcclusion, AnyIntegrator, Classic, Direct, FeatureImage, PathTracer, TYPES};
use crate::registry::Context;
use crate::scene::Scene;
use penombre_image::ToneCurve;
use penombre_scene::assets::Assets;
use penombre_scene::{Diagnostics, NodeId, ParamSpec, Role, SceneDescription};
use std::sync::Arc;

/// Roles whose nodes have no types, with their parameters.
pub const NODE_SCHEMAS: &[(Role, &[ParamSpec])] = &[(Role::Render, RenderSettings::SCHEMA)];

/// Key of the samples per pixel in [`Plan::provenance`].
pub const SPP_ENTRY: &str = "penombre:spp";

/// A scene, an integrator and a job.
#[derive(Debug)]
pub struct Plan {
    /// The scene.
    pub scene: Arc<Scene>,
    /// How light is computed.
    pub integrator: Box<dyn AnyIntegrator>,
    /// What is rendered.
    pub job: Job,
}

impl Plan {
    /// Builds all that a description asks for. *All* faults go to `out`; `None` if any of them is an error.
    pub fn new(description: &SceneDescription, assets: &Assets, out: &mut Diagnostics) -> Option<Self> {
        Self::with(description, assets, out, |options, out| Scene::build(description, assets, options, out))
    }

    /// The same, faster where the shapes of `previous` are the description's: see [`Scene::update`].
    pub fn update(
        previous: &Scene,
        description: &SceneDescription,
        assets: &Assets,
        out: &mut Diagnostics,
    ) -> Option<Self> {
        let scene =
            |options, out: &mut Diagnostics| Scene::update(previous, description, assets, options, out);
        Self::with(description, assets, out, scene)
    }

    /// Builds all but the scene, which comes from `scene`, given width over height of the image and whether lights are
    /// surfaces.
    fn with(
        description: &SceneDescription,
        assets: &Assets,
        out: &mut Diagnostics,
        scene: impl FnOnce((f32, bool), &mut Diagnostics) -> Option<Arc<Scene>>,
    ) -> Option<Self> {
        let mut context = Context { description, assets, out, node: NodeId(0) };
        let settings = RenderSettings::build(&mut context);
        check_size(&settings, context.out);
        let integrator = integrator(&settings, &mut context);
        let aspect = settings.size[0] as f32 / settings.size[1] as f32;
        let scene = scene((aspect, settings.integrator != Classic::NAME), out);
        let (scene, integrator) = (scene?, integrator?);
        let job = settings.job();
        (!out.has_errors()).then_some(Self { scene, integrator, job })
    }

    /// What files of the plan's image say of their making: key and value. `name`: what people call the scene;
    /// `scene_digest`: see [`SceneDescription::digest`]; `command`: the one that renders the same image.
    pub fn provenance(&self, name: &str, scene_digest: String, command: String) -> Vec<(String, String)> {
        let entry = |key: &str, value: String| (key.to_owned(), value);
        vec![
            entry("Software", format!("penombre {}", env!("CARGO_PKG_VERSION"))),
            entry("penombre:scene", name.to_owned()),
            entry("penombre:scene-digest", scene_digest),
            entry("penombre:command", command),
            entry("penombre:integrator", self.integrator.name().to_owned()),
            entry(SPP_ENTRY, self.job.spp.to_string()),
            entry("penombre:seed", self.job.seed.to_string()),
        ]
    }
}

/// The tone curve of 8-bit images unless told otherwise. The raw curve is the course's, and `classic` is the course's
/// integrator; what others compute is light.
pub fn default_tone(integrator: &str) -> ToneCurve {
    if integrator == Classic::NAME { ToneCurve::Raw } else { ToneCurve::Srgb }
}

/// Image files hold no more pixels than this.
fn check_size(settings: &RenderSettings, out: &mut Diagnostics) {
    let [w, h] = settings.size.map(u64::from);
    if w * h > penombre_image::MAX_PIXELS {
        let message = format!(
            "an image of {w}×{h} pixels is asked for, expected at most {} pixels",
            penombre_image::MAX_PIXELS
        );
        out.error("scene::out-of-range", settings.size_span, message).help =
            "render it in parts, each with a camera of its own, or smaller".to_owned();
    }
}

/// Builds the integrator that the settings name, and checks the parameters of all others.
fn integrator(settings: &RenderSettings, context: &mut Context<'_, '_>) -> Option<Box<dyn AnyIntegrator>> {
    let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
    let known = format!("integrators of this version: {}", names.join(", "));
    let help = |wanted: &str| match penombre_scene::nearest(wanted, &names) {
        Some(near) => format!("did you mean `{near}`? {known}"),
        None => known.clone(),
    };
    for (_, node) in context.description.of_role(Role::Integrator) {
        match TYPES.iter().find(|(name, _)| *name == node.name) {
            // The one that is built checks its own.
            Some((name, _)) if *name == settings.integrator => {}
            Some((_, schema)) => drop(context.decode(node, schema)),
            None => {
                let message = format!(
                    "`{}` sets parameters of an integrator that this version does not have",
                    node.path()
                );
                context.out.error("scene::unknown-integrator", node.span, message).help = help(&node.name);
            }
        }
    }
    if !names.contains(&settings.integrator.as_str()) {
        let message = format!("unknown integrator `{}`", settings.integrator);
        let fault = context.out.error("scene::unknown-integrator", settings.integrator_span, message);
        fault.help = help(&settings.integrator);
        return None;
    }
    Some(match settings.integrator.as_str() {
        PathTracer::NAME => PathTracer::build(context, settings.max_depth),
        Direct::NAME => Direct::build(context, settings.max_depth),
        AmbientOcclusion::NAME => AmbientOcclusion::build(context),
        FeatureImage::NAME => FeatureImage::build(context, settings.camera),
        _ => Classic::build(context, settings.max_depth),
    })
}
