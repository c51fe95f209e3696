//! Files that were made to do harm, built here: long lines, counts that are not true, wrong encodings, bombs.

use super::Folder;
use super::corpus::{answer, textured};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const SMALL: [&str; 6] = ["--size", "16x12", "--spp", "1", "-o", "out.png"];

/// Renders a mesh file with that content from another folder. `class` as in the index of the corpus.
fn mesh(name: &str, content: &[u8], class: &str) -> String {
    let (folder, files) = (Folder::new(), Folder::new());
    let path = files.path(name);
    std::fs::write(&path, content).unwrap();
    let said = answer(&folder, &[&["render", path.to_str().unwrap()], &SMALL[..]].concat(), &path, class);
    assert!(said.len() < 20_000, "{name}: {} bytes are said", said.len());
    said
}

/// Converts an image file with that content, and renders a scene with it.
fn image(name: &str, content: &[u8], class: &str) {
    let (folder, files) = (Folder::new(), Folder::new());
    let path = files.path(name);
    std::fs::write(&path, content).unwrap();
    answer(&folder, &["convert", path.to_str().unwrap(), "out.exr"], &path, class);
    files.write("scene.toml", &textured(name));
    let scene = files.path("scene.toml");
    answer(&folder, &[&["render", scene.to_str().unwrap()], &SMALL[..]].concat(), &path, class);
}

fn utf16(text: &str) -> Vec<u8> {
    std::iter::once('\u{feff}').chain(text.chars()).flat_map(|c| (c as u16).to_le_bytes()).collect()
}

#[test]
fn encodings_and_ends_of_lines() {
    let face = format!("{TRIANGLE}f 1 2 3\n");
    for text in
        [face.clone(), face.replace('\n', "\r\n"), face.replace('\n', "\r"), format!("\u{feff}{face}")]
    {
        assert_eq!(mesh("a.obj", text.as_bytes(), "OK"), "");
    }
    assert!(mesh("a.obj", &utf16(&face), "ERR").contains("UTF-16"));
    assert!(mesh("a.off", &utf16("OFF\n3 1 0\n"), "ERR").contains("UTF-16"));
    assert_eq!(mesh("a.obj", format!("{TRIANGLE}f 1 2 3\\").as_bytes(), "OK"), "");
    mesh("a.obj", format!("{face}{}", "\0".repeat(4096)).as_bytes(), "WARN");
}

#[test]
fn lines_and_names_without_end() {
    let face = "f 1 2 3\n";
    let long = |c: &str| c.repeat(10_000_000);
    mesh("comment.obj", format!("# {}\n{TRIANGLE}{face}", long("x")).as_bytes(), "OK");
    mesh("name.obj", format!("{TRIANGLE}usemtl {}\n{face}", long("n")).as_bytes(), "OK");
    mesh("library.obj", format!("mtllib {}\n{TRIANGLE}{face}", "n".repeat(1_000_000)).as_bytes(), "OK");
    mesh("word.obj", format!("{TRIANGLE}f 1 2 {}\n", long("3")).as_bytes(), "ERR");
    mesh("digits.obj", format!("v {} 0 0\n", long("0")).as_bytes(), "OK");
    mesh("words.stl", format!("solid {}", long("x")).as_bytes(), "WARN");
    mesh("header.ply", format!("ply\n{}", long("x")).as_bytes(), "ERR");
    // A face that goes round its triangle millions of times, and as many corners that lie anywhere.
    let round = mesh("round.obj", format!("{TRIANGLE}f {}\n", "1 2 3 ".repeat(1_000_000)).as_bytes(), "OK");
    assert!(round.contains("a polygon with very many corners"), "{round}");
    let spread = |i: u64, k: u64| (i.wrapping_mul(k) >> 44) as u32;
    let vertex = |i| format!("{} {} 0\n", spread(i, 0x9E37_79B9_7F4A_7C15), spread(i, 0xD1B5_4A32_D192_ED03));
    let vertices: String = (0..300_000).map(vertex).collect();
    let corners: String = (0..300_000).map(|i| format!(" {i}")).collect();
    let tangle = mesh("tangle.off", format!("OFF\n300000 1 0\n{vertices}300000{corners}\n").as_bytes(), "OK");
    assert!(tangle.contains("a polygon with very many corners"), "{tangle}");
    let materials: String = (0..100_000).map(|i| format!("usemtl m{i}\n{face}")).collect();
    let many = mesh("materials.obj", format!("{TRIANGLE}{materials}").as_bytes(), "ERR");
    assert!(many.contains("found 100000 materials in use, expected at most 65536"), "{many}");
}

