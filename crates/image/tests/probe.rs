//! Sizes told from the beginnings of files.

use penombre_image::{
    ColorSpace, Format, Image, MAX_PIXELS, PROBE_BYTES, WriteOptions, decode, encode, probe,
};
use std::path::{Path, PathBuf};

fn check(bytes: &[u8], name: &Path) {
    let image = decode(bytes, name, ColorSpace::Auto).expect("whole").image;
    let head = &bytes[..bytes.len().min(PROBE_BYTES as usize)];
    let size = probe(head, bytes.len() as u64, name).expect("a size");
    let (w, h) = (u64::from(image.width()), u64::from(image.height()));
    assert_eq!((size.width, size.height), (w, h), "{name:?}");
    assert!(size.channels >= image.channels(), "{name:?}: {size:?}");
    assert!(size.bytes() >= image.bytes(), "{name:?}: {size:?}");
    // Cut off anywhere, it gives an answer.
    for end in 0..head.len().min(600) {
        let _ = probe(&head[..end], bytes.len() as u64, name);
    }
}

#[test]
fn sizes_are_those_of_the_decoded_images() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(files.len() >= 14);
    for path in files {
        check(&std::fs::read(&path).unwrap(), &path);
    }
    let formats = ["png", "jpg", "ppm", "pgm", "pfm", "exr", "hdr", "tga", "bmp", "webp"];
    for (name, channels) in formats.iter().flat_map(|f| [1, 3, 4].map(|c| (format!("a.{f}"), c))) {
        let format = Format::from_path(Path::new(&name)).unwrap();
        let mut bytes = Vec::new();
        encode(format, &Image::new(37, 11, channels), &WriteOptions::default(), &mut bytes).unwrap();
        check(&bytes, Path::new(&name));
    }
}

#[test]
fn what_cannot_be_decoded_has_no_size() {
    let none = |head: &[u8], length| assert_eq!(probe(head, length, Path::new("a")), None, "{head:?}");
    none(b"", 0);
    none(b"hello, world", 1 << 40);
    none(b"P6\n99999 99999\n255\n", 30_000);
    none(b"P6\n99999 99999\n255\n", MAX_PIXELS * 100);
    none(b"P6\n0 9\n255\n", 30_000);
    none(b"P6\n# 5 5\n", 30_000);
    let size = probe(b"P6 # 7 7\n 30 20\n255\n", 1820, Path::new("a")).unwrap();
    assert_eq!((size.width, size.height, size.bytes()), (30, 20, 30 * 20 * 3));
    // A JPEG file whose frame is far behind.
    let size = probe(b"\xff\xd8\xff\xe1\xff\xff", 1 << 20, Path::new("a")).unwrap();
    assert!(size.bytes() > 12 << 20);
}
