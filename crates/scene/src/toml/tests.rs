use super::*;
use crate::builtin::{NAMES, builtin};
use crate::description::{Node, Param, Role, SceneDescription, Value, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::native::NativeScene;
use crate::span::Sources;
use crate::span::Span;
use proptest::prelude::*;
use std::path::Path;

/// Reads a text; the scene and its faults as `line:column message | help`.
fn read(text: &str) -> (NativeScene, Vec<String>) {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let file = sources.add(Path::new("a.toml"), "a.toml", text);
    let scene = read_toml(text, file, &mut out);
    assert!(out.iter().all(|d| d.span.is_some() && !d.help.is_empty()), "{out:?}");
    let shown = out.iter().map(|d| {
        let place = sources.locate(d.span).map_or(String::new(), |at| format!("{}:{} ", at.line, at.column));
        format!("{place}{} | {}", d.message, d.help)
    });
    (scene, shown.collect())
}

fn good(text: &str) -> SceneDescription {
    let (scene, faults) = read(text);
    assert_eq!(faults, [""; 0]);
    scene.description
}

/// Every fault must start with the given place and contain the words after it.
fn bad(text: &str, expected: &[(&str, &str)]) -> NativeScene {
    let (scene, faults) = read(text);
    assert_eq!(faults.len(), expected.len(), "{faults:#?}");
    for (fault, (place, words)) in faults.iter().zip(expected) {
        assert!(fault.starts_with(place) && fault.contains(words), "{fault:?}, expected {place:?} {words:?}");
    }
    scene
}

#[test]
fn headers_dotted_keys_and_inline_tables_mean_the_same() {
    let headers = good(
        "penombre = 1\n[render]\nspp = 4\n[camera.main]\ntype = \"perspective\"\nfov = 45\nx.y = true\n",
    );
    let dotted = good(
        "penombre = 1\nrender.spp = 4\ncamera.main.type = \"perspective\"\ncamera.main.fov = 45\ncamera.main.x.y = true\n",
    );
    let inline = good(
        "penombre = 1\nrender = { spp = 4 }\ncamera.main = { type = \"perspective\", fov = 45, x = { y = true } }\n",
    );
    assert_eq!(headers, dotted);
    assert_eq!(headers, inline);
    let camera = headers.node(headers.find(Role::Camera, "main").unwrap());
    assert_eq!((camera.type_name.as_str(), camera.params.len()), ("perspective", 2));
    assert_eq!(camera.param("fov").unwrap().value.kind, ValueKind::Int(45));
}

#[test]
fn nodes_and_parameters_keep_the_order_of_the_file() {
    let text = "penombre = 1\n[shape.z]\ntype = \"s\"\nb = 1\na = 2\n[material.m]\ntype = \"p\"\n[shape.a]\ntype = \"s\"\n";
    let scene = good(text);
    let paths: Vec<String> = scene.iter().map(|(_, n)| n.path()).collect();
    assert_eq!(paths, ["shape.z", "material.m", "shape.a"]);
    let names: Vec<&str> = scene.node(crate::NodeId(0)).params.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["b", "a"]);
}

#[test]
fn spans_point_at_keys_values_types_and_headers() {
    let text = "penombre = 1\n[shape.ball]\ntype = \"sphere\"\nradius = -1.5 # m\n";
    let scene = good(text);
    let marked = |s: Span| &text[s.start as usize..][..s.len as usize];
    let (_, node) = scene.iter().next().unwrap();
    assert_eq!(marked(node.span), "[shape.ball]");
    assert_eq!(marked(node.type_span), "\"sphere\"");
    let radius = node.param("radius").unwrap();
    assert_eq!((marked(radius.name_span), marked(radius.value.span)), ("radius", "-1.5"));
}

