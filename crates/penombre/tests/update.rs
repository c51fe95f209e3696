//! Scenes that take over the shapes of another are those of a full build, to the last bit.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre::{Event, Observer, Plan, Render};
use penombre_scene::load::{LoadOptions, load};
use penombre_scene::{Assets, Diagnostics, Node, Role, SceneDescription, Value};
use std::ops::ControlFlow;

struct Quiet;

impl Observer for Quiet {
    fn on(&self, _: Event<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn digest(plan: Plan) -> String {
    let mut render = Render::new(plan);
    render.run(2, &Quiet);
    render.image().digest()
}

fn small(mut d: SceneDescription) -> SceneDescription {
    let id = d.find(Role::Render, "").unwrap_or_else(|| d.add(Node::new(Role::Render, "render", "")));
    d.node_mut(id).set("size", [24, 20].into());
    d.node_mut(id).set("spp", 2.into());
    d
}

fn builtin(name: &str) -> SceneDescription {
    small(penombre_scene::builtin::builtin(name).unwrap())
}

fn changed(
    d: &SceneDescription,
    role: Role,
    name: &str,
    param: &str,
    value: impl Into<Value>,
) -> SceneDescription {
    let mut d = d.clone();
    let id = d.find(role, name).unwrap();
    d.node_mut(id).set(param, value.into());
    d
}

/// The nodes that are wanted, in memory of their own.
fn apart(d: &SceneDescription, wanted: impl Fn(&Node) -> bool) -> SceneDescription {
    let mut copy = SceneDescription::default();
    d.iter().filter(|(_, node)| wanted(node)).for_each(|(_, node)| _ = copy.add(node.clone()));
    copy
}

/// Builds `after` anew and from the scene of `before`: the same bits and messages. True if the shapes were taken over.
fn takes_over(before: &SceneDescription, after: &SceneDescription, assets: &Assets) -> bool {
    let previous = Plan::new(before, assets, &mut Diagnostics::default()).unwrap();
    let [mut full_out, mut out] = [Diagnostics::default(), Diagnostics::default()];
    let full = Plan::new(after, assets, &mut full_out).unwrap();
    let updated = Plan::update(&previous.scene, after, assets, &mut out).unwrap();
    assert_eq!(out, full_out);
    assert!(!updated.scene.shares_shapes(&full.scene));
    let shared = updated.scene.shares_shapes(&previous.scene);
    assert_eq!(updated.scene.summary(), full.scene.summary());
    let expected = digest(full);
    assert_eq!(digest(updated), expected);
    assert_ne!(digest(previous), expected, "what was changed is to be seen");
    shared
}

/// Names of the shapes that name a material.
fn with_material(d: &SceneDescription, material: &str) -> Vec<String> {
    let named = |node: &Node| node.param("material").is_some_and(|p| p.value == material.into());
    d.of_role(Role::Shape).filter(|(_, node)| named(node)).map(|(_, node)| node.name.clone()).collect()
}

#[test]
fn all_but_the_shapes_may_change() {
    let cornell = builtin("cornell");
    let lamp = cornell.of_role(Role::Light).next().unwrap().1.name.clone();
    let material = cornell.of_role(Role::Material).next().unwrap().1.name.clone();
    assert!(!with_material(&cornell, &material).is_empty());
    let moved = changed(&cornell, Role::Camera, "main", "position", [0.5, 0.25, 5.0]);
    let lit = changed(&cornell, Role::Light, &lamp, "color", [0.25, 0.5, 1.0]);
    let painted = changed(&cornell, Role::Material, &material, "diffuse", [0.2, 0.9, 0.4]);
    let larger = changed(&cornell, Role::Render, "", "size", [31, 20]);
    for after in [&moved, &lit, &painted, &larger] {
        assert!(takes_over(&cornell, after, &Assets::default()));
        // Nodes that say the same need not be the same in memory.
        assert!(takes_over(&cornell, &apart(after, |_| true), &Assets::default()));
    }
    // The materials are at other places: each shape finds its own.
    let mut before = apart(&cornell, |node| node.role != Role::Material);
    before.add(Node::new(Role::Material, "mirror", "unused"));
    cornell.of_role(Role::Material).for_each(|(_, node)| _ = before.add(node.clone()));
    assert!(takes_over(&before, &apart(&moved, |_| true), &Assets::default()));
}

#[test]
fn changed_shapes_are_built() {
    let cornell = builtin("cornell");
    let spheres: Vec<&Node> = cornell
        .of_role(Role::Shape)
        .map(|(_, node)| node)
        .filter(|node| node.type_name == "sphere")
        .collect();
    let smaller = changed(&cornell, Role::Shape, &spheres[0].name, "radius", 0.5);
    let fewer = apart(&cornell, |node| node.name != spheres[1].name);
    let mut more = cornell.clone();
    let shift = Value::from([("translate", [0.0, 1.0, 0.0].into())]);
    more.add(
        Node::new(Role::Instance, "instance", "again")
            .with("of", spheres[0].name.as_str())
            .with("transform", vec![shift]),
    );
    for after in [&smaller, &fewer, &more] {
        assert!(!takes_over(&cornell, after, &Assets::default()));
        assert!(!takes_over(after, &cornell, &Assets::default()));
    }
    // Instances are as good as shapes.
    let moved = changed(&more, Role::Camera, "main", "position", [0.5, 0.25, 5.0]);
    assert!(takes_over(&more, &moved, &Assets::default()));
    let elsewhere = Value::from([("translate", [0.0, -1.0, 0.5].into())]);
    let elsewhere = changed(&more, Role::Instance, "again", "transform", vec![elsewhere]);
    assert!(!takes_over(&more, &elsewhere, &Assets::default()));
    // A name alone changes no bit, but is told by inspectors.
    let mut renamed = cornell.clone();
    renamed.node_mut(cornell.find(Role::Shape, &spheres[0].name).unwrap()).name = "ball".to_owned();
    let previous = Plan::new(&cornell, &Assets::default(), &mut Diagnostics::default()).unwrap();
    let plan =
        Plan::update(&previous.scene, &renamed, &Assets::default(), &mut Diagnostics::default()).unwrap();
    assert!((0..plan.scene.shapes() as u32).any(|shape| plan.scene.shape_name(shape) == "ball"));
}

#[test]
fn meshes_of_files_are_told_apart_by_the_file_that_was_read() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/meshes/spot.obj");
    let spot = load(file, &LoadOptions::default());
    let before = small(spot.description);
    let moved = changed(&before, Role::Camera, "auto", "fov", 25.0);
    assert!(takes_over(&before, &moved, &spot.assets));
    assert!(!takes_over(&before, &changed(&before, Role::Shape, "mesh", "crease_angle", 0.0), &spot.assets));
    // Read again, it might be another: it is not looked into.
    let again = load(file, &LoadOptions::default()).assets;
    let previous = Plan::new(&before, &spot.assets, &mut Diagnostics::default()).unwrap();
    let updated =
        |assets| Plan::update(&previous.scene, &moved, assets, &mut Diagnostics::default()).unwrap();
    assert!(!updated(&again).scene.shares_shapes(&previous.scene));
    assert!(updated(&spot.assets.clone()).scene.shares_shapes(&previous.scene));
}

#[test]
fn faults_are_those_of_a_full_build() {
    let cornell = builtin("cornell");
    let previous = Plan::new(&cornell, &Assets::default(), &mut Diagnostics::default()).unwrap();
    let material = cornell.of_role(Role::Material).next().unwrap().1.name.clone();
    let users = with_material(&cornell, &material);
    let no_material = apart(&cornell, |node| node.name != material);
    let mut faulty = changed(&cornell, Role::Camera, "main", "fov", 200);
    faulty = changed(&faulty, Role::Render, "", "integrator", "magic");
    faulty = changed(&faulty, Role::Shape, &users[0], "radios", 1);
    faulty.add(Node::new(Role::Instance, "instance", "lost").with("of", "nothing"));
    for (after, expected) in [(no_material, users.len()), (faulty, 4)] {
        let [mut full, mut updated] = [Diagnostics::default(), Diagnostics::default()];
        assert!(Plan::new(&after, &Assets::default(), &mut full).is_none());
        assert!(Plan::update(&previous.scene, &after, &Assets::default(), &mut updated).is_none());
        assert_eq!(full, updated);
        assert!(full.iter().len() >= expected, "{full:?}");
    }
}
