//! The same image, bit for bit, from the optimised and the unoptimised build.

use crate::json;
use crate::run::{Call, Outcome, built};

/// Scene and options whose digests are compared.
const PICTURES: &[&str] = &[
    "cornell --size 96x96 --spp 4",
    "cornell --size 96x96 --spp 4 --phase 2 --seed 7",
    "sphere --size 96x96 --spp 4",
    "tests/oracle/scenes/checker-glass.toml --size 96x96 --spp 4",
];

/// Builds the profile `plain` and compares its digests, on one thread, with those of the release build.
pub fn compare_profiles() -> Outcome {
    Call::cargo(&["build", "--profile", "plain", "-p", "penombre-cli"]).status()?;
    let folder = std::env::temp_dir().join(format!("penombre-bits-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let image = folder.join("image.pfm").to_string_lossy().into_owned();
    let differing = PICTURES.iter().try_fold(Vec::new(), |mut differing, &picture| {
        let fast = digest("release", &format!("{picture} --threads 2"), &image)?;
        let plain = digest("plain", &format!("{picture} --threads 1"), &image)?;
        println!("{picture}: {}", if fast == plain { &fast } else { "DIFFERENT" });
        if fast != plain {
            differing.push(format!("{picture}: {fast} with optimisation, {plain} without"));
        }
        Ok::<_, String>(differing)
    });
    std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let differing = differing?;
    if differing.is_empty() { Ok(()) } else { Err(differing.join("\n")) }
}

fn digest(profile: &str, picture: &str, image: &str) -> Result<String, String> {
    let mut arguments = vec!["render"];
    arguments.extend(picture.split_whitespace());
    arguments.extend(["--json", "--no-progress", "-o", image]);
    let render = Call::new(built(profile, "penombre"), &arguments);
    let line = render.output()?;
    let digest = json::text(&line, "digest").ok_or_else(|| format!("`{}`: no digest", render.typed()))?;
    Ok(digest.to_owned())
}
