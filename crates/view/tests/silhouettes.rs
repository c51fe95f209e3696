//! The raster preview and the ray tracer see the same outlines.
//!
//! For each scene and camera the preview's triangles are drawn by the software rasteriser and by the graphics card
//! (each object in a colour of its own), and the ray tracer asks one ray through the middle of each pixel which object
//! it meets. Every pixel at an outline of the one must lie within 1.5 pixels of an outline of the other.

mod common;

use penombre::Plan;
use penombre_math::Vec2;
use penombre_view::camera::{AxisView, Button, CourseCamera};
use penombre_view::preview::{Limits, PreviewMesh};
use penombre_view::raster::{Frame, NOTHING};
use penombre_view::session::{Session, Setup, Source};
use penombre_view::window::gpu::{Gpu, GpuMesh, Look, Target};

const SIZE: [u32; 2] = [240, 180];
/// Largest distance between outlines, pixels.
const TOLERANCE: f64 = 1.5;

/// What the ray tracer meets at the middle of each pixel.
fn traced(plan: &Plan) -> Vec<u32> {
    let [w, h] = SIZE.map(|v| v as f32);
    let camera = &plan.scene.cameras()[plan.job.camera as usize].value;
    let object = |x: u32, y: u32| {
        let (u, v) = ((x as f32 + 0.5) / w, (y as f32 + 0.5) / h);
        let ray = camera
            .ray(Vec2::new((2.0 * u - 1.0) * (w / h), 1.0 - 2.0 * v))
            .expect("these cameras see everywhere")
            .ray;
        plan.scene.surface(&ray, &plan.scene.closest(&ray)).map_or(NOTHING, |at| at.shape)
    };
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).map(|(x, y)| object(x, y)).collect()
}

/// A preview in which every object has a colour of its own: its number in the red and green bytes, plus one.
fn numbered(mesh: &PreviewMesh) -> PreviewMesh {
    let mut mesh = mesh.clone();
    for (triangle, object) in mesh.indices.chunks_exact(3).zip(&mesh.objects) {
        let [low, high, ..] = (object + 1).to_le_bytes().map(|byte| f32::from(byte) / 255.0);
        triangle.iter().for_each(|i| mesh.vertices[*i as usize].color = [low, high, 0.0, 1.0]);
    }
    for material in &mut mesh.materials {
        (material.diffuse, material.texture) = ([1.0; 3], None);
    }
    mesh
}

/// What the graphics card draws at each pixel.
fn drawn(gpu: &Gpu, mesh: &PreviewMesh, camera: &CourseCamera) -> Vec<u32> {
    let (target, mesh) = (Target::new(gpu, SIZE), GpuMesh::new(gpu, &numbered(mesh)));
    let look = Look { flat: true, srgb: false, exposure: 0.0, wireframe: false };
    gpu.draw(&target, Some((&mesh, None)), camera, &look);
    let pixels = target.read(gpu).expect("the card gives the picture back");
    let object = |p: &[u8]| match u32::from_le_bytes([p[0], p[1], 0, 0]) {
        // The background is blue, and objects have none.
        _ if p[2] != 0 => NOTHING,
        number => number - 1,
    };
    pixels.chunks_exact(4).map(object).collect()
}

/// Pixels whose right or lower neighbour shows another object.
fn outline(objects: &[u32]) -> Vec<[i64; 2]> {
    let [w, h] = SIZE.map(|v| v as usize);
    let differs = |x: usize, y: usize| {
        let at = objects[y * w + x];
        (x + 1 < w && objects[y * w + x + 1] != at) || (y + 1 < h && objects[(y + 1) * w + x] != at)
    };
    let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    pixels.filter(|(x, y)| differs(*x, *y)).map(|(x, y)| [x as i64, y as i64]).collect()
}

/// The largest distance of a pixel of `a` from the nearest one of `b`.
fn farthest(a: &[[i64; 2]], b: &[[i64; 2]]) -> f64 {
    let distance = |p: &[i64; 2]| {
        let squares = b.iter().map(|q| (p[0] - q[0]).pow(2) + (p[1] - q[1]).pow(2));
        squares.min().map_or(f64::INFINITY, |d| (d as f64).sqrt())
    };
    a.iter().map(distance).fold(0.0, f64::max)
}

