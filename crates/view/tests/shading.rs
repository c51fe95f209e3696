//! What the graphics card computes for a pixel is the preview's formula: Phong of the scene's lights and the head light.

mod common;

use penombre_math::{DVec2, DVec3};
use penombre_view::preview::Limits;
use penombre_view::session::{Session, Source};
use penombre_view::window::gpu::{Gpu, GpuMesh, Look, Target};

const SIZE: [u32; 2] = [60, 40];

/// A wall in the plane z = 0 before a camera at z = 5, lit from the side.
fn scene(lens: &str) -> String {
    format!(
        "penombre = 1\n[camera.main]\n{lens}\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n\
         [material.wall]\ntype = \"phong\"\ndiffuse = [0.6, 0.3, 0.1]\nspecular = [0.2, 0.4, 0.5]\nshininess = 7\n\
         [shape.wall]\ntype = \"quad\"\norigin = [-9, -9, 0]\nsides = [[18, 0, 0], [0, 18, 0]]\nmaterial = \"wall\"\n\
         [light.lamp]\ntype = \"point\"\nposition = [1.5, 1, 2]\ncolor = [1, 0.8, 0.5]\n"
    )
}

/// The preview's colour at a point of the wall, seen along `v` (unit, to the viewer): three tenths of a light at the
/// viewer's head, seven tenths of the scene's light.
fn expected(p: DVec3, v: DVec3) -> [f64; 3] {
    let (n, l) = (DVec3::Z, (DVec3::new(1.5, 1.0, 2.0) - p).normalize());
    let r = n * (2.0 * n.dot(l)) - l;
    let highlight = r.dot(v).max(0.0).powf(7.0);
    let (kd, ks, light) = ([0.6, 0.3, 0.1], [0.2, 0.4, 0.5], [1.0, 0.8, 0.5]);
    [0, 1, 2].map(|i| {
        let own = light[i] * (kd[i] * n.dot(l) + ks[i] * highlight);
        (0.3 * kd[i] * n.dot(v) + 0.7 * own).min(1.0)
    })
}

/// Draws the scene and compares every pixel; `at` gives the point of the wall and the direction to the viewer from a
/// pixel's place, (−1, −1) lower left to (1, 1).
fn compare(lens: &str, at: impl Fn(DVec2) -> (DVec3, DVec3)) {
    let Some(state) = common::card() else { return };
    let gpu = Gpu::with_samples(&state, 1);
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("wall.toml");
    std::fs::write(&path, scene(lens)).expect("a new file");
    let source = Source::file(&path).expect("a name in Unicode");
    let session = Session::load(&source, Some(SIZE), &Limits::default()).expect("a sound scene");
    let (target, mesh) = (Target::new(&gpu, SIZE), GpuMesh::new(&gpu, session.preview()));
    let look = Look { flat: false, srgb: false, exposure: 0.0, wireframe: false };
    gpu.draw(&target, Some((&mesh, None)), &session.start_camera(), &look);
    let pixels = target.read(&gpu).expect("the card gives the picture back");
    for (i, found) in pixels.chunks_exact(4).enumerate() {
        let (x, y) = ((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5);
        let place = DVec2::new(2.0 * x / f64::from(SIZE[0]) - 1.0, 1.0 - 2.0 * y / f64::from(SIZE[1]));
        let (p, v) = at(place);
        for (channel, expected) in expected(p, v).into_iter().enumerate() {
            let apart = (f64::from(found[channel]) - 255.0 * expected).abs();
            assert!(apart <= 1.5, "pixel {x}, {y}, channel {channel}: {} for {expected}", found[channel]);
        }
    }
}

#[test]
fn perspective() {
    // At depth 5 the view is as high as 2 · 5 · tan 30°.
    let half = 5.0 * 30f64.to_radians().tan();
    compare("type = \"perspective\"\nfov = 60", |place| {
        let p = DVec3::new(place.x * half * 1.5, place.y * half, 0.0);
        (p, (DVec3::new(0.0, 0.0, 5.0) - p).normalize())
    });
}

#[test]
fn parallel_rays() {
    compare("type = \"orthographic\"\nheight = 4", |place| {
        (DVec3::new(place.x * 3.0, place.y * 2.0, 0.0), DVec3::Z)
    });
}
