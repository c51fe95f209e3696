//! Layers out and in again: one OpenEXR file, or one file each.

use penombre_image::{
    Format, Image, ImageErrorKind, Layer, Layers, STANDARD_LAYERS, Samples, ToneCurve, WriteOptions,
    decode_layers, encode, encode_layers, layer_path, load, load_layers, quantise, save_layers,
};
use std::path::{Path, PathBuf};

const SIZES: [(u32, u32); 6] = [(1, 1), (1, 5), (7, 3), (8, 2), (33, 17), (201, 9)];

/// Numbers at the edges of the format.
const ODD: [f32; 10] = [
    f32::MIN_POSITIVE,
    f32::MAX,
    -0.0,
    -1.5e-30,
    1e-45,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MIN,
    16_777_217.0,
    0.1,
];

/// SplitMix64, the high half.
fn noise(i: u64) -> u32 {
    let mut z = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 32) as u32
}

/// Any numbers but NaN, odd ones first.
fn floats(count: usize, seed: u64) -> Vec<f32> {
    let any = |i: usize| f32::from_bits(noise(i as u64 + (seed << 32)));
    let tame = |v: f32| if v.is_nan() { 0.5 } else { v };
    (0..count).map(|i| if i < 3 { ODD[(i + seed as usize) % 10] } else { tame(any(i)) }).collect()
}

/// All layers of the list and more: 30 channels, 3 of them whole numbers.
fn many(width: u32, height: u32) -> Layers {
    let pixels = width as usize * height as usize;
    let mut layers = Layers::new(width, height);
    let mut seed = 0;
    for (name, channels) in STANDARD_LAYERS {
        let mut layer = Layer::new(*name);
        for channel in *channels {
            seed += 1;
            layer = match *name {
                "object-id" | "material-id" | "samples" => {
                    let numbers = (0..pixels as u64).map(|i| u32::MAX - noise(i + seed) * (i % 2) as u32);
                    layer.with(*channel, numbers.collect::<Vec<u32>>())
                }
                _ => layer.with(*channel, floats(pixels, seed)),
            };
        }
        layers.push(layer).expect("the layer fits");
    }
    for name in
        ["light.key", "light.fill", "AO", "a name much longer than the 31 bytes of old files", "Größe"]
    {
        let channels: &[&str] = if name.starts_with("light") { &["R", "G", "B"] } else { &["X"] };
        let interleaved = floats(pixels * channels.len(), seed);
        layers.push(Layer::interleaved(name, channels, &interleaved)).expect("the layer fits");
    }
    layers
}

/// Every sample as bits: infinities, signed zeros and all.
fn bits(layers: &Layers) -> Vec<(String, String, Vec<u32>)> {
    let channels = layers.layers().iter().flat_map(|l| l.channels().iter().map(move |c| (l.name(), c)));
    let bits = |samples: &Samples| match samples {
        Samples::F32(s) => s.iter().map(|v| v.to_bits()).collect(),
        Samples::U32(s) => s.iter().map(|v| !v).collect(),
    };
    channels.map(|(l, c)| (l.to_owned(), c.name.clone(), bits(&c.samples))).collect()
}

fn exr(layers: &Layers, options: &WriteOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_layers(layers, options, &mut bytes).expect("the layers can be written");
    bytes
}

#[test]
fn thirty_channels_keep_every_bit() {
    let metadata = vec![("integrator".to_owned(), "path".to_owned()), ("scene".to_owned(), "é".to_owned())];
    let options = WriteOptions { metadata: metadata.clone(), ..WriteOptions::default() };
    for (width, height) in SIZES {
        let layers = many(width, height);
        assert_eq!(layers.layers().iter().map(|l| l.channels().len()).sum::<usize>(), 30);
        let file = exr(&layers, &options);
        assert_eq!(exr(&layers, &options), file, "the same bytes each time");
        let back = decode_layers(&file, Path::new("memory")).unwrap();
        assert!(bits(&back.layers) == bits(&layers), "{width} {height}");
        assert!(back.layers == layers);
        assert_eq!((back.format, back.metadata), (Format::Exr, metadata.clone()));
    }
}

