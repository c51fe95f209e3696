//! The rays that all kernels get: primary, diffuse bounce, shadow.

use crate::measure::Kernel;
use crate::meshes::{Mesh, View};
use crate::ours::Batch;
use penombre_bvh::{Bvh, Hit, Ray};
use penombre_lab::Pcg32;
use penombre_math::Vec3;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From a camera in pixel order, closest hit.
    Primary,
    /// From what the camera sees into cosine-weighted directions, closest hit.
    Bounce,
    /// From what the camera sees to points of an area light, any hit.
    Shadow,
}

impl Kind {
    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
        }
    }
}

/// Rays of all kinds, in pixel order.
pub struct Rays {
    primary: Vec<Ray>,
    bounce: Vec<Ray>,
    shadow: Vec<Ray>,
}

impl Rays {
    /// Each kind with its rays.
    pub fn each(&self) -> [(Kind, &[Ray]); 3] {
        [(Kind::Primary, &self.primary), (Kind::Bounce, &self.bounce), (Kind::Shadow, &self.shadow)]
    }
}

/// About `count` rays of each kind for a mesh; one bounce and one shadow ray leave each point that a primary ray hits.
pub fn make(mesh: &Mesh, bvh: &Bvh, count: usize) -> Rays {
    make_seen(&mesh.view, bvh, count, |hit| mesh.normal(hit.prim))
}

/// [`make`] of anything whose normals are known.
pub fn make_seen(view: &View, bvh: &Bvh, count: usize, normal: impl Fn(&Hit) -> Vec3) -> Rays {
    let primary = camera(view, count);
    let mut hits = vec![Hit::MISS; primary.len()];
    Batch(bvh).closest(&primary, &mut hits);
    let mut rng = Pcg32::new(5);
    let mut rays = Rays { primary, bounce: Vec::new(), shadow: Vec::new() };
    for (ray, hit) in rays.primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let normal = facing(normal(hit), ray.dir);
        let from = ray.at(hit.t) + normal * (2e-5 * hit.t);
        let bounce = (normal + direction(&mut rng)).try_normalize().unwrap_or(normal);
        rays.bounce.push(Ray::new(from, bounce, 0.0, f32::INFINITY));
        let side = |rng: &mut Pcg32| (rng.next_f32() - 0.5) * view.light_side;
        let target = view.light + Vec3::new(side(&mut rng), 0.0, side(&mut rng));
        let way = target - from;
        rays.shadow.push(Ray::new(from, way.normalize(), 0.0, way.length() * 0.9999));
    }
    rays
}

/// A picture of 4 : 3 that is as wide as its distance.
fn camera(view: &View, count: usize) -> Vec<Ray> {
    let width = (count as f64 * 4.0 / 3.0).sqrt() as usize;
    let height = count / width.max(1);
    let forward = (view.at - view.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let offset = |i: usize, n: usize| (i as f32 + 0.5) / n as f32 - 0.5;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let ray = |(x, y)| {
        let dir = forward + right * offset(x, width) - up * (0.75 * offset(y, height));
        Ray::new(view.eye, dir.normalize(), 0.0, f32::INFINITY)
    };
    pixels.map(ray).collect()
}

/// The normal on the side that a ray comes from.
fn facing(normal: Vec3, dir: Vec3) -> Vec3 {
    if normal.dot(dir) > 0.0 { -normal } else { normal }
}

/// Uniform directions of unit length, by rejection.
pub fn direction(rng: &mut Pcg32) -> Vec3 {
    loop {
        let v = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0;
        let square = v.length_squared();
        if (1e-4..=1.0).contains(&square) {
            return v / square.sqrt();
        }
    }
}
