//! Every format out and in again, and exact bytes where a format promises them.

use penombre_image::{
    ColorSpace, Decoded, Format, Image, ImageErrorKind, ToneCurve, WriteOptions, decode, encode, load,
    quantise, save,
};
use std::path::Path;

fn write(format: Format, image: &Image, options: &WriteOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(format, image, options, &mut bytes).expect("the image can be written");
    bytes
}

fn read(bytes: &[u8], space: ColorSpace) -> Decoded {
    decode(bytes, Path::new("memory"), space).expect("the file is good")
}

fn raw() -> WriteOptions {
    WriteOptions { tone: ToneCurve::Raw, ..WriteOptions::default() }
}

/// Values from a fixed sequence (SplitMix64), 0 to `top`.
fn noise(width: u32, height: u32, channels: u32, top: f32, seed: u64) -> Image {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32 * top
    };
    let data = (0..width * height * channels).map(|_| next()).collect();
    Image::from_data(width, height, channels, data).expect("the shape fits")
}

const SIZES: [(u32, u32); 6] = [(1, 1), (1, 5), (7, 3), (8, 2), (33, 17), (200, 9)];

#[test]
fn small_ppm_has_exactly_these_bytes() {
    let image = Image::from_data(2, 1, 3, vec![0.0, 0.5, 1.0, -1.0, f32::NAN, 9.0]).unwrap();
    assert_eq!(write(Format::Ppm, &image, &raw()), b"P6\n2 1\n255\n\x00\x80\xff\x00\x00\xff");
    let srgb = write(Format::Ppm, &image, &WriteOptions::default());
    assert_eq!(srgb, b"P6\n2 1\n255\n\x00\xbc\xff\x00\x00\xff");
    let grey = Image::from_data(2, 1, 1, vec![0.0, 1.0]).unwrap();
    assert_eq!(write(Format::Pgm, &grey, &raw()), b"P5\n2 1\n255\n\x00\xff");
    // Luminance of pure green: 0.7152 · 255 = 182.4.
    let green = Image::from_data(1, 1, 3, vec![0.0, 1.0, 0.0]).unwrap();
    assert_eq!(write(Format::Pgm, &green, &raw()), b"P5\n1 1\n255\n\xb6");
}

#[test]
fn course_ppm_is_one_line_truncated_and_without_curve() {
    let data = vec![0.0, 0.5, 1.0, 0.999, -3.0, 7.0, f32::NAN, 0.2, 1.0 / 255.0, 0.7, 0.8, 0.9];
    let image = Image::from_data(2, 2, 3, data).unwrap();
    // The tone curve does not matter.
    for tone in [ToneCurve::Raw, ToneCurve::Srgb] {
        let options = WriteOptions { tone, course_ppm: true, ..WriteOptions::default() };
        let expected = "P3\n2 2\n255\n0 127 255 254 0 255 0 51 1 178 204 229 \n";
        assert_eq!(String::from_utf8(write(Format::Ppm, &image, &options)).unwrap(), expected);
    }
    let options = WriteOptions { course_ppm: true, ..WriteOptions::default() };
    let decoded = read(&write(Format::Ppm, &image, &options), ColorSpace::Linear);
    assert_eq!(decoded.image.rgb(1, 0), [254.0 / 255.0, 0.0, 1.0]);
}

#[test]
fn eight_bit_formats_keep_their_bytes() {
    for (i, (w, h)) in SIZES.into_iter().enumerate() {
        let image = noise(w, h, 3, 1.1, i as u64);
        for tone in ToneCurve::ALL.iter().copied() {
            let options = WriteOptions { tone, ..WriteOptions::default() };
            let bytes = quantise(&image, tone, 0.0);
            for format in [Format::Png, Format::Ppm] {
                let file = write(format, &image, &options);
                let linear = read(&file, ColorSpace::Linear);
                assert!(!linear.was_srgb);
                assert_eq!(quantise(&linear.image, ToneCurve::Raw, 0.0), bytes, "{format}");
                let auto = read(&file, ColorSpace::Auto);
                // PNG remembers that a picture has no curve; the others are taken for sRGB.
                let remembered = format == Format::Png && tone == ToneCurve::Raw;
                assert_eq!(auto.was_srgb, !remembered);
                let back = if remembered { ToneCurve::Raw } else { ToneCurve::Srgb };
                assert_eq!(quantise(&auto.image, back, 0.0), bytes, "{format}");
                let told = auto.metadata.iter().any(|(k, v)| k == "penombre:tone" && *v == tone.to_string());
                assert_eq!(told, format == Format::Png && tone != ToneCurve::Srgb, "{format} {tone}");
                assert_eq!((auto.format, auto.image.width(), auto.image.height()), (format, w, h));
            }
        }
    }
}