/// The scene's own view, one turned and panned with the mouse, and one from above or the side that shows all.
fn cameras(session: &Session) -> [CourseCamera; 3] {
    let start = session.start_camera();
    let (mut turned, mut framed) = (start, start);
    let window = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    turned.drag(Button::Left, Vec2::new(100.0, 90.0), Vec2::new(150.0, 70.0), window);
    turned.drag(Button::Right, Vec2::ZERO, Vec2::new(60.0, -45.0), window);
    turned.drag(Button::Middle, Vec2::ZERO, Vec2::new(0.0, 130.0), window);
    framed.look_along(AxisView::Right);
    framed.drag(Button::Left, Vec2::new(120.0, 60.0), Vec2::new(133.0, 99.0), window);
    framed.frame(&session.bounds(), 4.0 / 3.0);
    [start, turned, framed]
}

/// Compares outlines from three cameras; `least` pixels of outline at least, so that there is something to compare.
fn compare(source: &Source, least: usize) {
    let session = Session::load(source, Some(SIZE), &Limits::default()).expect("a sound scene");
    assert_eq!(session.preview().note, None);
    // With several samples per pixel the colours at outlines would be mixtures.
    let gpu = common::card().map(|state| Gpu::with_samples(&state, 1));
    for (i, camera) in cameras(&session).into_iter().enumerate() {
        let frame = Frame::draw(session.preview(), &camera, SIZE);
        let plan = session.plan(&Setup { camera, ..session.setup() }).expect("a sound scene");
        let (raster, rays) = (outline(&frame.objects), outline(&traced(&plan)));
        assert!(rays.len() >= least, "{} camera {i}: only {} pixels", source.scene, rays.len());
        let apart = farthest(&raster, &rays).max(farthest(&rays, &raster));
        assert!(apart <= TOLERANCE, "{} camera {i}: {apart} pixels apart", source.scene);
        if let Some(gpu) = &gpu {
            let raster = outline(&drawn(gpu, session.preview(), &camera));
            let apart = farthest(&raster, &rays).max(farthest(&rays, &raster));
            assert!(apart <= TOLERANCE, "{} camera {i}: {apart} pixels apart on the card", source.scene);
        }
    }
}

fn data(name: &str) -> Source {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    Source::file(&path).expect("a name in Unicode")
}

#[test]
fn the_scenes_of_the_course() {
    for scene in ["sphere", "square", "cornell"] {
        compare(&Source::builtin(scene), 100);
    }
}

#[test]
fn a_mesh() {
    compare(&data("mesh.toml"), 200);
}

#[test]
fn ellipsoids() {
    compare(&data("ellipsoids.toml"), 200);
}

#[test]
fn disks() {
    compare(&data("disks.toml"), 200);
}

#[test]
fn instances() {
    compare(&data("instances.toml"), 400);
}

#[test]
fn parallel_rays() {
    compare(&data("parallel.toml"), 200);
}

/// The measure notices what it should: an object that has moved by a few pixels, and one that is missing.
#[test]
fn outlines_that_differ_are_noticed() {
    let disk = |cx: i64, r: i64| -> Vec<u32> {
        let inside = |x: i64, y: i64| (x - cx) * (x - cx) + (y - 90) * (y - 90) <= r * r;
        let pixels = (0..i64::from(SIZE[1])).flat_map(|y| (0..i64::from(SIZE[0])).map(move |x| (x, y)));
        pixels.map(|(x, y)| if inside(x, y) { 0 } else { NOTHING }).collect()
    };
    let apart =
        |a: &[u32], b: &[u32]| farthest(&outline(a), &outline(b)).max(farthest(&outline(b), &outline(a)));
    assert!(apart(&disk(100, 40), &disk(101, 40)) <= TOLERANCE);
    assert!(apart(&disk(100, 40), &disk(103, 40)) > TOLERANCE);
    assert!(apart(&disk(100, 40), &disk(100, 43)) > TOLERANCE);
    assert!(apart(&disk(100, 40), &vec![NOTHING; disk(0, 1).len()]).is_infinite());
}

/// The front wall of the box lies in the near plane: both show the inside.
#[test]
fn the_near_plane_shows_the_inside_of_the_box() {
    let session = Session::load(&Source::builtin("cornell"), Some(SIZE), &Limits::default()).unwrap();
    let frame = Frame::draw(session.preview(), &session.start_camera(), SIZE);
    let plan = session.plan(&session.setup()).unwrap();
    let rays = traced(&plan);
    let front = (0..plan.scene.shapes() as u32).find(|s| plan.scene.shape_name(*s) == "front-wall").unwrap();
    assert!(frame.objects.iter().all(|o| *o != front) && rays.iter().all(|o| *o != front));
    for name in ["left-sphere", "right-sphere", "back-wall"] {
        let seen = |objects: &[u32]| {
            objects.iter().filter(|o| **o != NOTHING && plan.scene.shape_name(**o) == name).count()
        };
        assert!(seen(&frame.objects) > 500 && seen(&rays) > 500, "{name}");
    }
}