#[test]
fn numbers_at_the_ends_of_their_ranges() {
    for index in ["0", "-4", "4294967297", "18446744073709551617", "-9223372036854775808", "1.5", "1//1//1"] {
        mesh("a.obj", format!("{TRIANGLE}f {index} 2 3\n").as_bytes(), "ERR");
    }
    for number in ["0x10", "0,5", "1e39", "one"] {
        mesh("a.obj", format!("v {number} 0 0\n{TRIANGLE}f 1 2 3\n").as_bytes(), "ERR");
    }
    for number in ["1e-320", "1e-99999999999", "nan", "-inf"] {
        mesh("a.obj", format!("v {number} 0 0\n{TRIANGLE}f 2 3 4\n").as_bytes(), "OK");
    }
    let far = mesh("far.obj", b"v 3e38 0 0\nv -3e38 0 0\nv 0 3e38 0\nf 1 2 3\n", "ERR");
    assert!(far.contains("found a box from (-3e38, 0e0, 0e0) to (3e38"), "{far}");
    for counts in ["-3 1 0", "3 99999999999999999999 0", "1e3 1 0", "3 x 0"] {
        mesh("a.off", format!("OFF\n{counts}\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").as_bytes(), "ERR");
    }
    for count in ["18446744073709551615", "4000000000", "1e3", "-1", ""] {
        let head = format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n");
        let rest = "property float x\nproperty float y\nproperty float z\nend_header\n";
        mesh("a.ply", format!("{head}{rest}").as_bytes(), "ERR");
    }
    let binary = |count: u32| [&[0; 80][..], &count.to_le_bytes(), &[0; 50]].concat();
    for count in [2, u32::MAX] {
        mesh("a.stl", &binary(count), "ERR");
    }
    mesh("a.stl", &binary(1), "OK");
}

#[test]
fn lists_of_ply_that_lie() {
    let file = |list: &str, values: &[u8]| {
        let head = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
        let head = format!("{head}element face 1\nproperty list {list} vertex_indices\nend_header\n");
        let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
        [head.as_bytes(), &corners, values].concat()
    };
    let ints = |values: &[i32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    mesh("a.ply", &file("int int", &ints(&[3, 0, 1, 2])), "OK");
    mesh("a.ply", &file("float int", &ints(&[3, 0, 1, 2])), "ERR");
    mesh("a.ply", &file("int float", &ints(&[3, 0, 1, 2])), "ERR");
    for length in [-1, 4, i32::MAX, i32::MIN] {
        mesh("a.ply", &file("int int", &ints(&[length, 0, 1, 2])), "ERR");
    }
    for index in [-1, 3, i32::MAX] {
        mesh("a.ply", &file("int int", &ints(&[3, 0, 1, index])), "ERR");
    }
    // Rows that take no bytes cost no time, rows of empty lists no more than they have bytes.
    let nothing = "ply\nformat ascii 1.0\nelement nothing 4000000000\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    mesh("a.ply", nothing.as_bytes(), "OK");
}

#[test]
fn of_many_faults_the_first_are_told() {
    let folder = Folder::new();
    std::fs::write(folder.path("bad.png"), b"\x89PNG\r\n\x1a\nno more").unwrap();
    let texture = |i: usize| {
        format!(
            "[texture.t{i}]\ntype = \"image\"\nfile = \"bad.png\"\n[material.m{i}]\ntype = \"diffuse\"\ncolor = {{ texture = \"t{i}\" }}\n"
        )
    };
    folder.write("many.toml", &format!("penombre = 1\n{}", (0..300).map(texture).collect::<String>()));
    let letter = "Dear reader, this is a letter: it is no scene\n".repeat(500);
    folder.write("letter.toml", &letter);
    for name in ["many.toml", "letter.toml"] {
        let json = folder.run(&["check", "--json", name]).stdout;
        let all: serde_json::Value = serde_json::from_slice(&json).unwrap();
        let errors = all.as_array().unwrap().iter().filter(|fault| fault["severity"] == "error").count();
        assert!(errors > 20, "{errors}");
        let said = folder.refused(&["render", name]);
        assert_eq!(said.lines().filter(|line| line.starts_with("error: ")).count(), 20, "{said}");
        let (more, plural) = (errors - 20, if errors == 21 { "" } else { "s" });
        let rest = format!("… and {more} more error{plural}: `penombre check --json` tells all");
        assert!(said.contains(&rest) && said.len() < 10_000, "{said}");
    }
}

#[test]
fn names_that_are_odd_are_names() {
    let face = format!("{TRIANGLE}f 1 2 3\n");
    assert_eq!(mesh("a:b.obj", face.as_bytes(), "OK"), "");
    let turned = mesh("\u{202e}jbo.obj", format!("usemtl \u{202e}der\u{feff}\n{face}").as_bytes(), "OK");
    assert!(turned.contains("`\\u{202e}der\\u{feff}`") && !turned.contains('\u{202e}'), "{turned}");
}

/// A chunk of a PNG file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let crc = !kind.iter().chain(data).fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xEDB8_8320 } else { c >> 1 })
    });
    [&(data.len() as u32).to_be_bytes(), &kind[..], data, &crc.to_be_bytes()].concat()
}

