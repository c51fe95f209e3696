//! TGA, BMP, WebP and GIF; JPEG of all kinds; files that other programs wrote.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre_image::{
    ColorSpace, Decoded, Format, Image, Layer, Layers, WriteOptions, decode, encode, encode_layers, save,
};
use std::path::Path;

fn read(bytes: &[u8], name: &str, space: ColorSpace) -> Decoded {
    decode(bytes, Path::new(name), space).unwrap_or_else(|e| panic!("{e}"))
}

fn write(format: Format, image: &Image) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(format, image, &WriteOptions::default(), &mut bytes).unwrap();
    bytes
}

/// A picture whose samples are all exact sRGB bytes, with alpha or without.
fn picture(channels: u32) -> Image {
    let bytes: Vec<u8> = (0..7 * 5 * channels).map(|i| (i * 37 % 256) as u8).collect();
    let kind = if channels == 4 { 6 } else { 2 };
    let mut tga = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 5, 0, 8 * channels as u8, 0x20];
    tga[17] |= if kind == 6 { 8 } else { 0 };
    read(&[tga, bytes].concat(), "a", ColorSpace::Auto).image
}

#[test]
fn what_is_written_without_loss_comes_back_with_alpha() {
    for format in [Format::Png, Format::Tga, Format::Bmp, Format::Webp] {
        for channels in [3, 4] {
            let image = picture(channels);
            let found = read(&write(format, &image), "a", ColorSpace::Auto);
            assert_eq!((found.format, found.was_srgb), (format, true));
            assert_eq!(found.image, image, "{format}, {channels} channels");
        }
    }
    for format in [Format::Jpeg, Format::Ppm] {
        assert_eq!(read(&write(format, &picture(4)), "a", ColorSpace::Auto).image.channels(), 3, "{format}");
    }
}

#[test]
fn gif_is_not_written_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gif");
    let error = save(&path, &picture(3), &WriteOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a.gif") && error.contains("not written") && error.contains(".webp"), "{error}");
    assert!(encode(Format::Gif, &picture(3), &WriteOptions::default(), &mut Vec::new()).is_err());
    assert!(!path.exists());
}

/// A header of kind, depth and descriptor for a picture of 2 × 2, with a colour table of that depth.
fn tga(kind: u8, depth: u8, descriptor: u8, table: Option<(u8, &[u8])>, pixels: &[u8]) -> Vec<u8> {
    let mut file = vec![3, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, depth, descriptor];
    file.extend(b"abc");
    if let Some((bits, entries)) = table {
        file[1] = 1;
        file[3] = 5;
        file[5] = entries.len() as u8 / bits.div_ceil(8);
        file[7] = bits;
        file.extend(entries);
    }
    file.extend(pixels);
    file
}

#[test]
fn tga_of_every_kind() {
    // The picture: red, green above blue, white.
    let [r, g, b, w] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
    let expected = [r, g, b, w].concat();
    let bgr = [[0, 0, 255], [0, 255, 0], [255, 0, 0], [255; 3]].as_flattened().to_vec();
    let five: Vec<u8> = [0x7c00u16, 0x03e0, 0x001f, 0x7fff].iter().flat_map(|c| c.to_le_bytes()).collect();
    let four: Vec<u8> = bgr.chunks(3).flat_map(|c| [c[0], c[1], c[2], 7]).collect();
    let runs = [&[0u8][..], &bgr[..3], &[1], &bgr[3..9], &[0x80], &bgr[9..]].concat();
    let below = [&bgr[6..], &bgr[..6]].concat();
    let left = [&bgr[3..6], &bgr[..3], &bgr[9..], &bgr[6..9]].concat();
    let files = [
        ("colour", tga(2, 24, 0x20, None, &bgr)),
        ("colour that runs", tga(10, 24, 0x20, None, &runs)),
        ("from below", tga(2, 24, 0, None, &below)),
        ("from the right", tga(2, 24, 0x30, None, &left)),
        ("15 bits", tga(2, 15, 0x20, None, &five)),
        ("16 bits", tga(2, 16, 0x20, None, &five)),
        ("32 bits without alpha", tga(2, 32, 0x20, None, &four)),
        ("table", tga(1, 8, 0x20, Some((24, &bgr)), &[5, 6, 7, 8])),
        ("table of 16 bits", tga(1, 8, 0x20, Some((16, &five)), &[5, 6, 7, 8])),
        ("table that runs", tga(9, 16, 0x20, Some((24, &bgr)), &[3, 5, 0, 6, 0, 7, 0, 8, 0])),
        ("unused table", tga(2, 24, 0x20, Some((24, &bgr)), &bgr)),
    ];
    for (name, file) in files {
        let found = read(&file, "a.TGA", ColorSpace::Auto);
        assert_eq!(found.format, Format::Tga, "{name}");
        assert_eq!((found.image.channels(), found.image.to_data()), (3, expected.to_vec()), "{name}");
    }
    let alpha = read(&tga(2, 32, 0x28, None, &four), "a", ColorSpace::Linear).image;
    assert_eq!(*alpha.pixel(0, 0), [1.0, 0.0, 0.0, 7.0 / 255.0]);
    let grey = read(&tga(3, 8, 0x20, None, &[0, 51, 102, 255]), "a", ColorSpace::Linear).image;
    assert_eq!((grey.channels(), grey.to_data()), (1, vec![0.0, 0.2, 0.4, 1.0]));
    let grey = read(&tga(11, 16, 0x28, None, &[0x83, 51, 255]), "a", ColorSpace::Linear).image;
    assert_eq!(*grey.pixel(1, 1), [0.2, 1.0]);
}