#[test]
fn values_of_all_kinds() {
    let scene = good(
        "penombre = 1\n[render]\na = true\nb = 0x1F\nc = 1_000.5e3\nd = inf\ne = \"\\u00e9\"\nf = [1, [2.0]]\ng = {}\nh = 1e999\n\
         i = 99999999999999999999\nj = 1979-05-27\nk = -99999999999999999999\nl = 0x1_0000_0000_0000_0000_0000\n",
    );
    let render = scene.node(crate::NodeId(0));
    let value = |name: &str| render.param(name).unwrap().value.kind.clone();
    assert_eq!(value("a"), ValueKind::Bool(true));
    assert_eq!(value("b"), ValueKind::Int(31));
    assert_eq!(value("c"), ValueKind::Float(1_000_500.0));
    assert_eq!(value("d"), ValueKind::Float(f64::INFINITY));
    assert_eq!(value("e"), ValueKind::String("é".to_owned()));
    assert_eq!(value("f"), Value::from(vec![Value::from(1), Value::from([2.0])]).kind);
    assert_eq!(value("g"), ValueKind::Table(vec![]));
    assert_eq!(value("h"), ValueKind::Float(f64::MAX));
    assert_eq!(value("i"), ValueKind::Float(1e20));
    assert_eq!(value("j"), ValueKind::String("1979-05-27".to_owned()));
    assert_eq!(value("k"), ValueKind::Float(-1e20));
    assert_eq!(value("l"), ValueKind::Float(f64::from(1 << 16) * 2.0_f64.powi(64)));
}

#[test]
fn includes_are_listed_with_their_places() {
    let (scene, faults) = read("penombre = 1\ninclude = [\"a.toml\", \"b/c.toml\"]\n");
    assert_eq!(faults, [""; 0]);
    let names: Vec<&str> = scene.includes.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["a.toml", "b/c.toml"]);
    bad("penombre = 1\ninclude = \"a.toml\"\n", &[("2:11", "a list of file names")]);
    bad("penombre = 1\ninclude = [\"\", 3]\n", &[("2:12", "the text \"\""), ("2:16", "`include` has 3")]);
}

#[test]
fn version_must_be_there_and_known() {
    bad("[render]\n", &[("1:1", "begin the file with the line `penombre = 1`")]);
    bad("penombre = 2\n", &[("1:12", "written for a newer penombre")]);
    bad("penombre = \"1\"\n", &[("1:12", "is the text \"1\", expected the format version 1")]);
    bad("", &[("1:1", "which version")]);
    bad("\u{feff}penombre = 0\n", &[("1:", "write `penombre = 1`")]);
}

#[test]
fn roles_and_names_are_checked() {
    bad("penombre = 1\n[materials.red]\ntype = \"phong\"\n", &[("2:2", "did you mean `material`?")]);
    bad("penombre = 1\n[camera]\ntype = \"perspective\"\n", &[("2:1", "[camera.main]")]);
    bad("penombre = 1\n[[shape]]\ntype = \"sphere\"\n", &[("2:1", "`shape` is a list")]);
    bad("penombre = 1\nrender = 3\n", &[("2:10", "write [render]")]);
    bad("penombre = 1\n[shape.\"\"]\ntype = \"s\"\n", &[("2:1", "empty name")]);
    let scene = bad(
        "penombre = 1\n[shape.a]\nr = 1\n[shape.b]\ntype = 3\n",
        &[("2:1", "`shape.a` has no `type`"), ("5:8", "`type` of `shape.b` is 3")],
    );
    assert!(scene.description.find(Role::Shape, "a").is_some(), "references to it still stand");
}

#[test]
fn integrators_and_instances_have_no_type_key() {
    let scene = good("penombre = 1\n[integrator.classic]\nphase = 1\n[instance.i]\nof = \"x\"\n");
    let types: Vec<&str> = scene.iter().map(|(_, n)| n.type_name.as_str()).collect();
    assert_eq!(types, ["classic", "instance"]);
    let scene = good("penombre = 1\n[integrator.classic]\ntype = \"path\"\n");
    assert!(
        scene.node(crate::NodeId(0)).param("type").is_some(),
        "left to the schema, which does not know it"
    );
}

#[test]
fn syntax_faults_have_their_places() {
    for text in [
        "penombre = 1\n[shape.a\ntype = \"s\"\n",
        "penombre = 1\nx = \n",
        "penombre = 1\nx = [1, 2\n",
        "penombre = 1\nx = \"abc\n",
        "penombre = 1\nx = { a = 1\n",
        "penombre = 1\nx = 1.2.3\n",
        "penombre = 1\nx = 01\n",
        "penombre = 1\nx y = 1\n",
        "penombre = 1\nx = 1 y = 2\n",
        "penombre = 1\nx = \"\\q\"\n",
        "penombre = 1\n= 1\n",
        "penombre = 1\nx = \u{1}\n",
    ] {
        let (scene, faults) = read(text);
        assert!(!scene.readable && scene.description.is_empty(), "{text:?}");
        assert!(!faults.is_empty() && faults[0].starts_with(['2', '3']), "{text:?}: {faults:?}");
    }
    bad("penombre = 1\n[render]\nspp = 1\nspp = 2\n", &[("4:1", "`spp` is defined twice")]);
    bad("penombre = 1\n[shape.a]\n[shape.a]\n", &[("3:8", "`a` is defined twice")]);
    let (_, faults) = read("penombre = 1\nx = red\ny = 1.2.3\nz = \"a\n");
    assert_eq!(faults.len(), 3, "{faults:?}");
}