#[test]
fn float_formats_keep_every_bit() {
    let odd = [f32::MIN_POSITIVE, f32::MAX, -0.0, -1.5e-30, 1e-45, f32::INFINITY, 3.0e9, 0.1];
    for channels in 1..=4 {
        for (i, (w, h)) in SIZES.into_iter().enumerate() {
            let mut image = noise(w, h, channels, 1000.0, i as u64 * 31 + u64::from(channels));
            for (v, o) in image.data_mut().iter_mut().zip(odd) {
                *v = o;
            }
            let exr = read(&write(Format::Exr, &image, &raw()), ColorSpace::Auto);
            assert_eq!(exr.image.channels(), channels);
            assert!(!exr.was_srgb);
            let bits = |i: &Image| i.to_data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&exr.image), bits(&image));
            let pfm = read(&write(Format::Pfm, &image, &raw()), ColorSpace::Auto).image;
            assert_eq!(pfm.channels(), if channels < 3 { 1 } else { 3 });
            assert_eq!(bits(&pfm.to_rgb()), bits(&image.to_rgb()));
            assert_eq!(pfm.digest(), image.digest());
        }
    }
}

#[test]
fn radiance_is_right_to_half_a_step() {
    for (i, (w, h)) in SIZES.into_iter().enumerate() {
        for top in [1.0, 1e-20, 1e30] {
            let mut image = noise(w, h, 3, top, i as u64 + 7);
            // Long runs too, so that both kinds of stretches occur.
            for y in 0..h {
                for x in w / 3..w * 2 / 3 {
                    image.pixel_mut(x, y).fill(top * 0.25);
                }
            }
            let back = read(&write(Format::Hdr, &image, &raw()), ColorSpace::Auto).image;
            for (a, b) in image.rgb_pixels().zip(back.rgb_pixels()) {
                let largest = a[0].max(a[1]).max(a[2]);
                for c in 0..3 {
                    assert!((a[c] - b[c]).abs() <= largest / 255.0, "{a:?} became {b:?}");
                }
            }
            // What the format can hold exactly stays as it is.
            let again = read(&write(Format::Hdr, &back, &raw()), ColorSpace::Auto).image;
            assert_eq!(again.digest(), back.digest());
        }
    }
    let extremes = vec![f32::MAX, 0.0, 0.0, 1.0, 0.5, 0.996, f32::NAN, -1.0, 0.0, 1e-45, 1e-40, 0.0];
    let image = Image::from_data(4, 1, 3, extremes).unwrap();
    let back = read(&write(Format::Hdr, &image, &raw()), ColorSpace::Auto).image;
    assert!(back.rgb(0, 0)[0] > 1.6e38 && back.rgb(0, 0)[0].is_finite());
    assert_eq!(back.rgb(1, 0)[..2], [1.0, 0.5]);
    assert_eq!(back.rgb(2, 0), [0.0; 3]);
    assert_eq!(back.rgb(3, 0), [0.0; 3]);
}