#[test]
fn files_of_layers_are_pictures_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let layers = many(7, 3);
    assert_eq!(save_layers(&path, &layers, &WriteOptions::default()).unwrap(), std::slice::from_ref(&path));
    let image = load(&path).unwrap();
    assert_eq!(image, layers.get("").unwrap().to_image(7, 3).unwrap());
    assert!(load_layers(&path).unwrap().layers == layers);
    // Other colours do not take the place of the picture's, and alpha comes along.
    let mut layers = Layers::new(2, 1);
    layers.push(Layer::interleaved("albedo", &["R", "G", "B"], &[9.0; 6])).unwrap();
    let rgba = Image::from_data(2, 1, 4, vec![1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, 1.0]).unwrap();
    layers.push(Layer::color(&rgba)).unwrap();
    save_layers(&path, &layers, &WriteOptions::default()).unwrap();
    assert_eq!(load(&path).unwrap(), rgba);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_picture_alone_is_the_same_file() {
    for channels in 1..=4 {
        let image = Image::from_data(5, 2, channels, floats(10 * channels as usize, 3)).unwrap();
        let mut expected = Vec::new();
        encode(Format::Exr, &image, &WriteOptions::default(), &mut expected).unwrap();
        let layers = Layers::from_image(&image);
        assert_eq!(exr(&layers, &WriteOptions::default()), expected);
        assert_eq!(layers.layers()[0].to_image(5, 2).unwrap(), image);
        let back = decode_layers(&expected, Path::new("memory")).unwrap();
        assert_eq!(back.layers, layers);
    }
}

#[test]
fn channels_are_in_their_order() {
    let one = |v: f32| vec![v];
    let layer =
        Layer::new("x").with("A", one(4.0)).with("B", one(3.0)).with("R", one(1.0)).with("G", one(2.0));
    assert!(layer.is_color());
    assert_eq!(layer.to_image(1, 1).unwrap().to_data(), [1.0, 2.0, 3.0, 4.0]);
    let normal = Layer::new("n").with("Z", one(3.0)).with("X", one(1.0)).with("Y", one(2.0));
    assert!(!normal.is_color());
    assert_eq!(normal.to_image(1, 1).unwrap().to_data(), [1.0, 2.0, 3.0]);
    let uv = Layer::new("uv").with("V", one(2.0)).with("U", one(1.0));
    assert_eq!(uv.to_image(1, 1).unwrap().to_data(), [1.0, 2.0, 0.0]);
    let grey = Layer::new("").with("A", one(0.5)).with("Y", one(1.0));
    assert_eq!(grey.to_image(1, 1).unwrap().channels(), 2);
    assert!(uv.to_image(2, 1).is_err());
    let four = normal.with("W", one(0.0));
    assert!(four.to_image(1, 1).is_err() && Layer::new("none").to_image(1, 1).is_err());
}