#[test]
fn syntax_faults_show_what_right_toml_looks_like() {
    for (line, help) in [
        ("x = .3", "numbers look like"),
        ("x = 1.", "numbers look like"),
        ("x = 0X1f", "numbers look like"),
        ("x = 1__0", "numbers look like"),
        ("x = +-3", "numbers look like"),
        ("x = 007", "without the zero"),
        ("x = \"a", "a text begins and ends with a quote"),
        ("x = a\"", "a text begins and ends with a quote"),
        ("x = red", "put texts in quotes"),
        ("x = \"c:\\dir\"", "a backslash begins an escape"),
        ("x = [1, 2", "a list has commas"),
        ("x = [1,, 2]", "a list has commas"),
        ("x = { a = 1", "a table in a line"),
        ("x = { a 1 }", "a table in a line"),
        ("x = { a = 1 b = 2 }", "one `key = value` a line, with commas"),
        ("[shape.ball", "a header looks like [shape.ball]"),
        ("[[shape.ball]", "a header looks like [shape.ball]"),
        ("x: 3", "keys and values have `=` between them"),
        ("x", "keys and values have `=` between them"),
        ("x y = 1", "keys and values have `=` between them"),
        ("x = 1 y = 2", "one `key = value` a line"),
        ("x = \"a\" y = 2", "one `key = value` a line"),
        ("<scene>", "a line is `key = value`, a header"),
        ("x = 1\nx.y = 2", "has a value already"),
    ] {
        let (_, faults) = read(&format!("penombre = 1\n{line}\n"));
        assert!(faults.iter().any(|f| f.split(" | ").nth(1).unwrap().contains(help)), "{line}: {faults:?}");
    }
}

#[test]
fn deep_nesting_is_a_fault_and_no_crash() {
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let text = format!("penombre = 1\nx = {}1{}\n", open.repeat(100_000), close.repeat(100_000));
        let (_, faults) = read(&text);
        assert!(!faults.is_empty() && faults.len() <= 22, "{}", faults.len());
        assert!(faults.iter().any(|f| f.contains("nested too deeply")), "{faults:?}");
    }
    let (_, faults) = read(&format!("penombre = 1\n[{}]\n", vec!["a"; 100_000].join(".")));
    assert!(!faults.is_empty());
    let (_, faults) = read(&format!("penombre = 1\n{} = 1\n", vec!["a"; 100_000].join(".")));
    assert!(!faults.is_empty());
}

#[test]
fn builtins_survive_writing_and_reading() {
    for name in NAMES {
        let scene = builtin(name).unwrap();
        assert_eq!(good(&write_toml(&scene)), scene, "{name}");
    }
}

#[test]
fn writes_stable_readable_text() {
    let mut scene = SceneDescription::default();
    let long: Vec<Value> = (0..20).map(|i| Value::from([f64::from(i), 0.5, -1e-7])).collect();
    scene.add(Node::new(Role::Render, "render", "").with("spp", 4));
    scene.add(Node::new(Role::Shape, "mesh", "a b").with("text", "say \"hi\"\n").with("points", long));
    let text = write_toml(&scene);
    assert!(
        text.starts_with("penombre = 1\n\n[render]\nspp = 4\n\n[shape.\"a b\"]\ntype = \"mesh\"\n"),
        "{text}"
    );
    assert!(text.contains("text = \"say \\\"hi\\\"\\n\"\n"), "{text}");
    assert!(text.contains("points = [\n    [0.0, 0.5, -1e-7],\n"), "{text}");
    assert_eq!(good(&text), scene);
    let nan = Node::new(Role::Render, "render", "").with("x", f64::NAN);
    let mut scene = SceneDescription::default();
    scene.add(nan);
    assert!(write_toml(&scene).contains("x = nan"));
}

