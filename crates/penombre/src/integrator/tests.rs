//! Tests of the executor and of the classic integrator on small scenes.

use super::*;
use crate::Plan;
use crate::render::record;
use crate::testing::{plan, set, small};
use penombre_bvh::Ray;
use penombre_math::Vec3;
use penombre_scene::{Node, SceneDescription};

fn radiance(plan: &Plan, pixel: [u32; 2]) -> [f32; 3] {
    record(&plan.scene, &*plan.integrator, &plan.job, pixel, 0).radiance.to_rgb()
}

fn shape_seen(plan: &Plan, pixel: [u32; 2]) -> Option<String> {
    let path = record(&plan.scene, &*plan.integrator, &plan.job, pixel, 0);
    path.vertices[0].surface.map(|at| plan.scene.shape_name(at.shape).to_owned())
}

#[test]
fn phase_one_is_the_flat_colour_and_a_miss_is_black() {
    let mut d = small("sphere", 32, 1);
    set(&mut d, penombre_scene::Role::Integrator, "classic", "phase", 1);
    let plan = plan(&d);
    assert_eq!(radiance(&plan, [16, 16]), [1.0; 3]);
    assert_eq!(radiance(&plan, [0, 0]), [0.0; 3]);
}

#[test]
fn the_near_plane_opens_the_box_also_in_its_corners() {
    use penombre_scene::Role::{Camera, Render};
    for size in [[64, 64], [96, 54]] {
        let mut d = small("cornell", 64, 1);
        set(&mut d, Render, "", "size", size);
        let open = plan(&d);
        set(&mut d, Camera, "main", "near", 0.0);
        let closed = plan(&d);
        let front = shape_seen(&closed, [size[0] as u32 / 2, 32]).unwrap();
        for pixel in [[0, 0], [size[0] as u32 - 1, 0], [0, size[1] as u32 - 1], [30, 30]] {
            assert_ne!(shape_seen(&open, pixel).as_ref(), Some(&front), "{pixel:?}");
        }
        assert!(front.contains("front"), "{front}");
    }
}

/// Light is summed in an order that depends on the sample alone, so batches may be cut anywhere.
#[test]
fn samples_have_the_same_bits_alone_and_in_a_crowd() {
    let plan = plan(&small("cornell", 48, 1));
    let mut worker = plan.integrator.worker(&plan.scene);
    let aim = |i: u32| {
        // At the glass ball, where paths branch most.
        let target = Vec3::new(1.0, -1.25, 0.5) + Vec3::new(i as f32 * 0.01 - 0.6, 0.1, 0.0);
        let origin = Vec3::new(0.0, 0.0, 1.9);
        let sampler = Sampler::new(crate::sampler::SamplerKind::Sobol, 3, [i, 7], 2);
        CameraSample { ray: Ray::new(origin, (target - origin).normalize(), 0.0, f32::INFINITY), sampler }
    };
    let samples: Vec<CameraSample> = (0..3000).map(|i| aim(i % 120)).collect();
    let mut crowd = vec![Spectrum::BLACK; samples.len()];
    worker.trace(&samples, &mut crowd, &|| false);
    for (sample, expected) in samples.iter().zip(&crowd).take(120) {
        let mut alone = [Spectrum::BLACK];
        worker.trace(std::slice::from_ref(sample), &mut alone, &|| false);
        assert_eq!(alone[0].to_rgb().map(f32::to_bits), expected.to_rgb().map(f32::to_bits));
        assert_eq!(worker.record(sample).radiance, *expected);
    }
}

