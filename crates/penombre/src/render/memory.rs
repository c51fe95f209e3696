//! How much memory a render will take, told before anything is built.
//!
//! The factors are measured: `docs/benchmarks.md` has the estimates beside the peaks of whole runs.

use super::Job;
use crate::film::FilmLayer;
use penombre_scene::assets::AssetMemory;
use penombre_scene::{Role, SceneDescription, ValueKind};

/// Bytes for each triangle that the finished acceleration structure takes, and while it is built.
const TREE: u64 = 56;
const TREE_BUILDING: u64 = 200;
/// Bytes for each instance, with its place in the acceleration structure.
const INSTANCE: u64 = 512;
/// Bytes for each pixel of a light's image: its colour, and the tables from which it is sampled.
const LIGHT_PIXEL: u64 = 32;
/// Buffers of a thread that renders, bytes.
const THREAD: u64 = 2 << 20;

/// Something that takes memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryPart {
    /// What it is, for people.
    pub what: &'static str,
    /// How much, bytes.
    pub bytes: u64,
}

/// What takes memory at the moment at which it is most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryEstimate {
    /// The largest first, without those that take nothing.
    parts: Vec<MemoryPart>,
}

impl MemoryEstimate {
    /// The memory that it takes to load a scene, build it and, if there is a job, to render and save it with those
    /// layers on so many threads. `program`: what the process takes without all that, bytes.
    pub fn new(
        program: u64,
        description: &SceneDescription,
        assets: &AssetMemory,
        job: Option<(&Job, &[FilmLayer], usize)>,
    ) -> Self {
        let tables = assets.lights.saturating_mul(LIGHT_PIXEL);
        let shapes = assets.shapes.saturating_add(INSTANCE.saturating_mul(instances(description)));
        let tree = |per_triangle: u64| assets.triangles.saturating_mul(per_triangle);
        let files = [("the program", program), ("meshes", assets.meshes), ("images", assets.images)];
        let built = [("shapes", shapes), ("tables of lights", tables)];
        let loading = [("decoding", assets.decoding)];
        let building = [("the acceleration structure", tree(TREE_BUILDING))];
        let mut moments = vec![[&files[..], &loading].concat(), [&files[..], &built, &building].concat()];
        if let Some((job, layers, threads)) = job {
            let rendering = [
                ("the acceleration structure", tree(TREE)),
                ("film", job.film_bytes()),
                ("image files", files_bytes(job, layers)),
                ("threads", THREAD * threads as u64),
            ];
            moments.push([&files[..], &built, &rendering].concat());
        }
        let moments = moments.into_iter().map(Self::of);
        moments.max_by_key(Self::total).unwrap_or(Self { parts: Vec::new() })
    }

    fn of(parts: Vec<(&'static str, u64)>) -> Self {
        let mut parts: Vec<MemoryPart> = parts
            .into_iter()
            .map(|(what, bytes)| MemoryPart { what, bytes })
            .filter(|p| p.bytes > 0)
            .collect();
        parts.sort_by_key(|part| std::cmp::Reverse(part.bytes));
        Self { parts }
    }

    /// All of it, bytes.
    pub fn total(&self) -> u64 {
        self.parts.iter().fold(0, |sum, part| sum.saturating_add(part.bytes))
    }

    /// What it consists of, the largest first.
    pub fn parts(&self) -> &[MemoryPart] {
        &self.parts
    }
}

/// Number of instances.
fn instances(description: &SceneDescription) -> u64 {
    let count = |node: &penombre_scene::Node| match node.param("transforms").map(|p| &p.value.kind) {
        Some(ValueKind::Array(list)) => list.len() as u64,
        _ => 1,
    };
    description.of_role(Role::Instance).map(|(_, node)| count(node)).sum()
}

/// Pictures on their way to files: each channel as a float, and once more as the format wants it.
fn files_bytes(job: &Job, layers: &[FilmLayer]) -> u64 {
    let channels = 3 + layers.iter().map(|layer| layer.channel_count()).sum::<usize>();
    u64::from(job.size[0]) * u64::from(job.size[1]) * 8 * channels as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_scene::Node;

    fn job(width: u32, height: u32) -> Job {
        let size = [i64::from(width), i64::from(height)].map(penombre_scene::Value::from);
        let mut description = SceneDescription::default();
        description.add(Node::new(Role::Render, "render", "").with("size", size));
        Job::planned(&description)
    }

    fn estimate(assets: AssetMemory, job: Option<&Job>) -> MemoryEstimate {
        let job = job.map(|job| (job, &[FilmLayer::Depth, FilmLayer::Albedo][..], 4));
        MemoryEstimate::new(1000, &SceneDescription::default(), &assets, job)
    }

    #[test]
    fn a_planned_job_is_that_of_the_plan() {
        assert_eq!((job(300, 200).size, job(300, 200).tile), ([300, 200], 16));
        assert_eq!(Job::planned(&SceneDescription::default()).size, [640, 480]);
    }

    #[test]
    fn the_moment_that_takes_most_counts() {
        let large =
            |decoding, triangles| AssetMemory { images: 500, decoding, triangles, ..AssetMemory::default() };
        let parts = |estimate: &MemoryEstimate| estimate.parts().iter().map(|p| p.what).collect::<Vec<_>>();
        let loading = estimate(large(5000, 10), None);
        assert_eq!((parts(&loading), loading.total()), (vec!["decoding", "the program", "images"], 6500));
        let building = estimate(large(5000, 100), None);
        assert_eq!(building.total(), 1500 + 100 * TREE_BUILDING);
        let rendering = estimate(large(5000, 100), Some(&job(1000, 1000)));
        assert_eq!(parts(&rendering)[..2], ["film", "image files"]);
        // Two planes of sums of 32 bytes, an image; seven channels of layers and colour.
        assert_eq!(rendering.parts()[0].bytes, 1_000_000 * (2 * 32 + 12));
        assert_eq!(rendering.parts()[1].bytes, 1_000_000 * 7 * 8);
    }

    #[test]
    fn numbers_beyond_all_bounds_do_not_overflow() {
        let all = u64::MAX;
        let assets =
            AssetMemory { meshes: all, images: all, lights: all, decoding: all, shapes: all, triangles: all };
        assert_eq!(estimate(assets, Some(&job(65_536, 65_536))).total(), all);
    }

    #[test]
    fn every_place_of_an_instance_counts() {
        let mut description = SceneDescription::default();
        let places = vec![penombre_scene::Value::from(1.0); 500];
        let kind = ValueKind::Array(places);
        let many = Node::new(Role::Instance, "instance", "a")
            .with("transforms", penombre_scene::Value { kind, span: penombre_scene::Span::NONE });
        description.add(many);
        description.add(Node::new(Role::Instance, "instance", "b"));
        let found = MemoryEstimate::new(0, &description, &AssetMemory::default(), None);
        assert_eq!(found.total(), 501 * INSTANCE);
    }
}
