//! The scene that is shown, and the command that gives the same image.
//!
//! What the window changes (camera, size, panel) is a list of edits. The same list is applied to the
//! description that is rendered and written as options of `penombre render`, so the two cannot go apart.

mod edits;
mod loading;
mod shell;

use crate::camera::{CourseCamera, Lens, LookAt};
use crate::preview::{Limits, PreviewMesh};
use edits::Edit;
use penombre::camera::AnyCamera;
use penombre::integrator::Classic;
use penombre::render::default_tone;
use penombre::{Plan, Scene};
use penombre_image::ToneCurve;
use penombre_math::{Bounds3, Vec3};
use penombre_scene::load::{LoadOptions, Loaded, load};
use penombre_scene::{Diagnostics, Node, Params, Role, SceneDescription, auto};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use loading::Loading;

/// What is to be loaded, as the command names it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// A built-in scene's name or a file.
    pub scene: String,
    /// Further folders below which files may be read.
    pub asset_roots: Vec<PathBuf>,
    /// Changes of parameters, `PATH=VALUE`.
    pub sets: Vec<String>,
}

impl Source {
    /// A built-in scene.
    pub fn builtin(name: &str) -> Self {
        Self { scene: name.to_owned(), ..Self::default() }
    }

    /// A file, also if it is called like a built-in scene or an option of the command.
    ///
    /// # Errors
    ///
    /// A text for a person if the path is no Unicode.
    pub fn file(path: &std::path::Path) -> Result<Self, String> {
        let Some(text) = path.to_str() else {
            return Err(format!(
                "the name of {} is no Unicode: rename the file or its folder",
                path.display()
            ));
        };
        let doubtful = text.starts_with('-') || penombre_scene::builtin::NAMES.contains(&text);
        Ok(Self { scene: if doubtful { format!("./{text}") } else { text.to_owned() }, ..Self::default() })
    }
}

/// What the panel changes; `None`: as in the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Phase of the course, 1 to 4.
    pub phase: Option<u8>,
    /// Area lights act as points.
    pub hard_shadows: Option<bool>,
    /// Name of the integrator.
    pub integrator: Option<String>,
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Shadow rays per point, of all lights that have an area.
    pub shadow_samples: Option<u32>,
    /// Brightness of what is shown and of 8-bit files, in powers of two.
    pub exposure: f32,
    /// Tone curve of what is shown and of 8-bit files.
    pub tone: Option<ToneCurve>,
}

/// What is to be rendered of a session's scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Width and height of the image, pixels.
    pub size: [u32; 2],
    /// Where the camera stands.
    pub camera: CourseCamera,
    /// The panel.
    pub settings: Settings,
}

/// The values that the scene itself has, for the panel.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneValues {
    /// Width and height of the image, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub spp: u32,
    /// Name of the integrator.
    pub integrator: String,
    /// Phase of the course.
    pub phase: u8,
    /// Area lights act as points.
    pub hard_shadows: bool,
    /// Shadow rays per point of the first light that has an area.
    pub shadow_samples: Option<u32>,
}

/// A loaded scene. It does not change: edits make plans from it, which share its shapes.
#[derive(Clone, Debug)]
pub struct Session {
    source: Source,
    loaded: Arc<Loaded>,
    scene: Arc<Scene>,
    preview: Arc<PreviewMesh>,
    values: SceneValues,
    /// Name of the camera's node; `None` if the scene has none.
    camera_name: Option<String>,
    start: CourseCamera,
    warnings: String,
    resized: Arc<Mutex<Option<Resized>>>,
}

/// A bare mesh at a size other than that at which it was loaded, kept from one plan to the next.
#[derive(Debug)]
struct Resized {
    /// Width and height of the image, pixels.
    size: [u32; 2],
    /// Before the edits.
    description: SceneDescription,
    /// The latest that was built, perhaps for another size.
    scene: Arc<Scene>,
}

