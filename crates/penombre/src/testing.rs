//! What the tests of several rooms share.

use crate::Plan;
use crate::bsdf::Bsdf;
use crate::material::{AnyMaterial, PhongView};
use crate::render::{Event, Observer, Render};
use crate::scene::SurfacePoint;
use penombre_bvh::Ray;
use penombre_math::{Spectrum, Vec3};
use penombre_scene::assets::Assets;
use penombre_scene::toml::read_toml;
use penombre_scene::{Diagnostics, FileId, Node, NodeId, Role, SceneDescription, Severity, Value};
use std::ops::ControlFlow;

/// Builds a description, which must be without fault.
pub fn plan(description: &SceneDescription) -> Plan {
    let mut out = Diagnostics::default();
    let plan = Plan::new(description, &Assets::default(), &mut out);
    assert!(!out.has_errors(), "{out:?}");
    plan.unwrap()
}

/// Renders a plan on two threads.
pub fn rendered(plan: Plan) -> Render {
    struct Quiet;
    impl Observer for Quiet {
        fn on(&self, _: Event<'_>) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
    }
    let mut render = Render::new(plan);
    render.run(2, &Quiet);
    render
}

/// A built-in scene.
pub fn builtin(name: &str) -> SceneDescription {
    penombre_scene::builtin::builtin(name).unwrap()
}

/// Sets a parameter of a node, made if it is not there.
pub fn set(description: &mut SceneDescription, role: Role, name: &str, param: &str, value: impl Into<Value>) {
    let id: NodeId = description.find(role, name).unwrap_or_else(|| {
        let type_name = if name.is_empty() { role.name() } else { name };
        description.add(Node::new(role, type_name, name))
    });
    description.node_mut(id).set(param, value.into());
}

/// A built-in scene at a small size, with changes.
pub fn small(name: &str, size: i64, spp: i64) -> SceneDescription {
    let mut d = builtin(name);
    set(&mut d, Role::Render, "", "size", [size, size]);
    set(&mut d, Role::Render, "", "spp", spp);
    d
}

/// A scene in TOML, without its version, and what is to be said about it.
pub fn from_toml(text: &str) -> (Option<Plan>, Diagnostics) {
    let mut out = Diagnostics::default();
    let read = read_toml(&format!("penombre = 1\n{text}"), FileId(0), &mut out);
    (Plan::new(&read.description, &Assets::default(), &mut out), out)
}

/// The unit square in the plane z = 0, outside towards +z, of the material `it`.
pub struct Bench {
    plan: Plan,
    out: Diagnostics,
}

/// `half` is a texture of value 0.5 where u < 0.5, and 1 elsewhere.
fn bench(material: &str) -> (Option<Plan>, Diagnostics) {
    from_toml(&format!(
        "[material.it]\n{material}\n\
        [texture.half]\ntype = \"checker\"\nscale = [2, 1]\na = [0.5, 0.5, 0.5]\nb = [1, 1, 1]\n\
        [shape.square]\ntype = \"quad\"\norigin = [0, 0, 0]\nsides = [[1, 0, 0], [0, 1, 0]]\nmaterial = \"it\""
    ))
}

/// Message and help of the first error of a scene with this material `it`.
pub fn fault(material: &str) -> (String, String) {
    let (plan, out) = bench(material);
    assert!(plan.is_none());
    let fault = out.iter().find(|d| d.severity == Severity::Error).unwrap();
    assert!(fault.span.len > 0, "{fault:?}");
    (fault.message.clone(), fault.help.clone())
}

impl Bench {
    /// With the parameters of the material `it` in TOML; more tables may follow.
    pub fn new(material: &str) -> Self {
        let (plan, out) = bench(material);
        Self { plan: plan.unwrap_or_else(|| panic!("{material}: {out:?}")), out }
    }

    /// The material.
    pub fn material(&self) -> &AnyMaterial {
        &self.plan.scene.materials()[0].value
    }

    /// Messages that are not errors.
    pub fn warnings(&self) -> Vec<String> {
        self.out.iter().map(|d| d.message.clone()).collect()
    }

    /// The surface at u, seen from the outside or the inside.
    fn at(&self, u: f32, outside: bool) -> SurfacePoint {
        let side = if outside { 1.0 } else { -1.0 };
        let ray = Ray::new(Vec3::new(u, 0.25, side), Vec3::Z * -side, 0.0, f32::INFINITY);
        let hit = penombre_bvh::Hit { t: 1.0, u, v: 0.25, geometry: 0, prim: 0, ..penombre_bvh::Hit::MISS };
        self.plan.scene.surface(&ray, &hit).unwrap()
    }

    /// How the middle of its left half scatters.
    pub fn bsdf(&self, outside: bool) -> Bsdf {
        self.plan.scene.bsdf(&self.at(0.25, outside), 0.0)
    }

    /// How its outside scatters at u.
    pub fn bsdf_at(&self, u: f32) -> Bsdf {
        self.chosen(u, 0.0)
    }

    /// How its outside scatters at u, by a number that chooses.
    pub fn chosen(&self, u: f32, choice: f32) -> Bsdf {
        self.plan.scene.bsdf(&self.at(u, true), choice)
    }

    /// What it emits at u.
    pub fn emitted(&self, u: f32, outside: bool) -> Spectrum {
        self.plan.scene.emitted(&self.at(u, outside))
    }

    /// Share of it that is there at u.
    pub fn opacity(&self, u: f32) -> f32 {
        let at = self.at(u, true);
        let ray = Ray::new(at.p + Vec3::Z, -Vec3::Z, 0.0, f32::INFINITY);
        let hit = penombre_bvh::Hit { t: 1.0, u, v: 0.25, geometry: 0, prim: 0, ..penombre_bvh::Hit::MISS };
        self.plan.scene.opacity(&ray, &hit)
    }

    /// The middle of its left half in Phong's terms.
    pub fn view(&self, outside: bool) -> PhongView {
        self.plan.scene.phong_view(&self.at(0.25, outside))
    }
}
