//! The pictures of the README.

use crate::run::{Call, Outcome, release_binary, root};

/// Name of the picture in `docs/images/`, scene, and further options of `penombre render`.
const PICTURES: &[(&str, &str, &str)] = &[
    ("cornell-phase-1.png", "cornell", "--phase 1 --size 240x240 --spp 64"),
    ("cornell-phase-2.png", "cornell", "--phase 2 --size 240x240 --spp 64"),
    ("cornell-phase-3.png", "cornell", "--phase 3 --size 240x240 --spp 64"),
    ("cornell-phase-4.png", "cornell", "--phase 4 --size 240x240 --spp 64"),
    ("cornell-path.png", "cornell", "--integrator path --size 240x240 --spp 512"),
    ("cornell.png", "cornell", ""),
    ("materials.jpg", "scenes/materials.toml", ""),
    ("spot.jpg", "assets/meshes/spot.obj", "--size 480x480 --spp 256"),
    ("spot-gold.jpg", "scenes/spot.toml", "--asset-root assets --exposure -0.4"),
    ("checker-mirror.png", "tests/oracle/scenes/checker-mirror.toml", ""),
    ("checker-glass.png", "tests/oracle/scenes/checker-glass.toml", ""),
];

/// Builds the command and renders every picture.
pub fn run() -> Outcome {
    Call::cargo(&["build", "--release", "-p", "penombre-cli"]).status()?;
    let folder = root().join("docs/images");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, scene, options) in PICTURES {
        let output = format!("docs/images/{name}");
        let mut arguments = vec!["render", scene];
        arguments.extend(options.split_whitespace());
        arguments.extend(["--no-progress", "-o", &output]);
        Call::new(release_binary(), &arguments).status()?;
        println!("{output}    {scene} {options}");
    }
    Ok(())
}