impl Session {
    /// Loads a scene and builds it, with its preview. `size`: of the window, pixels; `None`: what the scene says.
    ///
    /// # Errors
    ///
    /// All faults with their places, as text for a person.
    pub fn load(source: &Source, size: Option<[u32; 2]>, limits: &Limits) -> Result<Self, String> {
        // As for the command, the size is known while loading: the camera of a bare mesh is fitted to it.
        let edit = size.map(Edit::Size);
        let sets = source.sets.iter().cloned().chain(edit.iter().filter_map(Edit::early)).collect();
        let mut loaded = load(&source.scene, &LoadOptions { asset_roots: source.asset_roots.clone(), sets });
        let plan = if loaded.readable {
            Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics)
        } else {
            None
        };
        loaded.diagnostics.sort_by_place();
        let text = penombre_scene::report::render_all_plain(&loaded.diagnostics, &loaded.sources);
        let Some(plan) = plan.filter(|_| !loaded.diagnostics.has_errors()) else { return Err(text) };
        let scene = plan.scene.clone();
        let name = scene.cameras()[plan.job.camera as usize].name.clone();
        let camera_name = (!name.is_empty()).then_some(name);
        let aspect = plan.job.size[0] as f32 / plan.job.size[1] as f32;
        let look = look_at_of(&loaded.description, camera_name.as_deref(), &scene.bounds(), aspect);
        Ok(Self {
            source: source.clone(),
            preview: Arc::new(PreviewMesh::new(&scene, limits)),
            values: values(&loaded.description, &plan),
            start: CourseCamera::of_look_at(&look, &scene.bounds()),
            loaded: Arc::new(loaded),
            scene,
            camera_name,
            warnings: text,
            resized: Arc::default(),
        })
    }

    /// What was loaded.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// What people call the scene.
    pub fn name(&self) -> &str {
        &self.loaded.name
    }

    /// Warnings and advice about the scene, as text; empty for none.
    pub fn warnings(&self) -> &str {
        &self.warnings
    }

    /// The scene as loaded.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// What a rasteriser draws.
    pub fn preview(&self) -> &Arc<PreviewMesh> {
        &self.preview
    }

    /// The values that the scene itself has.
    pub fn values(&self) -> &SceneValues {
        &self.values
    }

    /// The scene's own camera.
    pub fn start_camera(&self) -> CourseCamera {
        self.start
    }

    /// A box around all shapes, metres.
    pub fn bounds(&self) -> Bounds3 {
        self.scene.bounds()
    }

    /// The scene as loaded, at its own size.
    pub fn setup(&self) -> Setup {
        Setup { size: self.values.size, camera: self.start, settings: Settings::default() }
    }

    /// The tone curve that shows images: the panel's, or the one that the command would take.
    pub fn tone(&self, settings: &Settings) -> ToneCurve {
        let integrator = settings.integrator.as_deref().unwrap_or(&self.values.integrator);
        settings.tone.unwrap_or_else(|| default_tone(integrator))
    }

    /// The scene with all edits, ready to be rendered: what the command of [`Session::command_line`] renders. No edit
    /// touches a shape, so it takes a moment only; but the ground of a bare mesh changes with the size, and the first
    /// plan of each size takes as long as building the scene.
    ///
    /// # Errors
    ///
    /// All faults, as text for a person.
    pub fn plan(&self, setup: &Setup) -> Result<Plan, String> {
        self.described_plan(setup).map(|(plan, _)| plan)
    }

    /// The plan, and the description that it was made from.
    fn described_plan(&self, setup: &Setup) -> Result<(Plan, SceneDescription), String> {
        let (mut description, previous) = self.base(setup.size);
        let mut sources = self.loaded.sources.clone();
        let mut faults = Diagnostics::default();
        if self.camera_name.is_none() && self.camera_is_set(setup) {
            description.add(self.camera_node(setup));
        }
        for edit in self.edits(setup) {
            edit.apply(&mut description, &mut sources, &mut faults);
        }
        let plan = Plan::update(&previous, &description, &self.loaded.assets, &mut faults);
        let plan = plan
            .filter(|_| !faults.has_errors())
            .ok_or_else(|| penombre_scene::report::render_all_plain(&faults, &sources))?;
        if let Some(resized) = self.resized().as_mut().filter(|resized| resized.size == setup.size) {
            resized.scene = plan.scene.clone();
        }
        Ok((plan, description))
    }

    /// What files of the image say of their making; `spp`: the samples per pixel that it has.
    pub fn provenance(&self, setup: &Setup, spp: f64) -> Vec<(String, String)> {
        let Ok((plan, description)) = self.described_plan(setup) else { return Vec::new() };
        let digest = description.digest(&self.loaded.assets);
        // Where no command gives the image, the reason is as good an answer.
        let command = self.command_line(setup).unwrap_or_else(|reason| reason);
        let mut entries = plan.provenance(self.name(), digest, command);
        for (_, value) in entries.iter_mut().filter(|(key, _)| key == penombre::render::SPP_ENTRY) {
            *value = spp.to_string();
        }
        entries
    }

    /// The command that renders the same image, bit for bit; quoted for a POSIX shell. Where it writes is left to
    /// the command.
    ///
    /// # Errors
    ///
    /// If no options can say it: a scene file without a camera, whose camera was moved. The text for a person has the
    /// lines that the file needs.
    pub fn command_line(&self, setup: &Setup) -> Result<String, String> {
        if self.camera_name.is_none() && self.camera_is_set(setup) {
            return Err(format!(
                "the scene has no camera that the command could move: add these lines to {}\n{}",
                self.source.scene,
                edits::toml(&self.camera_node(setup))
            ));
        }
        let mut words = vec!["penombre".to_owned(), "render".to_owned(), self.source.scene.clone()];
        for root in &self.source.asset_roots {
            words.extend(["--asset-root".to_owned(), root.display().to_string()]);
        }
        for set in &self.source.sets {
            words.extend(["--set".to_owned(), set.clone()]);
        }
        for edit in self.edits(setup) {
            words.extend(edit.options());
        }
        if setup.settings.exposure != 0.0 {
            words.push(format!("--exposure={}", setup.settings.exposure));
        }
        if let Some(tone) = setup.settings.tone {
            words.extend(["--tone".to_owned(), tone.to_string()]);
        }
        Ok(words.iter().map(|w| shell::quote(w)).collect::<Vec<_>>().join(" "))
    }

    /// The description before the edits, and the scene whose shapes most likely are its own.
    fn base(&self, size: [u32; 2]) -> (SceneDescription, Arc<Scene>) {
        if !self.loaded.bare_mesh || size == self.values.size {
            return (self.loaded.description.clone(), self.scene.clone());
        }
        let mut resized = self.resized();
        match &*resized {
            Some(known) if known.size == size => (known.description.clone(), known.scene.clone()),
            _ => {
                let (description, scene) = (self.refitted(size), self.scene.clone());
                *resized = Some(Resized { size, description: description.clone(), scene: scene.clone() });
                (description, scene)
            }
        }
    }

    /// What is in it is whole at every moment, so a panic elsewhere spoils nothing.
    fn resized(&self) -> MutexGuard<'_, Option<Resized>> {
        self.resized.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The description of a bare mesh at another size: its surroundings depend on the size of the picture, and are
    /// made anew, as loading would make them.
    fn refitted(&self, size: [u32; 2]) -> SceneDescription {
        let loaded = &self.loaded.description;
        let own = |node: &Node| node.role != Role::Camera;
        let mut description = SceneDescription::default();
        // The camera is the first node that was added, and all after it were added too.
        for (id, _) in loaded.iter().take_while(|(_, node)| own(node)) {
            description.add_shared(loaded.shared(id).clone());
        }
        Edit::Size(size).apply(&mut description, &mut Default::default(), &mut Diagnostics::default());
        // Where there is no place for a camera, building the scene says so.
        let _ = auto::complete(&mut description, &self.loaded.assets);
        // Changes of nodes that have only now been added; the others are applied already, and again is harmless.
        for set in &self.source.sets {
            let edit = Edit::Set(set.clone());
            edit.apply(&mut description, &mut Default::default(), &mut Diagnostics::default());
        }
        description
    }

    /// True if the image's camera is not the one that the command takes by itself: it was moved, or the command would
    /// fit it to another size of the picture.
    fn camera_is_set(&self, setup: &Setup) -> bool {
        let fitted = self.loaded.bare_mesh || self.camera_name.is_none();
        setup.camera != self.start || (fitted && setup.size != self.values.size)
    }

    fn edits(&self, setup: &Setup) -> Vec<Edit> {
        let settings = &setup.settings;
        let mut edits = vec![Edit::Size(setup.size)];
        edits.extend(settings.spp.map(Edit::Spp));
        edits.extend(settings.integrator.clone().map(Edit::Integrator));
        // The command refuses them with another integrator, where they do nothing.
        if settings.integrator.as_ref().unwrap_or(&self.values.integrator) == Classic::NAME {
            edits.extend(settings.phase.map(Edit::Phase));
            edits.extend(settings.hard_shadows.map(Edit::HardShadows));
        }
        if let Some(samples) = settings.shadow_samples {
            let lights = self.loaded.description.of_role(Role::Light).map(|(_, node)| node);
            let areas = lights.filter(|node| has_area(node));
            edits.extend(areas.map(|n| Edit::set(n, "shadow_samples", i64::from(samples).into())));
        }
        if let Some(name) = &self.camera_name
            && self.camera_is_set(setup)
        {
            let id = self.loaded.description.find(Role::Camera, name);
            let node = id.map(|id| self.loaded.description.node(id));
            for param in self.camera_node(setup).params {
                // Lens and planes stay the scene's own.
                if ["position", "target", "up", "height"].contains(&param.name.as_str()) {
                    edits.extend(node.map(|n| Edit::set(n, &param.name, param.value.clone())));
                }
            }
        }
        edits
    }

    /// The camera as a node.
    fn camera_node(&self, setup: &Setup) -> Node {
        let look = setup.camera.look_at();
        let (type_name, lens, value) = match look.lens {
            Lens::Perspective { fov } => ("perspective", "fov", fov),
            Lens::Orthographic { height } => ("orthographic", "height", height),
        };
        let mut node = Node::new(Role::Camera, type_name, self.camera_name.as_deref().unwrap_or("main"))
            .with("position", edits::short(look.position.as_vec3()))
            .with("target", edits::short(look.target.as_vec3()))
            .with("up", edits::short(look.up.as_vec3()))
            .with(lens, value)
            .with("near", look.near);
        if look.far.is_finite() {
            node = node.with("far", look.far);
        }
        node
    }
}

