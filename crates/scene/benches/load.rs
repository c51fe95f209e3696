//! Loads a scene or mesh file once, as the command does, and prints what it took as a line of JSON:
//! `cargo bench -p penombre-scene --bench load -- FILE`. `cargo xtask bench load` compares it with other programs.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark talks to a person")]

use penombre_scene::Role;
use penombre_scene::load::{LoadOptions, load};
use std::time::Instant;

fn main() {
    let Some(file) = std::env::args().skip(1).find(|a| a != "--bench") else { return };
    let base = penombre_sys::peak_rss().unwrap_or(0);
    let (start, cpu) = (Instant::now(), penombre_sys::process_cpu_time().unwrap_or_default());
    let loaded = load(&file, &LoadOptions::default());
    let seconds = start.elapsed().as_secs_f64();
    let cpu = penombre_sys::process_cpu_time().unwrap_or_default().saturating_sub(cpu).as_secs_f64();
    let peak = penombre_sys::peak_rss().unwrap_or(0);
    assert!(!loaded.diagnostics.has_errors(), "{:?}", loaded.diagnostics);
    let shapes = loaded.description.of_role(Role::Shape);
    let triangles: usize =
        shapes.filter_map(|(id, _)| Some(loaded.assets.mesh(id)?.mesh.indices.len())).sum();
    let bytes = loaded.assets.bytes();
    println!(
        "{{\"file\":{file:?},\"triangles\":{triangles},\"load_s\":{seconds:.4},\"cpu_s\":{cpu:.4},\"bytes\":{bytes},\
         \"base_rss\":{base},\"peak_rss\":{peak}}}"
    );
}
