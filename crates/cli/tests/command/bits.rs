//! The path tracer's bits: the same for any number of threads, size of tiles and set of instructions.

use super::{Folder, text};

/// A scene with all materials, lights and shapes, cut-outs, mixes, textures, caustics and interpolated normals.
const EVERYTHING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/scenes/everything.toml");

/// Digest of a render, in which no sample is lost.
fn digest(folder: &Folder, set: &str, more: &[&str]) -> String {
    let fixed = ["render", EVERYTHING, "--size", "40x32", "--spp", "4", "--json"];
    let mut command = folder.command(&[&fixed, more].concat());
    let output = command.env("PENOMBRE_INSTRUCTIONS", set).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["non_finite"], 0, "{line}");
    line["digest"].as_str().unwrap().to_owned()
}

#[test]
fn everything_has_the_same_bits_everywhere() {
    let folder = Folder::new();
    for filter in ["box", "gaussian", "blackman-harris"] {
        let set = format!("render.filter={filter:?}");
        let base = ["--set", set.as_str()];
        let expected = digest(&folder, "portable", &[&base[..], &["--threads", "1"]].concat());
        // A set that the processor does not have is not used.
        for instructions in ["avx2", "avx512"] {
            assert_eq!(digest(&folder, instructions, &base), expected, "{filter}, {instructions}");
        }
        for more in [["--threads", "3"], ["--tile", "8"], ["--tile", "17"], ["--tile", "64"]] {
            assert_eq!(digest(&folder, "avx2", &[&base[..], &more].concat()), expected, "{filter}, {more:?}");
        }
        assert_ne!(digest(&folder, "avx2", &[&base[..], &["--seed", "1"]].concat()), expected);
    }
    let stratified = ["--set", "render.sampler=\"stratified\""];
    assert_eq!(digest(&folder, "portable", &stratified), digest(&folder, "avx512", &stratified));
}
