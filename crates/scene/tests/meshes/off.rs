//! The OFF reader, feature by feature.

use crate::common::{Read, counts, read_in};
use penombre_math::color::srgb_decode;
use penombre_math::{Vec2, Vec3};
use penombre_scene::readers::MeshFormat;
use std::path::Path;

fn off(text: &str) -> Read {
    read_in(Path::new("."), MeshFormat::Off, text.as_bytes())
}

const QUAD: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn a_quad_becomes_two_triangles() {
    let read = off(&format!("OFF\n4 1 4\n{QUAD}4 0 1 2 3\n"));
    let mesh = &read.file().mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3]]);
    assert!(
        mesh.normals.is_empty() && mesh.uvs.is_empty() && mesh.colors.is_empty() && mesh.slots.is_empty()
    );
    assert!(mesh.face_colors.is_empty());
    assert_eq!(counts(&read.out), [0; 3]);
    assert_eq!(read.file().materials.len(), 1);
}

#[test]
fn headers_in_all_shapes() {
    let plain = off(&format!("OFF\n4 1 4\n{QUAD}4 0 1 2 3\n")).file().clone();
    for header in [
        "OFF 4 1 4\n",
        "# c\n\n OFF # c\r\n#\n4 1 0 # c\r\n",
        "OFF4 1 4\n",
        "OFF\n4 1\n",
        "OFF\n4\n1\n0\n",
        "\u{feff}off\n4 1 0\n",
    ] {
        let read = off(&format!("{header}{QUAD}\n# c\n4 0 1 2 3 # c"));
        assert_eq!(read.file(), &plain, "{header}");
        assert_eq!(counts(&read.out), [0; 3], "{header}");
    }
    let read = off(&format!("4 1 4\n{QUAD}4 0 1 2 3"));
    assert_eq!(read.file(), &plain);
    assert_eq!(
        read.only(),
        "warning off::magic m.off:1:1 the first line is not `OFF`: found `4`, taken as the number of vertices"
    );
    // All vertices on one line.
    let read = off(&format!("OFF 4 1 4\n{}\n4 0 1 2 3", QUAD.replace('\n', " ")));
    assert_eq!(read.file(), &plain);
}