#[test]
fn radiance_of_other_programs() {
    let head = "#?RADIANCE\n# made by hand\nEXPOSURE=2.0\nFORMAT=32-bit_rle_rgbe\n\n";
    let pixels = [[128u8, 64, 32, 129], [1, 1, 1, 2], [0, 0, 0, 0], [64, 64, 64, 130]].concat();
    let file = |size: &str| [head.as_bytes(), size.as_bytes(), &pixels].concat();
    // The old run-length form: the first pixel is repeated twice; exposure 2 halves the values.
    let image = read(&file("-Y 1 +X 5\n"), ColorSpace::Auto).image;
    for x in 0..3 {
        assert_eq!(image.rgb(x, 0), [0.5, 0.25, 0.125]);
    }
    assert_eq!(image.rgb(3, 0), [0.0; 3]);
    assert_eq!(image.rgb(4, 0), [0.5; 3]);
    let mirrored = read(&file("-Y 1 -X 5\n"), ColorSpace::Auto).image;
    assert_eq!(mirrored.rgb(4, 0), [0.5, 0.25, 0.125]);
    let column = [head.as_bytes(), b"+Y 2 +X 1\n", &[128, 0, 0, 129, 0, 128, 0, 129]].concat();
    assert_eq!(read(&column, ColorSpace::Auto).image.rgb(0, 0), [0.0, 0.5, 0.0], "bottom row first");
}

#[test]
fn jpeg_is_close() {
    let mut image = Image::new(40, 24, 3);
    for y in 0..24 {
        for x in 0..40 {
            let rgb = [x as f32 / 40.0, y as f32 / 24.0, 0.3];
            image.pixel_mut(x, y).copy_from_slice(&rgb);
        }
    }
    let options = WriteOptions { metadata: vec![("scene".into(), "cornell".into())], ..raw() };
    let file = write(Format::Jpeg, &image, &options);
    assert!(file.windows(14).any(|w| w == b"scene: cornell"));
    let back = read(&file, ColorSpace::Linear).image;
    let rms = penombre_image::metrics::compare(&back, &image).unwrap().rmse;
    assert!(rms < 0.015, "{rms}");
    assert!(read(&file, ColorSpace::Auto).was_srgb);
    let grey = include_bytes!("data/grey.jpg");
    let decoded = read(grey, ColorSpace::Linear);
    assert_eq!((decoded.image.channels(), decoded.image.width(), decoded.image.height()), (1, 24, 16));
    let mean = decoded.image.mean()[0];
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
}

#[test]
fn metadata_comes_back() {
    let metadata: Vec<(String, String)> =
        [("Comment", "é is Latin"), ("Scene", "日本 is not"), ("seed", "17")]
            .map(|(k, v)| (k.into(), v.into()))
            .into();
    let options = WriteOptions { metadata: metadata.clone(), ..WriteOptions::default() };
    let image = noise(4, 4, 3, 1.0, 1);
    for format in [Format::Png, Format::Exr] {
        let file = write(format, &image, &options);
        let mut found = read(&file, ColorSpace::Auto).metadata;
        found.sort();
        assert_eq!(found, metadata, "{format}");
        for _ in 0..8 {
            assert_eq!(write(format, &image, &options), file, "{format}: the same bytes each time");
        }
    }
    let hdr = write(Format::Hdr, &image, &options);
    assert!(String::from_utf8_lossy(&hdr[..100]).contains("# Scene: 日本 is not\n"));
    assert_eq!(read(&hdr, ColorSpace::Auto).image.pixel_count(), 16);
    for (format, name) in [(Format::Exr, ""), (Format::Png, ""), (Format::Png, "日")] {
        let options = WriteOptions { metadata: vec![(name.into(), "x".into())], ..WriteOptions::default() };
        let result = encode(format, &image, &options, &mut Vec::new());
        assert!(matches!(result, Err(ImageErrorKind::NotWritable { .. })), "{format} {name}");
    }
    let options = WriteOptions { metadata: vec![("channels".into(), "x".into())], ..WriteOptions::default() };
    let found = read(&write(Format::Exr, &image, &options), ColorSpace::Auto).metadata;
    assert_eq!(found, [("text.channels".to_owned(), "x".to_owned())]);
    let options = WriteOptions { metadata: vec![("a".into(), "x\0y".into())], ..WriteOptions::default() };
    assert!(encode(Format::Png, &image, &options, &mut Vec::new()).is_err());
}

