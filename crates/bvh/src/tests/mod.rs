use crate::lanes::Baseline;
use crate::prepared::PreparedRay;
use crate::primitive::{Key, Meeting};
use crate::query::{Closest, Query};
use crate::{Bvh, Disk, Geometry, Hit, Instance, Quad, Ray, Sphere, Triangles};

mod agreement;
mod bodies;
mod builds;
mod cornell;
mod data;
mod meshes;
mod primitives;
mod properties;
mod refits;
mod scenes;
mod watertight;

/// The closest hit by asking every primitive: no boxes, no early rejection.
fn exhaustive(bvh: &Bvh, ray: &Ray) -> Hit {
    let mut query = Closest::until(ray.t_max);
    if let Some(ray) = PreparedRay::new(ray, bvh.tree.extent) {
        ask_all(bvh, &ray, &mut query, Hit::NO_INSTANCE);
    }
    query.hit
}

fn ask_all(bvh: &Bvh, ray: &PreparedRay, query: &mut Closest, instance: u32) {
    let tree = &bvh.tree;
    let mut offer = |meeting: Option<Meeting>, key| {
        if let Some(meeting) = meeting {
            query.offer(meeting, key, instance);
        }
    };
    for block in tree.blocks.iter() {
        (0..block.len()).for_each(|lane| {
            offer(block.meet::<Baseline>(lane, ray), Key::numbered(block.number(lane), &tree.starts))
        });
    }
    tree.spheres.iter().for_each(|s| offer(s.meet(&ray.line()).single(), s.key));
    tree.quads.iter().for_each(|q| offer(q.meet(&ray.line()).single(), q.key));
    tree.disks.iter().for_each(|d| offer(d.meet(&ray.line()).single(), d.key));
    for placed in &tree.instances {
        if let Some(local) = placed.local_ray(ray) {
            ask_all(&placed.bvh, &local, query, placed.index);
        }
    }
}

fn build(geometries: Vec<Geometry>) -> Bvh {
    Bvh::build(geometries, &crate::BuildOptions::default()).expect("test geometry is valid")
}
