//! Tests of meshes: normals, interpolation, transforms.

use super::*;

fn square() -> TriangleMesh {
    TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        colors: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        ..TriangleMesh::default()
    }
}

fn point(mesh: &Mesh, prim: u32, u: f32, v: f32) -> ShapePoint {
    let ray = Ray::new(Vec3::Z, -Vec3::Z, 0.0, 10.0);
    mesh.point(&ray, &Hit { t: 1.0, u, v, geometry: 0, prim, instance: Hit::NO_INSTANCE })
}

#[test]
fn attributes_are_interpolated() {
    let mesh = Mesh::place(&square(), &DAffine3::IDENTITY, 180.0).unwrap();
    let at = point(&mesh, 0, 0.25, 0.5);
    assert_eq!(at.p, Vec3::new(0.75, 0.5, 0.0));
    assert_eq!(at.color.to_rgb(), [0.25, 0.25, 0.5]);
    assert_eq!(at.uv, Vec2::new(0.75, 0.5));
    assert_eq!(at.ns, Vec3::Z);
    assert!(at.p_error.max_element() < 1e-5);
}

#[test]
fn mirroring_turns_the_winding_and_keeps_the_outside() {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mesh = Mesh::place(&square(), &mirror, 180.0).unwrap();
    let at = point(&mesh, 0, 0.25, 0.5);
    assert_eq!(at.ng, Vec3::Z);
    assert!(at.p.x < 0.0);
}

/// Two faces of a roof that meet at 90 degrees along the y axis.
fn roof() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let positions = vec![Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 0.0, -1.0), Vec3::new(-1.0, 0.0, -1.0)];
    (positions, vec![[0, 2, 1], [0, 1, 3]])
}

#[test]
fn creases_stay_sharp_only_beyond_the_angle() {
    let (positions, indices) = roof();
    let ridge = |angle: f32| {
        let normals = normals::smooth(&positions, &indices, angle);
        normals.corners(0, &indices).unwrap()[0]
    };
    let s = 0.5f32.sqrt();
    assert!(ridge(180.0).distance(Vec3::Z) < 1e-6);
    assert!(ridge(100.0).distance(Vec3::Z) < 1e-6);
    assert!(ridge(80.0).distance(Vec3::new(s, 0.0, s)) < 1e-6);
    assert!(normals::smooth(&positions, &indices, 0.0).values.is_empty());
}

#[test]
fn a_fan_of_many_faces_takes_linear_time_and_keeps_its_normal() {
    let n = 100_000u32;
    let mut positions = vec![Vec3::ZERO];
    positions.extend((0..=n).map(|i| {
        let (s, c) = penombre_math::float::sin_cos(i as f32 / n as f32);
        Vec3::new(c, s, 0.01 * s)
    }));
    let indices: Vec<[u32; 3]> = (1..=n).map(|i| [0, i, i + 1]).collect();
    let normals = normals::smooth(&positions, &indices, 30.0);
    let hub = normals.corners(77, &indices).unwrap()[0];
    assert!(hub.z > 0.99 && (hub.length() - 1.0).abs() < 1e-5);
}

#[test]
fn faces_without_area_count_for_nothing() {
    let mut mesh = square();
    mesh.indices.push([0, 0, 1]);
    let mesh = Mesh::place(&mesh, &DAffine3::IDENTITY, 180.0).unwrap();
    assert_eq!(point(&mesh, 0, 0.2, 0.2).ns, Vec3::Z);
    assert!(point(&mesh, 2, 0.2, 0.2).ns.is_finite());
}
