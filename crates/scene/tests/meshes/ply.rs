//! The PLY reader, feature by feature: every text is also read in both binary encodings, which must give the same.

use crate::common::{Read, counts, read_in};
use penombre_math::color::srgb_decode;
use penombre_math::{Vec2, Vec3};
use penombre_scene::TriangleMesh;
use penombre_scene::readers::MeshFormat;
use std::path::Path;

pub fn read(bytes: &[u8]) -> Read {
    read_in(Path::new("."), MeshFormat::Ply, bytes)
}

/// A file in text, written anew in binary.
pub fn as_binary(text: &str, big: bool) -> Vec<u8> {
    let (header, body) = text.split_once("end_header\n").unwrap();
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!("{}end_header\n", header.replace("ascii", format)).into_bytes();
    let mut words = body.split_whitespace();
    let mut put = |kind: &str, word: &str| {
        let v: f64 = word.parse().unwrap();
        let mut number = match kind {
            "char" | "int8" => (v as i8).to_le_bytes().to_vec(),
            "uchar" | "uint8" => (v as u8).to_le_bytes().to_vec(),
            "short" | "int16" => (v as i16).to_le_bytes().to_vec(),
            "ushort" | "uint16" => (v as u16).to_le_bytes().to_vec(),
            "int" | "int32" => (v as i32).to_le_bytes().to_vec(),
            "uint" | "uint32" => (v as u32).to_le_bytes().to_vec(),
            "float" | "float32" => (v as f32).to_le_bytes().to_vec(),
            _ => v.to_le_bytes().to_vec(),
        };
        if big {
            number.reverse();
        }
        bytes.extend(number);
        v
    };
    let mut elements: Vec<(usize, Vec<Vec<&str>>)> = Vec::new();
    for line in header.lines() {
        let line: Vec<&str> = line.split_whitespace().collect();
        match line.first().copied().unwrap_or("") {
            "element" => elements.push((line[2].parse().unwrap(), Vec::new())),
            "property" => elements.last_mut().unwrap().1.push(line),
            _ => {}
        }
    }
    for (rows, properties) in elements {
        for property in std::iter::repeat_n(&properties, rows).flatten() {
            if property[1] == "list" {
                let length = put(property[2], words.next().unwrap());
                (0..length as usize).for_each(|_| _ = put(property[3], words.next().unwrap()));
            } else {
                put(property[1], words.next().unwrap());
            }
        }
    }
    bytes
}

/// The mesh of a text, the same in all encodings.
pub fn mesh(text: &str) -> TriangleMesh {
    let first = read(text.as_bytes());
    assert_eq!(counts(&first.out), [0; 3], "{:?}", first.messages());
    for big in [false, true] {
        let binary = read(&as_binary(text, big));
        assert_eq!(binary.file(), first.file(), "{text}");
        assert_eq!(counts(&binary.out), [0; 3], "{:?}", binary.messages());
    }
    (*first.file().mesh).clone()
}

/// A header: `element` and `property` lines without these words, between semicolons.
pub fn header(lines: &str) -> String {
    let line = |l: &str| match l.trim().split_once(' ') {
        Some(("vertex" | "face" | "tristrips" | "other", _)) => format!("element {}\n", l.trim()),
        _ => format!("property {}\n", l.trim()),
    };
    format!("ply\nformat ascii 1.0\n{}end_header\n", lines.split(';').map(line).collect::<String>())
}

