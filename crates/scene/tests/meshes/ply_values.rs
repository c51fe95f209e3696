//! The PLY reader: numbers that are not finite or do not fit, and encodings.

use crate::common::counts;
use crate::ply::{LIST, QUAD, XYZ, as_binary, header, mesh, read};
use penombre_math::color::srgb_decode;
use penombre_math::{Vec2, Vec3};

#[test]
fn a_byte_order_mark_may_stand_first() {
    let text = format!("{}{QUAD}4 0 1 2 3\n", header(&format!("vertex 4; {XYZ}; face 1; {LIST}")));
    let plain = mesh(&text);
    for bytes in [text.clone().into_bytes(), as_binary(&text, true)] {
        let read = read(&[b"\xef\xbb\xbf", &bytes[..]].concat());
        assert_eq!((read.file().mesh.as_ref(), counts(&read.out)), (&plain, [0; 3]));
    }
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(&wide).only(), "error mesh::encoding m.ply:1:1 found text in UTF-16, expected UTF-8");
}

#[test]
fn attributes_that_are_not_finite_are_told_and_replaced() {
    let normals = "double nx; float ny; float nz";
    let colors = "float red; float green; float blue";
    let head =
        header(&format!("vertex 3; {XYZ}; {normals}; float s; float t; {colors}; face 1; {LIST}; {colors}"));
    let rows = "0 0 0 0 0 1 0 0 1 0 0\n1 0 0 0 nan 1 nan 0 0 inf 0\n0 1 0 1e300 0 1 0 1 nan 0 0\n";
    let text = format!("{head}{rows}3 0 1 2 0 nan 0\n");
    let said = [
        (
            "ply::normal",
            "vertex 1",
            " has a normal that is not finite: it has none (2 times, here the first)",
        ),
        ("ply::uv", "vertex 1", " has texture coordinates that are not finite: taken as 0"),
        (
            "ply::color",
            "vertex 1",
            " has a colour that is not finite: taken as white (2 times, here the first)",
        ),
        ("ply::color", "face 0", " has a colour that is not finite: taken as white"),
    ];
    for (bytes, is_text) in
        [(text.clone().into_bytes(), true), (as_binary(&text, false), false), (as_binary(&text, true), false)]
    {
        let read = read(&bytes);
        let messages = read.messages();
        assert_eq!(messages.len(), 4, "{messages:?}");
        for (message, (code, row, what)) in messages.iter().zip(said) {
            let line = if row == "face 0" { 24 } else { 22 };
            let place = if is_text { format!("m.ply:{line}:1 ") } else { String::new() };
            assert!(message.starts_with(&format!("warning {code} {place}")), "{message}");
            assert!(message.contains(row) && message.ends_with(what), "{message}");
            assert!(is_text || message.contains(&format!("{row} at byte ")), "{message}");
        }
        let mesh = &read.file().mesh;
        assert_eq!(mesh.normals, [Vec3::Z, Vec3::ZERO, Vec3::ZERO]);
        assert_eq!(mesh.normal_indices, [[0, u32::MAX, u32::MAX]]);
        assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::ZERO, Vec2::Y]);
        assert_eq!(mesh.colors, [[1.0, 0.0, 0.0], [1.0; 3], [1.0; 3]]);
        assert_eq!(mesh.face_colors, [[1.0; 3]]);
    }
    // Rows with a list, and those in a long run.
    let head = header(&format!("vertex 3; {XYZ}; face 300; {LIST}; {colors}; list uchar float texcoord"));
    let faces = format!("3 0 1 2 0 0 0 6 0 0 0 0 0 0\n{}", "3 0 1 2 0 0 nan 6 0 0 0 0 inf 0\n".repeat(299));
    let text = format!("{head}0 0 0\n1 0 0\n0 1 0\n{faces}");
    for bytes in [text.clone().into_bytes(), as_binary(&text, false)] {
        let messages = read(&bytes).messages();
        assert!(
            messages.len() == 2 && messages.iter().all(|m| m.contains("face 1") && m.contains("(299 times"))
        );
    }
    let head = header(&format!("vertex 3; {XYZ}; face 300; {LIST}; {colors}"));
    let text = format!("{head}0 0 0\n1 0 0\n0 1 0\n{}3 0 1 2 nan 0 0\n", "3 0 1 2 0 0 1\n".repeat(299));
    let start = as_binary(&text, false).len() - 25;
    let message = read(&as_binary(&text, false)).only();
    assert!(message.contains(&format!("face 299 at byte {start} has a colour")), "{message}");
}

#[test]
fn numbers_too_large_for_single_precision_are_called_so() {
    let head = header(&format!("vertex 3; double x; double y; double z; face 1; {LIST}"));
    let with = |v: &str| format!("{head}0 0 0\n1 {v} 0\n0 1 0\n3 0 1 2\n");
    for (v, expected) in [
        ("1e300", "too large for a 32-bit float, expected numbers below 3.4e38"),
        ("inf", "not finite, expected three finite numbers"),
        ("nan", "not finite, expected three finite numbers"),
    ] {
        let text = with(v);
        for bytes in [text.clone().into_bytes(), as_binary(&text, false), as_binary(&text, true)] {
            let message = read(&bytes).only();
            assert!(
                message.ends_with(&format!("found vertex 1 with a position that is {expected}")),
                "{message}"
            );
        }
    }
}

#[test]
fn numbers_of_texts_beyond_their_type_are_told() {
    let head = header(
        "vertex 3; uchar x; short y; float z; face 1; list uchar int vertex_indices; uchar red; uchar green; uchar blue",
    );
    let points = "0 0 0\n300 0 0\n0 1 0\n";
    let one = read(format!("{head}{points}3 0 1 2 9 9 9\n").as_bytes());
    assert_eq!(
        one.only(),
        "warning ply::range m.ply:14:1 found `300`, expected a whole number from 0 to 255 (uchar): used as it stands"
    );
    assert_eq!(one.file().mesh.positions[1].x, 300.0);
    let all = read(format!("{head}-1 0 0\n1.5 40000 0\n1 1 0\n3 0 1 2 300 -1 1.5\n").as_bytes());
    assert_eq!(
        all.only(),
        "warning ply::range m.ply:13:1 found `-1`, expected a whole number from 0 to 255 (uchar): used as it stands (6 times, here the first)"
    );
    assert_eq!(all.file().mesh.face_colors, [[1.0, 0.0, srgb_decode(1.0 / 255.0)]]);
    // Whole numbers may be written with a point.
    let whole = read(format!("{head}{points}3 0 1.0 2 9.0 9 9\n").replace("300", "3.0").as_bytes());
    assert_eq!(counts(&whole.out), [0; 3]);
    // A polygon of more corners than its list may have.
    let points: String = (0..300).map(|i| format!("{i} {} 0\n", i * i)).collect();
    let list: String = (0..300).map(|i| format!(" {i}")).collect();
    let head = header(&format!("vertex 300; {XYZ}; face 1; {LIST}"));
    let message = read(format!("{head}{points}300{list}\n").as_bytes()).only();
    assert!(message.starts_with("warning ply::range m.ply:310:1 found `300`, expected"), "{message}");
}
