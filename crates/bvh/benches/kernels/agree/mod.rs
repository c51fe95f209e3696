//! `cargo xtask bench agree`: where our hits are not those of Embree's watertight scenes, who is right?
//!
//! ```text
//! cargo xtask bench agree [--only NAME-PART] [--mesh FILE]… [--rays N] [--json]
//! ```
//!
//! A million rays of each kind (or `--rays`) on each mesh of the bench `kernels`, in batches. Differences are sorted
//! into classes. Those that are more than another choice between equal distances go to an oracle: a search of all
//! triangles with exact signs and distances in double precision. Besides, each of these rays is answered once more by a
//! loop over the triangles near it, each alone in a hierarchy of its own: other bits than the tree's are a fault, and the
//! program fails.
//!
//! Margins tell how clear a truth is: from the ray to the nearest edge, or from its end to the plane, in units of 2⁻²⁴ of
//! the distance to the farthest corner. A few units are what rounding of coordinates in single precision does.

mod classes;
mod exact;
mod oracle;
mod report;

use crate::embree::{self, Build, Embree, Shared};
use crate::files;
use crate::measure::Kernel;
use crate::meshes::{self, Mesh};
use crate::options::Options;
use crate::ours::{self, Batch};
use crate::rays::{self, Kind};
use classes::Classes;
use oracle::Oracle;
use penombre_bvh::{Hit, Ray};

/// Rays of each kind unless said otherwise: a million, and what pictures of whole pixels leave out.
const RAYS: usize = 1_010_000;

/// Runs it with the words behind its name.
pub fn run(words: impl Iterator<Item = String>) -> Result<(), String> {
    let options = Options::parse(words, RAYS)?;
    let embree = Embree::from_environment()?.ok_or("EMBREE_LIB does not name Embree 4's library")?;
    exact::check()?;
    report::opening(options.json, &embree.version());
    let mut faults = 0;
    for (name, make) in meshes::BUILT_IN.iter().filter(|(name, _)| options.wants(name)) {
        match make() {
            Ok(mesh) => faults += compare(name, &mesh, &embree, &options)?,
            Err(why) => eprintln!("NOT RUN: {name}: {why}"),
        }
    }
    for path in &options.meshes {
        let mesh = files::read(path)?.in_room();
        faults += compare(&files::name_of(path), &mesh, &embree, &options)?;
    }
    if faults > 0 {
        Err(format!("{faults} of our hits are not those of a loop over all triangles"))
    } else {
        Ok(())
    }
}

/// All kinds of rays on one mesh. Returns the number of our faults.
fn compare(name: &str, mesh: &Mesh, embree: &Embree, options: &Options) -> Result<usize, String> {
    let bvh = ours::build_high(mesh.geometry())?;
    let robust = embree.build(&Shared::new(mesh), Build::Robust)?;
    let (ours, theirs) = (Batch(&bvh), embree::One(&robust));
    let oracle = Oracle { mesh };
    let mut faults = 0;
    for (kind, rays) in rays::make(mesh, &bvh, options.rays).each() {
        let classes = match kind {
            Kind::Shadow => occluded(&oracle, &ours, &theirs, rays),
            _ => closest(&oracle, &ours, &theirs, rays),
        };
        report::row(options.json, name, mesh.indices.len(), kind, &classes);
        faults += classes.faults.len();
    }
    Ok(faults)
}

fn closest(oracle: &Oracle<'_>, ours: &dyn Kernel, theirs: &dyn Kernel, rays: &[Ray]) -> Classes {
    let [mut a, mut b] = [vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]];
    ours.closest(rays, &mut a);
    theirs.closest(rays, &mut b);
    let mut classes = Classes::default();
    for ((ray, ours), theirs) in rays.iter().zip(&a).zip(&b) {
        classes.closest(oracle, ray, ours, theirs);
    }
    classes
}

fn occluded(oracle: &Oracle<'_>, ours: &dyn Kernel, theirs: &dyn Kernel, rays: &[Ray]) -> Classes {
    let [mut a, mut b] = [vec![false; rays.len()], vec![false; rays.len()]];
    ours.occluded(rays, &mut a);
    theirs.occluded(rays, &mut b);
    let mut classes = Classes::default();
    for ((ray, ours), theirs) in rays.iter().zip(&a).zip(&b) {
        classes.occluded(oracle, ray, *ours, *theirs);
    }
    classes
}