#[test]
fn colours_are_display_colours() {
    let byte = |v: f32| srgb_decode(v / 255.0);
    let faces = "3 0 1 2 255 128 0\n3 0 2 3 0 255 0 255\n";
    let read = off(&format!("OFF\n4 2 0\n{QUAD}{faces}"));
    assert_eq!(read.file().mesh.face_colors, [[1.0, byte(128.0), 0.0], [0.0, 1.0, 0.0]]);
    // Fractions, and a face without a colour, which multiplies by one.
    let read = off(&format!("OFF\n4 2 0\n{QUAD}3 0 1 2 0.5 0.25 1 0.75\n3 0 2 3\n"));
    assert_eq!(read.file().mesh.face_colors, [[srgb_decode(0.5), srgb_decode(0.25), 1.0], [1.0; 3]]);
    // Whole numbers, but none above 1: fractions written short.
    let read = off(&format!("OFF\n4 2 0\n{QUAD}3 0 1 2 1 0 0\n3 0 2 3 0 0 1\n"));
    assert_eq!(read.file().mesh.face_colors, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    // An index into a colour map says nothing here.
    let read = off(&format!("OFF\n4 1 0\n{QUAD}4 0 1 2 3 7\n"));
    assert!(read.file().mesh.face_colors.is_empty());
    // The colour of a polygon is that of all its triangles.
    let read = off(&format!("OFF\n4 1 0\n{QUAD}4 0 1 2 3 255 0 0\n"));
    assert_eq!(read.file().mesh.face_colors, [[1.0, 0.0, 0.0]; 2]);
}

#[test]
fn prefixes_add_attributes_to_vertices() {
    let read = off(
        "STCNOFF\n3 1 0\n0 0 0 0 0 2 255 0 0 255 0.1 0.2\n1 0 0 0 3 0 0 255 0 255 0.3 0.4\n0 1 0 0 0 0 0 0 255 255 0.5 0.6\n3 0 1 2",
    );
    let mesh = &read.file().mesh;
    assert_eq!(mesh.normals, [Vec3::Z, Vec3::Y, Vec3::ZERO]);
    assert_eq!(mesh.colors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(mesh.uvs, [Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4), Vec2::new(0.5, 0.6)]);
    assert!(mesh.normal_indices.is_empty() && mesh.uv_indices.is_empty());
    let read = off("COFF\n3 1 0\n0 0 0 1.0 0.5 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2");
    assert_eq!(read.file().mesh.colors[0], [1.0, srgb_decode(0.5), 0.0]);
    let read = off("STOFF\n3 1 0\n0 0 0 7 8\n1 0 0 0 0\n0 1 0 0 0\n3 0 1 2");
    assert_eq!(read.file().mesh.uvs[0], Vec2::new(7.0, 8.0));
}

#[test]
fn unsupported_forms_say_so() {
    for (header, named) in [("4OFF", "4OFF"), ("nOFF", "nOFF"), ("OFF BINARY", "BINARY"), ("CnOFF", "CnOFF")]
    {
        let read = off(&format!("{header}\n3 1 0\n"));
        let message = read.only();
        assert!(
            message.starts_with("error off::unsupported m.off:1:") && message.contains(named),
            "{message}"
        );
    }
}

#[test]
fn faults_name_their_place() {
    let head = "OFF\n3 1 0\n0 0 0\n1 0 0\n";
    let cases = [
        ("", "error off::empty m.off:1:1 found an empty file, expected `OFF`, the counts and the vertices"),
        ("PLY\n1 2", "error off::magic m.off:1:1 this is no OFF file: found `PLY`, expected `OFF`"),
        (
            "OFF\n-3 1 0\n",
            "error off::counts m.off:2:1 found `-3`, expected the number of vertices, 0 or more",
        ),
        (
            "OFF\n3 x 0\n0 0 0 0 0 0 0 0 0 0",
            "error off::counts m.off:2:3 found `x`, expected the number of faces, 0 or more",
        ),
        (
            "OFF\n4000000000 1 0\n0 0 0\n",
            "error off::counts m.off:2:1 4000000000 vertices are announced: found 11 bytes behind that, expected more",
        ),
        (
            "OFF\n3 1 4000000000\n0 0 0\n",
            "error off::counts m.off:2:5 4000000000 edges are announced: found 7 bytes behind that, expected more",
        ),
        (
            "OFF\n3 1 -1\n0 0 0",
            "error off::counts m.off:2:5 found `-1`, expected the number of edges, 0 or more",
        ),
        (
            "OFF\n3 1\nx\n0 0 0",
            "error off::counts m.off:3:1 found `x`, expected the number of edges, 0 or more",
        ),
        (
            "OFF 3 1 nan\n0 0 0",
            "error off::counts m.off:1:9 found `nan`, expected the number of edges, 0 or more",
        ),
        (
            "OFF 3 1 2.5\n0 0 0",
            "error off::counts m.off:1:9 found `2.5`, expected the number of edges, 0 or more",
        ),
        ("OFF\n3", "error off::truncated m.off:2:2 found the end of the file, expected the number of faces"),
        (
            "OFF\n1 1\n0 0 0\n",
            "error off::truncated m.off:4:1 found the end of the file after 0 of 1 faces, expected all",
        ),
        (
            "OFF\n3 1 0\n0 0 0\n1 0",
            "error off::vertex m.off:4:1 vertex 1: found 2 numbers, expected 3 or more: x y z",
        ),
    ];
    for (text, expected) in cases {
        let messages = off(text).messages();
        assert_eq!(messages.first().map(String::as_str), Some(expected), "{text}");
    }
    let lines = [
        ("0 y 0\n3 0 1 2", "error off::number m.off:5:3 found `y`, expected a number"),
        (
            "0 1e39 0\n3 0 1 2",
            "error off::number m.off:5:3 found `1e39`, which is too large, expected a number below 3.4e38",
        ),
        ("0 1 0\n3 0 1 3", "error off::index m.off:6:7 found vertex 3 in the face, expected 0 to 2"),
        ("0 1 0\n3 0 -1 2", "error off::index m.off:6:5 found vertex -1 in the face, expected 0 to 2"),
        ("0 1 0\n3 0 1.5 2", "error off::index m.off:6:5 found `1.5`, expected the index of a vertex"),
        (
            "0 1 0\n1000000000 0 1 2",
            "error off::face m.off:6:1 the face announces 1000000000 corners: found 3 indices in its line, expected as many",
        ),
        ("0 1 0\n-3 0 1 2", "error off::face m.off:6:1 found `-3`, expected the number of corners of a face"),
        ("0 1 0\n3 0 1 2 x", "error off::number m.off:6:9 found `x`, expected a number"),
        ("0 1 0\n3 0 1 2 1 0 red", "error off::number m.off:6:13 found `red`, expected a number"),
        (
            "0 1 0\n3 0 1 2 1 1e39 0",
            "error off::number m.off:6:11 found `1e39`, which is too large, expected a number below 3.4e38",
        ),
    ];
    for (rest, expected) in lines {
        assert_eq!(off(&format!("{head}{rest}")).only(), expected);
    }
}

#[test]
fn normals_that_are_not_there_are_missed() {
    let read = off("NOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    assert_eq!(
        read.messages()[0],
        "error off::vertex m.off:3:1 vertex 0: found 3 numbers, expected 6 or more: x y z nx ny nz"
    );
}

#[test]
fn what_is_said_in_vain_is_a_warning() {
    let read = off("OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\nnan 0 0\n3 0 1 2\n3 0 1 3\n2 0 1\nmore");
    assert_eq!(read.file().mesh.indices, [[0, 1, 2]]);
    assert_eq!(
        read.messages(),
        [
            "warning off::trailing m.off:10:1 found `more` after the last face, expected the end of the file",
            "warning off::thin-face m.off:9:1 a face with fewer than 3 corners is left out",
            "warning mesh::not-finite m.off:6:1 a vertex is not a finite point: the faces that use it are left out",
        ]
    );
    let read = off("OFF\n3 1 0\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n");
    assert_eq!(
        read.only(),
        "warning off::extra m.off:3:7 numbers after a vertex are passed over (3 times, here the first)"
    );
    // Colours that are none are left out; a face without corners is thin.
    for (face, expected) in [
        (
            "3 0 1 2 nan 0 0",
            "face-color m.off:6:9 this is no face colour and is passed over, expected 3 or 4 numbers",
        ),
        (
            "3 0 1 2 1 0",
            "face-color m.off:6:9 this is no face colour and is passed over, expected 3 or 4 numbers",
        ),
        (
            "3 0 1 2 0.5",
            "face-color m.off:6:9 this is no face colour and is passed over, expected 3 or 4 numbers",
        ),
        ("3 0 1 2\n0", "thin-face m.off:7:1 a face with fewer than 3 corners is left out"),
        ("3 0 1 2\n1 0", "thin-face m.off:7:1 a face with fewer than 3 corners is left out"),
    ] {
        let count = face.lines().count();
        let read = off(&format!("OFF\n3 {count} 0\n0 0 0\n1 0 0\n0 1 0\n{face}\n"));
        assert_eq!(read.only(), format!("warning off::{expected}"));
        assert_eq!(read.file().mesh.indices, [[0, 1, 2]]);
        assert!(read.file().mesh.face_colors.is_empty());
    }
    let read = off("CNOFF\n3 1 0\n0 0 0 0 0 1 1 nan 1\n1 0 0 0 inf 1 1 1 1\n0 1 0 0 0 1 1 1 1\n3 0 1 2\n");
    assert_eq!(
        read.only(),
        "warning off::not-finite m.off:3:15 a number behind the position of a vertex is not finite and taken as 0 (2 times, here the first)"
    );
    assert_eq!((read.file().mesh.indices.len(), read.file().mesh.colors[0]), (1, [1.0, 0.0, 1.0]));
    let read = off("OFF 0 0 0");
    assert!(read.only().starts_with("warning mesh::empty"));
}

#[test]
fn reading_stops_after_twenty_errors() {
    let text = format!("OFF\n3 100 0\n0 0 0\n1 0 0\n0 1 0\n{}", "3 0 1 9\n".repeat(100));
    assert_eq!(counts(&off(&text).out), [20, 0, 1]);
}