fn values() -> impl Strategy<Value = Value> {
    let finite = any::<f64>().prop_filter("nan is unequal to itself", |v| !v.is_nan());
    let leaf = prop_oneof![
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        finite.prop_map(Value::from),
        any::<String>().prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 24, 5, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(Value::from),
            entries(inner).prop_map(|params| ValueKind::Table(params).into()),
        ]
    })
}

fn entries(value: impl Strategy<Value = Value>) -> impl Strategy<Value = Vec<Param>> {
    prop::collection::vec(("[a-z_]{1,4}|\\PC{0,3}", value), 0..5).prop_map(|list| {
        let mut node = Node::new(Role::Render, "render", "");
        for (name, value) in list.into_iter().filter(|(name, _)| name != "type") {
            node.set(&name, value);
        }
        node.params
    })
}

fn scenes() -> impl Strategy<Value = SceneDescription> {
    let node =
        (prop::sample::select(Role::ALL.to_vec()), "[a-z0-9-]{1,6}|\\PC{1,3}", ".{1,8}", entries(values()));
    prop::collection::vec(node, 0..8).prop_map(|nodes| {
        let mut scene = SceneDescription::default();
        for (role, name, type_name, params) in nodes {
            let name = if role == Role::Render { String::new() } else { name };
            let type_name = match role {
                Role::Integrator => name.clone(),
                Role::Render | Role::Instance => role.name().to_owned(),
                _ => type_name,
            };
            if scene.find(role, &name).is_none() {
                let mut node = Node::new(role, type_name, name);
                node.params = params;
                scene.add(node);
            }
        }
        scene
    })
}

/// Fixed seed: every run tries the same scenes.
fn runner(cases: u32) -> proptest::test_runner::TestRunner {
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

#[test]
fn reading_what_was_written_gives_the_same_scene() {
    let checked = runner(400).run(&scenes(), |scene| {
        let text = write_toml(&scene);
        let (back, faults) = read(&text);
        prop_assert_eq!(&faults, &Vec::<String>::new(), "{}", text);
        prop_assert_eq!(write_toml(&back.description), text);
        prop_assert_eq!(back.description, scene);
        Ok(())
    });
    checked.unwrap();
}

#[test]
fn no_text_makes_the_reader_panic() {
    let scene = write_toml(&builtin("cornell").unwrap());
    let mutation = (0..scene.len(), 0..40_usize, "[\\[\\]{}=.\",#a-z0-9\\n\\PC]{0,6}");
    let checked = runner(3000).run(&mutation, |(at, cut, text)| {
        let from = scene.floor_char_boundary(at);
        let to = scene.floor_char_boundary((from + cut).min(scene.len()));
        read(&format!("{}{text}{}", &scene[..from], &scene[to..]));
        Ok(())
    });
    checked.unwrap();
}

#[test]
fn millions_of_faults_are_told_quickly() {
    for line in ["01,", "a,", "{a=1,a=2},", "\"\\q\","] {
        let begin = std::time::Instant::now();
        let (_, faults) = read(&format!("penombre = 1\nx = [{}]\n", line.repeat(300_000)));
        assert!(!faults.is_empty() && faults.len() <= 21, "{}", faults.len());
        assert!(begin.elapsed().as_secs() < 10, "{line}: {:?}", begin.elapsed());
    }
}

#[test]
fn a_stray_key_hides_no_named_table() {
    let scene = bad(
        "penombre = 1\n[material]\nfoo = 1\nx = { texture = \"t\" }\nblue = { type = \"phong\" }\n[material.red]\ntype = \"phong\"\n",
        &[("2:1", "`material` has the key `foo` but no name")],
    );
    let names: Vec<String> = scene.description.iter().map(|(_, n)| n.path()).collect();
    // What has neither a header nor a type is a value of the node without a name.
    assert_eq!(names, ["material.blue", "material.red"]);
}

#[test]
fn many_faults_take_no_quadratic_time() {
    let count = 100_000;
    let nodes: String = (0..count).map(|i| format!("[shape.s{i}]\nradius = 1\n")).collect();
    let begin = std::time::Instant::now();
    let (_, faults) = read(&format!("penombre = 1\n{nodes}"));
    assert_eq!(faults.len(), count);
    assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
}
