//! Meshes whose vertices and faces stand in the scene file.

use crate::registry::Context;
use penombre_scene::TriangleMesh;
use penombre_scene::params::Params;

/// Reads `positions`, `faces` and the attributes. Reports attributes of the wrong length and indices beyond
/// the vertices; polygons are cut into fans.
pub fn read(p: &Params, context: &mut Context<'_, '_>) -> Option<TriangleMesh> {
    let path = context.description.node(context.node).path();
    let mut mesh = TriangleMesh { positions: p.vec3_list("positions"), ..TriangleMesh::default() };
    let count = mesh.positions.len();
    let mut sound = true;
    for polygon in p.faces("faces") {
        if let Some(beyond) = polygon.iter().find(|i| **i as usize >= count) {
            let message =
                format!("`{path}` has vertex index {beyond} in `faces`, expected 0 to {}", count.max(1) - 1);
            let fault = context.out.error("scene::index", p.span("faces"), message);
            fault.help = format!("`positions` has {count} vertices, counted from 0");
            sound = false;
            break;
        }
        mesh.indices.extend((2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]));
    }
    mesh.normals = p.vec3_list("normals").into_iter().map(|n| n.normalize_or_zero()).collect();
    mesh.uvs = p.vec2_list("uvs");
    mesh.colors = p.color_list("colors");
    let lengths = [("normals", mesh.normals.len()), ("uvs", mesh.uvs.len()), ("colors", mesh.colors.len())];
    for (name, length) in lengths {
        if length != 0 && length != count {
            let message = format!("`{path}` has {length} {name} for {count} positions, expected as many");
            context.out.error("scene::length", p.span(name), message).help =
                "give one for each vertex, or leave them out".to_owned();
            sound = false;
        }
    }
    sound.then_some(mesh)
}
