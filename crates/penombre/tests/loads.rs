//! Loading again and again in one process takes no more memory. A program of its own: nothing else moves its memory.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use penombre::Plan;
use penombre_image::{Image, WriteOptions, save};
use penombre_scene::load::{LoadOptions, load};
use std::fmt::Write as _;
use std::path::Path;

/// Loads before memory is looked at, and in between.
const FIRST: usize = 20;
const LOADS: usize = 100;
/// How often so many.
const HUNDREDS: usize = 6;

/// Resident memory of this process, bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

/// A textured mesh with its library, and a second copy of it.
fn write_scene(folder: &Path) {
    const EDGE: usize = 30;
    let mut mesh = String::from("mtllib a.mtl\nusemtl m\n");
    for i in 0..EDGE * EDGE {
        let (x, y) = ((i % EDGE) as f32 / EDGE as f32, (i / EDGE) as f32 / EDGE as f32);
        writeln!(mesh, "v {x} {y} {}\nvt {x} {y}", x * y).unwrap();
    }
    for i in (0..EDGE * (EDGE - 1)).filter(|i| i % EDGE + 1 < EDGE).map(|i| i + 1) {
        let corners = [i, i + 1, i + EDGE + 1, i + EDGE].map(|c| format!("{c}/{c}"));
        writeln!(mesh, "f {}", corners.join(" ")).unwrap();
    }
    std::fs::write(folder.join("a.obj"), &mesh).unwrap();
    std::fs::write(folder.join("a.mtl"), "newmtl m\nmap_Kd a.png\n").unwrap();
    save(&folder.join("a.png"), &Image::new(256, 256, 3), &WriteOptions::default()).unwrap();
    let shapes: String = (0..4)
        .map(|i| {
            let name = if i < 2 { "a.obj" } else { "b.obj" };
            format!("[shape.s{i}]\ntype = \"mesh\"\nfile = \"{name}\"\ntransform = [{{ translate = [{i}, 0, 0] }}]\n")
        })
        .collect();
    std::fs::write(folder.join("b.obj"), &mesh).unwrap();
    let text = format!("penombre = 1\n{shapes}[light.l]\ntype = \"point\"\nposition = [0, 0, 9]\n");
    std::fs::write(folder.join("scene.toml"), text).unwrap();
}

#[test]
fn a_hundred_loads_leave_no_memory_behind() {
    let folder = tempfile::tempdir().unwrap();
    write_scene(folder.path());
    let scene = folder.path().join("scene.toml");
    let once = || {
        let mut loaded = load(scene.to_str().unwrap(), &LoadOptions::default());
        let plan = Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics);
        assert!(plan.is_some(), "{:?}", loaded.diagnostics);
    };
    (0..FIRST).for_each(|_| once());
    let resident: Vec<u64> = (0..=HUNDREDS)
        .map(|_| {
            (0..LOADS).for_each(|_| once());
            resident()
        })
        .collect();
    // Which heap of the allocator a thread takes is chance, and each fills once; what is lost is lost in every hundred.
    let growth = resident.windows(2).map(|w| w[1].saturating_sub(w[0])).min().unwrap();
    assert!(growth <= resident[0] / 1000, "{resident:?}");
}
