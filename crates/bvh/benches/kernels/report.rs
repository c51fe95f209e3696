//! What is printed: a table for a person, or lines of JSON for a program.

use crate::measure::{BuildFigures, Peer, Rates};
use crate::rays::Kind;
use penombre_bvh::InstructionSet;

/// The ratios of speeds that are printed: ours over Embree's.
pub const RATIOS: [&str; 4] = ["one/robust", "one/best one", "batch/best one", "batch/best 16"];

/// Prints as figures come, and remembers the ratios.
pub struct Report {
    json: bool,
    /// Name and triangles of the mesh that is being measured.
    mesh: (String, usize),
    ratios: Vec<(Kind, [f64; 4])>,
    meshes: usize,
}

impl Report {
    /// Lines of JSON, or a table.
    pub fn new(json: bool) -> Self {
        Self { json, mesh: (String::new(), 0), ratios: Vec::new(), meshes: 0 }
    }

    /// For a person: beside the JSON on standard error, otherwise on standard output.
    fn say(&self, line: &str) {
        if self.json { eprintln!("{line}") } else { println!("{line}") }
    }

    /// What is compared.
    pub fn opening(&self, embree: Option<String>) {
        let peer = embree.map_or_else(
            || "no peer: EMBREE_LIB does not name Embree 4's library".to_owned(),
            |v| format!("Embree {v}"),
        );
        self.say(&format!(
            "ray kernels: Mrays/s on one thread with {}, wall time of builds with up to two threads; {peer}",
            InstructionSet::best()
        ));
    }

    /// A mesh that is not there.
    pub fn not_run(&self, name: &str, why: &str) {
        eprintln!("NOT RUN: {name}: {why}");
    }

    /// The mesh that the next figures belong to, and its builds.
    pub fn mesh(&mut self, name: &str, triangles: usize, ours: &BuildFigures, theirs: Option<&BuildFigures>) {
        self.mesh = (name.to_owned(), triangles);
        self.meshes += 1;
        if self.json {
            println!("{}", self.build_line(ours, theirs));
            return;
        }
        println!("\n{name}: {triangles} triangles");
        println!("  build   {}", build_text("fast", ours));
        if let Some(theirs) = theirs {
            println!("  Embree  {}", build_text("medium", theirs));
        }
        let peers = if theirs.is_some() { PEERS } else { "" };
        println!("  {:8}{:>8}{:>8}{peers}", "", "one", "batch");
    }

    /// Figures of one kind of rays.
    pub fn rays(&mut self, kind: Kind, rates: &Rates) {
        if self.json {
            println!("{}", self.ray_line(kind, rates));
        } else {
            let peer = rates.embree.as_ref().map_or_else(String::new, peer_text);
            println!("  {:8}{:8.2}{:8.2}{peer}", kind.name(), rates.one, rates.batch);
        }
        if rates.inconsistent > 0 {
            let (name, kind) = (&self.mesh.0, kind.name());
            eprintln!("FAULT: {name}: {} {kind} rays differ between our two calls", rates.inconsistent);
        }
        let Some(peer) = rates.embree else { return };
        self.ratios.push((kind, peer.ratios));
        if peer.coherent_16 > 0.0 {
            let share = rates.batch / peer.coherent_16;
            self.say(&format!(
                "          Embree, 16 rays said to be coherent: {:.2}; batch {share:.2} of it",
                peer.coherent_16
            ));
        }
        if self.json && peer.differing.total() > 0 {
            let (name, kind, differ) = (&self.mesh.0, kind.name(), difference_text(peer));
            eprintln!("{name}: of {} {kind} rays differ from Embree robust: {differ}", rates.rays);
        }
    }

    /// Geometric means over all meshes. An error if there was none.
    pub fn closing(&self) -> Result<(), String> {
        if self.meshes == 0 {
            return Err("no mesh was measured".into());
        }
        if self.ratios.is_empty() {
            return Ok(());
        }
        self.say(&format!("\ngeometric mean (smallest) of the ratios to Embree, {} meshes", self.meshes));
        self.say(&format!("  {:8}{}", "", RATIOS.map(|name| format!("{name:>18}")).concat()));
        for kind in [Kind::Primary, Kind::Bounce, Kind::Shadow] {
            let cells: String = (0..RATIOS.len()).map(|i| self.mean_text(kind, i)).collect();
            self.say(&format!("  {:8}{cells}", kind.name()));
        }
        Ok(())
    }

    fn mean_text(&self, kind: Kind, ratio: usize) -> String {
        let values = || self.ratios.iter().filter(|(k, _)| *k == kind).map(|(_, ratios)| ratios[ratio]);
        let mean = (values().map(f64::ln).sum::<f64>() / values().count() as f64).exp();
        let smallest = values().fold(f64::INFINITY, f64::min);
        format!("{:>18}", format!("{mean:.2} ({smallest:.2})"))
    }

    fn ray_line(&self, kind: Kind, rates: &Rates) -> String {
        let embree = |figure: fn(&Peer) -> f64| number(rates.embree.as_ref().map(figure));
        format!(
            r#"{{"mesh":{},"triangles":{},"rays":"{}","one":{},"batch":{},"embree_robust":{},"embree_best_one":{},"embree_best_16":{}}}"#,
            quoted(&self.mesh.0),
            self.mesh.1,
            kind.name(),
            number(Some(rates.one)),
            number(Some(rates.batch)),
            embree(|p| p.robust),
            embree(|p| p.best_one),
            embree(|p| p.best_16),
        )
    }

    fn build_line(&self, ours: &BuildFigures, theirs: Option<&BuildFigures>) -> String {
        format!(
            r#"{{"mesh":{},"build_fast_s":{},"build_high_s":{},"embree_medium_s":{},"embree_high_s":{},"bytes":{},"embree_bytes":{}}}"#,
            quoted(&self.mesh.0),
            number(Some(ours.quick)),
            number(Some(ours.high)),
            number(theirs.map(|t| t.quick)),
            number(theirs.map(|t| t.high)),
            ours.bytes,
            theirs.map_or_else(|| "null".to_owned(), |t| t.bytes.to_string()),
        )
    }
}

const PEERS: &str = "  robust best one best 16 | one/robust one/best1 batch/best1 batch/best16 | differ";

fn peer_text(peer: &Peer) -> String {
    let [a, b, c, d] = peer.ratios;
    let rates = format!("{:8.2}{:9.2}{:8.2}", peer.robust, peer.best_one, peer.best_16);
    format!("{rates} |{a:11.2}{b:10.2}{c:12.2}{d:13.2} | {}", difference_text(*peer))
}

fn difference_text(peer: Peer) -> String {
    let differ = peer.differing;
    format!("{} ({} hit or miss)", differ.total(), differ.hit_or_miss)
}

fn build_text(quick: &str, build: &BuildFigures) -> String {
    let bytes = build.bytes as f64 / 1_048_576.0;
    format!("{quick} {:.3} s, high {:.3} s, {bytes:.1} MiB", build.quick, build.high)
}

fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(|| "null".to_owned(), |v| format!("{v:.4}"))
}

/// A JSON string. Names of files may hold anything.
pub fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04x}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
