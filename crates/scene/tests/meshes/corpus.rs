//! The large test data: every mesh file answers as it should.

use crate::common::{assert_helpful, counts, test_data};
use penombre_scene::load::LoadOptions;
use penombre_scene::{
    Assets, Diagnostic, Diagnostics, Folders, Node, Role, SceneDescription, Sources, TriangleMesh,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

const ENDINGS: [&str; 4] = ["obj", "off", "ply", "stl"];

/// A scene of one mesh file, loaded.
struct Loaded {
    scene: SceneDescription,
    assets: Assets,
    messages: Vec<String>,
    counts: [usize; 3],
}

fn load(path: &Path) -> Loaded {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let folders = Folders { root: path.parent().unwrap().to_owned(), asset_roots: Vec::new() };
    let name = path.file_name().unwrap().to_str().unwrap();
    let mut scene = SceneDescription::default();
    scene.add(Node::new(Role::Shape, "mesh", "mesh").with("file", name));
    let assets = Assets::load(&mut scene, &folders, &mut sources, &mut out);
    assert_helpful(&out);
    let place = |span| sources.locate(span).map(|l| format!("{}:{}:{}", l.name, l.line, l.column));
    let messages =
        out.iter().map(|d| format!("{} {} {:?} {}", d.severity.name(), d.code, place(d.span), d.message));
    Loaded { scene, assets, messages: messages.collect(), counts: counts(&out) }
}

impl Loaded {
    fn triangles(&self) -> usize {
        let (id, _) = self.scene.of_role(Role::Shape).next().unwrap();
        self.assets.mesh(id).map_or(0, |file| file.mesh.indices.len())
    }
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().map(|e| e.to_ascii_lowercase());
        if path.is_dir() {
            files(&path, found);
        } else if ending.is_some_and(|e| ENDINGS.contains(&e.to_str().unwrap_or(""))) {
            found.push(path);
        }
    }
    found.sort();
}

#[test]
fn bad_inputs_answer_as_their_index_says() {
    let Some(folder) = test_data("bad-inputs") else { return };
    let index = std::fs::read_to_string(folder.join("INDEX.tsv")).unwrap();
    let mut seen = 0;
    for line in index.lines().filter(|l| !l.starts_with('#')) {
        let [name, class, ..] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
        let wanted = Path::new(name).extension().is_some_and(|e| ENDINGS.contains(&e.to_str().unwrap_or("")));
        if !wanted {
            continue;
        }
        let begin = Instant::now();
        let path = folder.join(name);
        let loaded = penombre_scene::load::load(path.to_str().unwrap(), &LoadOptions::default());
        let seconds = begin.elapsed().as_secs_f32();
        assert!(seconds < 2.0, "{name}: {seconds} s");
        let [errors, warnings, _] = counts(&loaded.diagnostics);
        assert!(loaded.diagnostics.iter().all(|d| !d.help.is_empty()), "{name}: {:?}", loaded.diagnostics);
        let file = path.file_name().unwrap().to_str().unwrap();
        let said = |d: &Diagnostic| match loaded.sources.locate(d.span) {
            Some(place) => format!("{}:{}:{}: {}", place.name, place.line, place.column, d.message),
            None => d.message.clone(),
        };
        let messages: Vec<String> = loaded.diagnostics.iter().map(said).collect();
        match class {
            "ERR" => {
                assert!(errors > 0, "{name} was accepted: {messages:?}");
                let stem = file.split('.').next().unwrap();
                assert!(messages.iter().all(|m| m.contains(stem)), "{name} is not named: {messages:?}");
            }
            "WARN" => assert!(errors + warnings > 0, "{name}: nothing said"),
            "OK" => {
                let (id, _) = loaded.description.of_role(Role::Shape).next().unwrap();
                let triangles = loaded.assets.mesh(id).map_or(0, |file| file.mesh.indices.len());
                assert!(errors == 0 && triangles > 0, "{name}: {messages:?}");
                assert!(loaded.description.find(Role::Camera, "auto").is_some());
            }
            other => assert_eq!(other, "ANY"),
        }
        seen += 1;
    }
    assert!(seen > 55, "{seen}");
}

