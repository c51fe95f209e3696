use super::*;
use crate::builtin::{NAMES, builtin};
use crate::description::SceneDescription;
use crate::span::Sources;
use crate::toml::{read_toml, write_toml};
use std::path::Path;

/// Reads a text; the scene and its faults as `line:column message | help`.
fn read(text: &str) -> (NativeScene, Vec<String>) {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let file = sources.add(Path::new("a.json"), "a.json", text);
    let scene = read_json(text, file, &mut out);
    assert!(out.iter().all(|d| d.span.is_some() && !d.help.is_empty()), "{out:?}");
    let shown = out.iter().map(|d| {
        let place = sources.locate(d.span).map_or(String::new(), |at| format!("{}:{} ", at.line, at.column));
        format!("{place}{} | {}", d.message, d.help)
    });
    (scene, shown.collect())
}

/// The same scene, places aside.
fn as_toml(scene: &SceneDescription) -> String {
    write_toml(scene)
}

#[test]
fn json_says_what_toml_says() {
    let toml = "penombre = 1\ninclude = [\"m.json\"]\n[render]\nspp = 4\nsize = [3, 2]\n[camera.main]\ntype = \"perspective\"\nfov = 4.5e1\n\
        [shape.\"a b\"]\ntype = \"sphere\"\ntransform = [{ rotate = [0, 1, 0], angle = -30.5 }]\nname = \"\\u00e9\\t\\\\\"\nfar = inf\nyes = true\n\
        [integrator.path]\nclamp = 10\n[instance.i]\nof = \"a b\"\n";
    let json = r#"{"$schema": "penombre.schema.json", "penombre": 1, "include": ["m.json"], "render": {"spp": 4, "size": [3, 2]},
        "camera": {"main": {"type": "perspective", "fov": 4.5e1}},
        "shape": {"a b": {"type": "sphere", "transform": [{"rotate": [0, 1, 0], "angle": -30.5}], "name": "\u00e9\t\\",
            "far": Infinity, "yes": true}},
        "integrator": {"path": {"clamp": 10}}, "instance": {"i": {"of": "a b"}} }"#;
    let mut out = Diagnostics::default();
    let expected = read_toml(toml, FileId(0), &mut out);
    let (found, faults) = read(json);
    assert!(out.is_empty() && faults.is_empty(), "{out:?} {faults:?}");
    assert_eq!(as_toml(&found.description), as_toml(&expected.description));
    assert_eq!(found.includes[0].name, "m.json");
}

#[test]
fn scenes_come_back_as_they_were() {
    for name in NAMES {
        let scene = builtin(name).unwrap();
        let text = write_json(&scene);
        let (again, faults) = read(&text);
        assert!(faults.is_empty(), "{faults:?}");
        // JSON puts roles together.
        assert_eq!(write_json(&again.description), text);
        let order = |s: &SceneDescription| {
            let mut nodes: Vec<String> = as_toml(s).split("\n\n").map(|n| n.trim().to_owned()).collect();
            nodes.sort();
            nodes
        };
        assert_eq!(order(&again.description), order(&scene));
    }
}

#[test]
fn faults_of_syntax_have_place_and_hint() {
    for (text, place, expected, help) in [
        ("", "1:1", "found the end of the file, expected a value", "values are"),
        ("[1]", "1:1", "the file holds a list", "\"penombre\": 1"),
        ("{\"a\": 1,}", "1:9", "a comma before `}`", "take the comma"),
        ("{\"a\" 1}", "1:6", "found '1', expected `:`", "colon"),
        ("{a: 1}", "1:2", "found `a`, expected a key in quotes", "quotes"),
        ("{\n\"a\": [1 2]}", "2:9", "found '2', expected `,` or `]`", "commas"),
        ("{\"a\": 01}", "1:7", "`01` is no number", "numbers look like"),
        ("{\"a\": 1.}", "1:7", "`1.` is no number", "both sides"),
        ("{\"a\": -}", "1:7", "`-` is no number", "numbers"),
        ("{\"a\": null}", "1:7", "found `null`", "leave out"),
        ("{\"a\": NaN}", "1:7", "found `NaN`", "values are"),
        ("{\"a\": \"x}", "1:7", "no closing quote", "quote"),
        ("{\"a\": \"\\q\"}", "1:8", "no escape", "double it"),
        ("{\"a\": \"\\ud800\"}", "1:8", "no escape", "double it"),
        ("{\"a\": 1, \"a\": 2}", "1:10", "`a` is defined twice", "once"),
        ("{} {}", "1:4", "expected the end of the file", "one object"),
        ("{ // x\n}", "1:3", "found '/'", "no comments"),
    ] {
        let (scene, faults) = read(text);
        assert!(!scene.readable && faults.len() == 1, "{text}: {faults:?}");
        let (message, hint) = faults[0].split_once(" | ").unwrap();
        assert!(message.starts_with(place) && message.contains(expected), "{text}: {message}");
        assert!(hint.contains(help), "{text}: {hint}");
    }
    let deep = "[".repeat(1_000_000);
    assert!(read(&deep).1[0].contains("nested too deeply"));
}

#[test]
fn faults_of_meaning_are_told_in_json() {
    for (text, expected, help) in [
        ("{}", "does not say which version", "{ \"penombre\": 1,"),
        ("{\"penombre\": 2}", "`penombre` is 2", "newer"),
        ("{\"penombre\": 1, \"shapes\": {}}", "unknown table `shapes`", "shape"),
        ("{\"penombre\": 1, \"shape\": 3}", "`shape` is 3, expected a table", "\"shape\": { \"NAME\""),
        ("{\"penombre\": 1, \"shape\": {\"x\": {}}}", "`shape.x` has no `type`", "\"type\": \"sphere\""),
        (
            "{\"penombre\": 1, \"camera\": {\"fov\": 3}}",
            "`camera` has the key `fov` but no name",
            "\"camera\": { \"main\"",
        ),
        (
            "{\"penombre\": 1, \"include\": \"x\"}",
            "expected a list of file names",
            "\"include\": [\"materials",
        ),
    ] {
        let (_, faults) = read(text);
        assert!(
            faults.len() == 1 && faults[0].contains(expected) && faults[0].contains(help),
            "{text}: {faults:?}"
        );
    }
}

#[test]
fn numbers_keep_their_kind() {
    let (scene, _) = read(
        "{\"penombre\": 1, \"render\": {\"a\": 3, \"b\": 3.0, \"c\": 1e400, \"d\": 99999999999999999999, \"e\": -0}}",
    );
    let node = scene.description.iter().next().unwrap().1;
    let kinds: Vec<_> = node.params.iter().map(|p| p.value.kind.clone()).collect();
    use ValueKind::{Float, Int};
    assert_eq!(kinds, [Int(3), Float(3.0), Float(f64::MAX), Float(1e20), Int(0)]);
}
