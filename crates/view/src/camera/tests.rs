//! Tests of the window's camera.

use super::*;
use penombre_math::Vec3;

const COURSE: LookAt = LookAt {
    position: DVec3::new(0.0, 0.0, 6.1),
    target: DVec3::ZERO,
    up: DVec3::Y,
    lens: Lens::Perspective { fov: 45.0 },
    near: 4.1,
    far: 10000.0,
};

const BOX: Bounds3 = Bounds3 { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
const WINDOW: Vec2 = Vec2::new(480.0, 480.0);

fn course() -> CourseCamera {
    CourseCamera::of_look_at(&COURSE, &BOX)
}

fn general() -> LookAt {
    LookAt {
        position: DVec3::new(3.0, -1.0, 20.0),
        target: DVec3::new(1.0, 0.5, -0.5),
        up: DVec3::new(0.1, 0.9, 0.2),
        lens: Lens::Perspective { fov: 30.0 },
        near: 0.0,
        far: f64::INFINITY,
    }
}

fn times(m: &[[f32; 4]; 4], v: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|row| (0..4).map(|c| f64::from(m[c][row]) * v[c]).sum())
}

fn project(camera: &CourseCamera, p: DVec3) -> [f64; 4] {
    let eye = times(&camera.view_matrix(), [p.x, p.y, p.z, 1.0]);
    times(&camera.projection_matrix(1.0), eye)
}

fn near_to(a: DVec3, b: DVec3, tolerance: f64) -> bool {
    (a - b).length() <= tolerance
}

#[test]
fn the_start_has_the_numbers_of_the_course() {
    let camera = course();
    assert_eq!((camera.zoom(), camera.pan()), (3.0, DVec3::new(0.0, 0.0, -3.1)));
    assert_eq!((camera.distance(), camera.scale()), (6.1, 1.0));
    assert_eq!(camera.rotation(), DMat3::IDENTITY);
    let look = camera.look_at();
    assert_eq!((look.position, look.target, look.up), (COURSE.position, COURSE.target, COURSE.up));
    let identity: [[f32; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, -6.1, 1.0]];
    assert_eq!(camera.view_matrix(), identity);
}

/// The half-extents of the view at z = 2, 0, −2 that the course's camera has, through the matrices.
#[test]
fn the_matrices_see_the_extents_of_the_course() {
    for (z, extent) in [(2.0, 1.6983), (0.0, 2.5267), (-2.0, 3.3551)] {
        let [x, y, _, w] = project(&course(), DVec3::new(extent, -extent, z));
        assert!((x / w - 1.0).abs() < 1e-4 && (y / w + 1.0).abs() < 1e-4, "{x} {y} {w}");
    }
}

#[test]
fn depth_runs_from_0_at_the_near_plane_to_1_at_the_far_plane() {
    let depth = |camera: &CourseCamera, depth: f64| {
        let [_, _, z, w] = project(camera, DVec3::new(0.5, 0.5, 6.1 - depth));
        z / w
    };
    // The front wall at z = 2 lies in the near plane: out of sight, but only just.
    assert!(depth(&course(), 4.1) < 0.0);
    assert!(depth(&course(), 4.1 * 1.0001) > 0.0);
    assert!((depth(&course(), 10000.0) - 1.0).abs() < 1e-4);
    let endless = CourseCamera::of_look_at(&LookAt { near: 0.0, far: f64::INFINITY, ..COURSE }, &BOX);
    assert!(depth(&endless, 1e7) < 1.0001 && depth(&endless, 1e7) > 0.999);
    assert!(depth(&endless, 0.01) > 0.0);
    let flat = LookAt { lens: Lens::Orthographic { height: 4.0 }, ..COURSE };
    let flat = CourseCamera::of_look_at(&flat, &BOX);
    assert!((depth(&flat, 10000.0) - 1.0).abs() < 1e-4 && depth(&flat, 4.1).abs() < 1e-4);
    let [x, y, _, w] = project(&flat, DVec3::new(2.0, -2.0, 0.0));
    assert_eq!((x, y, w), (1.0, -1.0, 1.0));
}

