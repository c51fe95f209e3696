//! What the tests of several rooms share.

use crate::Plan;
use penombre_scene::assets::Assets;
use penombre_scene::{Diagnostics, Node, NodeId, Role, SceneDescription, Value};

/// Builds a description, which must be without fault.
pub fn plan(description: &SceneDescription) -> Plan {
    let mut out = Diagnostics::default();
    let plan = Plan::new(description, &Assets::default(), &mut out);
    assert!(!out.has_errors(), "{out:?}");
    plan.unwrap()
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
