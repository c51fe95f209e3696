//! From command-line arguments to a plan.

use crate::args::{SceneArgs, Verbosity};
use crate::loading::Loading;
use crate::memory::{Budget, Use};
use crate::{report, terminal};
use penombre::Plan;
use penombre::integrator::{Classic, PathTracer};
use penombre::render::MemoryEstimate;
use penombre_scene::load::{LoadOptions, Loaded, load_observed};
use penombre_scene::{Diagnostics, Node, Role, SceneDescription, Span, Value, ValueKind, harmless};
use std::time::Instant;

/// A loaded scene, ready to run.
pub struct Prepared {
    /// The scene as read, the command line's changes included.
    pub loaded: Loaded,
    /// What is to be rendered.
    pub plan: Plan,
    /// Seconds spent on reading and decoding files.
    pub load_s: f64,
    /// Seconds spent on building.
    pub build_s: f64,
    /// What it takes to render it.
    pub memory: MemoryEstimate,
}

/// A scene as read, and its plan if it has no fault.
pub struct Examined {
    /// The scene as read, the command line's changes included.
    pub loaded: Loaded,
    /// What is to be rendered.
    pub plan: Option<Plan>,
    /// Seconds spent on reading and decoding files.
    pub load_s: f64,
    /// Seconds spent on building.
    pub build_s: f64,
    /// What it takes to render it.
    pub memory: MemoryEstimate,
}

/// Loads and builds. All faults are printed to standard error; `None` if any of them is an error.
pub fn prepare(args: &SceneArgs, usage: Use<'_>, verbosity: &Verbosity) -> Option<Prepared> {
    let Examined { mut loaded, plan, load_s, build_s, memory } = examine(args, usage, verbosity);
    loaded.diagnostics.sort_by_place();
    report::print(&loaded.diagnostics, &loaded.sources, verbosity.quiet);
    let errors = loaded.diagnostics.count(penombre_scene::Severity::Error);
    if errors > 0 {
        let plural = if errors == 1 { "" } else { "s" };
        let scene = harmless(&args.scene);
        terminal::err(&format!("{scene}: {errors} error{plural}, nothing was rendered"));
        return None;
    }
    plan.map(|plan| Prepared { loaded, plan, load_s, build_s, memory })
}

/// Loads and builds; the faults are in the result. Nothing is decoded or built that would take too much memory.
pub fn examine(args: &SceneArgs, usage: Use<'_>, verbosity: &Verbosity) -> Examined {
    let begin = Instant::now();
    let budget = Budget::new(args.memory_limit, usage);
    let mut loaded = load(args, &budget, verbosity);
    let load_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let mut plan = None;
    if loaded.readable {
        apply(args, &mut loaded.description, &mut loaded.diagnostics);
        let broken = loaded.diagnostics.has_errors();
        // The sizes are exact now. What was refused before they were known is not refused twice.
        let refused = if broken { None } else { budget.check(&loaded.description, &loaded.assets.memory()) };
        match refused {
            Some(fault) => loaded.diagnostics.push(fault),
            None => plan = Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics),
        }
        plan = plan.filter(|_| !broken);
    }
    let memory = budget.estimate(&loaded.description, &loaded.assets.memory(), true);
    Examined { loaded, plan, load_s, build_s: begin.elapsed().as_secs_f64(), memory }
}

fn load(args: &SceneArgs, budget: &Budget<'_>, verbosity: &Verbosity) -> Loaded {
    // The camera of a bare mesh is fitted to the picture, so its size must be known while loading.
    let size = args.size.map(|[w, h]| format!("render.size=[{w}, {h}]"));
    let sets = args.set.iter().cloned().chain(size).collect();
    let options = LoadOptions { asset_roots: args.asset_root.clone(), sets };
    let loading = Loading::new(verbosity, budget);
    let loaded = load_observed(&args.scene, &options, &loading);
    loading.finish();
    loaded
}

/// Writes the options that stand for scene parameters into the description.
fn apply(args: &SceneArgs, description: &mut SceneDescription, out: &mut Diagnostics) {
    let mut render = |name: &str, value: Value| node(description, Role::Render, "").set(name, value);
    if let Some(spp) = args.spp {
        render("spp", i64::from(spp).into());
    }
    if let Some(seed) = args.seed {
        render("seed", (seed as i64).into());
    }
    if let Some(name) = &args.integrator {
        render("integrator", name.as_str().into());
    }
    if let Some(depth) = args.max_depth {
        render("max_depth", i64::from(depth).into());
    }
    if args.disable_pixel_jitter {
        render("pixel_jitter", false.into());
    }
    if let Some(wanted) = &args.camera {
        choose_camera(wanted, description, out);
    }
    let mut classic =
        |name: &str, value: Value| node(description, Role::Integrator, "classic").set(name, value);
    if let Some(phase) = args.phase {
        classic("phase", i64::from(phase).into());
    }
    if args.hard_shadows {
        classic("hard_shadows", true.into());
    }
    refuse_classic_options(args, description, out);
}

/// Reports options of the course's integrator where another one renders: they would do nothing.
fn refuse_classic_options(args: &SceneArgs, description: &SceneDescription, out: &mut Diagnostics) {
    let render = description.of_role(Role::Render).next().map(|(_, node)| node);
    let name = match render.and_then(|n| n.param("integrator")).map(|p| &p.value.kind) {
        Some(ValueKind::String(name)) => name.as_str(),
        Some(_) => return,
        None => PathTracer::NAME,
    };
    if name == Classic::NAME {
        return;
    }
    for (option, given) in [("--phase", args.phase.is_some()), ("--hard-shadows", args.hard_shadows)] {
        if given {
            let message = format!("`{option}` is an option of the integrator classic, and this is `{name}`");
            out.error("scene::classic-only", Span::NONE, message).help =
                "add --integrator classic".to_owned();
        }
    }
}

/// The node of that role and name, made if it is not there.
fn node<'a>(description: &'a mut SceneDescription, role: Role, name: &str) -> &'a mut Node {
    let id = description.find(role, name).unwrap_or_else(|| {
        let type_name = if name.is_empty() { role.name() } else { name };
        description.add(Node::new(role, type_name, name))
    });
    description.node_mut(id)
}

/// `--camera`: a name, or a number from 0.
fn choose_camera(wanted: &str, description: &mut SceneDescription, out: &mut Diagnostics) {
    let names: Vec<String> = description.of_role(Role::Camera).map(|(_, n)| n.name.clone()).collect();
    let by_number = wanted.parse::<usize>().ok().and_then(|i| names.get(i));
    match names.iter().find(|n| *n == wanted).or(by_number) {
        Some(name) => node(description, Role::Render, "").set("camera", name.as_str().into()),
        None => {
            let message = format!("`--camera {wanted}`: the scene has no such camera");
            let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            out.error("scene::camera", Span::NONE, message).help = format!("cameras of the scene: {known}");
        }
    }
}