/// The view matrix against an independent look-at: coordinates along right, up and back from the eye.
#[test]
fn the_view_matrix_is_the_look_at_of_its_own_description() {
    let mut camera = CourseCamera::of_look_at(&general(), &BOX);
    for step in 0..20 {
        let (from, to) = (Vec2::new(200.0, 130.0 + step as f32), Vec2::new(240.0 + step as f32, 100.0));
        camera.drag([Button::Left, Button::Right, Button::Middle][step % 3], from, to, WINDOW);
        let look = camera.look_at();
        let forward = (look.target - look.position).normalize();
        let right = forward.cross(look.up).normalize();
        let up = right.cross(forward);
        for p in [DVec3::ZERO, DVec3::new(1.0, 2.0, -3.0), DVec3::new(-4.0, 0.5, 1.0)] {
            let from_eye = p - look.position;
            let expected = DVec3::new(from_eye.dot(right), from_eye.dot(up), -from_eye.dot(forward));
            let found = times(&camera.view_matrix(), [p.x, p.y, p.z, 1.0]);
            assert!(near_to(expected, DVec3::new(found[0], found[1], found[2]), 1e-5), "{found:?}");
        }
    }
}

#[test]
fn any_scene_starts_in_its_own_view() {
    let camera = CourseCamera::of_look_at(&general(), &BOX);
    let look = camera.look_at();
    assert!(near_to(look.position, general().position, 1e-12));
    assert!(near_to(look.target, general().target, 1e-12));
    assert_eq!((camera.zoom(), camera.pan().z), (3.0, -3.1));
    // A target that only gives a direction: the pivot lies in the scene all the same.
    let mut far_target = general();
    far_target.target = far_target.position + (far_target.target - far_target.position) * 100.0;
    let camera = CourseCamera::of_look_at(&far_target, &BOX);
    assert!((camera.distance() - 20.6).abs() < 0.5, "{}", camera.distance());
    // Starting again from the description of a view gives the view.
    let again = CourseCamera::of_look_at(&camera.look_at(), &BOX);
    assert!(near_to(again.look_at().position, camera.look_at().position, 1e-9));
}

#[test]
fn pan_and_zoom_are_always_by_480() {
    for window in [Vec2::new(480.0, 480.0), Vec2::new(1280.0, 720.0), Vec2::new(1.0, 1.0)] {
        let mut camera = course();
        camera.drag(Button::Right, Vec2::new(10.0, 20.0), Vec2::new(58.0, 68.0), window);
        camera.drag(Button::Middle, Vec2::new(0.0, 0.0), Vec2::new(99.0, 240.0), window);
        assert!(near_to(camera.pan(), DVec3::new(0.1, -0.1, -3.1), 1e-12));
        assert!((camera.zoom() - 3.5).abs() < 1e-12, "down is away");
        let look = camera.look_at();
        assert!(near_to(look.position, DVec3::new(-0.1, 0.1, 6.6), 1e-12), "{look:?}");
    }
}

#[test]
fn the_wheel_halves_and_doubles_and_never_arrives() {
    let mut camera = course();
    camera.wheel(1.0);
    assert!(camera.distance() < 6.1 && camera.distance() > 5.0);
    camera.wheel(-1.0);
    assert!((camera.distance() - 6.1).abs() < 1e-5);
    camera.wheel(1e30);
    camera.wheel(f32::NAN);
    assert!(camera.distance() > 0.0);
}

