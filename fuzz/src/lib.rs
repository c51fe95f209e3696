//! What the fuzz targets do with their bytes: what the tests beside the readers do, within bounds. What breaks them ends
//! the process, which the fuzzer takes as a finding.
#![forbid(unsafe_code)]

#[path = "../../crates/scene/tests/meshes/common.rs"]
pub mod common;
#[path = "../../crates/scene/tests/meshes/fuzzed.rs"]
pub mod readers;

#[path = "../../crates/image/tests/fuzzed.rs"]
pub mod images;

#[path = "../../crates/penombre/tests/fuzzed.rs"]
pub mod scenes;

use peak_alloc::PeakAlloc;
use penombre_image::panic_is_contained;
use penombre_scene::readers::MeshFormat;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;
use tempfile::TempDir;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Most memory that a file may take beyond its own length, bytes: what the project promises.
const MOST_MEMORY: usize = 256 << 20;
/// Most processor time that a file may take. The promise is 2 s; the fuzzer's instruments make decoders up to 30 times
/// slower (a JPEG file of 13 × 65476 pixels: 2.2 s and 0.06 s).
const MOST_TIME: Duration = Duration::from_secs(8);

/// Called once: panics that the image library contains are answers and not findings.
pub fn begin() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !panic_is_contained() {
            usual(info);
        }
    }));
}

/// Runs a reader on bytes within the promised bounds.
fn bounded(data: &[u8], read: impl FnOnce(&[u8])) {
    let (before, start) = (MEMORY.current_usage(), penombre_sys::process_cpu_time());
    MEMORY.reset_peak_usage();
    read(data);
    let taken = MEMORY.peak_usage().saturating_sub(before);
    assert!(taken <= MOST_MEMORY + data.len(), "{taken} bytes of memory for {} bytes", data.len());
    let time = penombre_sys::process_cpu_time().zip(start).map(|(now, then)| now.saturating_sub(then));
    assert!(time.unwrap_or_default() <= MOST_TIME, "{time:?} for {} bytes", data.len());
}

/// A folder in memory for files that readers look for beside theirs.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    FOLDER.get_or_init(|| tempfile::tempdir_in("/dev/shm").expect("a folder in memory")).path()
}

/// Reads a mesh.
pub fn mesh(format: MeshFormat, data: &[u8]) {
    bounded(data, |data| readers::mesh(folder(), format, data));
}

/// Reads a material library.
pub fn mtl(data: &[u8]) {
    bounded(data, |data| readers::mtl(folder(), data));
}

/// Unpacks a gzip file.
pub fn gzip(data: &[u8]) {
    bounded(data, readers::gzip);
}

/// Reads an image, and once more as layers.
pub fn image(data: &[u8]) {
    bounded(data, images::image);
    bounded(data, images::layers);
}

/// Reads a scene in TOML.
pub fn toml(data: &[u8]) {
    bounded(data, readers::toml);
}

/// Reads a scene in JSON.
pub fn json(data: &[u8]) {
    bounded(data, readers::json);
}

/// Builds and renders a scene in TOML.
pub fn scene(data: &[u8]) {
    bounded(data, scenes::scene);
}