/// A floor under a quad light, half of which a second quad hides.
fn half_hidden(count: i64) -> SceneDescription {
    use penombre_scene::Role::{Integrator, Light, Material, Render, Shape};
    let mut d = SceneDescription::default();
    let render = Node::new(Render, "render", "").with("integrator", "classic");
    d.add(render.with("size", [3i64, 3]).with("spp", 1i64).with("pixel_jitter", false));
    d.add(Node::new(Integrator, "classic", "classic").with("phase", 2i64));
    d.add(Node::new(penombre_scene::Role::Camera, "perspective", "main").with("position", [0.0, 0.5, 3.0]));
    d.add(Node::new(Material, "phong", "white").with("diffuse", [1.0, 1.0, 1.0]));
    let quad = |name: &str, origin: [f64; 3], sides: [[f64; 3]; 2]| {
        Node::new(Shape, "quad", name).with("origin", origin).with("sides", sides).with("material", "white")
    };
    d.add(quad("floor", [-5.0, 0.0, -5.0], [[0.0, 0.0, 10.0], [10.0, 0.0, 0.0]]));
    d.add(quad("lid", [0.0, 1.0, -1.0], [[0.0, 0.0, 2.0], [1.0, 0.0, 0.0]]));
    let light = Node::new(Light, "quad", "lamp")
        .with("origin", [-0.5, 2.0, -0.5])
        .with("sides", [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        .with("shadow_samples", count);
    d.add(light);
    d
}

#[test]
fn soft_shadows_are_the_visible_fraction() {
    let plan = plan(&half_hidden(4096));
    let path = record(&plan.scene, &*plan.integrator, &plan.job, [1, 1], 0);
    let light = &path.vertices[0].lights[0];
    let fraction = f64::from(light.visible) / f64::from(light.shadow_rays);
    // Seen from right under the edge of the lid, half of the light is free, to within a row of strata.
    assert!((fraction - 0.5).abs() < 0.02, "{fraction}");
    assert!((light.added.to_rgb()[0] - light.unoccluded.to_rgb()[0] * fraction as f32).abs() < 1e-6);
}

/// Huge shapes as grounds: nothing shadows itself, and points are where the ray meets them.
#[test]
fn grounds_of_any_size_are_lit_alike() {
    use penombre_scene::Role::Shape;
    for size in [1e3f64, 2e4, 1e5, 1e6, 1e7] {
        let quad = Node::new(Shape, "quad", "ground")
            .with("origin", [-size, 0.0, -size])
            .with("sides", [[0.0, 0.0, 2.0 * size], [2.0 * size, 0.0, 0.0]]);
        let sphere =
            Node::new(Shape, "sphere", "ground").with("center", [0.0, -size, 0.0]).with("radius", size);
        let disk = Node::new(Shape, "disk", "ground").with("normal", [0.0, 1.0, 0.0]).with("radius", size);
        let corners = [[-size, 0.0, -size], [0.0, 0.0, size], [size, 0.0, -size]];
        let mesh =
            Node::new(Shape, "mesh", "ground").with("positions", corners).with("faces", vec![[0i64, 1, 2]]);
        for ground in [quad, sphere, disk, mesh] {
            assert_lit_ground(ground, size);
        }
    }
}

fn assert_lit_ground(ground: Node, size: f64) {
    use penombre_scene::Role::{Camera, Light, Render};
    let type_name = ground.type_name.clone();
    let mut d = SceneDescription::default();
    let render = Node::new(Render, "render", "").with("integrator", "classic");
    d.add(render.with("size", [24i64, 24]).with("spp", 1i64));
    d.add(Node::new(Camera, "perspective", "main").with("position", [0.0, 1.0, 4.0]).with("fov", 30.0));
    d.add(Node::new(Light, "point", "lamp").with("position", [1.0, 3.0, 2.0]));
    d.add(ground);
    let plan = plan(&d);
    for pixel in (0..24).map(|i| [i, 14 + i % 10]) {
        let path = record(&plan.scene, &*plan.integrator, &plan.job, pixel, 0);
        let vertex = &path.vertices[0];
        let at = vertex.surface.unwrap();
        let (origin, dir) = (vertex.ray.origin.as_dvec3(), vertex.ray.dir.as_dvec3());
        let exact = origin - dir * (origin.y / dir.y);
        let off = (at.p.as_dvec3() - exact).length();
        // The sphere curves away from the plane by x²/2r, seen from four metres at a slant.
        assert!(off < 5e-6 + 200.0 / size, "{type_name} {size}: {} off by {off}", at.p);
        assert_eq!(vertex.lights[0].visible, 1, "{type_name} {size} at {pixel:?} shadows itself");
    }
}

#[test]
fn mirrors_facing_each_other_end_in_black_after_the_last_bounce() {
    use penombre_scene::Role::{Integrator, Material};
    let mut d = half_hidden(1);
    d.add(Node::new(Material, "mirror", "mirror"));
    for shape in ["floor", "lid"] {
        set(&mut d, penombre_scene::Role::Shape, shape, "material", "mirror");
    }
    set(&mut d, Integrator, "classic", "phase", 3);
    set(&mut d, Integrator, "classic", "max_bounces", 3);
    set(&mut d, penombre_scene::Role::Camera, "main", "position", [0.5, 0.5, 0.9]);
    set(&mut d, penombre_scene::Role::Camera, "main", "target", [0.5, 0.0, 0.8]);
    let plan = plan(&d);
    let path = record(&plan.scene, &*plan.integrator, &plan.job, [1, 1], 0);
    assert_eq!(path.vertices.len(), 4);
    assert_eq!(path.radiance, Spectrum::BLACK);
    let places: Vec<u32> = path.vertices.iter().map(|v| v.place.node).collect();
    assert_eq!(places, [1, 2, 4, 8]);
}
