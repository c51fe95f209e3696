//! `penombre info`.

use crate::args::{InfoArgs, Verbosity};
use crate::memory::{Use, bytes};
use crate::scene::{Prepared, prepare};
use crate::{Exit, terminal};
use penombre::scene::{Count, Hierarchy, Summary};
use serde_json::{Value, json};

/// Tells what is inside a scene.
pub fn run(args: &InfoArgs, verbosity: &Verbosity) -> Exit {
    let Some(prepared) = prepare(&args.scene, Use::Tell, verbosity) else { return Exit::Usage };
    let summary = prepared.plan.scene.summary();
    if args.json {
        terminal::out(&to_json(&args.scene.scene, &prepared, &summary).to_string());
    } else {
        terminal::out(&to_text(&prepared, &summary));
    }
    Exit::Done
}

fn to_json(scene: &str, prepared: &Prepared, summary: &Summary) -> Value {
    let by_type = |counts: &[Count]| -> Value {
        counts
            .iter()
            .map(|c| (c.type_name.to_owned(), json!(c.count)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let (b, job, tree) = (summary.bounds, &prepared.plan.job, prepared.plan.scene.hierarchy());
    let bounds =
        if b.is_empty() { Value::Null } else { json!({"min": b.min.to_array(), "max": b.max.to_array()}) };
    json!({
        "scene": scene,
        "name": prepared.loaded.name,
        "digest": prepared.loaded.description.digest(&prepared.loaded.assets),
        "shapes": by_type(&summary.shapes),
        "materials": by_type(&summary.materials),
        "textures": by_type(&summary.textures),
        "lights": by_type(&summary.lights),
        "cameras": summary.cameras,
        "triangles": summary.triangles,
        "instances": summary.instances,
        "bounds": bounds,
        "bvh_bytes": summary.bvh_bytes,
        "bvh_nodes": tree.nodes,
        "bvh_leaves": tree.leaves,
        "bvh_depth": tree.depth,
        "bvh_sah_cost": tree.sah_cost,
        "bvh_build_s": tree.build_time.as_secs_f64(),
        "asset_bytes": prepared.loaded.assets.bytes(),
        "memory_estimate_bytes": prepared.memory.total(),
        "extensions": [],
        "integrator": prepared.plan.integrator.name(),
        "size": job.size,
        "spp": job.spp,
        "load_s": prepared.load_s,
        "build_s": prepared.build_s,
    })
}

fn to_text(prepared: &Prepared, summary: &Summary) -> String {
    let (b, job) = (summary.bounds, &prepared.plan.job);
    let list = |counts: &[Count]| match counts {
        [] => "none".to_owned(),
        some => some.iter().map(|c| format!("{} {}", c.count, c.type_name)).collect::<Vec<_>>().join(", "),
    };
    let bounds = if b.is_empty() {
        "empty".to_owned()
    } else {
        format!("{} to {}, size {} m", triple(b.min), triple(b.max), triple(b.size()))
    };
    let names = summary.cameras.iter().map(|n| if n.is_empty() { "automatic" } else { n });
    let lines = [
        ("scene", prepared.loaded.name.clone()),
        ("shapes", list(&summary.shapes)),
        ("triangles", summary.triangles.to_string()),
        ("instances", summary.instances.to_string()),
        ("materials", list(&summary.materials)),
        ("textures", list(&summary.textures)),
        ("lights", list(&summary.lights)),
        ("cameras", names.collect::<Vec<_>>().join(", ")),
        ("bounds", bounds),
        ("tree", tree_text(&prepared.plan.scene.hierarchy())),
        (
            "memory",
            format!(
                "{} tree, {} assets; about {} to render it",
                bytes(summary.bvh_bytes as u64),
                bytes(prepared.loaded.assets.bytes()),
                bytes(prepared.memory.total())
            ),
        ),
        (
            "render",
            format!(
                "{}, {}×{} pixels, {} spp",
                prepared.plan.integrator.name(),
                job.size[0],
                job.size[1],
                job.spp
            ),
        ),
        ("times", format!("loaded in {:.3} s, built in {:.3} s", prepared.load_s, prepared.build_s)),
    ];
    lines.map(|(name, value)| format!("{name:10} {value}")).join("\n")
}

fn tree_text(tree: &Hierarchy) -> String {
    let nested = match tree.nested {
        0 => String::new(),
        n => format!(", nested {n}"),
    };
    format!(
        "nodes {}, leaves {}, depth {}{nested}, cost {:.1}, built in {:.3} s",
        tree.nodes,
        tree.leaves,
        tree.depth,
        tree.sah_cost,
        tree.build_time.as_secs_f64()
    )
}

fn triple(v: penombre_math::Vec3) -> String {
    let number = |x: f32| {
        let text = format!("{x:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    format!("({}, {}, {})", number(v.x), number(v.y), number(v.z))
}
