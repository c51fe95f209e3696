//! Other renderers: where their scripts are, and the scenes that all of them render.

use crate::json;
use crate::run::{Call, Outcome, release_binary, root, test_data};
use std::path::{Path, PathBuf};

/// Noise that is left in the reference images, as relMSE, by scene: from their own notes.
pub const REFERENCES: [(&str, f64); 2] = [("cornell", 6.6e-6), ("materials", 7.3e-6)];

/// The scripts of the peers and an interpreter that has what they import.
#[derive(Clone, Debug)]
pub struct Peers {
    scripts: PathBuf,
    references: PathBuf,
    python: PathBuf,
}

impl Peers {
    /// Finds them.
    ///
    /// # Errors
    ///
    /// What is missing, and how to get it.
    pub fn find() -> Result<Self, String> {
        let data = test_data().ok_or(
            "the scripts of the other renderers are in `peers` of the test data: set PENOMBRE_TESTDATA to its folder, or \
             put it beside the workspace as `shared`",
        )?;
        let data = super::absolute(data)?;
        let scripts = data.join("peers");
        if !scripts.join("bench.py").is_file() {
            return Err(format!("no `peers/bench.py` in {}", data.display()));
        }
        let home = std::env::var_os("PEERS_VENV").map(PathBuf::from);
        let home = home.unwrap_or_else(|| std::env::temp_dir().join("peers-venv"));
        let python = home.join("bin/python");
        if !python.is_file() {
            return Err(format!(
                "no {}: run `{}` and set PEERS_VENV as it says",
                python.display(),
                scripts.join("setup.sh").display()
            ));
        }
        Ok(Self { scripts, references: data.join("references"), python })
    }

    /// The image that a scene is held against.
    pub fn reference(&self, scene: &str) -> String {
        self.references.join(format!("{scene}.exr")).to_string_lossy().into_owned()
    }

    /// A call of Python with one of the files; nothing is written beside them.
    fn python(&self, script: &Path, arguments: &[&str]) -> Call {
        let script = script.to_string_lossy().into_owned();
        let words: Vec<&str> = [script.as_str()].into_iter().chain(arguments.iter().copied()).collect();
        Call::new(&self.python, &words)
            .env("PYTHONPATH", &self.scripts)
            .env("PENOMBRE_ADAPTER", adapter())
            .env("PENOMBRE", release_binary())
            // What they make they would keep beside themselves, and the test data is not ours to write to.
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("PEERS_CACHE", root().join("target/peers-cache"))
    }

    /// Writes one of the common scenes as a scene file of penombre into a folder and returns its path.
    pub fn scene_file(&self, scene: &str, folder: &Path, size: u32) -> Result<String, String> {
        let json = self.references.join(format!("{scene}.json")).to_string_lossy().into_owned();
        let place = folder.join(scene);
        std::fs::create_dir_all(&place).map_err(|e| format!("{}: {e}", place.display()))?;
        let said = self.python(&adapter(), &[&json, &place.to_string_lossy(), &size.to_string()]).output()?;
        Ok(said.trim().to_owned())
    }

    /// relMSE of Mitsuba's image at a number of samples per pixel.
    pub fn mitsuba(&self, scene: &str, spp: u32) -> Result<f64, String> {
        let (reference, spp) = (self.reference(scene), spp.to_string());
        let run = self.scripts.join("run.py");
        // With one thread Mitsuba 3.9.1 waits for ever once it has read an environment.
        let options = ["--peer", "mitsuba", "--scene", scene, "--res", "256", "--threads", "2"];
        let more = ["--spp", spp.as_str(), "--ref", reference.as_str()];
        let line = self.python(&run, &[&options[..], &more[..]].concat()).output()?;
        json::number(&line, "relmse").ok_or_else(|| format!("mitsuba said no relmse: {line}"))
    }
}

/// What makes the scenes ours.
fn adapter() -> PathBuf {
    root().join("bench/peers/peer_penombre.py")
}

/// Runs the comparison, with its options; its references and output are chosen unless they are given.
pub fn run(options: &[&str]) -> Outcome {
    let options = options.strip_prefix(&["--"]).unwrap_or(options);
    let peers = Peers::find()?;
    super::build_command()?;
    let mut words = options.to_vec();
    let references = peers.references.to_string_lossy().into_owned();
    let out = root().join("target/peers.jsonl").to_string_lossy().into_owned();
    for (option, value) in [("--peers", "penombre,mitsuba"), ("--refs", &references), ("--out", &out)] {
        if !options.contains(&option) {
            words.extend([option, value]);
        }
    }
    peers.python(&peers.scripts.join("bench.py"), &words).status()
}
/// Loads large meshes beside Mitsuba.
pub fn load(options: &[&str]) -> Outcome {
    let options = options.strip_prefix(&["--"]).unwrap_or(options);
    Call::cargo(&["bench", "-q", "-p", "penombre-scene", "--bench", "load", "--no-run"]).status()?;
    Peers::find()?.python(&root().join("bench/load/load.py"), options).status()
}
