//! The STL reader, feature by feature.

use crate::common::{Read, counts, read_in};
use penombre_math::Vec3;
use penombre_math::color::srgb_decode;
use penombre_scene::readers::MeshFormat;
use std::path::Path;

fn stl(bytes: impl AsRef<[u8]>) -> Read {
    read_in(Path::new("."), MeshFormat::Stl, bytes.as_ref())
}

/// Two triangles with an edge in common, in two solids.
pub const TEXT: &str = "solid one name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid one name\nSOLID\n  FACET NORMAL 0 0 1\n  OUTER LOOP\n  VERTEX 1e0 0 -0\n  VERTEX 1 1 0\n  VERTEX 0 1 0\n  ENDLOOP\n  ENDFACET\nENDSOLID\n";

const TRIANGLES: [([f32; 9], u16); 2] =
    [([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], 0), ([1.0, 0.0, -0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0], 0)];

/// A binary file: corners and the 16 bits behind them.
pub fn binary(header: &str, triangles: &[([f32; 9], u16)]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for (corners, bits) in triangles {
        let numbers = [0.0, 0.0, 1.0].iter().chain(corners);
        numbers.for_each(|v: &f32| bytes.extend(v.to_le_bytes()));
        bytes.extend(bits.to_le_bytes());
    }
    bytes
}

#[test]
fn corners_at_one_position_are_one_vertex() {
    let text = stl(TEXT);
    assert_eq!(counts(&text.out), [0; 3], "{:?}", text.messages());
    let mesh = &text.file().mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)]);
    assert_eq!(mesh.indices, [[0, 1, 2], [1, 3, 2]]);
    assert!(mesh.normals.is_empty() && mesh.face_colors.is_empty());
    for header in ["", "solid yet binary"] {
        let read = stl(binary(header, &TRIANGLES));
        assert_eq!(read.file(), text.file());
        assert_eq!(counts(&read.out), [0; 3]);
    }
    let one_line = TEXT.replace("\n", " ").replace("one name", "\n");
    assert_eq!(stl(one_line.replace("SOLID", "SOLID\n")).file(), text.file());
}

#[test]
fn colours_of_triangles() {
    let with = |header: &str, bits: [u16; 2]| {
        let triangles = [(TRIANGLES[0].0, bits[0]), (TRIANGLES[1].0, bits[1])];
        stl(binary(header, &triangles)).file().mesh.face_colors.clone()
    };
    let part = |v: u16| srgb_decode(f32::from(v) / 31.0);
    let bits = 31 | 10 << 5 | 3 << 10;
    assert_eq!(with("", [bits | 0x8000, 0x7FFF]), [[part(3), part(10), 1.0], [1.0; 3]]);
    assert!(with("", [bits, 5]).is_empty(), "no colour without the highest bit");
    let whole = [64u8, 32, 16].map(|v| srgb_decode(f32::from(v) / 255.0));
    assert_eq!(with("a COLOR=\u{40}\u{20}\u{10}\u{7f} b", [bits, 0x8000]), [[1.0, part(10), part(3)], whole]);
    let gold = "COLOR=\u{40}\u{20}\u{10}\u{7f}";
    assert_eq!(with(gold, [0, 0]), [whole; 2], "bits that are all zero are no black");
    assert_eq!(with(gold, [0, 0x8000]), [[0.0; 3], whole]);
}

#[test]
fn faults_of_texts_name_their_line() {
    let cases = [
        (
            "endfacet",
            "enfacet",
            "error stl::statement m.stl:8:1 found `enfacet`, expected a statement of STL",
        ),
        (
            "vertex 0 0 0",
            "vertex 0 0",
            "error stl::vertex m.stl:4:1 the vertex: found 2 numbers, expected 3: x y z",
        ),
        ("vertex 0 0 0", "vertex 0 o 0", "error stl::number m.stl:4:10 found `o`, expected a number"),
        ("vertex 0 0 0\n", "\n", "error stl::statement m.stl:2:1 found 2 vertices in the facet, expected 3"),
        (
            "endloop",
            "vertex 1 2 3",
            "error stl::statement m.stl:2:1 found 4 vertices in the facet, expected 3",
        ),
        (
            "facet normal 0 0 1\n",
            "\n",
            "error stl::statement m.stl:4:1 found a vertex outside of a facet, expected `facet` before it",
        ),
        (
            "endfacet\n",
            "\n",
            "error stl::statement m.stl:2:1 found the end of the solid within this facet, expected `endfacet`",
        ),
    ];
    for (from, to, expected) in cases {
        let messages = stl(TEXT.replacen(from, to, 1)).messages();
        assert_eq!(messages.first().map(String::as_str), Some(expected), "{messages:?}");
    }
    let cut = stl(&TEXT[..TEXT.find("vertex 1 0 0").unwrap()]).only();
    assert_eq!(
        cut,
        "error stl::truncated m.stl:5:1 found the end of the file in a facet with 1 vertices, expected 3 and `endfacet`"
    );
    let cut = stl(TEXT.trim_end().trim_end_matches("ENDSOLID"));
    assert_eq!(cut.file().mesh.indices.len(), 2);
    assert!(cut.only().starts_with("warning stl::truncated"));
    assert!(stl("solid Empty\nendsolid Empty").only().starts_with("warning mesh::empty"));
    assert_eq!(stl("").only(), "error stl::empty m.stl:1:1 found an empty file, expected triangles");
}

#[test]
fn faults_of_binary_files_name_their_byte() {
    let whole = binary("", &TRIANGLES);
    let first = |bytes: &[u8]| stl(bytes).messages().remove(0);
    assert_eq!(
        first(&whole[..whole.len() - 1]),
        "error stl::truncated m.stl:1:1 2 triangles are announced at byte 80: expected a file of 184 bytes, found 183"
    );
    assert_eq!(
        first(&whole[..80]),
        "error stl::header m.stl:1:1 found 80 bytes, expected `solid` or a binary header of 84"
    );
    let longer = [&whole[..], &[0; 10]].concat();
    let read = stl(&longer);
    assert_eq!(read.file().mesh.indices.len(), 2);
    assert_eq!(
        read.only(),
        "warning stl::trailing m.stl:1:1 10 bytes follow from byte 184 on, behind the 2 triangles that the header announces"
    );
}

#[test]
fn triangles_without_a_finite_surface_are_left_out() {
    let mut triangles = vec![([f32::NAN; 9], 0x8000), TRIANGLES[0], ([f32::INFINITY; 9], 0)];
    triangles[1].1 = 0x801F;
    let read = stl(binary("", &triangles));
    assert_eq!(read.file().mesh.indices, [[0, 1, 2]]);
    assert_eq!(read.file().mesh.face_colors, [[0.0, 0.0, 1.0]]);
    assert_eq!(
        read.only(),
        "warning mesh::not-finite m.stl:1:1 triangle 0, at byte 84, has a corner that is not a finite point: such triangles are left out (2 times, here the first)"
    );
    let read = stl(TEXT.replacen("vertex 1 0 0", "vertex nan 0 0", 1));
    assert_eq!(read.file().mesh.indices.len(), 1);
    assert!(read.only().starts_with("warning mesh::not-finite m.stl:2:1"));
}
