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
mod filters;
mod meshes;
mod primitives;
mod properties;
mod refits;
mod scenes;
mod twins;
mod users;
mod watertight;

/// The closest hit by asking every primitive: no boxes, no early rejection.
fn exhaustive(bvh: &Bvh, ray: &Ray) -> Hit {
    let mut query = Closest::until(ray.t_max);
    every_hit(bvh, ray, &mut |hit| {
        let Hit { t, u, v, geometry, prim, instance } = hit;
        query.offer(Meeting { t, u, v }, Key { geometry, prim }, instance);
    });
    query.hit
}

/// Calls `take` with all hits of a ray, also where it meets a primitive for the second time.
fn every_hit(bvh: &Bvh, ray: &Ray, take: &mut dyn FnMut(Hit)) {
    if let Some(ray) = PreparedRay::new(ray, bvh.tree.extent) {
        ask_all(bvh, &ray, take, Hit::NO_INSTANCE);
    }
}

fn ask_all(bvh: &Bvh, ray: &PreparedRay, take: &mut dyn FnMut(Hit), instance: u32) {
    let tree = &bvh.tree;
    let mut offer = |meeting: Option<Meeting>, key| {
        if let Some(meeting) = meeting {
            take(meeting.hit(key, instance));
        }
    };
    for block in tree.blocks.iter() {
        (0..block.len()).for_each(|lane| {
            let (meeting, number) = (block.meet::<Baseline>(lane, ray), block.number(lane));
            let twins = tree.twins_of(number).iter().map(|twin| twin.number);
            for number in std::iter::once(number).chain(twins) {
                offer(meeting, Key::numbered(number, &tree.starts));
            }
        });
    }
    for sphere in &tree.spheres {
        let first = sphere.meet(&ray.line()).single();
        offer(first, sphere.key);
        offer(sphere.meet_behind(ray.line(), first), sphere.key);
    }
    tree.quads.iter().for_each(|q| offer(q.meet(&ray.line()).single(), q.key));
    tree.disks.iter().for_each(|d| offer(d.meet(&ray.line()).single(), d.key));
    for user in &tree.users {
        let mut t_min = ray.t_min;
        while let Some(at) = user.meet(ray, t_min) {
            t_min = at.t;
            offer(Some(at), user.key);
        }
    }
    for placed in &tree.instances {
        if let Some(local) = placed.local_ray(ray) {
            ask_all(&placed.bvh, &local, take, placed.index);
        }
    }
}

fn build(geometries: Vec<Geometry>) -> Bvh {
    Bvh::build(geometries, &crate::BuildOptions::default()).expect("test geometry is valid")
}