#[test]
fn netpbm_of_every_kind() {
    let third = 1.0 / 3.0f32;
    let cases: [(&[u8], u32, Vec<f32>); 9] = [
        (b"P1 # bits\n3 1\n1 0\n1", 1, vec![0.0, 1.0, 0.0]),
        (b"P1\n3 1\n101", 1, vec![0.0, 1.0, 0.0]),
        (b"P2\n# size\n2 # width\n1\n3\n1 3\n", 1, vec![third, 1.0]),
        (b"P3 1 1 65535 65535 0 13107", 3, vec![1.0, 0.0, 0.2]),
        (b"P4\n9 1\n\x55\x80", 1, vec![1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]),
        (b"P5\n2 1\n255\n\xff\x33", 1, vec![1.0, 0.2]),
        (b"P5 1 1 65535\n\x33\x33", 1, vec![0.2]),
        (b"P6\r\n1 1\r255 \x00\xff\x33", 3, vec![0.0, 1.0, 0.2]),
        (b"P6 1 2 3\t\x00\x01\x02\x03\x00\x01", 3, vec![0.0, third, 2.0 * third, 1.0, 0.0, third]),
    ];
    for (file, channels, expected) in cases {
        let decoded = read(file, ColorSpace::Linear);
        assert_eq!(
            (decoded.image.channels(), decoded.image.to_data()),
            (channels, expected.to_vec()),
            "{}",
            file.escape_ascii()
        );
    }
    // Bits have no transfer curve, numbers do.
    assert!(!read(b"P1 1 1 1", ColorSpace::Auto).was_srgb);
    let half = read(b"P2 1 1 2 1", ColorSpace::Auto);
    assert!(half.was_srgb && (half.image.to_data()[0] - 0.214).abs() < 1e-3);
}

#[test]
fn pfm_of_both_endians() {
    let floats = [1.0f32, 2.0, 3.0, 4.0];
    let little: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    let big: Vec<u8> = floats.iter().flat_map(|f| f.to_be_bytes()).collect();
    for (head, body) in [("Pf\n2 2\n-1.0\n", &little), ("Pf 2 2 1\n", &big)] {
        let decoded = read(&[head.as_bytes(), body].concat(), ColorSpace::Auto);
        assert_eq!(decoded.image.to_data(), [3.0, 4.0, 1.0, 2.0], "bottom row first");
    }
    let scaled = [b"Pf\n2 2\n-2.5\n", &little[..]].concat();
    assert_eq!(read(&scaled, ColorSpace::Auto).image.to_data(), [7.5, 10.0, 2.5, 5.0]);
    let encoded = read(&[b"Pf\n1 1\n-1\n", &0.5f32.to_le_bytes()[..]].concat(), ColorSpace::Srgb);
    assert!(encoded.was_srgb && (encoded.image.to_data()[0] - 0.214).abs() < 1e-3);
}

/// A PNG of the given type, made with the `png` crate.
fn png_file(
    color: png::ColorType,
    depth: png::BitDepth,
    size: (u32, u32),
    data: &[u8],
    gamma: Option<f32>,
) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size.0, size.1);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![255, 0, 0, 0, 0, 51]);
        encoder.set_trns(vec![255, 51]);
    }
    if let Some(gamma) = gamma {
        encoder.set_source_gamma(png::ScaledFloat::new(gamma));
    }
    let mut writer = encoder.write_header().expect("the header is good");
    writer.write_image_data(data).expect("the data fits");
    writer.finish().expect("memory takes everything");
    file
}

