//! A camera, ground and light for meshes that come without.
//!
//! The camera looks from the front right, a little from above, with the whole mesh in view. Under the mesh lies a
//! ground that fills the picture; a soft key light stands at the upper left, a weak and larger fill light at the
//! right; except in `classic`, which has ambient light instead, a dim sky shines evenly.

use crate::assets::Assets;
use crate::description::{Node, Role, SceneDescription, Value, ValueKind};
use crate::mesh::TriangleMesh;
use penombre_math::float::tan_degrees;
use penombre_math::{Bounds3, DVec3, Vec3};

/// Name of the shape of a bare mesh file.
pub const MESH_NAME: &str = "mesh";
/// Field of view from the lower to the upper edge, degrees.
const FOV: f64 = 35.0;
/// Part of the picture that stays free at each side.
const MARGIN: f64 = 0.08;
/// Size of the picture, pixels.
const SIZE: [i64; 2] = [640, 480];
/// The ground fills pictures up to this ratio of width to height.
const WIDEST: f64 = 2.4;
/// From the middle of the mesh to the camera; not normalised.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.55, 0.45, 1.0);
/// Parts of the camera's left, world up and towards the camera in the directions of the lights.
const KEY: [f64; 3] = [0.55, 0.75, 0.4];
const FILL: [f64; 3] = [-0.9, 0.5, 0.5];

/// What is looked at where there is nothing.
const CUBE: Bounds3 = Bounds3 { min: Vec3::NEG_ONE, max: Vec3::ONE };

/// A description that shows a mesh file: the shape `mesh` and the settings of the render. [`complete`] adds the rest
/// when the assets are loaded. `file`: relative to the root folder.
pub fn bare_mesh(file: &str) -> SceneDescription {
    let mut scene = SceneDescription::default();
    scene.add(Node::new(Role::Render, "render", "").with("size", SIZE.map(Value::from)).with("spp", 32));
    scene.add(Node::new(Role::Integrator, "classic", "classic").with("ambient", [0.1; 3]));
    scene.add(Node::new(Role::Shape, "mesh", MESH_NAME).with("file", file).with("crease_angle", 60.0));
    scene
}

/// The positions that triangles use, each once.
fn used_positions(mesh: &TriangleMesh) -> impl Iterator<Item = Vec3> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.indices.iter().flatten().for_each(|i| used[*i as usize] = true);
    mesh.positions.iter().zip(used).filter_map(|(p, used)| used.then_some(*p))
}

/// Adds the camera `auto`, the shape and material `ground` and the lights `key`, `fill` and `sky` to a scene of meshes
/// (without transforms). Without a triangle they stand as for the cube of edge 2 about the origin.
///
/// # Errors
/// The box of the meshes, if they are so large that the camera, the ground or a light would stand beyond the numbers of
/// single precision. Nothing is added then.
pub fn complete(scene: &mut SceneDescription, assets: &Assets) -> Result<(), Bounds3> {
    let shapes: Vec<_> = scene.of_role(Role::Shape).map(|(id, _)| id).collect();
    let meshes = shapes.iter().filter_map(|id| assets.mesh(*id)).map(|file| &*file.mesh);
    let mut points: Vec<Vec3> = meshes.flat_map(used_positions).collect();
    let mut bounds = Bounds3::of_points(points.iter().copied());
    if bounds.is_empty() {
        bounds = CUBE;
        points = CUBE.corners().to_vec();
    }
    let aspect = aspect_of(scene);
    let stage = Stage::new(&bounds);
    let view = stage.fit(points.iter().map(|p| p.as_dvec3()), aspect);
    let [material, ground] = stage.ground(&view, aspect.max(WIDEST));
    // In `classic`, together with the ambient light a white surface gets about 1, whichever way it faces. Elsewhere a
    // white surface that faces the key light has a radiance of about 0.7, and the sky's 0.15 where it sees that alone.
    let key = stage.light("key", KEY, 2.4, [0.8, 11.0], 4);
    let fill = stage.light("fill", FILL, 4.0, [0.3, 0.6], 2);
    let sky = Node::new(Role::Light, "environment", "sky").with("radiance", [0.15; 3]);
    let made = [stage.camera(&view), material, ground, key, fill, sky];
    if !made.iter().all(is_in_range) {
        return Err(bounds);
    }
    made.into_iter().for_each(|node| _ = scene.add(node));
    Ok(())
}

/// Words about a mesh that is so large, to follow its name.
pub fn too_far(bounds: &Bounds3) -> String {
    let [min, max] = [bounds.min, bounds.max].map(|p| format!("({:e}, {:e}, {:e})", p.x, p.y, p.z));
    format!("found a box from {min} to {max}, expected one that leaves room for a camera around it")
}

/// What to do about that.
pub const TOO_FAR_HELP: &str =
    "numbers are kept in single precision, which ends at 3.4e38: scale the mesh down";

/// True if all numbers of a node are those of single precision.
pub fn is_in_range(node: &Node) -> bool {
    fn is_small(value: &Value) -> bool {
        match &value.kind {
            ValueKind::Float(v) => v.abs() <= f64::from(f32::MAX),
            ValueKind::Array(list) => list.iter().all(is_small),
            _ => true,
        }
    }
    node.params.iter().all(|p| is_small(&p.value))
}

/// Width over height of the picture that `render.size` asks for, as far as it is sound.
fn aspect_of(scene: &SceneDescription) -> f64 {
    let node = scene.of_role(Role::Render).next().map(|(_, node)| node);
    let edges = match node.and_then(|n| n.param("size")).map(|p| &p.value.kind) {
        Some(ValueKind::Array(list)) => list.as_slice(),
        _ => &[],
    };
    let edge = |i: usize| match edges.get(i).map(|v| &v.kind) {
        Some(ValueKind::Int(n @ 1..=65_536)) => *n,
        _ => SIZE[i],
    };
    (edge(0) as f64 / edge(1) as f64).clamp(0.01, 100.0)
}

