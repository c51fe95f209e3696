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

/// The first message about a text in which something is changed.
fn changed(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "{from}");
    stl(TEXT.replacen(from, to, 1)).messages().remove(0)
}

#[test]
fn texts_must_have_all_words() {
    let statements = [
        ("solid one", "solidx one", "1:1 found text that begins with `solidx`, expected `solid`"),
        ("solid one name\n", "", "1:1 found text that begins with `facet`, expected `solid`"),
        ("solid one", "xsolid one", "1:1 found text that begins with `xsolid`, expected `solid`"),
        ("facet normal", "facet abnormal", "2:7 found `abnormal`, expected `normal`"),
        ("facet normal 0 0 1", "facet", "3:1 found `outer`, expected `normal`"),
        ("facet normal 0 0 1\n", "", "2:1 found `outer`, expected `facet` or `endsolid`"),
        ("0 0 1\n", "0 0 1 0\n", "2:20 found `0`, expected `outer loop`"),
        ("outer loop", "outer", "4:1 found `vertex`, expected `outer loop`"),
        ("outer loop", "loop", "3:1 found `loop`, expected `outer loop`"),
        ("outer loop\n", "", "3:1 found `vertex`, expected `outer loop`"),
        ("vertex 0 0 0\n", "", "6:1 found `endloop`, expected `vertex`: a facet has three"),
        ("vertex 0 0 0", "vertex 0 0 0 0", "4:14 found `0`, expected `vertex`: a facet has three"),
        ("endloop", "vertex 1 2 3", "7:1 found `vertex`, expected `endloop`"),
        ("endloop\n", "", "7:1 found `endfacet`, expected `endloop`"),
        ("endloop", "end loop", "7:1 found `end`, expected `endloop`"),
        ("endfacet", "enfacet", "8:1 found `enfacet`, expected `endfacet`"),
        ("endfacet\n", "", "8:1 found `endsolid`, expected `endfacet`"),
        ("endsolid one name\n", "", "9:1 found `SOLID`, expected `facet` or `endsolid`"),
        ("endsolid one name", "endsolid\nmore", "10:1 found `more`, expected `solid` or the end of the file"),
        (
            "ENDSOLID\n",
            "ENDSOLID\n\0\0",
            "19:1 found `\u{fffd}\u{fffd}`, expected `solid` or the end of the file",
        ),
    ];
    for (from, to, expected) in statements {
        assert_eq!(changed(from, to), format!("error stl::statement m.stl:{expected}"));
    }
    let numbers = [
        ("vertex 0 0 0", "vertex 0 0", "vertex m.stl:4:1 the vertex: found 2 numbers, expected 3: x y z"),
        ("normal 0 0 1", "normal 0 0", "vertex m.stl:2:7 the normal: found 2 numbers, expected 3: x y z"),
        ("vertex 0 0 0", "vertex 0 o 0", "number m.stl:4:10 found `o`, expected a number"),
        ("normal 0 0 1", "normal 0 o 1", "number m.stl:2:16 found `o`, expected a number"),
    ];
    for (from, to, expected) in numbers {
        assert_eq!(changed(from, to), format!("error stl::{expected}"));
    }
    // One fault gives one message, and those behind it are found.
    let two = TEXT.replacen("endloop", "endlop", 1).replacen("1 1 0", "1 one 0", 1);
    assert_eq!(stl(two).messages().len(), 2);
}

#[test]
fn texts_that_were_cut_say_what_is_missing() {
    let cut = |at: usize| stl(TEXT[..at].trim_end()).messages().remove(0);
    let behind = |words: &str| TEXT.find(words).unwrap() + words.len();
    let cases = [
        (behind("solid one name"), "1:15", "`facet` or `endsolid`"),
        (behind("solid"), "1:6", "`facet` or `endsolid`"),
        (behind("facet"), "2:6", "`normal`"),
        (behind("outer"), "3:6", "`outer loop`"),
        (behind("vertex 0 0 0"), "4:13", "`vertex`: a facet has three"),
        (behind("vertex 0 1 0"), "6:13", "`endloop`"),
        (behind("endloop"), "7:8", "`endfacet`"),
        (behind("endfacet"), "8:9", "`facet` or `endsolid`"),
        (behind("ENDFACET"), "17:11", "`facet` or `endsolid`"),
    ];
    for (at, place, expected) in cases {
        let message =
            format!("error stl::truncated m.stl:{place} found the end of the file, expected {expected}");
        assert_eq!(cut(at), message);
    }
    assert_eq!(
        cut(behind("vertex 0 0")),
        "error stl::vertex m.stl:4:1 the vertex: found 2 numbers, expected 3: x y z"
    );
    // Whatever is missing at the end, it is no file.
    let ends = [TEXT.len(), TEXT.len() - 1, behind("endsolid one name\n"), behind("endsolid")];
    for at in (0..TEXT.len()).filter(|at| !ends.contains(at)) {
        let read = stl(&TEXT[..at]);
        let is_named = (behind("endsolid")..behind("endsolid one name\n")).contains(&at);
        assert!(read.file.is_none() || is_named, "{at}: {:?}", read.messages());
    }
    assert!(stl("solid Empty\nendsolid Empty").only().starts_with("warning mesh::empty"));
    assert_eq!(stl("").only(), "error stl::empty m.stl:1:1 found an empty file, expected triangles");
}

