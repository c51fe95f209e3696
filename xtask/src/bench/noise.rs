//! Whether `--noise` keeps its word: the true error of images by the error that they promise.

use super::peers::Peers;
use super::{Folder, number_option, rel_mse};
use crate::json;
use crate::run::{Call, Outcome, release_binary};

/// Errors that are asked for.
const WANTED: [&str; 2] = ["0.05", "0.02"];
/// The truth has so many times the samples, and another seed.
const MORE: u32 = 16;
/// Ratios outside of this are told.
const FAIR: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// Renders five scenes until the estimated error is 5 % and 2 %, `--size N` pixels square (default 64), with at most `--spp N`
/// samples per pixel (default 1024), and prints true by promised error.
pub fn run(options: &[&str]) -> Outcome {
    let size = number_option(options, "--size", 64)?;
    let cap = number_option(options, "--spp", 1024)?;
    let peers = Peers::find();
    super::build_command()?;
    let folder = Folder::new("noise")?;
    let mut scenes: Vec<(String, Vec<String>)> = ["path", "classic"]
        .map(|i| (format!("cornell {i}"), ["cornell", "--integrator", i].map(str::to_owned).to_vec()))
        .to_vec();
    match peers {
        Ok(peers) => {
            for scene in ["cornell", "materials", "course"] {
                let file = peers.scene_file(scene, folder.path(), size)?;
                scenes.push((format!("ref-{scene}"), vec![file, "--asset-root".to_owned(), "/".to_owned()]));
            }
        }
        Err(message) => println!("without the scenes of the peers: {message}"),
    }
    for (name, words) in &scenes {
        for wanted in WANTED {
            let (line, spp) = ratio(words, wanted, size, cap, &folder)?;
            println!("{name}, --noise {wanted}: {line}");
            if spp >= f64::from(cap) {
                // Less noise would be the same image.
                break;
            }
        }
    }
    Ok(())
}

/// Measures one image: what to say of it, and its samples per pixel.
fn ratio(
    words: &[String],
    wanted: &str,
    size: u32,
    cap: u32,
    folder: &Folder,
) -> Result<(String, f64), String> {
    let [image, truth] = ["image.exr", "truth.exr"].map(|name| folder.file(name));
    let size = format!("{size}x{size}");
    let render = |output: &str, spp: u32, seed: &str, more: &[&str]| {
        let spp = spp.to_string();
        let mut call = vec!["render"];
        call.extend(words.iter().map(String::as_str));
        call.extend(["--size", &size, "--spp", &spp, "--seed", seed, "--threads", "1", "--no-progress"]);
        call.extend(["--json", "-o", output]);
        call.extend(more);
        Call::new(release_binary(), &call).output()
    };
    let line = render(&image, cap, "1", &["--noise", wanted])?;
    let number = |key| json::number(&line, key).ok_or_else(|| format!("no number `{key}` in: {line}"));
    let (spp, promised) = (number("spp")?, number("error")?);
    render(&truth, spp as u32 * MORE, "1000", &[])?;
    // The truth has noise, too: a share of 1/16 if variances fall with the number of samples.
    let found = (rel_mse(&image, &truth)? / (1.0 + 1.0 / f64::from(MORE))).sqrt();
    let ratio = found / promised;
    let verdict = if FAIR.contains(&ratio) { "" } else { "  OUTSIDE" };
    Ok((format!("{spp:.0} spp, promised {promised:.4}, true {found:.4}, ratio {ratio:.3}{verdict}"), spp))
}