pub const XYZ: &str = "float x; float y; float z";
pub const LIST: &str = "list uchar int vertex_indices";
pub const QUAD: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn positions_and_polygons() {
    let head = header(&format!("vertex 4; {XYZ}; face 2; {LIST}"));
    let found = mesh(&format!("{head}{QUAD}4 0 1 2 3\n3 0 2 3\n"));
    assert_eq!(found.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(found.indices, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    let rest = TriangleMesh {
        positions: found.positions.clone(),
        indices: found.indices.clone(),
        ..Default::default()
    };
    assert_eq!(found, rest);
    // Not convex: ears are cut.
    let found = mesh(&format!(
        "{}0 0 0\n2 0 0\n0.5 0.5 0\n0 2 0\n4 0 1 2 3\n",
        header(&format!("vertex 4; {XYZ}; face 1; {LIST}"))
    ));
    assert!(found.indices.iter().all(|t| t.contains(&2)));
}

#[test]
fn attributes_of_vertices() {
    let all =
        "float nx; float ny; float nz; uchar red; uchar green; uchar blue; uchar alpha; float s; float t";
    let rows = "0 0 0 0 0 2 255 0 0 9 0.25 0.5\n1 0 0 0 1 0 0 128 0 9 1 0\n0 1 0 1 0 0 0 0 255 9 0 1\n";
    let found =
        mesh(&format!("{}{rows}3 0 1 2\n", header(&format!("vertex 3; {XYZ}; {all}; face 1; {LIST}"))));
    assert_eq!(found.normals, [Vec3::Z, Vec3::Y, Vec3::X]);
    assert_eq!(found.uvs, [Vec2::new(0.25, 0.5), Vec2::X, Vec2::Y]);
    let green = srgb_decode(128.0 / 255.0);
    assert_eq!(found.colors, [[1.0, 0.0, 0.0], [0.0, green, 0.0], [0.0, 0.0, 1.0]]);
    assert!(found.normal_indices.is_empty() && found.uv_indices.is_empty());
    for names in ["u v", "texture_u texture_v"] {
        let (u, v) = names.split_once(' ').unwrap();
        let head = header(&format!("vertex 3; {XYZ}; float {v}; float {u}; face 1; {LIST}"));
        let found = mesh(&format!("{head}0 0 0 1 2\n1 0 0 3 4\n0 1 0 5 6\n3 0 1 2\n"));
        assert_eq!(found.uvs, [Vec2::new(2.0, 1.0), Vec2::new(4.0, 3.0), Vec2::new(6.0, 5.0)]);
    }
}

#[test]
fn normals_that_are_zero_are_none() {
    let head = header(&format!("vertex 3; {XYZ}; float nx; float ny; float nz; face 1; {LIST}"));
    let found = mesh(&format!("{head}0 0 0 0 0 1\n1 0 0 0 0 0\n0 1 0 0 0 1\n3 0 1 2\n"));
    assert_eq!(found.normal_indices, [[0, u32::MAX, 2]]);
    let found = mesh(&format!("{head}0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n"));
    assert!(found.normals.is_empty() && found.normal_indices.is_empty());
}

#[test]
fn every_type_of_number() {
    let names =
        "char uchar short ushort int uint float double int8 uint8 int16 uint16 int32 uint32 float32 float64";
    let plain = mesh(&format!(
        "{}0 0 0\n9 0 0\n0 7 0\n3 0 1 2\n",
        header(&format!("vertex 3; {XYZ}; face 1; {LIST}"))
    ));
    for name in names.split(' ') {
        let coordinates = format!("{name} x; {name} y; {name} z");
        let list = if name.starts_with(['f', 'd']) {
            LIST.to_owned()
        } else {
            format!("list {name} {name} vertex_index")
        };
        let head = header(&format!("vertex 3; {coordinates}; face 1; {list}"));
        assert_eq!(mesh(&format!("{head}0 0 0\n9 0 0\n0 7 0\n3 0 1 2\n")), plain, "{name}");
    }
}

#[test]
fn colours_of_every_range() {
    let colors = |kind: &str, rows: [&str; 3]| {
        let head = header(&format!("vertex 3; {XYZ}; {kind} red; {kind} green; {kind} blue; face 1; {LIST}"));
        let rows: String = rows.iter().map(|r| format!("0 0 0 {r}\n")).collect();
        mesh(&format!("{head}{rows}3 0 1 2\n")).colors
    };
    let of = |unit: f32, c: [f32; 3]| c.map(|v| srgb_decode(v / unit));
    assert_eq!(colors("ushort", ["65535 0 1000", "0 0 0", "1 2 3"])[0], of(65535.0, [65535.0, 0.0, 1000.0]));
    assert_eq!(colors("float", ["0.5 1 0.25", "0 0 0", "1 1 1"])[0], of(1.0, [0.5, 1.0, 0.25]));
    assert_eq!(colors("float", ["255 128 0", "0 0 0", "1 1 1"])[0], of(255.0, [255.0, 128.0, 0.0]));
    assert_eq!(colors("int", ["255 128 0", "0 0 0", "1 1 1"])[2], of(255.0, [1.0; 3]));
    assert_eq!(colors("uchar", ["1 1 1", "0 0 0", "1 0 1"])[0], of(255.0, [1.0; 3]));
}

/// Many triangles, now and then a larger polygon, with colours: longer than a block.
#[test]
fn long_files_with_all_kinds_of_faces() {
    let (mut rows, mut faces, mut triangles, mut colors) =
        (String::new(), String::new(), Vec::new(), Vec::new());
    let mut number = 0;
    for i in 0..1000u32 {
        rows.push_str(&format!("{} {} 0 {}\n", i % 30, i / 30, i % 7));
    }
    for i in 0..900u32 {
        let color = [i % 256, 255 - i % 256, i % 3];
        let linear = color.map(|c| srgb_decode(c as f32 / 255.0));
        let corners = match i {
            0 | 400 | 401 | 899 => vec![i, i + 1, i + 31, i + 30],
            _ => vec![i, i + 1, i + 30],
        };
        triangles.push([i, i + 1, corners[2]]);
        colors.push(linear);
        if corners.len() == 4 {
            triangles.push([i, i + 31, i + 30]);
            colors.push(linear);
        }
        let list: Vec<String> = corners.iter().map(u32::to_string).collect();
        faces.push_str(&format!(
            "5 {} {} {} {} {}\n",
            corners.len(),
            list.join(" "),
            color[0],
            color[1],
            color[2]
        ));
        number += 1;
    }
    let face = format!("face {number}; short flags; {LIST}; uchar red; uchar green; uchar blue");
    let grid =
        mesh(&format!("{}{rows}{faces}", header(&format!("vertex 1000; {XYZ}; float quality; {face}"))));
    // Every 30th quadrangle wraps round the grid; those above do not.
    assert_eq!(grid.positions[999], Vec3::new(9.0, 33.0, 0.0));
    assert_eq!(grid.indices.len(), triangles.len());
    assert_eq!((&grid.indices, &grid.face_colors), (&triangles, &colors));
}

#[test]
fn what_is_not_known_is_passed_over() {
    let head = header(&format!(
        "other 2; list short double a; char b; vertex 3; list uchar int more; {XYZ}; uchar confidence; face 1; uint flags; list uchar char own; {LIST}; float last"
    ));
    let body = "2 1.5 2 7\n0 8\n0 0 0 0 1\n2 5 6 1 0 0 2\n1 9 0 1 0 3\n77 2 1 2 3 0 1 2 0.5\n";
    let found = mesh(&format!("{head}{body}"));
    assert_eq!(found.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(found.indices, [[0, 1, 2]]);
}

#[test]
fn faces_may_stand_before_vertices() {
    let head = header(&format!("face 2; {LIST}; vertex 4; {XYZ}; other 1; int a"));
    assert_eq!(mesh(&format!("{head}3 0 1 2\n3 0 2 3\n{QUAD}5\n")).indices, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn texture_coordinates_of_corners() {
    let head = header(&format!("vertex 4; {XYZ}; face 2; {LIST}; list uchar float texcoord"));
    let found = mesh(&format!("{head}{QUAD}3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 0\n"));
    assert_eq!(found.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert_eq!(found.uv_indices, [[0, 1, 2], [u32::MAX; 3]]);
}

#[test]
fn strips_of_triangles() {
    let head = header(&format!("vertex 4; {XYZ}; tristrips 1; list int int vertex_indices"));
    let found = mesh(&format!("{head}{QUAD}10 0 1 2 3 3 -1 3 1 2 -1\n"));
    assert_eq!(found.indices, [[0, 1, 2], [2, 1, 3], [3, 1, 2]]);
}

#[test]
fn line_ends_and_comments_of_headers() {
    let head = header(&format!("vertex 3; {XYZ}; face 1; {LIST}"))
        .replace("1.0\n", "1.0 \ncomment end_header follows\nobj_info num_cols 5\n\n");
    let text = format!("{head}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let plain = mesh(&text);
    assert_eq!(read(text.replacen("ply", "ply \t", 1).as_bytes()).file().mesh.as_ref(), &plain);
    for end in ["\r\n", "\r"] {
        let other = read(text.replace('\n', end).as_bytes());
        assert_eq!(other.file().mesh.as_ref(), &plain);
        let binary = as_binary(&text, false);
        let at = binary.windows(12).position(|w| w == b"\nend_header\n").unwrap() + 12;
        let head = String::from_utf8(binary[..at].to_vec()).unwrap().replace('\n', end);
        let other = read(&[head.as_bytes(), &binary[at..]].concat());
        assert_eq!(other.file().mesh.as_ref(), &plain, "{:?}", other.messages());
    }
}

#[test]
fn faults_of_headers_name_their_place() {
    let cases = [
        ("", "error ply::empty m.ply:1:1 found an empty file, expected a line `ply`"),
        ("v 0 0 0\n", "error ply::magic m.ply:1:1 this is no PLY file: found `v`, expected a line `ply`"),
        (
            "ply\nend_header\n",
            "error ply::format m.ply:1:1 found no line `format`, expected one in the header",
        ),
        ("ply\nformat ascii 2.0\n", "error ply::format m.ply:2:14 found the version `2.0`, expected 1.0"),
        (
            "ply\nformat text 1.0\n",
            "error ply::format m.ply:2:8 found the format `text`, expected ascii, binary_little_endian or binary_big_endian",
        ),
        (
            "ply\nelement vertex -3\n",
            "error ply::count m.ply:2:16 found `-3`, expected the number of rows of `vertex`, 0 or more",
        ),
        (
            "ply\nelement vertex 18446744073709551616\n",
            "error ply::count m.ply:2:16 found `18446744073709551616`, expected the number of rows of `vertex`, below 2⁶³",
        ),
        ("ply\nelement vertex 3 4\n", "error ply::header m.ply:2:18 found `4`, expected the end of the line"),
        (
            "ply\nelement a 1\nproperty int x y\n",
            "error ply::header m.ply:3:16 found `y`, expected the end of the line",
        ),
        (
            "ply\nelement a 1\nproperty list uchar int x y\n",
            "error ply::header m.ply:3:27 found `y`, expected the end of the line",
        ),
        ("ply\nformat ascii 1.0 x\n", "error ply::header m.ply:2:18 found `x`, expected the end of the line"),
        (
            "ply\nformat ascii 1.0\nformat binary_little_endian 1.0\n",
            "error ply::format m.ply:3:1 found a second line `format`, expected one",
        ),
        (
            "ply\nelement vertex\n",
            "error ply::header m.ply:2:1 found the end of the line `element`, expected the number of its rows",
        ),
        (
            "ply\nproperty int x\n",
            "error ply::header m.ply:2:1 found the property `x`, expected an element before it",
        ),
        (
            "ply\nelement a 1\nproperty real x\n",
            "error ply::type m.ply:3:10 found the type `real`, expected one of PLY",
        ),
        (
            "ply\nelement a 1\nproperty list float int x\n",
            "error ply::type m.ply:3:15 found the type float for the length of a list, expected a whole one",
        ),
        (
            "ply\nelement a 1\nelement a 1\n",
            "error ply::element m.ply:3:9 found the element `a` twice, expected it once",
        ),
        (
            "ply\nfoo\n",
            "error ply::header m.ply:2:1 found `foo`, expected comment, element, property, obj_info or end_header",
        ),
        (
            "ply\nformat ascii 1.0\n",
            "error ply::header m.ply:3:1 found the end of the file in the header, expected a line `end_header`",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(read(text.as_bytes()).only(), expected);
    }
    let cases = [
        (
            "face 1; list uchar int vertex_indices".to_owned(),
            "3 0 0 0\n",
            "ply::vertex m.ply:3:9 found no element `vertex`, expected one with the properties x, y and z",
        ),
        (
            "vertex 1; int x; int y".to_owned(),
            "0 0\n",
            "ply::vertex m.ply:3:9 found no property `z` of vertices, expected x, y and z",
        ),
        (
            format!("vertex 1; {XYZ}; face 1; int a"),
            "0 0 0\n1\n",
            "ply::face m.ply:7:9 found no list `vertex_indices` in `face`, expected one",
        ),
        (
            format!("vertex 1; {XYZ}; face 1; list int float vertex_indices"),
            "0 0 0\n0\n",
            "ply::type m.ply:8:25 found fractions for the numbers of vertices, expected a list of int or uint",
        ),
    ];
    for (lines, body, expected) in cases {
        assert_eq!(read(format!("{}{body}", header(&lines)).as_bytes()).only(), format!("error {expected}"));
    }
}

#[test]
fn faults_of_data_name_their_place() {
    let head = header(&format!("vertex 3; {XYZ}; face 2; {LIST}"));
    let (points, good) = ("0 0 0\n1 0 0\n0 1 0\n", "3 0 1 2\n");
    let text = |rest: &str| read(format!("{head}{rest}").as_bytes()).messages().remove(0);
    let cases = [
        (
            format!("{points}{good}"),
            "ply::truncated m.ply:14:1 found the end of the file after 1 of 2 rows of `face`, expected all",
        ),
        (format!("0 0 0\n1 0 0\n0 y 0\n{good}"), "ply::number m.ply:12:3 found `y`, expected a number"),
        (
            format!("0 0 0\n1 0 0\n0 1e39 0\n{good}"),
            "ply::number m.ply:12:3 found `1e39`, which is too large, expected a number below 3.4e38",
        ),
        (
            format!("0 0 0\n1 0\n0 1 0\n{good}{good}"),
            "ply::truncated m.ply:11:1 found the end of the line of vertex 1, expected all of `z`",
        ),
        (
            format!("{points}{good}3 0 1\n"),
            "ply::truncated m.ply:14:1 found the end of the line of face 1, expected all of `vertex_indices`",
        ),
        (
            format!("{points}{good}-3 0 1 2\n"),
            "ply::number m.ply:14:1 face 1: found `-3`, expected the length of the list `vertex_indices`",
        ),
        (format!("{points}{good}3 0 1 3\n"), "ply::index m.ply:14:1 face 1: found vertex 3, expected 0 to 2"),
        (
            format!("{points}{good}3 0 -1 2\n"),
            "ply::index m.ply:14:1 face 1: found vertex -1, expected 0 to 2",
        ),
        (
            format!("{points}{good}3 0 1 2.5\n"),
            "ply::index m.ply:14:7 face 1: found vertex `2.5`, expected a whole number from -2147483648 to 2147483647 (int)",
        ),
        (
            format!("{points}{good}3 0 nan 2\n"),
            "ply::index m.ply:14:5 face 1: found vertex `nan`, expected a whole number from -2147483648 to 2147483647 (int)",
        ),
        (
            format!("{points}{good}3 18446744073709551616 1 2\n"),
            "ply::index m.ply:14:3 face 1: found vertex `18446744073709551616`, expected a whole number from -2147483648 to 2147483647 (int)",
        ),
        (
            format!("{points}{good}7 0 1 2 0 1 2 0\n"),
            "ply::face m.ply:14:1 face 1: found 7 corners, expected at most twice the 3 vertices",
        ),
        (
            format!("0 0 0\nnan 0 0\n0 1 0\n{good}"),
            "ply::not-finite m.ply:13:1 face 0: found vertex 1 with a position that is not finite, expected three finite numbers",
        ),
    ];
    for (rest, expected) in cases {
        assert_eq!(text(&rest), format!("error {expected}"));
    }
    let huge = header(&format!("vertex 9223372036854775806; {XYZ}; face 1; {LIST}"));
    let message = read(format!("{huge}{points}").as_bytes()).only();
    let expected =
        "9223372036854775806 rows of `vertex` are announced: expected at least 55340232221128654836 bytes";
    assert!(message.contains(expected), "{message}");
    let huge = header(&format!("vertex 4000000000; {XYZ}; face 1; {LIST}"));
    let message = read(format!("{huge}{points}").as_bytes()).only();
    assert!(message.starts_with("error ply::truncated m.ply:3:9 4000000000 rows of `vertex` are announced: expected at least 24000000000 bytes from byte 1"), "{message}");
}

#[test]
fn faults_of_binary_data_name_their_byte() {
    let head = header(&format!("vertex 3; {XYZ}; face 2; {LIST}"));
    let start = as_binary(&format!("{head}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"), false);
    let faces = start.len() - 2 * 13;
    let mut wild = start.clone();
    wild[faces + 13 + 5..faces + 13 + 9].copy_from_slice(&(-7i32).to_le_bytes());
    let place = "m.ply:7:9";
    let second = faces + 13;
    assert_eq!(
        read(&wild).only(),
        format!("error ply::index {place} face 1 at byte {second}: found vertex -7, expected 0 to 2")
    );
    let expected = format!(
        "error ply::truncated {place} face 1 at byte {second}: the list `vertex_indices` at byte {second} announces 3 values: expected 12 bytes, found 11"
    );
    assert_eq!(read(&start[..start.len() - 1]).only(), expected);
    let expected = format!(
        "error ply::truncated m.ply:3:9 3 rows of `vertex` are announced: expected 36 bytes from byte {} on, found 26",
        faces - 36
    );
    assert_eq!(read(&start[..faces - 10]).only(), expected);
    let mut broken = start.clone();
    broken[faces - 4..faces].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(
        read(&broken).only(),
        format!(
            "error ply::not-finite {place} face 0 at byte {faces}: found vertex 2 with a position that is not finite, expected three finite numbers"
        )
    );
    let mut thin = start.clone();
    thin.truncate(second);
    thin.extend([0]);
    let read = read(&thin);
    assert_eq!(read.file().mesh.indices, [[0, 1, 2]]);
    assert_eq!(
        read.only(),
        format!(
            "warning ply::thin-face {place} face 1 at byte {second} has fewer than 3 corners and is left out"
        )
    );
}

#[test]
fn what_is_said_in_vain_is_a_warning() {
    let head = header(&format!("vertex 4; {XYZ}; float x; face 1; {LIST}"));
    let points = "0 0 0 0\n1 0 0 7\n0 1 0 0\nnan 0 0 1 5\n";
    let read = read(format!("{head}{points}3 0 1 2\nmore").as_bytes());
    // A vertex that no face uses need not be finite: depth cameras write such.
    assert_eq!(read.file().mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO]);
    assert_eq!(
        read.messages(),
        [
            "warning ply::twice m.ply:7:16 `vertex` has two properties `x`: the first counts",
            "warning ply::extra m.ply:14:11 numbers behind those that the header lists are passed over",
            "warning ply::trailing m.ply:16:1 found `more` behind the last row, expected the end of the file",
        ]
    );
    let points = super::ply::read(format!("{}0 0 0\n", header(&format!("vertex 1; {XYZ}"))).as_bytes());
    assert!(points.only().starts_with("warning mesh::empty"));
}

#[test]
fn colours_of_faces_with_too_many_numbers_are_not_believed() {
    for kind in ["uchar", "ushort", "float"] {
        let color = format!("{kind} red; {kind} green; {kind} blue");
        let head = header(&format!("vertex 3; {XYZ}; face 1; {LIST}; {color}"));
        let read = read(format!("{head}0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 1 1 1 1 1 1 1 1 1\n").as_bytes());
        assert_eq!(read.file().mesh.face_colors, [[1.0; 3]]);
        assert!(read.only().starts_with("warning ply::extra m.ply:16:15"), "{}", read.only());
    }
}
