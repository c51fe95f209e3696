use super::*;
use crate::builtin::builtin;
use crate::span::Sources;
use std::path::Path;

/// Applies arguments to the built-in box; the scene and the messages.
fn set(arguments: &[&str]) -> (SceneDescription, Vec<(String, String, String)>) {
    let mut scene = builtin("cornell").unwrap();
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    for argument in arguments {
        let file = sources.add(Path::new(""), SOURCE_NAME, *argument);
        apply(argument, file, &mut scene, &mut out);
    }
    let marked = |d: &crate::Diagnostic| {
        let text = &sources.get(d.span.file).unwrap().text;
        text[d.span.start as usize..][..d.span.len as usize].to_owned()
    };
    let faults = out.iter().map(|d| (marked(d), d.message.clone(), d.help.clone())).collect();
    (scene, faults)
}

fn get(scene: &SceneDescription, role: Role, name: &str, param: &str) -> ValueKind {
    let id = scene.find(role, name).unwrap();
    scene.node(id).param(param).unwrap().value.kind.clone()
}

#[test]
fn sets_by_full_and_short_paths() {
    let (scene, faults) = set(&[
        "camera.fov=40",
        "camera.main.near = 0.5",
        "render.spp=16",
        "material.red.diffuse=[1, 0.5, 0]",
        "material.red.type=mirror",
        "light.color=#ff8000",
        "shape.floor.material='green'",
        "render.size.1=270",
    ]);
    assert_eq!(faults, []);
    assert_eq!(get(&scene, Role::Camera, "main", "fov"), ValueKind::Int(40));
    assert_eq!(get(&scene, Role::Camera, "main", "near"), ValueKind::Float(0.5));
    assert_eq!(get(&scene, Role::Render, "", "spp"), ValueKind::Int(16));
    assert_eq!(get(&scene, Role::Light, "ceiling", "color"), ValueKind::String("#ff8000".to_owned()));
    assert_eq!(get(&scene, Role::Shape, "floor", "material"), ValueKind::String("green".to_owned()));
    assert_eq!(get(&scene, Role::Render, "", "size"), Value::from([480, 270]).kind);
    let color = [ValueKind::Int(1), ValueKind::Float(0.5), ValueKind::Int(0)].map(Value::from);
    assert_eq!(get(&scene, Role::Material, "red", "diffuse"), ValueKind::Array(color.to_vec()));
    let red = scene.find(Role::Material, "red").unwrap();
    assert_eq!(scene.node(red).type_name, "mirror");
}

#[test]
fn creates_integrator_and_inner_tables() {
    let (scene, faults) =
        set(&["integrator.classic.phase=2", "integrator.phase=3", "shape.floor.color.texture=\"checks\""]);
    assert_eq!(faults, []);
    assert_eq!(get(&scene, Role::Integrator, "classic", "phase"), ValueKind::Int(3));
    let id = scene.find(Role::Integrator, "classic").unwrap();
    assert_eq!(scene.node(id).type_name, "classic");
    assert_eq!(get(&scene, Role::Shape, "floor", "color"), Value::from([("texture", "checks".into())]).kind);
}

#[test]
fn creates_render_in_a_scene_without_one() {
    let mut scene = SceneDescription::default();
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let file = sources.add(Path::new(""), SOURCE_NAME, "render.spp=4");
    apply("render.spp=4", file, &mut scene, &mut out);
    assert!(out.is_empty());
    assert_eq!(get(&scene, Role::Render, "", "spp"), ValueKind::Int(4));
}

#[test]
fn faults_name_the_word_and_the_candidates() {
    let (scene, faults) = set(&[
        "camera.fov",
        "camra.fov=3",
        "shape.radius=1",
        "shape.right-spere.radius=1",
        "camera.fov=",
        "camera.fov=[1,",
        "texture.scale=1",
        "a b.c=1",
        "camera=3",
        "camera.main=3",
        "integrator.phase=2",
        "render.size.7=1",
        "render=1",
        "shape.floor.x.y.z=1",
        "camera.fov.x.y=1",
        "material.red.type=3",
        "material.red.type=\"\"",
        "camera.mian.fov=30",
    ]);
    assert_eq!(scene, builtin("cornell").unwrap(), "a faulty argument changes nothing");
    let expect = [
        ("camera.fov", "the argument has no `=`"),
        ("camra", "unknown word `camra`"),
        ("shape", "the scene has 8 shapes and the path does not say which"),
        ("right-spere", "there is no shape `right-spere`"),
        ("", "the value is nothing"),
        ("[1,", "the value is \"[1,\""),
        ("texture", "the scene has no texture"),
        ("a b.c", "\"a b.c\" is no path"),
        ("camera", "`camera` needs a parameter"),
        ("main", "`camera.main` needs a parameter"),
        ("integrator", "the path does not say which integrator"),
        ("7", "`render.size` is a list with 2 entries and has no part `7`"),
        ("render", "`render` needs a parameter"),
        ("y", "`shape.floor.x` is a table and has no part `y`"),
        ("x", "`camera.fov` is 45.0 and has no part `x`"),
        ("3", "`type` of `material.red` must be the name of a type"),
        ("\"\"", "`type` of `material.red` must be the name of a type"),
        ("mian", "there is no camera `mian`"),
    ];
    assert_eq!(faults.len(), expect.len());
    for ((marked, message, help), (place, start)) in faults.iter().zip(expect) {
        assert_eq!(marked, place, "{message}");
        assert!(!help.is_empty(), "no help: {message}");
        assert!(message.starts_with(start), "{message}");
    }
    assert!(faults[1].2.contains("did you mean `camera`?"));
    assert!(faults[2].2.contains("left-sphere"));
    assert!(faults[3].2.contains("did you mean `right-sphere`?"));
}

#[test]
fn the_equals_sign_stands_outside_quotes_whatever_is_escaped_in_them() {
    assert_eq!(equals_sign(r#"camera."a=b".fov=4"#), Some(16));
    assert_eq!(equals_sign(r#"camera."q\"=q".fov=4"#), Some(18));
    assert_eq!(equals_sign(r#"camera."q\\"=4"#), Some(12));
    assert_eq!(equals_sign(r"camera.'q\'=4"), Some(11));
    assert_eq!(equals_sign("camera.fov"), None);
}