/// A camera named `auto` that has the whole box in view. `aspect`: width of the picture by its height. An empty box
/// is taken as the cube of edge 2 about the origin.
pub fn camera_for(bounds: &Bounds3, aspect: f32) -> Node {
    let bounds = if bounds.is_empty() || !bounds.is_finite() { &CUBE } else { bounds };
    let stage = Stage::new(bounds);
    let view =
        stage.fit(bounds.corners().into_iter().map(|p| p.as_dvec3()), f64::from(aspect).clamp(0.01, 100.0));
    stage.camera(&view)
}

/// The box in its surroundings, double precision.
struct Stage {
    center: DVec3,
    /// Half the diagonal of the box; above zero.
    radius: f64,
    floor: f64,
    /// Unit vectors of the camera: right, up, and back to the camera.
    right: DVec3,
    up: DVec3,
    back: DVec3,
}

/// Where a camera stands.
struct CameraPlace {
    target: DVec3,
    distance: f64,
}

impl Stage {
    fn new(bounds: &Bounds3) -> Self {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let (center, half) = ((min + max) * 0.5, (max - min).length() * 0.5);
        let reach = min.abs().max(max.abs()).max_element();
        // A point has no size; far from the origin single precision needs one.
        let radius = if half > 0.0 { half } else { (1e-3 * reach).max(1.0) };
        let back = TOWARDS_CAMERA.normalize();
        let right = DVec3::Y.cross(back).normalize();
        // Below the mesh by more than single precision can lose.
        let floor = min.y - (1e-3 * radius).max(2.5e-7 * reach);
        Self { center, radius, floor, right, up: back.cross(right), back }
    }

    /// The nearest place from which all points lie inside the four edges of the picture, the margin left free.
    ///
    /// A point at (x, y, z) in camera directions about the centre is inside the right edge if
    /// x − tx ≤ k·(distance − z), with k the tangent of half the field of view: one linear bound per edge.
    fn fit(&self, points: impl Iterator<Item = DVec3>, aspect: f64) -> CameraPlace {
        let tall = tan_degrees(FOV * 0.5) * (1.0 - 2.0 * MARGIN);
        let wide = tall * aspect;
        let mut edge = [f64::NEG_INFINITY; 4];
        let mut nearest = f64::NEG_INFINITY;
        for p in points {
            let p = p - self.center;
            let (x, y, z) = (p.dot(self.right), p.dot(self.up), p.dot(self.back));
            let bounds = [x + wide * z, -x + wide * z, y + tall * z, -y + tall * z];
            edge = std::array::from_fn(|i| edge[i].max(bounds[i]));
            nearest = nearest.max(z);
        }
        let distance = ((edge[0] + edge[1]) / (2.0 * wide)).max((edge[2] + edge[3]) / (2.0 * tall));
        let aside = self.right * ((edge[0] - edge[1]) * 0.5) + self.up * ((edge[2] - edge[3]) * 0.5);
        CameraPlace { target: self.center + aside, distance: distance.max(nearest + 0.1 * self.radius) }
    }

    fn camera(&self, view: &CameraPlace) -> Node {
        Node::new(Role::Camera, "perspective", "auto")
            .with("position", vector(view.target + self.back * view.distance))
            .with("target", vector(view.target))
            .with("up", vector(DVec3::Y))
            .with("fov", FOV)
    }

    /// A level square that the whole picture looks at: its material and its shape.
    fn ground(&self, view: &CameraPlace, widest: f64) -> [Node; 2] {
        let eye = view.target + self.back * view.distance;
        let tall = tan_degrees(FOV * 0.5);
        let mut half = 20.0 * self.radius;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let ray = self.right * (x * tall * widest) + self.up * (y * tall) - self.back;
            let hit = eye + ray * ((eye.y - self.floor) / -ray.y);
            let from_center = (hit - self.center).abs();
            half = half.max(1.1 * from_center.x.max(from_center.z));
        }
        let origin = DVec3::new(self.center.x - half, self.floor, self.center.z - half);
        let grey = [0.7; 3];
        let material = Node::new(Role::Material, "phong", "ground")
            .with("diffuse", grey)
            .with("specular", [0.0; 3])
            .with("ambient", grey);
        let shape = Node::new(Role::Shape, "quad", "ground")
            .with("origin", vector(origin))
            // In this order the normal points up.
            .with("sides", [vector(DVec3::Z * 2.0 * half), vector(DVec3::X * 2.0 * half)])
            .with("material", "ground");
        [material, shape]
    }

    /// A square light that faces the mesh. `size`: its edge in radii of the mesh; `strengths`: its colour in `classic` and its
    /// radiance elsewhere, W/(sr·m²).
    fn light(
        &self,
        name: &str,
        parts: [f64; 3],
        size: f64,
        strengths: [f64; 2],
        shadow_samples: i64,
    ) -> Node {
        let direction = (self.right * -parts[0] + DVec3::Y * parts[1] + self.back * parts[2]).normalize();
        let facing = -direction;
        let across = DVec3::Y.cross(facing).normalize() * (size * self.radius);
        let along = facing.cross(across);
        let origin = self.center + direction * (6.0 * self.radius) - (across + along) * 0.5;
        Node::new(Role::Light, "quad", name)
            .with("origin", vector(origin))
            .with("sides", [vector(across), vector(along)])
            .with("color", [strengths[0]; 3])
            .with("radiance", [strengths[1]; 3])
            .with("shadow_samples", shadow_samples)
    }
}

fn vector(v: DVec3) -> Value {
    v.to_array().into()
}

#[cfg(test)]
mod tests;