/// True for lights of a type that sends several shadow rays.
fn has_area(node: &Node) -> bool {
    let types = penombre::light::AnyLight::TYPES;
    let found = types.iter().find(|t| t.name == node.type_name || t.aliases.contains(&&*node.type_name));
    found.is_some_and(|t| t.schema.iter().any(|p| p.name == "shadow_samples"))
}

/// The camera of that name, with the numbers that stand in the file, or the one that a scene without a camera gets. The description was built: it is sound.
fn look_at_of(description: &SceneDescription, name: Option<&str>, bounds: &Bounds3, aspect: f32) -> LookAt {
    let cube = Bounds3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let named = name.and_then(|name| description.find(Role::Camera, name));
    let node = match named {
        Some(id) => description.node(id).clone(),
        None => auto::camera_for(if bounds.is_empty() { &cube } else { bounds }, aspect),
    };
    let is = |t: &&penombre::TypeInfo| t.name == node.type_name || t.aliases.contains(&&*node.type_name);
    let info = AnyCamera::TYPES.iter().find(is).unwrap_or(&AnyCamera::TYPES[0]);
    let p = Params::decode(&node, info.schema, description, &mut Diagnostics::default());
    LookAt {
        position: edits::wide(p.vec3("position")),
        target: edits::wide(p.vec3("target")),
        up: edits::wide(p.vec3("up")),
        lens: if info.schema.iter().any(|s| s.name == "height") {
            Lens::Orthographic { height: p.f64("height") }
        } else {
            Lens::Perspective { fov: p.f64("fov") }
        },
        near: p.f64("near"),
        far: p.f64("far"),
    }
}

fn values(description: &SceneDescription, plan: &Plan) -> SceneValues {
    let default = Node::new(Role::Integrator, Classic::NAME, Classic::NAME);
    let classic = description.find(Role::Integrator, Classic::NAME).map(|id| description.node(id));
    let decode =
        |node: &Node| Params::decode(node, Classic::SCHEMA, description, &mut Diagnostics::default());
    let p = decode(classic.unwrap_or(&default));
    let mut samples = plan.scene.lights().iter().map(|light| light.value.shadow_samples());
    SceneValues {
        size: plan.job.size,
        spp: plan.job.spp,
        integrator: plan.integrator.name().to_owned(),
        phase: p.int("phase") as u8,
        hard_shadows: p.bool("hard_shadows"),
        shadow_samples: samples.find(|n| *n > 0),
    }
}

#[cfg(test)]
mod tests;
