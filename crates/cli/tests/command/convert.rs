//! `penombre convert`, and bad images.

use super::{Folder, names, small, test_data, text};
use penombre_image::{ColorSpace, Format, Image, WriteOptions, load, load_as, load_layers, save};
use std::path::Path;

/// A picture whose colours are exact sRGB bytes.
fn picture() -> Image {
    let bytes: Vec<u8> = (0..7 * 5 * 3u32).map(|i| (i * 41 % 256) as u8).collect();
    let file = [b"P6 7 5 255\n", &bytes[..]].concat();
    penombre_image::decode(&file, Path::new("a"), ColorSpace::Auto).unwrap().image
}

#[test]
fn every_format_becomes_every_other() {
    let folder = Folder::new();
    save(&folder.path("a.png"), &picture(), &WriteOptions::default()).unwrap();
    let formats = ["png", "jpg", "ppm", "pfm", "exr", "hdr", "tga", "bmp", "webp"];
    for from in formats {
        let first = format!("1.{from}");
        folder.ok(&["convert", "a.png", &first]);
        let outputs: Vec<String> = formats.iter().map(|to| format!("{from}-2.{to}")).collect();
        let mut arguments = vec!["convert", first.as_str()];
        arguments.extend(outputs.iter().flat_map(|o| ["-o", o.as_str()]));
        let said = folder.ok(&arguments);
        assert_eq!(said.lines().count(), formats.len(), "{said}");
        if !["jpg", "hdr"].contains(&from) {
            for output in outputs.iter().filter(|o| !o.ends_with("jpg") && !o.ends_with("hdr")) {
                folder.ok(&["diff", output, "a.png", "--tolerance", "1e-6"]);
            }
        }
    }
}

#[test]
fn light_becomes_display_values_and_back() {
    let folder = Folder::new();
    let light = Image::from_data(2, 1, 3, vec![0.25, 0.5, 0.125, 1.0, 0.0, 4.0]).unwrap();
    save(&folder.path("a.exr"), &light, &WriteOptions::default()).unwrap();
    let pixel = |name: &str| load_as(&folder.path(name), ColorSpace::Linear).unwrap().image.rgb(0, 0);
    folder.ok(&["convert", "a.exr", "a.png", "--exposure", "1"]);
    // sRGB of 0.5, 1 and 0.25.
    assert_eq!(pixel("a.png").map(|v| (v * 255.0).round()), [188.0, 255.0, 137.0]);
    folder.ok(&["convert", "a.png", "b.pfm"]);
    let back = load(&folder.path("b.pfm")).unwrap().rgb(0, 0);
    assert!(back.iter().zip([0.5, 1.0, 0.25]).all(|(a, b)| (a - b).abs() < 0.005), "{back:?}");
    folder.ok(&["convert", "a.exr", "raw.png", "--tone", "raw"]);
    assert_eq!(pixel("raw.png").map(|v| (v * 255.0).round()), [64.0, 128.0, 32.0]);
    // It says of itself that it is raw; its copy of the same light with a curve does not.
    folder.ok(&["convert", "raw.png", "curve.png"]);
    folder.ok(&["diff", "raw.png", "curve.png", "--tolerance", "0.005"]);
    folder.ok(&["convert", "a.png", "data.pfm", "--color-space", "linear"]);
    assert_eq!(load(&folder.path("data.pfm")).unwrap().rgb(0, 0), pixel("a.png"));
    folder.ok(&["convert", "a.png", "data.bmp", "--color-space", "linear", "--tone", "raw"]);
    assert_eq!(pixel("data.bmp"), pixel("a.png"));
}

