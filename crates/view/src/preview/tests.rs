//! Tests of the preview's buffers.

use super::*;
use penombre::Plan;
use penombre_scene::{Assets, Diagnostics, Node, Role, SceneDescription, Value};
use std::sync::Arc;

fn scene(description: &SceneDescription) -> Arc<Scene> {
    let mut out = Diagnostics::default();
    let plan = Plan::new(description, &Assets::default(), &mut out);
    plan.unwrap_or_else(|| panic!("{out:?}")).scene
}

fn builtin(name: &str) -> SceneDescription {
    penombre_scene::builtin::builtin(name).unwrap()
}

/// A ball and many more of it.
fn balls(count: i64) -> SceneDescription {
    let mut d = builtin("sphere");
    let places: Vec<Value> =
        (0..count).map(|i| vec![Value::from([("translate", Value::from([3 * i, 0, 0]))])].into()).collect();
    d.add(Node::new(Role::Instance, "instance", "more").with("of", "sphere").with("transforms", places));
    d
}

#[test]
fn every_shape_is_there_and_groups_cover_all_triangles_once() {
    let scene = scene(&builtin("cornell"));
    let mesh = PreviewMesh::new(&scene, &Limits::default());
    assert_eq!(mesh.note, None);
    assert_eq!(mesh.objects.len(), mesh.triangles());
    assert_eq!(mesh.indices.len(), 3 * mesh.triangles());
    let mut covered = 0;
    for group in &mesh.groups {
        assert_eq!(group.indices.start, covered);
        covered = group.indices.end;
        for triangle in (group.indices.start / 3)..(group.indices.end / 3) {
            let shape = mesh.objects[triangle as usize];
            assert_eq!(scene.shape_materials(shape), [group.material]);
        }
    }
    assert_eq!(covered as usize, mesh.indices.len());
    for shape in 0..scene.shapes() as u32 {
        let expected = scene.tessellate(shape, &Detail::FULL).triangles.len();
        assert_eq!(mesh.objects.iter().filter(|o| **o == shape).count(), expected);
    }
    assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
    let normal = |v: &Vertex| Vec3::from(v.normal).length();
    assert!(mesh.vertices.iter().all(|v| (normal(v) - 1.0).abs() < 1e-4));
    assert_eq!(mesh.lights, [PreviewLight { center: [0.0, 1.5, 0.0], color: [1.0; 3] }]);
    let red = scene.materials().iter().position(|m| m.name == "red").unwrap();
    let (m, c) = (&mesh.materials[red], [1.0, 0.0, 0.0]);
    assert_eq!((m.diffuse, m.specular, m.shininess, &m.texture), (c, c, 16.0, &None));
}

#[test]
fn bytes_are_the_numbers_without_gaps() {
    let mesh = PreviewMesh::new(&scene(&builtin("square")), &Limits::default());
    assert_eq!(size_of::<Vertex>(), Vertex::STRIDE);
    let bytes = mesh.vertex_bytes();
    assert_eq!(bytes.len(), mesh.vertices.len() * Vertex::STRIDE);
    let number = |i: usize| f32::from_le_bytes(std::array::from_fn(|k| bytes[i * 4 + k]));
    let second = &mesh.vertices[1];
    assert_eq!(
        (number(12), number(17), number(18), number(23)),
        (second.position[0], second.normal[2], second.uv[0], 1.0)
    );
    assert_eq!(mesh.index_bytes().len(), mesh.indices.len() * 4);
}

#[test]
fn edges_are_those_of_the_triangles_once() {
    let mesh = PreviewMesh {
        indices: vec![0, 1, 2, 0, 2, 3, 2, 1, 0],
        groups: vec![Group { material: 5, indices: 0..6 }, Group { material: 7, indices: 6..9 }],
        ..PreviewMesh::default()
    };
    let edges = mesh.edges();
    assert_eq!(edges.indices, [0, 1, 0, 2, 0, 3, 1, 2, 2, 3, 0, 1, 0, 2, 1, 2]);
    let groups = [Group { material: 5, indices: 0..10 }, Group { material: 7, indices: 10..16 }];
    assert_eq!(edges.groups, groups);
    // A closed grid (Euler): the sphere's tessellation has as many edges as faces and vertices say, minus 1 for its
    // seam and poles, which are open.
    let sphere = PreviewMesh::new(&scene(&builtin("sphere")), &Limits::default());
    assert_eq!(sphere.edges().indices.len() / 2 + 1, sphere.triangles() + sphere.vertices.len());
}

