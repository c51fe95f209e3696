//! Rays per second of the kernels on one thread, and of Embree 4 beside them: `cargo xtask bench kernels`.
//!
//! ```text
//! cargo xtask bench kernels [--only NAME-PART] [--mesh FILE]… [--rays N] [--reps N] [--json]
//! ```
//!
//! Without a peer it prints our figures. With `EMBREE_LIB` naming Embree 4's shared library, which is loaded at
//! run time by this program alone, Embree's figures and the ratios come from the same interleaved run.
//!
//! The method: every mesh stands in a closed room; primary rays, diffuse bounces and shadow rays are buffers that all
//! kernels get alike. Each kernel traces the whole buffer in each repetition, one after the other, and the thread's
//! processor time counts, with the conversion of rays and hits from and to our layout. Rates and ratios are medians
//! over the repetitions; a ratio compares two times of the same repetition. Hits count as different if one of both
//! kernels misses or the distances differ by more than a hundred-thousandth.
//!
//! Embree's 16-ray calls are made as for rays in all directions, which suits bounces and shadows best. Primary rays it
//! traces faster if told that they are coherent; that figure stands below the row and counts in no ratio.
//!
//! The same program also asks who is right where the two differ ([`agree`]), and how cost grows with size ([`scale`]).
//!
//! `PENOMBRE_INSTRUCTIONS=avx2` (or `portable`) measures our kernels without the wider instructions.
//!
//! `--json` puts one object a line on standard output, one for each mesh and ray kind (Mrays/s, one thread) and one
//! for each mesh (seconds, bytes); everything else goes to standard error then.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a bench talks to a person")]

mod agree;
mod embree;
mod files;
mod measure;
mod meshes;
mod options;
mod ours;
mod packets;
mod rays;
mod report;
mod scale;

use embree::Embree;
use meshes::Mesh;
use options::Options;
use report::Report;
use std::process::ExitCode;

/// Rays of each kind unless said otherwise.
const RAYS: usize = 400_000;

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench").peekable();
    let outcome = match words.peek().map(String::as_str) {
        Some("agree") => agree::run(words.skip(1)),
        Some("scale") => scale::run(words.skip(1)),
        _ => Options::parse(words, RAYS).and_then(|options| run(&options)),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let embree = Embree::from_environment()?;
    let mut report = Report::new(options.json);
    report.opening(embree.as_ref().map(Embree::version));
    let built_in = meshes::BUILT_IN.iter().filter(|(name, _)| options.wants(name));
    for (name, make) in built_in {
        match make() {
            Ok(mesh) => bench(name, mesh, embree.as_ref(), options, &mut report)?,
            Err(why) => report.not_run(name, &why),
        }
    }
    for path in &options.meshes {
        let name = files::name_of(path);
        let mesh = files::read(path)?.in_room();
        bench(&name, mesh, embree.as_ref(), options, &mut report)?;
    }
    report.closing()
}

/// Builds all hierarchies of one mesh, makes its rays and measures.
fn bench(
    name: &str,
    mesh: Mesh,
    embree: Option<&Embree>,
    options: &Options,
    report: &mut Report,
) -> Result<(), String> {
    let (ours, build) = measure::build_ours(&mesh)?;
    let theirs = embree.map(|e| measure::build_embree(e, &mesh)).transpose()?;
    report.mesh(name, mesh.indices.len(), &build, theirs.as_ref().map(|t| &t.build));
    let rays = rays::make(&mesh, &ours, options.rays);
    for (kind, rays) in rays.each() {
        let scenes = theirs.as_ref().map(|t| &t.scenes);
        report.rays(kind, &measure::rays(&ours, scenes, kind, rays, options.reps));
    }
    Ok(())
}
