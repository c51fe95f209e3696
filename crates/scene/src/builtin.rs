//! The course's scenes, built in.
//!
//! `sphere`, `square` and `cornell` are its scenes 0, 1 and 2; the names with `-as-given` keep the material types
//! that the course's base code sets. Every wall is a quad whose sides turn so that sides\[0\] × sides\[1\] is the
//! wall's inward normal, as the base's transforms of its 2 × 2 square leave them.

use crate::description::{Node, Role, SceneDescription, Value};

/// Names of the built-in scenes.
pub const NAMES: [&str; 5] = ["sphere", "square", "cornell", "sphere-as-given", "cornell-as-given"];

/// The built-in scene of that name.
pub fn builtin(name: &str) -> Option<SceneDescription> {
    match name {
        "sphere" => Some(sphere("phong")),
        "sphere-as-given" => Some(sphere("mirror")),
        "square" => Some(square()),
        "cornell" => Some(cornell(&corrected_spheres())),
        "cornell-as-given" => Some(cornell(&spheres_as_given())),
        _ => None,
    }
}

/// A triple of numbers as a value.
fn triple(v: [f64; 3]) -> Value {
    v.into()
}

/// What all scenes of the course share: the image and the camera. The near plane cuts the box's front wall away.
fn scene() -> SceneDescription {
    let mut scene = SceneDescription::default();
    let render = Node::new(Role::Render, "render", "");
    scene.add(render.with("integrator", "classic").with("size", [480, 480]).with("spp", 50));
    let camera = Node::new(Role::Camera, "perspective", "main");
    scene.add(
        camera
            .with("position", triple([0.0, 0.0, 6.1]))
            .with("target", triple([0.0, 0.0, 0.0]))
            .with("up", triple([0.0, 1.0, 0.0]))
            .with("fov", 45.0)
            .with("near", 4.1)
            .with("far", 10000.0),
    );
    scene
}

fn material(type_name: &str, name: &str, diffuse: [f64; 3], specular: [f64; 3], shininess: f64) -> Node {
    Node::new(Role::Material, type_name, name)
        .with("diffuse", triple(diffuse))
        .with("specular", triple(specular))
        .with("shininess", shininess)
}

fn ball(name: &str, center: [f64; 3], radius: f64, material: &str) -> Node {
    Node::new(Role::Shape, "sphere", name)
        .with("center", triple(center))
        .with("radius", radius)
        .with("material", material)
}

fn quad(name: &str, origin: [f64; 3], sides: [[f64; 3]; 2], material: &str) -> Node {
    Node::new(Role::Shape, "quad", name)
        .with("origin", triple(origin))
        .with("sides", sides.map(triple))
        .with("material", material)
}

/// The point light of the first two scenes.
fn lamp() -> Node {
    Node::new(Role::Light, "point", "lamp")
        .with("position", triple([-5.0, 5.0, 5.0]))
        .with("color", triple([1.0, 1.0, 1.0]))
}

fn sphere(type_name: &str) -> SceneDescription {
    let mut scene = scene();
    scene.add(material(type_name, "sphere", [1.0; 3], [0.2; 3], 20.0));
    scene.add(ball("sphere", [0.0; 3], 1.0, "sphere"));
    scene.add(lamp());
    scene
}

fn square() -> SceneDescription {
    let mut scene = scene();
    scene.add(material("phong", "square", [0.8; 3], [0.8; 3], 20.0));
    scene.add(quad("square", [-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], "square"));
    scene.add(lamp());
    scene
}

