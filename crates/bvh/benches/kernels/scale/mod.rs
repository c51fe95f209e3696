//! `cargo xtask bench scale`: how cost grows from a thousand to ten million triangles, and to a million instances.
//!
//! ```text
//! cargo xtask bench scale [--largest N] [--instances N] [--rays N] [--reps N] [--svg FILE] [--json]
//! ```
//!
//! One family of meshes, the rough ball of the bench `kernels` in its room, in steps of ten. Costs of rays are medians on
//! one thread, as there; builds use all threads. Peaks of memory are the whole process's while it builds, with the mesh
//! and the copy of it that the hierarchy is built from. The instances are one ball of 10⁵ triangles, turned and stretched at
//! random in a room; hits are repeated by hand in the space of the instance hit, some of them in all instances.
//!
//! `--svg` also draws the table. `--largest` and `--instances` bound the work; 0 instances leave them out.

mod figures;
mod instances;
mod memory;
mod options;
mod plot;
mod report;

use crate::embree::Embree;
use crate::{meshes, rays};
use figures::{Built, Cost, EmbreeBuilt};
use options::Options;
use penombre_bvh::{Quality, Stats};
use report::Report;

/// The smallest mesh, triangles; each is ten times the one before.
const SMALLEST: usize = 1000;
/// Meshes up to this many triangles are built several times.
const SOON_BUILT: usize = 300_000;

/// Figures of one size.
pub struct Row {
    pub triangles: usize,
    pub fast: Built,
    pub high: Built,
    /// Of the high build, whose rays are measured.
    pub stats: Stats,
    pub embree: Option<EmbreeBuilt>,
    pub costs: [Cost; 3],
}

/// Runs it with the words behind its name.
pub fn run(words: impl Iterator<Item = String>) -> Result<(), String> {
    let options = Options::parse(words)?;
    let embree = Embree::from_environment()?;
    let report = Report::opening(options.json, embree.as_ref().map(Embree::version));
    let sizes = std::iter::successors(Some(SMALLEST), |n| n.checked_mul(10));
    let mut rows = Vec::new();
    for size in sizes.take_while(|n| *n <= options.largest) {
        let row = measure(size, embree.as_ref(), &options)?;
        report.row(&row);
        rows.push(row);
    }
    if let Some(file) = &options.svg {
        let text = plot::draw(&rows);
        std::fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    if options.instances > 0 {
        let field = instances::measure(options.instances, options.rays, options.reps)?;
        report.field(&field);
        if field.check.differing + field.check.wrong > 0 {
            return Err("hits in instances are not those of the nested hierarchy".into());
        }
    }
    Ok(())
}

fn measure(size: usize, embree: Option<&Embree>, options: &Options) -> Result<Row, String> {
    let mesh = meshes::rough_ball((size as f64 * 0.5).sqrt().ceil() as u32).in_room();
    let geometry = [mesh.geometry()];
    let times = if size <= SOON_BUILT { 3 } else { 1 };
    let (_, fast) = figures::build(&geometry, Quality::Fast, times)?;
    let (bvh, high) = figures::build(&geometry, Quality::High, times)?;
    let rays = rays::make(&mesh, &bvh, options.rays);
    let theirs = embree.map(|e| figures::build_embree(e, &mesh)).transpose()?;
    let costs = figures::costs(&bvh, theirs.as_ref().map(|(scenes, _)| scenes), &rays, options.reps);
    let embree = theirs.map(|(_, built)| built);
    Ok(Row { triangles: mesh.indices.len(), fast, high, stats: bvh.stats(), embree, costs })
}
