//! The OBJ and MTL readers, feature by feature.

use crate::common::{Read, counts, read_in};
use penombre_math::color::srgb_decode;
use penombre_math::{Vec2, Vec3};
use penombre_scene::readers::MeshFormat;
use penombre_scene::{Node, ValueKind};
use std::path::Path;

pub fn obj(text: &str) -> Read {
    read_in(Path::new("."), MeshFormat::Obj, text.as_bytes())
}

/// Reads an OBJ beside other files.
pub fn obj_with(text: &str, files: &[(&str, &str)]) -> Read {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    read_in(folder.path(), MeshFormat::Obj, text.as_bytes())
}

pub fn numbers(node: &Node, name: &str) -> Vec<f64> {
    let number = |kind: &ValueKind| match kind {
        ValueKind::Float(v) => *v,
        other => panic!("{other:?}"),
    };
    match &node.param(name).unwrap().value.kind {
        ValueKind::Array(list) => list.iter().map(|v| number(&v.kind)).collect(),
        kind => vec![number(kind)],
    }
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn corners_in_all_forms() {
    let attributes = "vt 0.1 0.2\nvt 0.3\nvn 0 0 2\n";
    let mesh = |face: &str| (*obj(&format!("{QUAD}{attributes}{face}\n")).file().mesh).clone();
    let plain = mesh("f 1 2 3 4");
    assert_eq!(plain.indices, [[0, 1, 2], [0, 2, 3]]);
    assert!(plain.uvs.is_empty() && plain.normals.is_empty());
    for same in ["f -4 -3 -2 -1", "f 1/ 2// 3 +4", "fo 1 2 3 4", "f 1 \\\n 2 3\\\r\n4 # c"] {
        assert_eq!(mesh(same), plain, "{same}");
    }
    let full = mesh("f 1/1/1 2/2/1 3/-1/-1");
    assert_eq!(full.indices, [[0, 1, 2]]);
    assert_eq!(full.uvs, [Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.0)]);
    assert_eq!(full.uv_indices, [[0, 1, 1]]);
    assert_eq!((full.normals, full.normal_indices), (vec![Vec3::Z], vec![[0, 0, 0]]));
    let partly = mesh("f 1//1 2 3/1");
    assert_eq!(partly.normal_indices, [[0, u32::MAX, u32::MAX]]);
    assert_eq!(partly.uv_indices, [[u32::MAX, u32::MAX, 0]]);
}

#[test]
fn a_face_may_stand_before_its_vertices() {
    let read = obj(&format!("f 1 2 3\n{TRIANGLE}"));
    assert_eq!(read.file().mesh.indices, [[0, 1, 2]]);
    assert_eq!(counts(&read.out), [0; 3]);
}

#[test]
fn concave_polygons_are_cut_at_their_ears() {
    let read = obj("v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 2 3 4 1\n");
    let mesh = &read.file().mesh;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).z * 0.5
    };
    let areas: Vec<f32> = mesh.indices.iter().map(area).collect();
    assert_eq!(areas.iter().sum::<f32>(), 1.0);
    assert!(areas.iter().all(|a| *a > 0.0));
}