#[test]
fn textures_are_baked_as_rays_see_them() {
    let mut d = builtin("square");
    let checks =
        Node::new(Role::Texture, "checker", "checks").with("scale", [4, 2]).with("b", [3.0, 0.0, 0.5]);
    d.add(checks);
    let id = d.of_role(Role::Material).next().unwrap().0;
    d.node_mut(id).set("diffuse", Value::from([("texture", "checks".into())]));
    let scene = scene(&d);
    let mesh = PreviewMesh::new(&scene, &Limits::default());
    let material = &mesh.materials[0];
    let texture = material.texture.as_ref().unwrap();
    assert_eq!((texture.edge, texture.rgba.len()), (512, 512 * 512 * 4));
    // Brighter than 1: the factor takes it.
    assert_eq!(material.diffuse, [3.0; 3]);
    for (u, v) in [(0.1, 0.1), (0.3, 0.1), (0.9, 0.7), (0.6, 0.3), (0.1, 0.9)] {
        let expected = scene.material_view(0, Vec2::new(u, v)).diffuse.to_rgb();
        let texel = ((v * 512.0) as usize * 512 + (u * 512.0) as usize) * 4;
        for (channel, expected) in expected.into_iter().enumerate() {
            let code = texture.rgba[texel + channel];
            let found = penombre_math::color::srgb_decode_u8(code) * material.diffuse[channel];
            assert!((found - expected).abs() < 0.02, "{u} {v}");
        }
    }
    // Many textures share the memory.
    let small = PreviewMesh::new(&scene, &Limits { texture_bytes: 20_000, ..Limits::default() });
    assert_eq!(small.materials[0].texture.as_ref().unwrap().edge, 64);
}

#[test]
fn instances_stand_where_the_scene_has_them() {
    let scene = scene(&balls(3));
    let mesh = PreviewMesh::new(&scene, &Limits::default());
    let (found, expected) = (mesh.bounds(), scene.bounds());
    assert!((found.min - expected.min).length() < 1e-3 && (found.max - expected.max).length() < 1e-3);
    assert_eq!(mesh.triangles(), 4 * scene.tessellate(0, &Detail::FULL).triangles.len());
}

#[test]
fn memory_is_bounded_and_what_is_missing_is_said() {
    let scene = scene(&balls(1000));
    let within = |limits: &Limits| {
        let mesh = PreviewMesh::new(&scene, limits);
        assert!(mesh.triangles() <= limits.triangles && mesh.vertices.len() <= limits.vertices);
        mesh
    };
    // Room for all balls if they are coarse.
    let mesh = within(&Limits { triangles: 200_000, ..Limits::default() });
    assert!(mesh.triangles() > 50_000 && mesh.note.is_none());
    // Room for some balls, as coarse as they get; the others are boxes at the right places.
    let mesh = within(&Limits { triangles: 15_000, ..Limits::default() });
    assert!(mesh.triangles() > 12_000);
    assert!((mesh.bounds().max - scene.bounds().max).length() < 1e-3);
    let note = mesh.note.unwrap();
    assert!(
        note.contains("1001 objects") && note.contains("as boxes") && !note.contains("not at all"),
        "{note}"
    );
    // Not even room for one ball: a part of its triangles, some boxes, and the rest is left out.
    let limits = Limits { triangles: 15, vertices: 100, ..Limits::default() };
    let mesh = within(&limits);
    assert!(mesh.triangles() > 4);
    let note = mesh.note.unwrap();
    assert!(note.contains("1 with a part") && note.contains("not at all"), "{note}");
    // Nothing at all is a picture too.
    let mesh = within(&Limits { triangles: 0, vertices: 0, curved: 0, texture_bytes: 0 });
    assert!(mesh.triangles() == 0 && mesh.note.unwrap().contains("1001 not at all"));
}