/// The right sphere's material, then the left one's: glass and mirror as the comments of the base call them.
fn corrected_spheres() -> [Node; 2] {
    [
        material("glass", "glass", [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 16.0).with("ior", 1.4),
        material("mirror", "mirror", [1.0; 3], [1.0; 3], 16.0),
    ]
}

/// The types that the base sets: mirror right, glass left.
fn spheres_as_given() -> [Node; 2] {
    [
        material("mirror", "mirror", [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 16.0),
        // The base's index is 0, which is none: no light would get in. This is the limit, total reflection.
        material("glass", "glass", [1.0; 3], [1.0; 3], 16.0).with("ior", 1e-6),
    ]
}

fn cornell([right, left]: &[Node; 2]) -> SceneDescription {
    const WHITE: [f64; 3] = [1.0; 3];
    const RED: [f64; 3] = [1.0, 0.0, 0.0];
    const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
    let mut scene = scene();
    for (name, color) in [("white", WHITE), ("red", RED), ("green", GREEN)] {
        scene.add(material("phong", name, color, color, 16.0));
    }
    scene.add(right.clone());
    scene.add(left.clone());

    let (x, y, z) = ([4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]);
    let minus = |v: [f64; 3]| v.map(|c| 0.0 - c);
    scene.add(quad("back-wall", [-2.0, -2.0, -2.0], [x, y], "white"));
    scene.add(quad("left-wall", [-2.0, -2.0, 2.0], [minus(z), y], "red"));
    scene.add(quad("right-wall", [2.0, -2.0, -2.0], [z, y], "green"));
    scene.add(quad("floor", [-2.0, -2.0, 2.0], [x, minus(z)], "white"));
    scene.add(quad("ceiling", [-2.0, 2.0, -2.0], [x, z], "white"));
    scene.add(quad("front-wall", [2.0, -2.0, 2.0], [minus(x), y], "white"));
    scene.add(ball("right-sphere", [1.0, -1.25, 0.5], 0.75, &right.name));
    scene.add(ball("left-sphere", [-1.0, -1.25, -0.5], 0.75, &left.name));

    scene.add(
        Node::new(Role::Light, "quad", "ceiling")
            .with("origin", triple([-0.5, 1.5, -0.5]))
            .with("sides", [triple([1.0, 0.0, 0.0]), triple([0.0, 0.0, 1.0])])
            .with("color", triple(WHITE))
            .with("radiance", triple([12.0; 3]))
            .with("shadow_samples", 16),
    );
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::ValueKind;

    fn numbers(value: &Value) -> Vec<f64> {
        match &value.kind {
            ValueKind::Float(v) => vec![*v],
            ValueKind::Int(i) => vec![*i as f64],
            ValueKind::Array(list) => list.iter().flat_map(numbers).collect(),
            other => panic!("no number: {other:?}"),
        }
    }

    fn get(scene: &SceneDescription, role: Role, name: &str, param: &str) -> Vec<f64> {
        let id = scene.find(role, name).unwrap_or_else(|| panic!("no {name}"));
        numbers(&scene.node(id).param(param).unwrap().value)
    }

    fn cross(s: &[f64]) -> [f64; 3] {
        [s[1] * s[5] - s[2] * s[4], s[2] * s[3] - s[0] * s[5], s[0] * s[4] - s[1] * s[3]]
    }

    #[test]
    fn every_name_is_built_and_every_reference_stands() {
        assert!(builtin("no-such-scene").is_none());
        for name in NAMES {
            let scene = builtin(name).unwrap();
            for (_, shape) in scene.of_role(Role::Shape) {
                let ValueKind::String(material) = &shape.param("material").unwrap().value.kind else {
                    panic!("material is no text");
                };
                assert!(scene.find(Role::Material, material).is_some(), "{name}: {material}");
            }
        }
    }

    #[test]
    fn walls_enclose_the_box_and_face_inward() {
        let scene = builtin("cornell").unwrap();
        let walls = [
            ("back-wall", [0.0, 0.0, 1.0]),
            ("left-wall", [1.0, 0.0, 0.0]),
            ("right-wall", [-1.0, 0.0, 0.0]),
            ("floor", [0.0, 1.0, 0.0]),
            ("ceiling", [0.0, -1.0, 0.0]),
            ("front-wall", [0.0, 0.0, -1.0]),
        ];
        for (name, normal) in walls {
            let origin = get(&scene, Role::Shape, name, "origin");
            let sides = get(&scene, Role::Shape, name, "sides");
            assert_eq!(cross(&sides), normal.map(|n| 16.0 * n), "{name}");
            // The plane lies at −2 along its inward normal, and the four corners are corners of the cube.
            let plane: f64 = origin.iter().zip(normal).map(|(o, n)| o * n).sum();
            assert_eq!(plane, -2.0, "{name}");
            for (a, b) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                for i in 0..3 {
                    assert_eq!((origin[i] + a * sides[i] + b * sides[3 + i]).abs(), 2.0, "{name}");
                }
            }
        }
    }

    #[test]
    fn light_hangs_under_the_ceiling_and_shines_down() {
        let scene = builtin("cornell").unwrap();
        let origin = get(&scene, Role::Light, "ceiling", "origin");
        let sides = get(&scene, Role::Light, "ceiling", "sides");
        assert_eq!(cross(&sides), [0.0, -1.0, 0.0]);
        let center: Vec<f64> = (0..3).map(|i| origin[i] + 0.5 * (sides[i] + sides[3 + i])).collect();
        assert_eq!(center, [0.0, 1.5, 0.0]);
    }

    #[test]
    fn spheres_have_the_course_types() {
        let type_of = |scene: &str, shape: &str| {
            let scene = builtin(scene).unwrap();
            let id = scene.find(Role::Shape, shape).unwrap();
            let ValueKind::String(name) = scene.node(id).param("material").unwrap().value.kind.clone() else {
                panic!("material is no text");
            };
            let material = scene.node(scene.find(Role::Material, &name).unwrap());
            (material.type_name.clone(), material.param("ior").map(|p| numbers(&p.value)[0]))
        };
        assert_eq!(type_of("sphere", "sphere"), ("phong".to_owned(), None));
        assert_eq!(type_of("sphere-as-given", "sphere"), ("mirror".to_owned(), None));
        assert_eq!(type_of("cornell", "right-sphere"), ("glass".to_owned(), Some(1.4)));
        assert_eq!(type_of("cornell", "left-sphere"), ("mirror".to_owned(), None));
        assert_eq!(type_of("cornell-as-given", "right-sphere"), ("mirror".to_owned(), None));
        assert_eq!(type_of("cornell-as-given", "left-sphere"), ("glass".to_owned(), Some(1e-6)));
        // Both spheres of the box touch the floor.
        let scene = builtin("cornell").unwrap();
        for name in ["left-sphere", "right-sphere"] {
            let lowest =
                get(&scene, Role::Shape, name, "center")[1] - get(&scene, Role::Shape, name, "radius")[0];
            assert_eq!(lowest, -2.0);
        }
    }
}
