//! Tests of sessions: the shown command gives the bits of the session's own render.

use super::*;
use crate::camera::{AxisView, Button};
use crate::testing::digest;
use penombre_math::Vec2;
use penombre_scene::Value;
use std::path::Path;

/// Words of a command line: bare ones and such in single quotes.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    let mut chars = line.chars();
    while let Some(c) = chars.next() {
        match c {
            '\'' => quoted = !quoted,
            '\\' if !quoted => words.last_mut().unwrap().extend(chars.next()),
            ' ' if !quoted => words.push(String::new()),
            c => words.last_mut().unwrap().push(c),
        }
    }
    words
}

/// The node of that role and name, made if it is not there.
fn set(d: &mut SceneDescription, role: Role, name: &str, param: &str, value: Value) {
    let type_name = if name.is_empty() { role.name() } else { name };
    let id = d.find(role, name).unwrap_or_else(|| d.add(Node::new(role, type_name, name)));
    d.node_mut(id).set(param, value);
}

/// The image of a command by the rules of `penombre render`, written down here a second time: `--set` and `--size`
/// while loading, the other options afterwards.
fn run_command(line: &str) -> String {
    let words = words(line);
    assert_eq!(words[..2], ["penombre", "render"]);
    let mut options = LoadOptions::default();
    let mut later: Vec<(Role, &str, &str, Value)> = Vec::new();
    let mut rest = words[3..].iter();
    let mut size = None;
    while let Some(option) = rest.next() {
        let mut value = || rest.next().unwrap();
        match option.as_str() {
            "--set" => options.sets.push(value().clone()),
            "--size" => size = value().split_once('x').map(|(w, h)| format!("render.size=[{w}, {h}]")),
            "--asset-root" => options.asset_roots.push(value().into()),
            "--spp" => later.push((Role::Render, "", "spp", value().parse::<i64>().unwrap().into())),
            "--integrator" => later.push((Role::Render, "", "integrator", value().as_str().into())),
            "--phase" => {
                later.push((Role::Integrator, "classic", "phase", value().parse::<i64>().unwrap().into()));
            }
            "--hard-shadows" => later.push((Role::Integrator, "classic", "hard_shadows", true.into())),
            "--tone" => assert!(value().parse::<ToneCurve>().is_ok()),
            other => assert!(other.starts_with("--exposure="), "{other}"),
        }
    }
    options.sets.extend(size);
    let mut loaded = load(&words[2], &options);
    for (role, name, param, value) in later {
        set(&mut loaded.description, role, name, param, value);
    }
    let plan = Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics);
    assert!(!loaded.diagnostics.has_errors(), "{:?}", loaded.diagnostics);
    digest(plan.unwrap())
}

fn session(scene: &str) -> Session {
    Session::load(&Source::builtin(scene), None, &Limits::default()).unwrap()
}

fn turned(mut camera: CourseCamera) -> CourseCamera {
    let window = Vec2::new(64.0, 48.0);
    camera.drag(Button::Left, Vec2::new(20.0, 30.0), Vec2::new(47.0, 21.0), window);
    camera.drag(Button::Right, Vec2::new(20.0, 30.0), Vec2::new(-7.0, 51.0), window);
    camera.drag(Button::Middle, Vec2::ZERO, Vec2::new(0.0, -31.0), window);
    camera.wheel(0.7);
    camera
}

fn same(session: &Session, setup: &Setup) -> String {
    let line = session.command_line(setup).unwrap();
    assert_eq!(run_command(&line), digest(session.plan(setup).unwrap()), "{line}");
    line
}

#[test]
fn an_untouched_scene_has_the_plain_command() {
    let session = session("cornell");
    let setup = session.setup();
    assert_eq!(session.command_line(&setup).unwrap(), "penombre render cornell --size 480x480");
    let values = SceneValues {
        size: [480, 480],
        spp: 50,
        integrator: "classic".to_owned(),
        phase: 4,
        hard_shadows: false,
        shadow_samples: Some(16),
    };
    assert_eq!((session.name(), session.values(), session.warnings()), ("cornell", &values, ""));
    assert_eq!(session.tone(&setup.settings), ToneCurve::Raw);
    // The camera is the course's, to the last bit.
    assert_eq!((setup.camera.zoom(), setup.camera.pan().z, setup.camera.scale()), (3.0, -3.1, 1.0));
}