#[test]
fn faults_of_tga_are_placed() {
    let three = [0u8; 9];
    for (file, expected) in [
        (tga(2, 24, 0x20, None, &three), "byte 21: found 9 more bytes"),
        (tga(2, 24, 0xe0, None, &three), "byte 17: found interleaved rows"),
        (tga(5, 24, 0x20, None, &three), "byte 2: found kind 5"),
        (tga(2, 23, 0x20, None, &three), "byte 16: found 23 bits"),
        (
            tga(10, 24, 0x20, None, &[0x84, 0, 0, 0]),
            "byte 21: found a packet of 5 pixels, expected at most 4",
        ),
        (
            tga(1, 8, 0x20, Some((24, &three)), &[5, 8, 5, 5]),
            "byte 31: found colour 8, expected colours 5 to below 8",
        ),
        (b"\xff\0\x0a".to_vec(), "18 bytes of the header"),
        (Vec::new(), "18 bytes of the header"),
    ] {
        let error = decode(&file, Path::new("a.tga"), ColorSpace::Auto).unwrap_err().to_string();
        assert!(error.contains("a.tga: TGA, byte ") && error.contains(expected), "{error}");
    }
}

/// All show red at the top that becomes blue at the bottom, 24 × 16 pixels; those with few colours, of which there are 4
/// at least, are dithered.
#[test]
fn files_of_other_programs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for (name, tolerance) in [
        ("cmyk.jpg", 0.06),
        ("progressive.jpg", 0.06),
        ("lossy.webp", 0.12),
        ("rle8.bmp", 0.06),
        ("palette.bmp", 0.3),
        ("interlaced.gif", 0.2),
        ("palette-rle.tga", 0.3),
        ("rgb-rle.tga", 0.01),
    ] {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let image = read(&bytes, name, ColorSpace::Linear).image;
        assert_eq!((image.width(), image.height(), image.channels()), (24, 16, 3), "{name}");
        for y in 0..16 {
            let t = y as f32 / 15.0;
            for (found, expected) in image.rgb(11, y).into_iter().zip([1.0 - t, 0.0, t]) {
                assert!((found - expected).abs() < tolerance, "{name}, row {y}: {:?}", image.rgb(11, y));
            }
        }
    }
    let bytes = std::fs::read(folder.join("grey.tga")).unwrap();
    assert_eq!(read(&bytes, "grey.tga", ColorSpace::Auto).image.channels(), 1);
}

#[test]
fn radiance_of_every_orientation() {
    // Rows of 2 × 3 pixels whose red tells the place: 1 2 / 3 4 / 5 6 sixty-fourths.
    let place = |x: usize, y: usize| [(1 + x + 2 * y) as u8 * 4, 0, 0, 128];
    let expected: Vec<f32> = (1..=6).flat_map(|i| [i as f32 / 64.0, 0.0, 0.0]).collect();
    for (y_sign, x_sign) in [("-Y", "+X"), ("-Y", "-X"), ("+Y", "+X"), ("+Y", "-X")] {
        let xs = if x_sign == "+X" { [0, 1] } else { [1, 0] };
        let ys = if y_sign == "-Y" { [0, 1, 2] } else { [2, 1, 0] };
        let rows = ys.iter().flat_map(|y| xs.iter().flat_map(|x| place(*x, *y))).collect::<Vec<u8>>();
        let columns = xs.iter().flat_map(|x| ys.iter().flat_map(|y| place(*x, *y))).collect::<Vec<u8>>();
        for (size, pixels) in
            [(format!("{y_sign} 3 {x_sign} 2\n"), rows), (format!("{x_sign} 2 {y_sign} 3\n"), columns)]
        {
            let file = [b"#?RADIANCE\n\n", size.as_bytes(), &pixels].concat();
            let found = read(&file, "a.hdr", ColorSpace::Auto).image;
            assert_eq!((found.width(), found.height()), (2, 3), "{size}");
            assert_eq!(found.to_data(), expected, "{size}");
        }
    }
}

#[test]
fn luminance_and_chroma_become_colours() {
    let rgb = [[0.2f32, 0.4, 0.8], [3.0, 1.0, 0.5]];
    let y: Vec<f32> = rgb.map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).to_vec();
    let chroma = |c: usize| -> Vec<f32> { (0..2).map(|i| (rgb[i][c] - y[i]) / y[i]).collect() };
    let mut layers = Layers::new(2, 1);
    let color = Layer::new("").with("RY", chroma(0)).with("BY", chroma(2)).with("A", vec![1.0f32, 0.5]);
    layers.push(color.with("Y", y.clone())).unwrap();
    let mut file = Vec::new();
    encode_layers(&layers, &WriteOptions::default(), &mut file).unwrap();
    let image = read(&file, "a.exr", ColorSpace::Auto).image;
    assert_eq!(image.channels(), 4);
    for (x, expected) in rgb.iter().enumerate() {
        let found = image.rgb(x as u32, 0);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3 * b), "{found:?}");
    }
    assert_eq!(image.pixel(1, 0)[3], 0.5);
}