#[test]
fn vertex_colours_are_display_colours() {
    let read = obj("v 0 0 0 1 0.5 0\nv 1 0 0\nv 0 1 0 nan 0 0\nf 1 2 3\n");
    assert_eq!(read.file().mesh.colors, [[1.0, srgb_decode(0.5), 0.0], [1.0; 3], [1.0; 3]]);
    assert_eq!(read.only(), "warning obj::color m.obj:3:1 a colour is not finite and taken as white");
    let read = obj("v 0 0 0 255 51 0\nv 1 0 0 0 0 0 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert_eq!(read.file().mesh.colors, [[1.0, srgb_decode(0.2), 0.0], [0.0; 3], [0.0; 3]]);
    // A fourth number is w and no colour.
    assert!(obj("v 0 0 0 0.5\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").file().mesh.colors.is_empty());
}

#[test]
fn errors_name_their_place() {
    let cases = [
        ("f 0 1 2", "error obj::index m.obj:4:3 found vertex 0 in the face, expected an index from 1"),
        (
            "vt 0 0\nf 1/0 2/1 3/1",
            "error obj::index m.obj:5:3 found texture vertex 0 in the face, expected an index from 1",
        ),
        (
            "vn 0 0 1\nf 1//1 2//0 3//1",
            "error obj::index m.obj:5:8 found normal 0 in the face, expected an index from 1",
        ),
        (
            "vn 0 0 1\nf 1//1 -2/-0 3//1",
            "error obj::index m.obj:5:8 found texture vertex 0 in the face, expected an index from 1",
        ),
        ("f 1 2 9", "error obj::index m.obj:4:7 found vertex 9 in the face, expected 1 to 3"),
        (
            "f 1 2 99999999999999999999",
            "error obj::index m.obj:4:7 found vertex 99999999999999999999 in the face, expected 1 to 3",
        ),
        (
            "f -1 -2 -4",
            "error obj::index m.obj:4:9 found vertex -4 in the face, expected -3 to -1: 3 came before",
        ),
        (
            "f 1 two 3",
            "error obj::corner m.obj:4:5 found `two`, expected a corner such as 7, 7/1, 7//3 or 7/1/3",
        ),
        (
            "f 1/2/3/4 2 3",
            "error obj::corner m.obj:4:3 found `1/2/3/4`, expected a corner such as 7, 7/1, 7//3 or 7/1/3",
        ),
        ("v 1 2", "error obj::numbers m.obj:4:1 the vertex: found 2 numbers, expected at least 3: x y z"),
        ("vn 1 2", "error obj::numbers m.obj:4:1 the normal: found 2 numbers, expected 3: x y z"),
        ("vt", "error obj::numbers m.obj:4:1 the texture vertex: found 0 numbers, expected 1 to 3: u v w"),
        ("v 1 2 é", "error obj::number m.obj:4:7 found `é`, expected a number"),
        (
            "v 1e999 0 0",
            "error obj::number m.obj:4:3 found `1e999`, which is too large, expected a number below 3.4e38",
        ),
        (
            "\u{1}\u{2} 3",
            "error obj::not-text m.obj:4:1 this is no text: found `\u{fffd}\u{fffd}`, expected a statement of OBJ",
        ),
    ];
    for (line, expected) in cases {
        assert_eq!(obj(&format!("{TRIANGLE}{line}\n")).only(), expected);
    }
    let read = obj("hello world\nhow are you\n");
    assert_eq!(
        read.messages()[1],
        "error obj::not-obj m.obj:1:1 found no statement of OBJ, expected lines that begin with `v` and `f`: this is no OBJ file, or not all of it"
    );
    let read = obj(&format!("{TRIANGLE}{}", "f 9 9 9\n".repeat(50)));
    assert_eq!(counts(&read.out), [20, 0, 1]);
}

#[test]
fn errors_do_not_hide_warnings_and_all_come_in_the_order_of_the_file() {
    let read = obj(&format!("{TRIANGLE}f 1 2 9\nf 1 2\nfoo\nf 1 x 2\nvn 0 0 0\nf -4 1 2\nf 1 2 7\nf 2\n"));
    let places: Vec<String> =
        read.messages().iter().map(|m| m.split(' ').take(3).collect::<Vec<_>>().join(" ")).collect();
    let expected = [
        "error obj::index m.obj:4:7",
        "warning obj::thin-face m.obj:5:1",
        "warning obj::unknown m.obj:6:1",
        "error obj::corner m.obj:7:5",
        "warning obj::normal m.obj:8:1",
        "error obj::index m.obj:9:3",
        "error obj::index m.obj:10:7",
    ];
    assert_eq!(places, expected);
    // Also for those who sort by place: excerpts are numbered in the same order.
    let mut sorted = read.out.clone();
    sorted.sort_by_place();
    assert_eq!(sorted, read.out);
    assert!(read.messages()[1].contains("(2 times"));
    // The reader stops after twenty errors, and says so at the last of them in the file.
    let read = obj(&format!("f 1 2\n{}", "v x\n".repeat(50)));
    assert_eq!(counts(&read.out), [20, 1, 1]);
    assert!(read.messages()[0].starts_with("warning obj::thin-face m.obj:1:1"));
    assert!(read.messages()[20].starts_with("advice reader::too-many-errors m.obj:21:3"));
}

#[test]
fn what_is_said_in_vain_is_a_warning() {
    let base = format!("{TRIANGLE}f 1 2 3\n");
    let whole = obj(&base).file().mesh.clone();
    let cases = [
        ("f 1 2", "obj::thin-face m.obj:5:1 a face with fewer than 3 corners is left out"),
        ("f", "obj::thin-face m.obj:5:1 a face with fewer than 3 corners is left out"),
        ("l 1 2\nl 2 3\np 1", "obj::unused m.obj:5:1 `l`: points and lines are not rendered and passed over"),
        (
            "cstype bezier\ndeg 3",
            "obj::unused m.obj:5:1 `cstype`: free-form curves and surfaces are not rendered and passed over",
        ),
        ("foo 1\nfoo 2", "obj::unknown m.obj:5:1 `foo` is no statement of OBJ and is passed over"),
        ("\0\0\0", "obj::nul m.obj:5:1 NUL bytes are passed over, expected text"),
        ("usemtl red\nf 1 2", "obj::thin-face m.obj:6:1 a face with fewer than 3 corners is left out"),
    ];
    for (line, expected) in cases {
        let read = obj(&format!("{base}{line}\n"));
        assert_eq!(read.only(), format!("warning {expected}"));
        assert_eq!(read.file().mesh, whole, "{line}");
    }
    let read = obj(&format!("{base}v nan 0 0\nv 0 -inf 0\nf 1 2 4\nf 1 2 5\nf 4 5 1\n"));
    assert_eq!(
        read.only(),
        "warning mesh::not-finite m.obj:5:1 a vertex is not a finite point: the faces that use it are left out (3 times, here the first)"
    );
    assert_eq!(read.file().mesh.indices, whole.indices);
    let read = obj(&format!("{TRIANGLE}vn 0 0 0\nvn 0 3 0\nf 1/1/1 2//2 3//7\n"));
    assert_eq!(
        read.messages(),
        [
            "warning obj::normal m.obj:4:1 a normal has no direction and is not used",
            "warning obj::attribute m.obj:6:3 a corner refers to a normal or to texture coordinates that the file does not have: not used",
        ]
    );
    assert_eq!(read.file().mesh.normal_indices, [[u32::MAX, 1, u32::MAX]]);
    let bytes = [b"g \xff\xfe\n".as_slice(), base.as_bytes()].concat();
    let read = read_in(Path::new("."), MeshFormat::Obj, &bytes);
    assert_eq!(read.only(), "warning obj::name m.obj:1:3 a name is not UTF-8");
    assert!(obj("").only().starts_with("warning mesh::empty m.obj:1:1"));
    let read = obj(&format!("{base}s 1\no x\ng a f b\nlod 3\n"));
    assert_eq!(counts(&read.out), [0; 3]);
}

#[test]
fn materials_come_from_libraries() {
    let text = format!(
        "mtllib a.mtl\n{QUAD}f 1 2 3\nusemtl red one\nf 1 3 4\nusemtl\nf 1 2 4\nusemtl red one\nf 2 3 4\n"
    );
    let library =
        "newmtl red one\nKd 1 0.1 0\nKs 0.5\nNs 250\nKa 1 1 1\nd 1\nnewmtl\nKd 0 0 1\nKs 1 1 1\nillum 1\n";
    let read = obj_with(&text, &[("a.mtl", library)]);
    let file = read.file();
    assert_eq!(read.only(), "warning mtl::name a.mtl:7:1 found `newmtl` without a name, expected one");
    assert_eq!(file.mesh.slots, [0, 1, 2, 1]);
    let names: Vec<&str> = file.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["mesh/default", "mesh/red one", "mesh/unnamed"]);
    assert!(file.materials.iter().all(|m| m.type_name == "phong"));
    assert_eq!(numbers(&file.materials[1], "diffuse"), [1.0, 0.1, 0.0]);
    assert_eq!(numbers(&file.materials[1], "ambient"), [1.0, 0.1, 0.0]);
    assert_eq!(numbers(&file.materials[1], "specular"), [0.5; 3]);
    assert_eq!(numbers(&file.materials[1], "shininess"), [250.0]);
    assert_eq!(numbers(&file.materials[2], "specular"), [0.0; 3]);
    assert_eq!(numbers(&file.materials[0], "diffuse"), [0.8; 3]);
}