#[test]
fn the_command_gives_the_same_bits_whatever_was_changed() {
    let session = session("cornell");
    let plain = Setup { size: [40, 30], ..session.setup() };
    let few = Settings { spp: Some(2), ..Settings::default() };
    let plain = Setup { settings: few.clone(), ..plain };
    let line = same(&session, &plain);
    assert_eq!(line, "penombre render cornell --size 40x30 --spp 2");
    let moved = Setup { camera: turned(plain.camera), ..plain.clone() };
    let line = same(&session, &moved);
    assert!(line.contains("--set 'camera.main.position=["), "{line}");
    assert_ne!(run_command(&line), digest(session.plan(&plain).unwrap()));
    let settings = Settings {
        phase: Some(2),
        hard_shadows: Some(false),
        integrator: Some("classic".to_owned()),
        shadow_samples: Some(3),
        exposure: -1.5,
        tone: Some(ToneCurve::Srgb),
        ..few.clone()
    };
    let line = same(&session, &Setup { settings, ..moved.clone() });
    for part in [
        "--phase 2",
        "light.ceiling.shadow_samples=3",
        "--exposure=-1.5",
        "--tone srgb",
        "hard_shadows=false",
    ] {
        assert!(line.contains(part), "{part} in {line}");
    }
    let mut settings = Settings { hard_shadows: Some(true), phase: Some(4), ..few };
    let line = same(&session, &Setup { settings: settings.clone(), ..moved.clone() });
    assert!(line.contains(" --hard-shadows"), "{line}");
    // What another integrator does not have is not in its command, which would be refused.
    settings.integrator = Some("path".to_owned());
    let line = same(&session, &Setup { settings, ..moved });
    assert!(line.contains("--integrator path") && !line.contains("--phase"), "{line}");
}

const ODD: &str = r#"
penombre = 1
[render]
integrator = "classic"
size = [32, 24]
spp = 2
camera = "it's"
[camera.first]
type = "perspective"
position = [0, 0, 9]
[camera."it's"]
type = "orthographic"
position = [1, 2, 6]
target = [0, 0.25, 0]
height = 3.5
[integrator.classic]
hard_shadows = true
[material.red]
type = "phong"
diffuse = [1, 0, 0]
[shape.ball]
type = "sphere"
material = "red"
[light."a b"]
type = "quad"
origin = [3, 3, 3]
sides = [[1, 0, 0], [0, 1, -1]]
"#;

/// A scene file with odd names in a folder with an odd name.
fn odd_file(folder: &Path) -> PathBuf {
    let folder = folder.join("it's a folder");
    std::fs::create_dir(&folder).unwrap();
    let file = folder.join("scene $1.toml");
    std::fs::write(&file, ODD).unwrap();
    file
}

#[test]
fn odd_names_and_parallel_rays_are_no_trouble() {
    let folder = tempfile::tempdir().unwrap();
    let mut source = Source::file(&odd_file(folder.path())).unwrap();
    source.sets.push("material.red.diffuse=[0.5, 0.25, 1]".to_owned());
    let session = Session::load(&source, None, &Limits::default()).unwrap();
    assert!(session.values().hard_shadows && session.values().shadow_samples == Some(16));
    let settings = Settings { hard_shadows: Some(false), shadow_samples: Some(2), ..Settings::default() };
    let mut setup = Setup { camera: turned(session.start_camera()), settings, ..session.setup() };
    let line = same(&session, &setup);
    assert!(line.contains("height") && line.contains("shadow_samples=2"), "{line}");
    for view in [AxisView::Front, AxisView::Right, AxisView::Top] {
        setup.camera.look_along(view);
        setup.camera.frame(&session.bounds(), 4.0 / 3.0);
        same(&session, &setup);
    }
}

#[test]
fn the_surroundings_of_a_bare_mesh_follow_the_size() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tetra.off");
    std::fs::write(&file, "OFF\n4 4 0\n0 0 0\n1 0 0\n0 2 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        .unwrap();
    let mut source = Source::file(&file).unwrap();
    source.sets.push("light.key.shadow_samples=2".to_owned());
    for loaded_at in [None, Some([40, 30])] {
        let session = Session::load(&source, loaded_at, &Limits::default()).unwrap();
        let settings = Settings { spp: Some(1), ..Settings::default() };
        for size in [[40, 30], [30, 40], [90, 20]] {
            let setup = Setup { size, settings: settings.clone(), ..session.setup() };
            same(&session, &setup);
            same(&session, &Setup { camera: turned(setup.camera), ..setup });
        }
    }
}