/// The files of the collections that are refused, and for what: they name files outside their folder, or vertices
/// that they do not have.
const REFUSED: [(&str, &str); 8] = [
    ("box-external-resources-in-root.obj", "asset::outside"),
    ("box-external-resources.obj", "asset::outside"),
    ("box-incomplete-positions.obj", "obj::index"),
    ("box-missing-mtllib.obj", "asset::outside"),
    ("box-missing-texture.obj", "asset::outside"),
    ("invalid-relative-texture-index.obj", "obj::index"),
    ("invalid-relative-vertex-index.obj", "obj::index"),
    // Its vertices lack the list that its header announces.
    ("issue623.ply", "ply::truncated"),
];
/// Those in which there is no triangle.
const EMPTY: [&str; 14] = [
    "empty.obj",
    "empty.ply",
    "empty.stl",
    "face_in_group_name.obj",
    "invalid-face-definition.obj",
    "line-prim.obj",
    "points-prim.obj",
    "points.ply",
    "float_two_att_point_cloud.ply",
    "int_point_cloud.ply",
    "points_ascii.ply",
    "points_ascii_with_lists.ply",
    "points_emptyascii.ply",
    "points_emptyface.ply",
];
/// Those in which something is amiss, and what the first warning is about.
const WARNED: [(&str, &str); 31] = [
    ("box-complex-material-alpha.obj", "mtl::left-out"),
    ("box-complex-material.obj", "mtl::left-out"),
    ("box-incomplete-normals.obj", "obj::attribute"),
    ("box-incomplete-uvs.obj", "obj::attribute"),
    ("box-missing-attributes.obj", "obj::attribute"),
    ("box-mixed-attributes-2.obj", "obj::material"),
    ("box-transparent.obj", "mtl::transparency"),
    ("box-unnamed-material.obj", "mtl::name"),
    ("box-unnormalized.obj", "obj::normal"),
    ("face_in_group_name_mid_file.obj", "obj::attribute"),
    ("box-resources-in-root.obj", "obj::library"),
    ("box-texture-options.obj", "mtl::left-out"),
    ("fuze_ascii.ply", "ply::extra"),
    ("issue-92.obj", "mtl::image"),
    ("issue-95.obj", "mtl::left-out"),
    ("jacked.obj", "obj::library"),
    ("map-bump.obj", "mtl::left-out"),
    ("missing_material_file.obj", "obj::material"),
    ("mtl filename with whitespace issue46.obj", "obj::library"),
    ("nancolor.obj", "obj::color"),
    ("norm-texopt.obj", "mtl::left-out"),
    ("notenoughindices.obj", "obj::thin-face"),
    ("obj_with_no_face_in_chunk.obj", "obj::material"),
    ("pbr-mat-ext.obj", "mtl::left-out"),
    ("refl.obj", "mtl::left-out"),
    ("skin-weight.obj", "obj::unused"),
    ("smoothing-group-two-squares.obj", "obj::attribute"),
    ("test-nan.obj", "mesh::not-finite"),
    ("texture-filename-with-whitespace.obj", "mtl::left-out"),
    ("texture-options-issue-85.obj", "mtl::left-out"),
    ("tr-and-d-issue-43.obj", "mtl::transparency"),
];

#[test]
fn the_collections_load() {
    let Some(folder) = test_data("scenes") else { return };
    let mut paths = Vec::new();
    ENDINGS.iter().for_each(|e| files(&folder.join(e), &mut paths));
    assert!(paths.len() > 120, "{}", paths.len());
    for path in paths {
        let loaded = load(&path);
        let name = path.file_name().unwrap().to_str().unwrap();
        let [errors, warnings, _] = loaded.counts;
        let of = |list: &[(&'static str, &'static str)]| {
            list.iter().find(|(n, _)| *n == name).map(|(_, code)| *code)
        };
        let first = |severity: &str| loaded.messages.iter().find(|m| m.starts_with(severity)).cloned();
        let expected_first = |severity, code: &str| {
            let message = first(severity).unwrap_or_default();
            assert!(message.starts_with(&format!("{severity} {code} Some(")), "{name}: {message}");
        };
        if let Some(code) = of(&REFUSED) {
            assert!(errors > 0 && loaded.triangles() == 0, "{name} was accepted");
            expected_first("error", code);
            continue;
        }
        assert_eq!(errors, 0, "{name}: {:?}", loaded.messages);
        assert_eq!(loaded.triangles() == 0, EMPTY.contains(&name), "{name}");
        match of(&WARNED) {
            Some(code) => expected_first("warning", code),
            None if EMPTY.contains(&name) || name == "wallhole.obj" => assert!(warnings > 0),
            None => assert_eq!(warnings, 0, "{name}: {:?}", loaded.messages),
        }
    }
}

#[test]
fn an_asset_root_lets_textures_from_beside_in() {
    let Some(folder) = test_data("scenes/obj/obj2gltf") else { return };
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let root = folder.join("box-external-resources");
    let folders = Folders { root, asset_roots: vec![folder] };
    let mut scene = SceneDescription::default();
    scene.add(Node::new(Role::Shape, "mesh", "mesh").with("file", "box-external-resources.obj"));
    let assets = Assets::load(&mut scene, &folders, &mut sources, &mut out);
    assert!(!out.has_errors());
    let textures: Vec<_> = scene.of_role(Role::Texture).collect();
    assert!(!textures.is_empty() && textures.iter().all(|(id, _)| assets.image(*id).is_some()));
}

#[test]
fn one_mesh_is_the_same_in_every_format() {
    let Some(folder) = test_data("scenes/one-mesh-all-formats") else { return };
    let mesh = |name: &str| {
        let loaded = load(&folder.join(name));
        assert_eq!(loaded.counts, [0; 3], "{:?}", loaded.messages);
        let (id, _) = loaded.scene.of_role(Role::Shape).next().unwrap();
        loaded.assets.mesh(id).unwrap().mesh.clone()
    };
    let bits = |m: &TriangleMesh| -> Vec<[u32; 3]> {
        m.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
    };
    let off = mesh("knot.off");
    assert_eq!((off.positions.len(), off.indices.len()), (1152, 2304));
    for name in [
        "knot.obj",
        "knot-negative-indices.obj",
        "knot-ascii.ply",
        "knot-big_endian.ply",
        "knot-little_endian.ply",
    ] {
        let other = mesh(name);
        assert_eq!(other.indices, off.indices, "{name}");
        assert_eq!(bits(&other), bits(&off), "{name}");
    }
    // STL has corners only: the same points, in the order of the triangles.
    let corners = |m: &TriangleMesh| -> Vec<[[u32; 3]; 3]> {
        let bits = bits(m);
        m.indices.iter().map(|t| t.map(|i| bits[i as usize])).collect()
    };
    for name in ["knot-ascii.stl", "knot-binary.stl"] {
        let other = mesh(name);
        assert_eq!(other.positions.len(), off.positions.len(), "{name}");
        assert_eq!(corners(&other), corners(&off), "{name}");
    }
}
