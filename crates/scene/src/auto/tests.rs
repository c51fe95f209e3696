use super::*;
use crate::description::ValueKind;
use crate::diagnostic::Diagnostics;
use crate::readers::Folders;
use crate::span::Sources;

fn floats(node: &Node, name: &str) -> Vec<f64> {
    fn collect(value: &Value, into: &mut Vec<f64>) {
        match &value.kind {
            ValueKind::Float(v) => into.push(*v),
            ValueKind::Array(list) => list.iter().for_each(|v| collect(v, into)),
            other => panic!("{other:?}"),
        }
    }
    let mut found = Vec::new();
    collect(&node.param(name).expect("given").value, &mut found);
    found
}

fn point(node: &Node, name: &str) -> DVec3 {
    DVec3::from_slice(&floats(node, name))
}

/// Largest |x| and |y| of points on the screen of a camera, as parts of its half width and half height.
fn extent(camera: &Node, points: &[DVec3], aspect: f64) -> [f64; 2] {
    let eye = point(camera, "position");
    let forward = (point(camera, "target") - eye).normalize();
    let right = forward.cross(point(camera, "up")).normalize();
    let up = right.cross(forward);
    let tall = tan_degrees(floats(camera, "fov")[0] * 0.5);
    let mut most = [0.0f64; 2];
    for p in points {
        let d = *p - eye;
        let depth = d.dot(forward);
        assert!(depth > 0.0, "behind the camera");
        most[0] = most[0].max((d.dot(right) / depth / tall / aspect).abs());
        most[1] = most[1].max((d.dot(up) / depth / tall).abs());
    }
    most
}

/// Loads and completes an OFF file.
fn bare(text: &str) -> (SceneDescription, Diagnostics) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("m.off"), text).expect("written");
    let folders = Folders { root: folder.path().to_owned(), asset_roots: Vec::new() };
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let mut scene = bare_mesh("m.off");
    let assets = Assets::load(&mut scene, &folders, &mut sources, &mut out);
    complete(&mut scene, &assets).expect("near");
    (scene, out)
}

fn find<'a>(scene: &'a SceneDescription, role: Role, name: &str) -> &'a Node {
    scene.node(scene.find(role, name).unwrap_or_else(|| panic!("no {name}")))
}

/// A tetrahedron, scaled and moved.
fn tetrahedron(scale: f64, offset: f64) -> Vec<DVec3> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    corners.iter().map(|c| DVec3::from_array(*c) * scale + DVec3::new(offset, -offset, offset)).collect()
}

fn off(points: &[DVec3], faces: &[&str]) -> String {
    let mut text = format!("OFF\n{} {} 0\n", points.len(), faces.len());
    points.iter().for_each(|p| text += &format!("{} {} {}\n", p.x, p.y, p.z));
    faces.iter().for_each(|f| text += &format!("{f}\n"));
    text
}

#[test]
fn the_mesh_fills_the_picture_but_for_the_margin() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1000.0), (1e-3, -5.0)] {
        let points = tetrahedron(scale, offset);
        let (scene, out) = bare(&off(&points, &["3 0 1 2", "3 0 1 3", "3 0 2 3"]));
        assert!(out.is_empty());
        let camera = find(&scene, Role::Camera, "auto");
        let rounded: Vec<DVec3> = points.iter().map(|p| p.as_vec3().as_dvec3()).collect();
        let [x, y] = extent(camera, &rounded, 640.0 / 480.0);
        let filled = x.max(y);
        assert!((filled - 0.84).abs() < 1e-6, "{scale} {offset}: {x} {y}");
    }
}

#[test]
fn the_ground_lies_just_below_and_fills_the_picture() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 3.0), (1e6, 0.0), (0.01, 1000.0)] {
        let points = tetrahedron(scale, offset);
        let (scene, _) = bare(&off(&points, &["3 0 1 2", "3 0 1 3"]));
        let ground = find(&scene, Role::Shape, "ground");
        let (origin, sides) = (point(ground, "origin"), floats(ground, "sides"));
        let (a, b) = (DVec3::from_slice(&sides[..3]), DVec3::from_slice(&sides[3..]));
        assert!(a.cross(b).normalize().abs_diff_eq(DVec3::Y, 1e-12));
        let lowest = points.iter().map(|p| p.y as f32).fold(f32::INFINITY, f32::min);
        assert!((origin.y as f32) < lowest, "the gap survives rounding");
        assert!(f64::from(lowest) - origin.y < 0.01 * scale + 2e-6 * offset.abs());
        let camera = find(&scene, Role::Camera, "auto");
        let eye = point(camera, "position");
        let forward = (point(camera, "target") - eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let tall = tan_degrees(FOV * 0.5);
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let ray = forward + right * (x * tall * 4.0 / 3.0) + up * (y * tall);
            let hit = eye + ray * ((origin.y - eye.y) / ray.y) - origin;
            assert!(ray.y < 0.0 && hit.x > 0.0 && hit.x < b.x && hit.z > 0.0 && hit.z < a.z, "{x} {y} {hit}");
        }
    }
}