#[test]
fn texts_may_be_laid_out_in_many_ways() {
    let whole = stl(TEXT).file().clone();
    let same = [
        TEXT.to_uppercase(),
        TEXT.replace('\n', "\r\n"),
        TEXT.replace('\n', "\r"),
        TEXT.replace('\n', "\n\n \t"),
        TEXT.replace(' ', " \t "),
        format!("\u{feff}\n  {TEXT}"),
        format!("{TEXT}\n \n"),
        TEXT.trim_end().to_owned(),
        TEXT.replacen("solid one name", "solid (1) facet normal é", 1),
        TEXT.replacen("solid one name", "solid", 1),
        TEXT.replacen("endsolid one name", "endsolid another", 1),
        TEXT.replacen("endsolid one name", "endsolid", 1),
        TEXT.replace("one name\nfacet", "one name facet").replace("SOLID\n  FACET", "SOLID FACET"),
        TEXT.replacen("normal", "\nnormal", 1).replacen("outer loop", "outer\nloop", 1),
    ];
    for text in same {
        let read = stl(&text);
        assert_eq!(read.file(), &whole, "{text}");
        assert_eq!(counts(&read.out), [0; 3]);
    }
}

#[test]
fn texts_are_not_taken_as_binary() {
    let page = format!("<!DOCTYPE html>\n{}", "<p>Not found</p>".repeat(20));
    assert_eq!(
        stl(&page).only(),
        "error stl::statement m.stl:1:1 found text that begins with `<!DOCTYPE`, expected `solid`"
    );
    let expected =
        "error stl::statement m.stl:1:1 found text that begins with `\u{fffd}solid`, expected `solid`";
    assert_eq!(stl(format!("\u{1}{TEXT}")).only(), expected);
    for big in [false, true] {
        let wide: Vec<u8> =
            TEXT.encode_utf16().flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect();
        assert_eq!(stl(wide).only(), "error mesh::encoding m.stl:1:1 found text in UTF-16, expected UTF-8");
    }
    // Whatever a binary file has as its text.
    for header in
        ["solid", "solid x\nfacet normal 0 0 1\nouter loop", "\u{feff}solid", "facet normal", "Made by x"]
    {
        assert_eq!(stl(binary(header, &TRIANGLES)).file(), stl(TEXT).file());
        let whole = binary(header, &TRIANGLES);
        assert!(stl(&whole[..whole.len() - 1]).only().starts_with("error stl::truncated"), "{header}");
    }
    // Random bytes behind the first word.
    let mut state = 1u32;
    let noise: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
    .take(4000)
    .collect();
    for length in [1, 5, 83, 84, 134, 1000] {
        for noise in noise.chunks(length).take(4) {
            assert!(stl([b"solid ", noise].concat()).file.is_none());
        }
    }
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
        first(&[0; 80]),
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
    // Normals change nothing.
    let read = stl(TEXT.replacen("0 0 1\n", "0 nan 1\n", 1));
    assert_eq!(read.file(), stl(TEXT).file());
    assert_eq!(
        read.only(),
        "warning stl::normal m.stl:2:7 a triangle has a normal that is not finite: normals of STL files are not used"
    );
    let mut bytes = binary("", &TRIANGLES);
    bytes[134..138].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_eq!(
        stl(bytes).only(),
        "warning stl::normal m.stl:1:1 triangle 1, at byte 134, has a normal that is not finite: normals of STL files are not used"
    );
}