/// A list of drags gives the rotation that the formulas of the course give, computed here on their own: in double
/// precision, with rotation matrices (Rodrigues) instead of quaternions.
#[test]
fn a_list_of_drags_turns_as_the_course_does() {
    let window = Vec2::new(640.0, 480.0);
    let points =
        [(320.0, 240.0), (400.0, 250.0), (430.0, 100.0), (5.0, 470.0), (-40.0, 30.0), (300.0, 300.0)];
    let lift = |(px, py): (f64, f64)| {
        let (x, y) = ((2.0 * px - 640.0) / 640.0, (480.0 - 2.0 * py) / 480.0);
        let d = (x * x + y * y).sqrt();
        let inside = d < 0.8 / 2f64.sqrt();
        DVec3::new(x, y, if inside { (0.64 - d * d).sqrt() } else { 0.32 / d })
    };
    let mut expected = DMat3::IDENTITY;
    let mut camera = course();
    for pair in points.windows(2) {
        let (a, b) = (lift(pair[0]), lift(pair[1]));
        let angle = 2.0 * ((b - a).length() / 1.6).clamp(-1.0, 1.0).asin();
        // The scene's front follows the mouse: about a × b.
        let n = a.cross(b).normalize();
        let cross = DMat3::from_cols(DVec3::X.cross(n), DVec3::Y.cross(n), DVec3::Z.cross(n)) * -1.0;
        let turn = DMat3::IDENTITY + cross * angle.sin() + cross * cross * (1.0 - angle.cos());
        expected = turn * expected;
        let pixel = |p: (f64, f64)| Vec2::new(p.0 as f32, p.1 as f32);
        camera.drag(Button::Left, pixel(pair[0]), pixel(pair[1]), window);
    }
    let difference = (camera.rotation() - expected).to_cols_array();
    assert!(difference.iter().all(|v| v.abs() < 1e-5), "{difference:?}");
    // About the world's origin: its depth has not changed.
    let origin = times(&camera.view_matrix(), [0.0, 0.0, 0.0, 1.0]);
    assert!((origin[2] + 6.1).abs() < 1e-6 && origin[0].abs() < 1e-6);
}

#[test]
fn framing_shows_all_of_the_box_and_fills_the_picture() {
    let bounds = Bounds3 { min: Vec3::new(3.0, 4.0, 5.0), max: Vec3::new(5.0, 8.0, 6.0) };
    for (lens, aspect) in [
        (Lens::Perspective { fov: 45.0 }, 1.0),
        (Lens::Perspective { fov: 20.0 }, 0.5),
        (Lens::Orthographic { height: 0.1 }, 0.7),
    ] {
        let mut camera = CourseCamera::of_look_at(&LookAt { lens, near: 0.1, ..general() }, &BOX);
        let direction = camera.look_at().target - camera.look_at().position;
        camera.frame(&bounds, aspect);
        let after = camera.look_at().target - camera.look_at().position;
        assert!(near_to(direction.normalize(), after.normalize(), 1e-9));
        let mut largest: f64 = 0.0;
        for corner in bounds.corners() {
            let p = corner.as_dvec3();
            let eye = times(&camera.view_matrix(), [p.x, p.y, p.z, 1.0]);
            let [x, y, z, w] = times(&camera.projection_matrix(aspect), eye);
            largest = largest.max((x / w).abs()).max((y / w).abs());
            assert!(z > 0.0);
        }
        assert!(largest < 1.0 && largest > 0.4, "{largest}");
    }
    let mut camera = course();
    camera.frame(&Bounds3::EMPTY, 1.0);
    assert_eq!(camera, course());
}

#[test]
fn axis_views_look_along_their_axis() {
    for (view, back, up) in [
        (AxisView::Front, DVec3::Z, DVec3::Y),
        (AxisView::Right, DVec3::X, DVec3::Y),
        (AxisView::Top, DVec3::Y, DVec3::NEG_Z),
    ] {
        let mut camera = course();
        camera.drag(Button::Left, Vec2::new(100.0, 200.0), Vec2::new(300.0, 150.0), WINDOW);
        camera.drag(Button::Right, Vec2::new(100.0, 200.0), Vec2::new(300.0, 150.0), WINDOW);
        camera.look_along(view);
        let look = camera.look_at();
        assert!(near_to(look.position, back * 6.1, 1e-9) && near_to(look.up, up, 1e-12), "{look:?}");
        assert!(camera.rotation().determinant() > 0.99);
    }
}