#[test]
fn lights_face_the_mesh_and_do_not_overexpose() {
    let points = tetrahedron(2.0, 10.0);
    let (scene, _) = bare(&off(&points, &["3 0 1 2", "3 0 1 3"]));
    let center = DVec3::new(11.0, -8.0, 13.0);
    let camera = find(&scene, Role::Camera, "auto");
    let right = (point(camera, "target") - point(camera, "position")).cross(DVec3::Y).normalize();
    let (mut total, mut physical) = (DVec3::ZERO, 0.0);
    for (name, side) in [("key", -1.0), ("fill", 1.0)] {
        let light = find(&scene, Role::Light, name);
        let sides = floats(light, "sides");
        let (a, b) = (DVec3::from_slice(&sides[..3]), DVec3::from_slice(&sides[3..]));
        let middle = point(light, "origin") + (a + b) * 0.5;
        assert!(a.cross(b).normalize().dot((center - middle).normalize()) > 0.99);
        assert!((middle - center).y > 0.0 && (middle - center).dot(right) * side > 0.0);
        total += (middle - center).normalize() * floats(light, "color")[0];
        // Radiance of a white surface that faces it, far off compared with its size.
        let solid_angle = a.cross(b).length() / (middle - center).length_squared();
        physical += floats(light, "radiance")[0] * solid_angle / std::f64::consts::PI;
    }
    // The sky is bright enough to be seen in, and less than the lamps.
    assert!((0.05..0.2).contains(&floats(find(&scene, Role::Light, "sky"), "radiance")[0]));
    // The brightest that a white surface can be, turned the best way.
    let brightest = total.length() + floats(find(&scene, Role::Integrator, "classic"), "ambient")[0];
    assert!((0.9..1.05).contains(&brightest), "{brightest}");
    assert!((0.4..0.8).contains(&physical), "{physical}");
}

#[test]
fn flat_and_degenerate_meshes_are_in_view() {
    let cases: [&[[f64; 3]]; 5] = [
        &[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0]],
        &[[-1.0, 5.0, -1.0], [1.0, 5.0, -1.0], [1.0, 5.0, 1.0]],
        &[[2.0, 2.0, 2.0]; 3],
        &[[0.0, 0.0, 0.0]; 3],
        // Seen end-on: all points on one line through the camera.
        &[[0.0, 0.0, 0.0], [0.55, 0.45, 1.0], [1.1, 0.9, 2.0]],
    ];
    for corners in cases {
        let points: Vec<DVec3> = corners.iter().map(|c| DVec3::from_array(*c)).collect();
        let (scene, _) = bare(&off(&points, &["3 0 1 2"]));
        let [x, y] = extent(find(&scene, Role::Camera, "auto"), &points, 4.0 / 3.0);
        assert!(x.max(y) < 0.841, "{corners:?}: {x} {y}");
    }
}

#[test]
fn an_empty_mesh_gives_the_background_of_others_and_a_warning() {
    let cube: Vec<DVec3> = CUBE.corners().iter().map(|c| c.as_dvec3()).collect();
    let (other, _) = bare(&off(&cube, &["4 0 1 2 3", "4 4 5 6 7"]));
    for text in ["OFF\n0 0 0\n", "OFF\n1 0 0\n7 7 7\n"] {
        let (scene, out) = bare(text);
        assert!(!out.has_errors() && out.iter().any(|d| d.code == "mesh::empty"));
        assert_eq!(scene, other);
    }
}

#[test]
fn a_mesh_beyond_single_precision_is_told_by_its_box() {
    let huge = Bounds3 { min: Vec3::new(-3e38, 0.0, 0.0), max: Vec3::new(3e38, 1.0, 1.0) };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let corners = [[-3e38, 0.0, 0.0], [3e38, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let text = off(&corners.map(DVec3::from_array), &["3 0 1 2"]);
    std::fs::write(folder.path().join("m.off"), text).expect("written");
    let folders = Folders { root: folder.path().to_owned(), asset_roots: Vec::new() };
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let mut scene = bare_mesh("m.off");
    let assets = Assets::load(&mut scene, &folders, &mut sources, &mut out);
    let before = scene.clone();
    assert_eq!(complete(&mut scene, &assets), Err(huge));
    assert_eq!(scene, before);
    assert!(!is_in_range(&camera_for(&huge, 1.0)));
    assert!(is_in_range(&camera_for(&CUBE, 1.0)));
}

#[test]
fn camera_for_sees_the_whole_box() {
    for aspect in [0.5f32, 1.0, 2.0] {
        let bounds = Bounds3 { min: Vec3::new(-3.0, 1.0, 0.0), max: Vec3::new(1.0, 2.0, 7.0) };
        let corners = bounds.corners().map(|c| c.as_dvec3());
        let [x, y] = extent(&camera_for(&bounds, aspect), &corners, f64::from(aspect));
        assert!((x.max(y) - 0.84).abs() < 1e-6, "{aspect}: {x} {y}");
    }
    let empty = camera_for(&Bounds3::EMPTY, 1.0);
    let [x, y] = extent(&empty, &[DVec3::ONE, -DVec3::ONE], 1.0);
    assert!(x.max(y) < 0.85);
}