#[test]
fn texts_alpha_and_layers_are_kept_where_there_is_a_place() {
    let folder = Folder::new();
    folder.ok(&small(&["render", "cornell", "--aov", "normal,object-id"], &["-o", "a.exr"]));
    folder.ok(&["convert", "a.exr", "-o", "b.exr", "-o", "b.png", "-o", "b.jpg"]);
    let layers = |name: &str| load_layers(&folder.path(name)).unwrap();
    assert_eq!(layers("a.exr").layers, layers("b.exr").layers);
    let seed = |name: &str| {
        let texts = load_as(&folder.path(name), ColorSpace::Auto).unwrap().metadata;
        texts.into_iter().find(|(name, _)| name == "penombre:seed").unwrap().1
    };
    assert_eq!([seed("b.exr"), seed("b.png")], ["0", "0"]);
    assert!(text(&std::fs::read(folder.path("b.jpg")).unwrap()).contains("penombre:seed: 0"));
    let alpha = Image::from_data(1, 1, 4, vec![1.0, 0.0, 1.0, 0.2]).unwrap();
    save(&folder.path("alpha.exr"), &alpha, &WriteOptions::default()).unwrap();
    let output = folder.run(&["convert", "alpha.exr", "-o", "alpha.webp", "-o", "alpha.hdr"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(text(&output.stderr).matches("alpha.hdr has no place for alpha").count(), 1);
    assert_eq!(*load(&folder.path("alpha.webp")).unwrap().pixel(0, 0), [1.0, 0.0, 1.0, 0.2]);
}

#[test]
fn many_images_go_to_a_folder() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    for name in ["a.png", "b.tga"] {
        save(&folder.path(name), &picture(), &WriteOptions::default()).unwrap();
    }
    folder.write("c.png", "no image");
    // The broken one does not keep the others from their files.
    let said = folder.run(&["convert", "a.png", "c.png", "b.tga", "-o", "out", "--format", "exr"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(text(&said.stderr).contains("c.png: byte 0: found \"no image\""), "{}", text(&said.stderr));
    assert_eq!(names(&folder.path("out")), ["a.exr", "b.exr"]);
}

#[test]
fn wrong_conversions_are_refused_before_anything_is_read() {
    let folder = Folder::new();
    save(&folder.path("a.png"), &picture(), &WriteOptions::default()).unwrap();
    std::fs::create_dir(folder.path("out")).unwrap();
    folder.write("mesh.obj", "v 0 0 0\n");
    for (arguments, expected) in [
        (vec!["mesh.obj", "b.png"], "`penombre render mesh.obj -o b.png` renders it"),
        (vec!["a.png", "b.glb"], "b.glb: scenes are written as .toml or .json only"),
        (vec!["a.png", "b.toml"], "a.png is an image, and b.toml a scene"),
        (vec!["a.png", "b.exr", "--set", "camera.fov=1"], "are for scenes"),
        (vec!["a.png", "b.gif"], "GIF: is read, but not written"),
        (vec!["a.png", "b.xyz"], "expected a file name that ends in one of .png"),
        (vec!["a.png", "nowhere/b.png"], "nowhere"),
        (vec!["a.png", "a.png"], "would replace a.png"),
        (vec!["a.png", "out"], "no extension"),
        (vec!["a.png", "-o", "out"], "--format png"),
        (vec!["a.png", "-o", "b.png", "--format", "png"], "is no folder"),
        (vec!["a.png", "a.png", "-o", "b.png"], "cannot all become"),
        (vec!["a.png", "a.png", "-o", "out", "--format", "png"], "two files would become"),
        (vec!["a.png", "b.exr", "--exposure", "1"], "outputs of 8 bits"),
        (vec!["a.png", "b.exr", "--color-space", "sRGB"], "auto, linear, srgb"),
        (vec!["none.png", "b.exr"], "none.png"),
    ] {
        let said = folder.refused(&[vec!["convert"], arguments].concat());
        assert!(said.contains(expected), "{said}");
    }
    assert_eq!(names(folder.0.path()), ["a.png", "mesh.obj", "out"]);
}

#[test]
fn the_good_images_of_the_corpus_become_pictures() {
    let Some(images) = test_data("scenes") else { return };
    let mut folders = vec![images.join("images"), images.join("hdri")];
    let folder = Folder::new();
    let mut count = 0;
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            folder.ok(&["convert", path.to_str().unwrap(), "a.png", "--tone", "agx"]);
            let image = load(&folder.path("a.png")).unwrap();
            let spread = image.rgb_pixels().flatten().fold([1.0f32, 0.0], |[a, b], v| [a.min(v), b.max(v)]);
            assert!(spread[0] < spread[1], "{}: one colour only", path.display());
            count += 1;
        }
    }
    assert!(count >= 20, "{count} images");
    assert!(Format::from_path(Path::new("a.png")).is_ok());
}
