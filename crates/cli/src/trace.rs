//! `penombre trace`.

use crate::args::{TraceArgs, Verbosity};
use crate::memory::Use;
use crate::scene::{Prepared, prepare};
use crate::{Exit, report, terminal};
use penombre::integrator::{LightRecord, PathRecord, VertexRecord};
use penombre::render::record;
use penombre_math::{Spectrum, Vec3};
use serde_json::{Value, json};

/// Tells every vertex of the path of one sample.
pub fn run(args: &TraceArgs, verbosity: &Verbosity) -> Exit {
    let Some(prepared) = prepare(&args.scene, Use::Trace, verbosity) else { return Exit::Usage };
    let (plan, [x, y]) = (&prepared.plan, args.pixel);
    let [w, h] = plan.job.size;
    if x >= w || y >= h {
        let message = format!("`--pixel {x},{y}` lies outside the image of {w}×{h} pixels");
        report::error(&message, "pixels are counted from 0,0 at the upper left");
        return Exit::Usage;
    }
    let path = record(&plan.scene, &*plan.integrator, &plan.job, args.pixel, args.sample);
    if args.json {
        terminal::out(&to_json(args, &prepared, &path).to_string());
    } else {
        terminal::out(&to_text(args, &prepared, &path));
    }
    Exit::Done
}

/// The index that every vertex was made by: the last one before it whose node is half of its own.
fn parent(path: &PathRecord, index: usize) -> Option<usize> {
    let node = path.vertices[index].place.node;
    path.vertices[..index].iter().rposition(|v| v.place.node == node / 2)
}

fn to_text(args: &TraceArgs, prepared: &Prepared, path: &PathRecord) -> String {
    let [x, y] = args.pixel;
    let mut lines = vec![format!(
        "{}, pixel {x},{y}, sample {}: radiance {}, {} vertices, {} rays",
        prepared.loaded.name,
        args.sample,
        color(path.radiance),
        path.vertices.len(),
        path.rays
    )];
    for (index, vertex) in path.vertices.iter().enumerate() {
        let from = parent(path, index).map(|p| format!(" from vertex {p}")).unwrap_or_default();
        lines.push(format!(
            "\nvertex {index}: {}{from}, bounce {}, weight {}",
            vertex.place.origin,
            vertex.place.depth,
            color(vertex.place.weight)
        ));
        lines.push(format!(
            "  ray       {} direction {}, t from {} to {}",
            point(vertex.ray.origin),
            point(vertex.ray.dir),
            vertex.ray.t_min,
            vertex.ray.t_max
        ));
        lines.extend(surface_lines(prepared, vertex));
        lines.extend(vertex.lights.iter().map(light_line));
    }
    lines.join("\n")
}

fn surface_lines(prepared: &Prepared, vertex: &VertexRecord) -> Vec<String> {
    let Some(at) = &vertex.surface else { return vec!["  meets     nothing: black".to_owned()] };
    let scene = &prepared.plan.scene;
    let material = &scene.materials()[at.material as usize];
    let name = if material.name.is_empty() { "default" } else { &material.name };
    vec![
        format!(
            "  meets     shape {} at t = {}, from the {}",
            scene.shape_name(at.shape),
            at.t,
            side(at.outside())
        ),
        format!(
            "  point     {} ± {:.1e}, uv ({}, {})",
            point(at.p),
            at.p_error.max_element(),
            at.uv.x,
            at.uv.y
        ),
        format!("  normal    {} shading {}", point(at.ng), point(at.ns)),
        format!("  material  {name} ({})", material.value.type_name()),
    ]
}

fn light_line(light: &LightRecord) -> String {
    match light.shadow_rays {
        0 => format!("  adds      {}", color(light.added)),
        n => format!(
            "  adds      {} = {} of {n} shadow rays free × {}",
            color(light.added),
            light.visible,
            color(light.unoccluded)
        ),
    }
}

fn side(outside: bool) -> &'static str {
    if outside { "outside" } else { "inside" }
}

fn point(v: Vec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

fn color(s: Spectrum) -> String {
    let [r, g, b] = s.to_rgb();
    format!("[{r}, {g}, {b}]")
}

fn to_json(args: &TraceArgs, prepared: &Prepared, path: &PathRecord) -> Value {
    let scene = &prepared.plan.scene;
    let light = |l: &LightRecord| {
        json!({
            "unoccluded": l.unoccluded.to_rgb(),
            "shadow_rays": l.shadow_rays,
            "visible": l.visible,
            "added": l.added.to_rgb(),
        })
    };
    let vertex = |(index, v): (usize, &VertexRecord)| {
        let surface = v.surface.as_ref().map(|at| {
            let material = &scene.materials()[at.material as usize];
            json!({
                "shape": scene.shape_name(at.shape),
                "material": material.name,
                "material_type": material.value.type_name(),
                "t": at.t,
                "point": at.p.to_array(),
                "point_error": at.p_error.to_array(),
                "geometric_normal": at.ng.to_array(),
                "shading_normal": at.ns.to_array(),
                "uv": at.uv.to_array(),
                "outside": at.outside(),
            })
        });
        json!({
            "parent": parent(path, index),
            "origin": v.place.origin,
            "depth": v.place.depth,
            "node": v.place.node,
            "weight": v.place.weight.to_rgb(),
            "ray": {
                "origin": v.ray.origin.to_array(),
                "direction": v.ray.dir.to_array(),
                "t_min": v.ray.t_min,
                "t_max": if v.ray.t_max.is_finite() { json!(v.ray.t_max) } else { Value::Null },
            },
            "surface": surface,
            "lights": v.lights.iter().map(light).collect::<Vec<_>>(),
        })
    };
    json!({
        "scene": args.scene.scene,
        "pixel": args.pixel,
        "sample": args.sample,
        "radiance": path.radiance.to_rgb(),
        "rays": path.rays,
        "vertices": path.vertices.iter().enumerate().map(vertex).collect::<Vec<_>>(),
    })
}
