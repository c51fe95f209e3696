//! What editors and shells ask for.

use super::{Folder, SMALL};

const TOML: &str = "penombre = 1
[camera.main]
type = \"perspective\"
position = [0, 0, 4]
target = [0, 0, 0]
[material.red]
type = \"diffuse\"
color = [0.8, 0.1, 0.1]
[shape.ball]
type = \"sphere\"
radius = 1
material = \"red\"
[light.sky]
type = \"environment\"
radiance = [1, 1, 1]
";

const JSON: &str = r#"{
  "penombre": 1,
  "camera": { "main": { "type": "perspective", "position": [0, 0, 4], "target": [0, 0, 0] } },
  "material": { "red": { "type": "diffuse", "color": [0.8, 0.1, 0.1] } },
  "shape": { "ball": { "type": "sphere", "radius": 1, "material": "red" } },
  "light": { "sky": { "type": "environment", "radiance": [1, 1, 1] } }
}"#;

#[test]
fn json_scenes_render_as_toml_scenes() {
    let folder = Folder::new();
    folder.write("a.toml", TOML);
    folder.write("b.json", JSON);
    folder.write("c.json", "{\"penombre\": 1, \"include\": [\"a.toml\"]}");
    let digests = ["a.toml", "b.json", "c.json"].map(|scene| {
        let words = [&["render", scene, "--json", "-o", "x.png"][..], &SMALL].concat();
        folder.json(&words)["digest"].to_string()
    });
    assert_eq!(digests[0], digests[1]);
    assert_eq!(digests[0], digests[2]);
}

#[test]
fn faults_of_json_have_their_place() {
    let folder = Folder::new();
    folder.write("a.json", &JSON.replace("\"radius\": 1,", "\"radius\": -1,"));
    let said = folder.refused(&["render", "a.json"]);
    assert!(said.contains("`radius` of `shape.ball` is -1") && said.contains("a.json:5:"), "{said}");
    folder.write("b.json", &JSON.replace("\"radius\": 1,", "\"radius\": 1"));
    let said = folder.refused(&["render", "b.json"]);
    assert!(said.contains("expected `,` or `}`") && said.contains("b.json:5:"), "{said}");
    let output = folder.run(&["check", "a.json", "--json"]);
    let faults: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(faults[0]["severity"], "error");
}

#[test]
fn the_schema_is_json_and_knows_the_types() {
    let schema = Folder::new().json(&["schema"]);
    assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    let shapes = schema["properties"]["shape"]["additionalProperties"]["anyOf"].as_array().unwrap().clone();
    assert!(shapes.iter().any(|s| s["properties"]["type"]["enum"][0] == "mesh"));
}

#[test]
fn shells_and_manuals_are_served() {
    let folder = Folder::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(folder.ok(&["completions", shell]).contains("max-depth"), "{shell}");
    }
    assert!(folder.refused(&["completions", "dos"]).contains("possible values"));
    let page = folder.ok(&["man"]);
    assert!(
        page.contains(".TH penombre 1") && page.contains("PENOMBRE RENDER") && page.contains("max\\-depth")
    );
}