#[test]
fn several_libraries_on_a_line() {
    let text =
        format!("mtllib one two.mtl b.mtl\nmtllib c d.mtl\n{TRIANGLE}usemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n");
    let library = |name: &str, red: f64| format!("newmtl {name}\nKd {red} 0 0\n");
    let files =
        [("one two.mtl", library("a", 0.1)), ("b.mtl", library("b", 0.2)), ("c d.mtl", library("c", 0.3))];
    let files: Vec<(&str, &str)> = files.iter().map(|(n, c)| (*n, c.as_str())).collect();
    let read = obj_with(&text, &files);
    assert_eq!(counts(&read.out), [0; 3], "{:?}", read.messages());
    assert_eq!(numbers(&read.file().materials[0], "diffuse")[0], 0.2);
    assert_eq!(numbers(&read.file().materials[1], "diffuse")[0], 0.3);
}

#[test]
fn missing_libraries_and_materials_give_grey() {
    let read = obj_with(&format!("mtllib no.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\n"), &[]);
    assert_eq!(
        read.messages(),
        [
            "warning obj::library m.obj:1:8 the material library is not read, its materials are grey: there is no file `no.mtl`",
            "warning obj::material m.obj:5:8 the material `red` is not defined: its faces are grey",
        ]
    );
    assert_eq!(numbers(&read.file().materials[0], "diffuse"), [0.8; 3]);
    assert_eq!(read.file().materials[0].name, "mesh/red");
}

