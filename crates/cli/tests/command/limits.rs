//! `--noise`, `--time`, `--aov`, samplers and filters.

use super::{Folder, names};
use penombre_image::{Samples, load_layers};
use serde_json::Value;
use std::time::Instant;

/// Arguments of a small box with soft shadows, and more.
fn cornell<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "cornell", "--size", "32x32", "--json"], more].concat()
}

fn digest(line: &Value) -> String {
    line["digest"].as_str().unwrap().to_owned()
}

#[test]
fn a_noise_limit_gives_the_same_bits_for_any_threads_and_tiles() {
    let folder = Folder::new();
    let run = |more: &[&str]| folder.json(&[&cornell(&["--noise", "0.015"]), more].concat());
    let expected = run(&["--threads", "1"]);
    assert!(expected["error"].as_f64().is_some_and(|e| e > 0.0 && e < 0.015), "{expected}");
    let spp = expected["spp"].as_f64().unwrap();
    assert!((32.0..4096.0).contains(&spp) && spp % 16.0 == 0.0, "{spp}");
    assert_eq!(expected["stopped_by"], "noise");
    for more in [["--threads", "2"], ["--threads", "3"], ["--tile", "7"], ["--tile", "64"]] {
        assert_eq!(digest(&run(&more)), digest(&expected), "{more:?}");
    }
    // The samples of the command line are the most that are taken.
    let capped = run(&["--spp", "34"]);
    assert_eq!((&capped["spp"], &capped["stopped_by"]), (&34.0.into(), &"spp".into()));
    assert!(capped["error"].as_f64().is_some_and(|e| e > 0.0));
    let set = run(&["--set", "render.spp=20"]);
    assert_eq!(set["spp"], 20.0);
    // Without a limit nothing is estimated.
    let plain = folder.json(&cornell(&["--spp", "4"]));
    assert_eq!((&plain["error"], &plain["stopped_by"]), (&Value::Null, &"spp".into()));
}

#[test]
fn a_time_limit_saves_an_image_of_whole_passes() {
    let folder = Folder::new();
    let begin = Instant::now();
    let line = folder.json(&cornell(&["--time", "0.5s", "-o", "a.pfm"]));
    assert!(begin.elapsed().as_secs() < 60);
    assert_eq!(line["stopped_by"], "time");
    let spp = line["spp"].as_f64().unwrap();
    assert!(spp >= 1.0 && spp.fract() == 0.0, "{spp}");
    assert!(folder.path("a.pfm").is_file());
    let spp = spp.to_string();
    assert_eq!(digest(&folder.json(&cornell(&["--spp", &spp]))), digest(&line));
    // However short: one sample of each pixel is taken.
    let line = folder.json(&cornell(&["--time", "0.000001"]));
    assert_eq!(line["spp"].as_f64().unwrap().fract(), 0.0);
    assert!(line["spp"].as_f64().unwrap() >= 1.0);
    // Samples and error end it as well.
    assert_eq!(folder.json(&cornell(&["--time", "1h", "--spp", "3"]))["stopped_by"], "spp");
    assert_eq!(folder.json(&cornell(&["--time", "1h", "--noise", "0.2"]))["stopped_by"], "noise");
}

#[test]
fn layers_are_in_the_exr_and_beside_other_files() {
    let folder = Folder::new();
    let all = "normal,albedo,depth,position,uv,object-id,material-id,samples,variance";
    let more = ["--spp", "8", "--aov", all, "-o", "a.exr", "-o", "b.pfm"];
    let line = folder.json(&cornell(&more));
    let layers = load_layers(&folder.path("a.exr")).unwrap().layers;
    assert_eq!(layers.layers().len(), 10);
    for name in all.split(',') {
        let layer = layers.get(name).unwrap();
        let file = format!("b.{name}.pfm");
        let alone = penombre_image::load(&folder.path(&file)).unwrap();
        let expected = layer.to_image(32, 32).unwrap();
        assert_eq!(alone.rgb(16, 20), expected.rgb(16, 20), "{name}");
        assert!(line["outputs"].as_array().unwrap().contains(&file.into()), "{line}");
    }
    assert_eq!(layers.get("samples").unwrap().channel("X"), Some(&Samples::U32(vec![8; 32 * 32])));
    let normal = layers.get("normal").unwrap().to_image(32, 32).unwrap().rgb(16, 16);
    assert!((normal.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-3, "{normal:?}");
    assert!(line["error"].as_f64().is_some_and(|e| e > 0.0), "asked for by the variance");
    // Layers of surfaces change no bit of the colour; names may be repeated.
    let plain = folder.json(&cornell(&["--spp", "8"]));
    let line =
        folder.json(&cornell(&["--spp", "8", "--aov", "normal", "--aov", "depth,normal", "-o", "c.png"]));
    assert_eq!(digest(&line), digest(&plain));
    for file in ["c.png", "c.normal.png", "c.depth.png"] {
        assert!(names(folder.0.path()).contains(&file.to_owned()), "{file}");
    }
}

#[test]
fn filters_and_samplers_are_chosen_by_path() {
    let folder = Folder::new();
    let run = |sets: &[&str]| digest(&folder.json(&cornell(&[&["--spp", "4"], sets].concat())));
    let expected = run(&[]);
    assert_eq!(run(&["--set", "render.filter=box"]), expected);
    let mut seen = vec![expected];
    for set in [
        "render.filter=gaussian",
        "render.filter=blackman-harris",
        "render.filter_radius=1",
        "render.sampler=stratified",
        "render.sampler=independent",
    ] {
        let found = run(&["--set", set]);
        assert!(!seen.contains(&found), "{set}");
        seen.push(found);
    }
}

#[test]
fn wrong_limits_and_layers_are_refused() {
    let folder = Folder::new();
    for (more, expected) in [
        (vec!["--noise", "0"], "above 0"),
        (vec!["--noise", "-1"], "above 0"),
        (vec!["--noise", "lots"], "above 0"),
        (vec!["--time", "0"], "above 0"),
        (vec!["--time", "-5s"], "above 0"),
        (vec!["--time", "3 parsec"], "expected s, min or h"),
        (vec!["--aov", "normals"], "did you mean `normal`"),
        (vec!["--aov", "depth,"], "layers: albedo, depth"),
        (vec!["--aov", "depth", "-o", "-"], "no file for the layers"),
        (vec!["--aov", "depth", "-o", "a.png", "-o", "a.depth.png"], "twice"),
        (vec!["--set", "render.filter=gauss"], "gaussian"),
        (vec!["--set", "render.filter_radius=0"], "filter_radius"),
        (vec!["--set", "render.sampler=sobel"], "sobol"),
    ] {
        let said = folder.refused(&[&["render", "cornell"], more.as_slice()].concat());
        assert!(said.contains(expected), "{more:?}: {said}");
    }
    assert!(names(folder.0.path()).is_empty());
}