#[test]
fn plans_share_the_shapes_of_the_loaded_scene() {
    let folder = tempfile::tempdir().unwrap();
    let odd = Session::load(&Source::file(&odd_file(folder.path())).unwrap(), None, &Limits::default());
    let settings = Settings {
        phase: Some(2),
        hard_shadows: Some(true),
        shadow_samples: Some(3),
        spp: Some(2),
        ..Settings::default()
    };
    for session in [session("cornell"), odd.unwrap()] {
        let setup =
            Setup { size: [33, 44], camera: turned(session.start_camera()), settings: settings.clone() };
        for setup in [session.setup(), setup] {
            assert!(session.plan(&setup).unwrap().scene.shares_shapes(session.scene()));
        }
    }
    // The ground of a bare mesh follows the size: one that was built for it is taken.
    let file = folder.path().join("flat.off");
    std::fs::write(&file, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n").unwrap();
    let bare = Session::load(&Source::file(&file).unwrap(), None, &Limits::default()).unwrap();
    let at = |size, camera| bare.plan(&Setup { size, camera, ..bare.setup() }).unwrap().scene;
    let [start, moved] = [bare.start_camera(), turned(bare.start_camera())];
    assert!(at(bare.values().size, moved).shares_shapes(bare.scene()));
    let tall = at([30, 40], start);
    assert!(!tall.shares_shapes(bare.scene()));
    assert!(at([30, 40], moved).shares_shapes(&tall));
    assert!(!at([40, 40], moved).shares_shapes(&tall));
    assert!(at(bare.values().size, start).shares_shapes(bare.scene()));
}

#[test]
fn a_scene_without_camera_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.toml");
    let text = "penombre = 1\n[render]\nsize = [24, 24]\nspp = 1\n[shape.ball]\ntype = \"sphere\"\n\
                [light.lamp]\ntype = \"point\"\nposition = [3, 4, 5]\n";
    std::fs::write(&file, text).unwrap();
    let session = Session::load(&Source::file(&file).unwrap(), None, &Limits::default()).unwrap();
    assert!(session.warnings().contains("no camera"));
    same(&session, &session.setup());
    // Moved, no option can say it, but lines in the file can: with them the image is the same.
    let setup = Setup { camera: turned(session.start_camera()), ..session.setup() };
    let advice = session.command_line(&setup).unwrap_err();
    let lines = advice.split_once("ball.toml\n").unwrap().1;
    std::fs::write(&file, format!("{text}{lines}")).unwrap();
    let expected = run_command(&format!("penombre render {}", file.display()));
    assert_eq!(digest(session.plan(&setup).unwrap()), expected);
}

#[test]
fn scenes_that_cannot_be_loaded_are_told_in_full() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("broken.toml");
    std::fs::write(
        &file,
        "penombre = 1\n[shape.a]\ntype = \"spere\"\n[shape.b]\ntype = \"sphere\"\nradius = -1\n",
    )
    .unwrap();
    let fault =
        |path: &Path| Session::load(&Source::file(path).unwrap(), None, &Limits::default()).unwrap_err();
    let text = fault(&file);
    assert!(text.contains("spere") && text.contains("radius"), "{text}");
    assert!(fault(&folder.path().join("gone.toml")).contains("gone.toml"));
    // What cannot be rendered is told as well.
    let session = session("square");
    let settings = Settings { integrator: Some("magic".to_owned()), ..Settings::default() };
    let error = session.plan(&Setup { settings, ..session.setup() }).unwrap_err();
    assert!(error.contains("magic"), "{error}");
}

#[test]
fn files_are_not_taken_for_scenes_or_options() {
    assert_eq!(Source::file(Path::new("cornell")).unwrap().scene, "./cornell");
    assert_eq!(Source::file(Path::new("-q.toml")).unwrap().scene, "./-q.toml");
    assert_eq!(Source::file(Path::new("some/a.toml")).unwrap().scene, "some/a.toml");
}

#[test]
fn loading_happens_in_the_background() {
    let (send, woken) = std::sync::mpsc::channel();
    let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(move || send.send(()).unwrap());
    let count = |session: &Session| session.preview().triangles();
    let mut loading = Loading::start(Source::builtin("square"), Some([10, 20]), count, wake.clone());
    woken.recv_timeout(std::time::Duration::from_secs(60)).unwrap();
    let (session, triangles) = loading.poll().unwrap().unwrap();
    assert_eq!(triangles, session.preview().triangles());
    assert_eq!((session.name(), session.values().size), ("square", [10, 20]));
    assert!(loading.poll().is_none(), "a result is taken once");
    let failed = Loading::start(Source::builtin("sqare"), None, count, wake).wait();
    assert!(failed.unwrap_err().contains("square"));
}

#[test]
fn files_say_how_they_were_made() {
    let session = Session::load(&Source::builtin("cornell"), Some([30, 20]), &Limits::default()).unwrap();
    let setup = Setup { camera: turned(session.start_camera()), ..session.setup() };
    let entries = session.provenance(&setup, 12.5);
    let value = |key: &str| entries.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone()).unwrap();
    assert_eq!(value("penombre:spp"), "12.5");
    assert_eq!(value("penombre:command"), session.command_line(&setup).unwrap());
    let start = session.provenance(&session.setup(), 50.0);
    let digest = start.iter().find(|(k, _)| k == "penombre:scene-digest").unwrap();
    assert_ne!(value("penombre:scene-digest"), digest.1, "another camera makes another scene");
}