#[test]
fn options_of_maps_may_stand_behind_the_name() {
    let map = |line: &str| {
        let library = format!("newmtl m\nmap_Kd {line}\n");
        let text = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
        let read = obj_with(&text, &[("a.mtl", &library), ("my -x t.png", ""), ("t.png", "")]);
        (read.file().textures[0].node.clone(), read.messages())
    };
    let same = |a: &str, b: &str| {
        let ((a, said), (b, _)) = (map(a), map(b));
        assert!(a.says_the_same(&b), "{a:?} {b:?}");
        said
    };
    assert_eq!(same("t.png -s 2 3 1 -clamp on", "-s 2 3 1 -clamp on t.png"), [""; 0]);
    assert_eq!(same("my -x t.png -o 0.5 0.5", "-o 0.5 0.5 my -x t.png"), [""; 0]);
    assert_eq!(same("t.png # -s 2 2 2", "t.png"), [""; 0]);
    assert_eq!(
        same("t.png\t-blendu on -boost 3", "t.png"),
        ["warning mtl::option a.mtl:2:25 the option `-boost` is not applied by this version"]
    );
}

#[test]
fn maps_have_options_and_windows_paths() {
    let text = format!("mtllib sub\\a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let library =
        "newmtl m\nKd 0.5 0.5 0.5\nmap_Kd -s 2 3 1 -clamp on -o 0 0 0 -blendu on .\\my images\\t 1.png\n";
    let read = obj_with(&text, &[("sub/a.mtl", library), ("sub/my images/t 1.png", "")]);
    assert_eq!(counts(&read.out), [0; 3], "{:?}", read.messages());
    let texture = &read.file().textures[0];
    assert_eq!(texture.node.name, "mesh/m");
    assert_eq!(
        texture.node.param("file").unwrap().value.kind,
        ValueKind::String("sub/my images/t 1.png".into())
    );
    assert_eq!(numbers(&texture.node, "scale"), [2.0, 3.0]);
    assert_eq!(texture.node.param("wrap").unwrap().value.kind, ValueKind::String("clamp".into()));
    let place = read.sources.locate(texture.node.param("file").unwrap().value.span).unwrap();
    assert_eq!((place.name, place.line, place.column), ("sub/a.mtl", 3, 47));
    let diffuse = &read.file().materials[0].param("diffuse").unwrap().value.kind;
    assert!(matches!(diffuse, ValueKind::Table(t) if t[0].name == "texture"));
}

#[test]
fn faults_of_libraries_name_the_library() {
    let text = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let cases = [
        (
            "newmtl m\nKd red green blue\n",
            "warning mtl::number a.mtl:2:4 found `red`, expected a number, 0 or more",
        ),
        ("newmtl m\nKd 1 2\n", "warning mtl::numbers a.mtl:2:1 `Kd`: found 2 numbers, expected 3: r g b"),
        ("newmtl m\nNs -5\n", "warning mtl::number a.mtl:2:4 found `-5`, expected a number, 0 or more"),
        ("newmtl m\nNs\n", "warning mtl::numbers a.mtl:2:1 `Ns` has no number, expected one from 0 to 1000"),
        (
            "newmtl m\nKd 1 0 0\nnewmtl n\nnewmtl m\nKd 0 1 0\n",
            "warning mtl::twice a.mtl:4:8 the material `m` is defined twice: the first counts",
        ),
        (
            "newmtl m\nmap_Kd ~/a.mtl\nnewmtl n\nmap_Kd x\\a.mtl\n",
            "warning mtl::image a.mtl:2:8 there is no file `~/a.mtl`: `a.mtl` is used, which has its last name",
        ),
        ("Kd 1 1 1\nnewmtl m\n", "warning mtl::order a.mtl:1:1 found `Kd` before any `newmtl`: passed over"),
        ("newmtl m\nmap_Kd\n", "warning mtl::map a.mtl:2:1 `map_Kd` names no file"),
        (
            "newmtl m\nmap_Kd no.png\n",
            "warning mtl::image a.mtl:2:8 there is no file `no.png`: the plain colour is used",
        ),
        (
            "newmtl m\nbump a.png\nmap_Bump b.png\nKa 1 1 1\nPs 0\nnewmtl n\nnorm c.png\n",
            "warning mtl::left-out a.mtl:2:1 `bump`: bump and normal maps are not rendered and left out",
        ),
        (
            "newmtl m\nfoo 1\n",
            "advice mtl::unknown a.mtl:2:1 `foo` is no statement of MTL that is known here",
        ),
        (
            "newmtl m\nmap_Kd -t 0.5 a.mtl\n",
            "warning mtl::option a.mtl:2:8 the option `-t` is not applied by this version",
        ),
    ];
    for (library, expected) in cases {
        let read = obj_with(&text, &[("a.mtl", library)]);
        assert_eq!(read.only(), expected);
        assert!(read.file.is_some());
    }
}

#[test]
fn files_outside_the_folder_are_refused_and_not_shown() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("secret.mtl"), "hunter2 hunter2\n").unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let text = format!("mtllib ../secret.mtl\n{TRIANGLE}f 1 2 3\n");
    let read = read_in(&inner, MeshFormat::Obj, text.as_bytes());
    let message = read.only();
    assert!(
        message.starts_with("error asset::outside m.obj:1:8 found `../secret.mtl`, which lies outside"),
        "{message}"
    );
    assert!(read.out.iter().all(|d| d.help.contains("--asset-root")));
    assert!(!format!("{:?}{:?}", read.out, read.sources).contains("hunter2"));
    std::fs::write(inner.join("a.mtl"), "newmtl m\nmap_Kd ../../../etc/passwd\n").unwrap();
    let read =
        read_in(&inner, MeshFormat::Obj, format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n").as_bytes());
    assert!(
        read.only()
            .starts_with("error asset::outside a.mtl:2:8 found `../../../etc/passwd`, which lies outside")
    );
}

#[test]
fn thousands_of_bad_materials_are_told_quickly_and_briefly() {
    let count = 20_000;
    let numbered = |line: &str| (0..count).map(|i| line.replace('@', &i.to_string())).collect::<String>();
    let library = numbered("newmtl m@\nKd x 0 0\nmap_Kd t@.png\n");
    let text = |libraries: &str| format!("{libraries}{TRIANGLE}{}", numbered("usemtl m@\nf 1 2 3\n"));
    let begin = std::time::Instant::now();
    for (text, files) in [
        (text(&"mtllib a.mtl\n".repeat(100)), vec![("a.mtl", library.as_str())]),
        (text(&numbered("mtllib no@.mtl\n")), vec![]),
        (text(""), vec![]),
    ] {
        let read = obj_with(&text, &files);
        assert_eq!(counts(&read.out), [0, 20, 1]);
        assert!(read.messages()[20].contains(": further warnings are left out"));
        assert_eq!(read.file().materials.len(), count);
    }
    assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
}