#[test]
fn png_of_every_kind() {
    use png::{BitDepth as D, ColorType as C};
    type Case<'a> = (C, D, (u32, u32), &'a [u8], u32, Vec<f32>);
    let cases: [Case<'_>; 9] = [
        (C::Grayscale, D::One, (3, 1), &[0b1010_0000], 1, vec![1.0, 0.0, 1.0]),
        (C::Grayscale, D::Two, (2, 1), &[0b1101_0000], 1, vec![1.0, 85.0 / 255.0]),
        (C::Grayscale, D::Four, (2, 1), &[0xf3], 1, vec![1.0, 0.2]),
        (C::Grayscale, D::Eight, (1, 2), &[51, 255], 1, vec![0.2, 1.0]),
        (C::GrayscaleAlpha, D::Eight, (1, 1), &[255, 51], 2, vec![1.0, 0.2]),
        (C::Indexed, D::One, (2, 1), &[0b0100_0000], 4, vec![1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.2, 0.2]),
        (C::Rgb, D::Eight, (1, 1), &[255, 0, 51], 3, vec![1.0, 0.0, 0.2]),
        (C::Rgb, D::Sixteen, (1, 1), &[0xff, 0xff, 0, 0, 0x33, 0x33], 3, vec![1.0, 0.0, 0.2]),
        (C::Rgba, D::Sixteen, (1, 1), &[0xff, 0xff, 0, 0, 0, 0, 0x33, 0x33], 4, vec![1.0, 0.0, 0.0, 0.2]),
    ];
    for (color, depth, size, data, channels, expected) in cases {
        let file = png_file(color, depth, size, data, None);
        let image = read(&file, ColorSpace::Linear).image;
        assert_eq!((image.channels(), image.to_data()), (channels, expected.to_vec()), "{color:?} {depth:?}");
        // Alpha is never encoded.
        let auto = read(&file, ColorSpace::Auto);
        assert!(auto.was_srgb);
        if channels % 2 == 0 {
            assert_eq!(auto.image.to_data().last(), expected.last());
        }
    }
}

#[test]
fn png_gamma_is_obeyed() {
    let file = |gamma| png_file(png::ColorType::Grayscale, png::BitDepth::Eight, (1, 1), &[128], gamma);
    let value = |gamma| read(&file(gamma), ColorSpace::Auto);
    let code = 128.0 / 255.0f32;
    let srgb = penombre_math::color::srgb_decode(code);
    assert_eq!(value(None).image.to_data(), [srgb]);
    assert_eq!(value(Some(0.45455)).image.to_data(), [srgb]);
    assert_eq!(value(Some(1.0)).image.to_data(), [code]);
    assert!(!value(Some(1.0)).was_srgb && value(None).was_srgb);
    assert!((value(Some(0.5)).image.to_data()[0] - code * code).abs() < 1e-6);
    assert_eq!(read(&file(Some(0.5)), ColorSpace::Linear).image.to_data(), [code]);
}

#[test]
fn files_go_out_and_in_by_extension() {
    let folder = tempfile::tempdir().unwrap();
    let image = noise(9, 7, 3, 1.0, 5);
    for extension in Format::EXTENSIONS {
        let path = folder.path().join(format!("a{extension}"));
        save(&path, &image, &WriteOptions::default()).unwrap();
        let back = load(&path).unwrap();
        assert_eq!((back.width(), back.height()), (9, 7), "{extension}");
        let difference = penombre_image::metrics::compare(&back, &image.to_rgb()).unwrap().rmse;
        let grey_or_lossy = [".jpg", ".jpeg", ".pgm", ".pbm"].contains(extension);
        assert!(difference < if grey_or_lossy { 0.6 } else { 0.01 }, "{extension}: {difference}");
    }
    let unknown = save(&folder.path().join("a.xyz"), &image, &WriteOptions::default()).unwrap_err();
    assert!(unknown.to_string().contains("a.xyz") && unknown.to_string().contains(".png"), "{unknown}");
    assert!(save(&folder.path().join("none/a.png"), &image, &WriteOptions::default()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), Format::EXTENSIONS.len());
}

#[test]
fn exr_of_other_programs() {
    // Half floats, a layer prefix, PIZ compression and tiles: written by the reference OpenEXR library.
    for name in ["half-piz.exr", "prefix-zips.exr", "tiled-rle.exr"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
        let image = load(&path).unwrap();
        assert_eq!((image.width(), image.height(), image.channels()), (20, 12, 3), "{name}");
        for y in 0..12 {
            for x in 0..20 {
                // Small multiples of 1/16 are exact in half precision.
                assert_eq!(
                    image.rgb(x, y),
                    [x as f32 / 16.0, y as f32 / 8.0, (x + y) as f32],
                    "{name} {x} {y}"
                );
            }
        }
    }
}