#[test]
fn layers_that_do_not_fit_are_refused() {
    let mut layers = Layers::new(2, 2);
    layers.push(Layer::new("albedo").with("R", vec![0.0f32; 4])).unwrap();
    let long = "n".repeat(254);
    let cases = [
        (Layer::new("albedo").with("R", vec![0.0f32; 4]), "taken"),
        (Layer::new("depth"), "no channels"),
        (Layer::new("depth").with("Z", vec![0.0f32; 3]), "3 samples"),
        (Layer::new("id").with("X", vec![0u32; 4]).with("X", vec![0u32; 4]), "two channels"),
        (Layer::new("id").with("X.Y", vec![0u32; 4]), "no name"),
        (Layer::new("id").with("", vec![0u32; 4]), "no name"),
        (Layer::new("i\0d").with("X", vec![0u32; 4]), "no name"),
        (Layer::new(long.clone()).with("X", vec![0u32; 4]), "no name"),
    ];
    for (layer, expected) in cases {
        let error = layers.push(layer).unwrap_err().to_string();
        assert!(error.contains(expected) && error.starts_with("layer"), "{error}");
    }
    layers.push(Layer::new(&long[1..]).with("X", vec![7u32; 4])).unwrap();
    let back = decode_layers(&exr(&layers, &WriteOptions::default()), Path::new("memory")).unwrap();
    assert_eq!(back.layers, layers);
    let folder = tempfile::tempdir().unwrap();
    for (name, layers) in [("a.exr", Layers::new(2, 2)), ("a.pfm", Layers::new(2, 2)), ("a.exr", many(0, 3))]
    {
        let error = save_layers(&folder.path().join(name), &layers, &WriteOptions::default()).unwrap_err();
        assert!(matches!(error.kind, ImageErrorKind::NotWritable { .. }), "{error}");
    }
    assert!(save_layers(Path::new("a.xyz"), &layers, &WriteOptions::default()).is_err());
    assert!(save_layers(&folder.path().join("none/a.exr"), &layers, &WriteOptions::default()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_layer_has_a_file_beside_the_picture() {
    let cases = [
        ("image.pfm", "", "image.pfm"),
        ("image.pfm", "albedo", "image.albedo.pfm"),
        ("out/a.b.png", "object-id", "out/a.b.object-id.png"),
        ("out/a", "uv", "out/a.uv"),
        ("out/a.hdr", "../../etc/x y", "out/a..._.._etc_x_y.hdr"),
        ("out/a.hdr", "light.key", "out/a.light.key.hdr"),
    ];
    for (path, layer, expected) in cases {
        assert_eq!(layer_path(Path::new(path), layer), PathBuf::from(expected));
    }
}

#[test]
fn other_formats_have_one_file_each() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let layers = many(7, 3);
    let files = save_layers(&path("a.pfm"), &layers, &WriteOptions::default()).unwrap();
    assert_eq!(files.len(), layers.layers().len());
    for (file, layer) in files.iter().zip(layers.layers()) {
        let (found, expected) = (load(file).unwrap(), layer.to_image(7, 3).unwrap());
        assert_eq!(found.digest(), expected.digest(), "{}", file.display());
    }
    assert!(files.contains(&path("a.albedo.pfm")) && files.contains(&path("a.pfm")));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files.len());
    // Names that differ in what a file name cannot say.
    let mut twins = Layers::new(1, 1);
    for name in ["a/b", "a_b"] {
        twins.push(Layer::new(name).with("X", vec![1.0f32])).unwrap();
    }
    let error = save_layers(&path("b.pfm"), &twins, &WriteOptions::default()).unwrap_err();
    assert!(error.to_string().contains("overwrite") && !path("b.a_b.pfm").exists(), "{error}");
}

#[test]
fn tone_and_exposure_are_the_pictures_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut layers = Layers::new(2, 1);
    let samples = [0.18, 0.5, 0.9, 0.01, 2.0, 0.3];
    for (name, channels) in
        [("", ["R", "G", "B"]), ("albedo", ["R", "G", "B"]), ("position", ["X", "Y", "Z"])]
    {
        layers.push(Layer::interleaved(name, &channels, &samples)).unwrap();
    }
    let options = WriteOptions { tone: ToneCurve::Agx, exposure: 1.5, ..WriteOptions::default() };
    save_layers(&path("a.ppm"), &layers, &options).unwrap();
    let image = Image::from_data(2, 1, 3, samples.to_vec()).unwrap();
    for (name, tone, exposure) in [
        ("a.ppm", ToneCurve::Agx, 1.5),
        ("a.albedo.ppm", ToneCurve::Srgb, 0.0),
        ("a.position.ppm", ToneCurve::Raw, 0.0),
    ] {
        let file = std::fs::read(path(name)).unwrap();
        assert_eq!(file[file.len() - 6..], quantise(&image, tone, exposure), "{name}");
    }
}

#[test]
fn layers_of_other_programs() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    // Half floats, floats and whole numbers with PIZ compression, written by the reference OpenEXR library.
    let found = load_layers(&data.join("layers-piz.exr")).unwrap();
    assert_eq!(found.metadata, [("remark".to_owned(), "by hand".to_owned())]);
    let (w, h) = (7, 5);
    let plane =
        |f: fn(f32, f32) -> f32| (0..w * h).map(|i| f((i % w) as f32, (i / w) as f32)).collect::<Vec<f32>>();
    let id: Vec<u32> = (0..w * h).map(|i| u32::MAX - i).collect();
    let mut expected = Layers::new(w, h);
    let color = Layer::new("").with("R", plane(|x, _| x / 16.0)).with("G", plane(|_, y| y / 8.0));
    let key = Layer::new("light.key").with("R", plane(|x, _| x * 2.0)).with("G", plane(|_, y| y * 2.0));
    expected.push(color.with("B", plane(|x, y| x + y))).unwrap();
    expected.push(key.with("B", plane(|_, _| 3.0))).unwrap();
    let depth = |x: f32, y: f32| (f64::from(x) * 1e10 - f64::from(y) * 1e-10) as f32;
    expected.push(Layer::new("depth").with("Z", plane(depth))).unwrap();
    expected.push(Layer::new("object-id").with("X", id)).unwrap();
    assert_eq!(found.layers, expected);
    for (name, layer) in [("half-piz.exr", ""), ("prefix-zips.exr", "diffuse"), ("tiled-rle.exr", "")] {
        let path = data.join(name);
        let found = load_layers(&path).unwrap().layers;
        let names: Vec<&str> = found.layers().iter().map(Layer::name).collect();
        assert!(names.contains(&layer), "{name}: {names:?}");
        assert_eq!(
            found.get(layer).unwrap().to_image(20, 12).unwrap().to_rgb(),
            load(&path).unwrap().to_rgb()
        );
    }
    let grey = load_layers(&data.join("grey.jpg")).unwrap();
    assert_eq!((grey.format, grey.layers.layers().len()), (Format::Jpeg, 1));
}
