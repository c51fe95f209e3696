//! A mesh placed many times, and a check of its hits by hand.

use super::figures::{self, Built, Cost};
use crate::measure::Kernel;
use crate::meshes::{self, Mesh, View};
use crate::ours::Batch;
use crate::rays::{self, Kind, direction};
use penombre_bvh::{Bvh, Geometry, Hit, Instance, Quality, Ray, Stats};
use penombre_lab::Pcg32;
use penombre_math::{DAffine3, DMat3, DVec3, Transform, Vec3};
use std::sync::Arc;

/// Columns and rows of the mesh: about 10⁵ triangles.
const SIDE: u32 = 224;
/// Rays that are put to every instance.
const EXHAUSTIVE: usize = 20;

/// Figures of a field of instances.
pub struct Field {
    pub instances: usize,
    /// Of the mesh that is placed.
    pub triangles: usize,
    pub fast: Built,
    pub high: Built,
    /// Of the high build.
    pub stats: Stats,
    pub costs: [Cost; 3],
    pub check: Check,
}

/// Hits compared with what a nested hierarchy says about the ray in its space.
#[derive(Clone, Copy, Debug, Default)]
pub struct Check {
    /// Hits in instances that were repeated in the space of the instance hit …
    pub repeated: usize,
    /// … and of these, those that came out with other bits.
    pub differing: usize,
    /// Rays that were put to every instance …
    pub exhaustive: usize,
    /// … and of these, those that are answered otherwise.
    pub wrong: usize,
}

/// A mesh and its places.
struct Places {
    mesh: Mesh,
    nested: Arc<Bvh>,
    to_world: Vec<Transform>,
    /// Twelve triangles around all, and where the camera stands.
    room: Mesh,
}

/// Builds `count` instances in a room, traces `rays` rays of each kind, and checks.
pub fn measure(count: usize, rays: usize, reps: usize) -> Result<Field, String> {
    let places = Places::new(count)?;
    let geometries = places.geometries();
    let (_, fast) = figures::build(&geometries, Quality::Fast, 1)?;
    let (bvh, high) = figures::build(&geometries, Quality::High, 1)?;
    drop(geometries);
    let view: &View = &places.room.view;
    let rays = rays::make_seen(view, &bvh, rays, |hit| places.normal(hit));
    let costs = figures::costs(&bvh, None, &rays, reps);
    let mut check = Check::default();
    for (_, rays) in rays.each().into_iter().filter(|(kind, _)| *kind != Kind::Shadow) {
        places.check(&bvh, rays, &mut check);
    }
    let triangles = places.mesh.indices.len();
    Ok(Field { instances: count, triangles, fast, high, stats: bvh.stats(), costs, check })
}

impl Places {
    fn new(count: usize) -> Result<Self, String> {
        let mesh = meshes::rough_ball(SIDE);
        let nested = Arc::new(figures::build(&[mesh.geometry()], Quality::High, 1)?.0);
        let side = (1..).find(|side: &usize| side.pow(3) >= count).unwrap_or(1);
        let mut rng = Pcg32::new(3);
        let place = |i: usize| {
            let cell = DVec3::new((i % side) as f64, (i / side % side) as f64, (i / side / side) as f64);
            Transform::new(turned(&mut rng, cell)).ok_or_else(|| "a place that cannot be inverted".to_owned())
        };
        let to_world = (0..count).map(place).collect::<Result<_, _>>()?;
        let corners = vec![Vec3::splat(-1.0), Vec3::splat(side as f32)];
        let room = Mesh { positions: corners, ..Mesh::default() }.in_room();
        Ok(Self { mesh, nested, to_world, room })
    }

    /// The room first, so that the instance of number i is the geometry i + 1.
    fn geometries(&self) -> Vec<Geometry> {
        let placed =
            |&to_world: &Transform| Geometry::Instance(Instance { bvh: Arc::clone(&self.nested), to_world });
        [self.room.geometry()].into_iter().chain(self.to_world.iter().map(placed)).collect()
    }

    fn normal(&self, hit: &Hit) -> Vec3 {
        if hit.instance == Hit::NO_INSTANCE {
            return self.room.normal(hit.prim);
        }
        let place = &self.to_world[hit.instance as usize - 1];
        place.normal(self.mesh.normal(hit.prim)).try_normalize().unwrap_or(Vec3::Y)
    }

    /// What the nested hierarchy of an instance answers.
    fn by_hand(&self, instance: u32, ray: &Ray) -> Hit {
        let local = in_space_of(&self.to_world[instance as usize - 1], ray);
        let hit = self.nested.closest(&local);
        if hit.is_hit() { Hit { instance, ..hit } } else { hit }
    }

    fn check(&self, bvh: &Bvh, rays: &[Ray], check: &mut Check) {
        let mut hits = vec![Hit::MISS; rays.len()];
        Batch(bvh).closest(rays, &mut hits);
        let inside = || rays.iter().zip(&hits).filter(|(_, hit)| hit.instance != Hit::NO_INSTANCE);
        for (ray, hit) in inside() {
            check.repeated += 1;
            check.differing += usize::from(bits(hit) != bits(&self.by_hand(hit.instance, ray)));
        }
        let step = (inside().count() / EXHAUSTIVE).max(1);
        for (ray, hit) in inside().step_by(step).take(EXHAUSTIVE) {
            let all = (1..=self.to_world.len() as u32).map(|instance| self.by_hand(instance, ray));
            // Of equal distances the first instance counts.
            let nearest = all.fold(Hit::MISS, |best, hit| if hit.t < best.t { hit } else { best });
            check.exhaustive += 1;
            check.wrong += usize::from(bits(hit) != bits(&nearest));
        }
    }
}

/// A place in the cell of a grid: turned at random, stretched along its axes, moved a little.
fn turned(rng: &mut Pcg32, cell: DVec3) -> DAffine3 {
    let (a, b) = (direction(rng).as_dvec3(), direction(rng).as_dvec3());
    let x = a.normalize_or(DVec3::X);
    let y = x.cross(b).normalize_or(x.any_orthonormal_vector());
    let axes = DMat3::from_cols(x, y, x.cross(y));
    let mut size = || 0.15 + 0.25 * rng.next_f64();
    let stretch = DMat3::from_diagonal(DVec3::new(size(), size(), size()));
    let mut aside = || 0.4 * (rng.next_f64() - 0.5);
    let moved = cell + DVec3::new(aside(), aside(), aside());
    DAffine3 { matrix3: axes * stretch, translation: moved }
}

/// The ray in an instance's space, as the library documents it: computed in double precision with the entries of the
/// rounded inverse, rounded once; distances stay what they are.
fn in_space_of(place: &Transform, ray: &Ray) -> Ray {
    let inverse = place.inverse();
    let columns = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| inverse.vector(axis).as_dvec3());
    let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let translation = inverse.point(Vec3::ZERO).as_dvec3();
    let origin = (linear * ray.origin.as_dvec3() + translation).as_vec3();
    Ray::new(origin, (linear * ray.dir.as_dvec3()).as_vec3(), ray.t_min, ray.t_max)
}

fn bits(hit: &Hit) -> [u32; 5] {
    [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim, hit.instance]
}