/// A PNG file whose picture is packed in stored blocks.
fn png([width, height]: [u32; 2], bits_and_color: [u8; 2], rows: &[u8], before: &[u8]) -> Vec<u8> {
    let [w, h] = [width, height].map(u32::to_be_bytes);
    let header = [&w[..], &h, &bits_and_color, &[0, 0, 0]].concat();
    let length = rows.len() as u16;
    let (a, b) = rows
        .iter()
        .fold((1u32, 0u32), |(a, b), v| ((a + u32::from(*v)) % 65521, (a + u32::from(*v) + b) % 65521));
    let stored = [
        &[0x78, 1, 1][..],
        &length.to_le_bytes(),
        &(!length).to_le_bytes(),
        rows,
        &(b << 16 | a).to_be_bytes(),
    ];
    let parts =
        [chunk(b"IHDR", &header), before.to_vec(), chunk(b"IDAT", &stored.concat()), chunk(b"IEND", b"")];
    [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
}

#[test]
fn images_that_lie() {
    let row = [0; 14];
    image("good.png", &png([2, 2], [8, 2], &row, &[]), "OK");
    image("deep.png", &png([2, 2], [16, 2], &[0; 26], &[]), "OK");
    image(
        "long-text.png",
        &png([2, 2], [8, 2], &row, &chunk(b"tEXt", &[b"k\0", &[b'v'; 1_000_000][..]].concat())),
        "OK",
    );
    image("no-palette.png", &png([2, 2], [8, 3], &[0; 6], &[]), "ERR");
    image("short.png", &png([2, 2], [8, 2], &row[..7], &[]), "ERR");
    image("twice.png", &png([2, 2], [8, 2], &row, &chunk(b"IHDR", &[0; 13])), "ERR");
    image("wide.png", &png([i32::MAX as u32, 1], [1, 0], &row, &[]), "ERR");
    image("bomb.png", &png([16_000, 16_000], [1, 0], &[0; 65_535], &[]), "ERR");
    image("empty.gif", b"GIF89a\x01\0\x01\0\0\0\0;", "ERR");
    image("wide.gif", b"GIF89a\xff\xff\xff\xff\x80\0\0\0\0\0\0\0\0,\0\0\0\0\xff\xff\xff\xff\0\x02\0;", "ERR");
    image("wide.webp", b"RIFF\x14\0\0\0WEBPVP8L\x08\0\0\0\x2f\xff\xff\xff\x0f\0\0\0", "ERR");
    image("headless.jpg", &[&b"\xff\xd8"[..], &[0xff; 1_000_000]].concat(), "ERR");
    for (name, text) in [
        ("a.ppm", "P3\n2 2\n255\n1 1 1 1 1 1 1 1 1 1 1"),
        ("a.ppm", "P6 99999999999 9 255\n"),
        ("a.ppm", "P3\n1 1\n65536\n1 1 1"),
        ("a.pgm", "P5 0 5 255\n"),
        ("a.pbm", "P4\n100000 100000\n"),
        ("a.pfm", "PF\n1 1\nnan\n000000000000"),
        ("a.pfm", "PF\n99999 99999\n-1\n000000000000"),
        ("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 99999999999\n"),
        ("a.exr", "v/1\u{1}\u{2}\0\0\0aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"),
    ] {
        image(name, text.as_bytes(), "ERR");
    }
}

/// A picture of one colour in runs of 128 pixels takes three bytes for a pixel in memory, not three floats.
#[test]
fn large_pictures_keep_the_numbers_of_their_files() {
    let side = 7680u16;
    let header = [0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let size = side.to_le_bytes();
    let run = [255, 10, 20, 30];
    let runs = usize::from(side) * usize::from(side) / 128;
    let (folder, files) = (Folder::new(), Folder::new());
    let path = files.path("large.tga");
    std::fs::write(&path, [&header[..], &size, &size, &[24, 0x20], &run.repeat(runs)].concat()).unwrap();
    answer(&folder, &["convert", path.to_str().unwrap(), "out.png"], &path, "OK");
    files.write("scene.toml", &textured("large.tga"));
    let scene = files.path("scene.toml");
    answer(&folder, &[&["render", scene.to_str().unwrap()], &SMALL[..]].concat(), &path, "OK");
}
