//! Cut-outs: hits of surfaces that are not entirely there.
//!
//! A hit counts if a number in [0, 1) lies below the opacity at that point. The number is a hash of the ray and the hit:
//! it depends on neither threads nor batches, and is another one for each ray, so that in the mean over rays a surface
//! of opacity α hides the share α of what lies behind.

use super::Scene;
use crate::material::Shade;
use crate::texture::TexturePoint;
use penombre_bvh::{Filter, Hit, Ray};
use penombre_math::hash::{hash_words, unit_f32};
use penombre_math::{Spectrum, Vec3};

/// The filter of hits of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutOuts<'a> {
    scene: &'a Scene,
}

impl Filter for CutOuts<'_> {
    fn accepts(&self, _: usize, ray: &Ray, hit: &Hit) -> bool {
        let opacity = self.scene.opacity(ray, hit);
        opacity >= 1.0 || (opacity > 0.0 && chance(ray, hit) < opacity)
    }
}

impl Scene {
    /// The filter that rays need; none if all surfaces are entirely there.
    #[inline]
    pub(super) fn filter(&self) -> Option<CutOuts<'_>> {
        (!self.cut_outs.is_empty()).then_some(CutOuts { scene: self })
    }

    /// For each shape, whether it has a material that is not entirely there; empty if none has.
    pub(super) fn find_cut_outs(&self) -> Vec<bool> {
        let has_opacity = |material: &u32| self.materials[*material as usize].value.has_opacity();
        let found: Vec<bool> = self.slots.iter().map(|slots| slots.iter().any(has_opacity)).collect();
        if found.contains(&true) { found } else { Vec::new() }
    }

    /// Share of the surface that is there at a hit of `ray`, holes found or not.
    pub(crate) fn opacity(&self, ray: &Ray, hit: &Hit) -> f32 {
        let index = if hit.instance == Hit::NO_INSTANCE { hit.geometry } else { hit.instance };
        let placed = &self.shapes.placed[index as usize];
        if !self.cut_outs.get(placed.shape as usize).is_some_and(|cut| *cut) {
            return 1.0;
        }
        let (uv, slot) = self.shapes.list[placed.shape as usize].value.coordinates(&placed.local(ray), hit);
        let material = self.material_of_slot(placed.shape, slot);
        self.materials[material as usize].value.opacity(&Shade {
            point: TexturePoint { uv },
            normal: Vec3::Z,
            wo: Vec3::Z,
            outside: true,
            vertex_color: Spectrum::WHITE,
            textures: &self.textures,
            materials: &self.materials,
            u: 0.0,
        })
    }
}

/// A number in [0, 1) of a ray and a hit. The distance is part of it: a ray may meet a sphere twice.
fn chance(ray: &Ray, hit: &Hit) -> f32 {
    let [ox, oy, oz] = ray.origin.to_array().map(f32::to_bits);
    let [dx, dy, dz] = ray.dir.to_array().map(f32::to_bits);
    let words = [ox, oy, oz, dx, dy, dz, hit.t.to_bits(), hit.geometry, hit.prim, hit.instance];
    unit_f32((hash_words(&words) >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Plan;
    use crate::testing::{from_toml, rendered};
    use penombre_lab::{Moments, Pcg32, kolmogorov_smirnov, sidak, z_test};

    /// Two squares [0, 1]² at z = 0 and, of the material, at z = 1; and the material's further tables.
    fn squares(material: &str) -> Plan {
        let text = format!(
            "[material.it]\n{material}\n\
            [texture.checks]\ntype = \"checker\"\nscale = [4, 4]\na = [1, 1, 1]\nb = [0, 0, 0]\n\
            [shape.back]\ntype = \"quad\"\norigin = [0, 0, 0]\nsides = [[1, 0, 0], [0, 1, 0]]\n\
            [shape.front]\ntype = \"quad\"\norigin = [0, 0, 1]\nsides = [[1, 0, 0], [0, 1, 0]]\n\
            material = \"it\"\n"
        );
        let (plan, out) = from_toml(&text);
        plan.unwrap_or_else(|| panic!("{out:?}"))
    }

    /// Rays down from random points at z = 2.
    fn rays(n: usize, seed: u64) -> Vec<Ray> {
        let mut rng = Pcg32::new(seed);
        let mut origin = || Vec3::new(rng.next_f32(), rng.next_f32(), 2.0);
        (0..n).map(|_| Ray::new(origin(), -Vec3::Z, 0.0, f32::INFINITY)).collect()
    }

    fn closest(scene: &Scene, rays: &[Ray]) -> Vec<Hit> {
        let mut hits = vec![Hit::MISS; rays.len()];
        scene.closest_batch(rays, &mut hits);
        hits
    }

    fn occluded(scene: &Scene, rays: &[Ray]) -> Vec<bool> {
        let mut blocked = vec![false; rays.len()];
        scene.occluded_batch(rays, &mut blocked);
        blocked
    }

    #[test]
    fn scenes_without_cut_outs_have_no_filter() {
        for material in
            ["type = \"glass\"", "type = \"metal\"\nopacity = 1", "type = \"phong\"\nopacity = 1.0"]
        {
            assert!(squares(material).scene.filter().is_none());
        }
        // A material that no shape has.
        let unused = "type = \"glass\"\n[material.ghost]\ntype = \"diffuse\"\nopacity = 0.5";
        assert!(squares(unused).scene.filter().is_none());
        assert!(squares("type = \"emissive\"\nopacity = 0.5").scene.filter().is_some());
    }

    /// A share of a thing that happens with this probability, among `n`.
    fn assert_share(found: usize, n: usize, probability: f64, tests: usize) {
        let n = n as f64;
        let test = z_test(found as f64 / n, probability * (1.0 - probability) / n, probability);
        assert!(test.p_value > sidak(0.01, tests), "{found} of {n}: {test:?}");
    }

    #[test]
    fn a_share_of_rays_passes() {
        let rays = rays(40_000, 1);
        let cases = [("0.5", 0.5), ("0.03", 0.03), ("0.999", 0.999), ("{ texture = \"checks\" }", 0.5)];
        for (opacity, probability) in cases {
            let plan = squares(&format!("type = \"diffuse\"\nopacity = {opacity}"));
            let hits = closest(&plan.scene, &rays);
            assert!(hits.iter().all(|h| h.t == 1.0 || h.t == 2.0));
            let front = hits.iter().filter(|h| h.t == 1.0).count();
            assert_share(front, rays.len(), probability, cases.len());
        }
        let gone = squares("type = \"glass\"\nopacity = 0");
        assert!(closest(&gone.scene, &rays).iter().all(|h| h.t == 2.0));
    }

    #[test]
    fn all_ways_to_ask_agree_whatever_the_batch() {
        let scene = &squares("type = \"mirror\"\nopacity = 0.4").scene;
        let mut rays = rays(3000, 2);
        rays.iter_mut().for_each(|r| r.t_max = 1.5);
        let (hits, blocked) = (closest(scene, &rays), occluded(scene, &rays));
        for ((ray, hit), blocked) in rays.iter().zip(&hits).zip(&blocked) {
            assert_eq!((scene.closest(ray), hit.is_hit()), (*hit, *blocked));
        }
        assert_eq!(closest(scene, &rays[7..]), hits[7..]);
        rays.reverse();
        assert!(closest(scene, &rays).iter().eq(hits.iter().rev()));
    }

    #[test]
    fn a_texture_makes_exact_holes() {
        let scene = &squares("type = \"diffuse\"\nopacity = { texture = \"checks\" }").scene;
        let rays = rays(20_000, 3);
        let solid = |r: &Ray| ((r.origin.x * 4.0) as u32 + (r.origin.y * 4.0) as u32).is_multiple_of(2);
        // Up to 1e-5 beside an edge the coordinates of a hit are rounded to the other side.
        let edge = |v: f32| (v * 4.0 - (v * 4.0).round()).abs() < 1e-5;
        let clear: Vec<Ray> = rays.into_iter().filter(|r| !edge(r.origin.x) && !edge(r.origin.y)).collect();
        for (ray, hit) in clear.iter().zip(closest(scene, &clear)) {
            assert_eq!(hit.t, if solid(ray) { 1.0 } else { 2.0 }, "{ray:?}");
        }
        // Shadow rays from the square behind: they end before a light at z = 3.
        let up = |r: &Ray| Ray::new(r.origin - Vec3::Z * 1.99, Vec3::Z, 0.0, 2.99);
        let shadows: Vec<Ray> = clear.iter().map(up).collect();
        for (ray, blocked) in shadows.iter().zip(occluded(scene, &shadows)) {
            assert_eq!(blocked, solid(ray), "{ray:?}");
        }
    }

    #[test]
    fn instances_and_both_walls_of_a_ball_decide_for_themselves() {
        let (plan, _) = from_toml(
            "[material.it]\ntype = \"diffuse\"\nopacity = 0.5\n\
            [shape.ball]\ntype = \"sphere\"\nmaterial = \"it\"\n\
            [instance.far]\nof = \"ball\"\ntransform = [{ scale = [1, 2, 1] }, { translate = [0, 0, -3] }]",
        );
        let scene = plan.unwrap().scene;
        let mut rays = rays(20_000, 4);
        rays.iter_mut().for_each(|r| r.origin = Vec3::new(r.origin.x * 0.5, r.origin.y * 0.5, 2.0));
        let hits = closest(&scene, &rays);
        let within = |from: f32, to: f32| hits.iter().filter(|h| h.t >= from && h.t < to).count();
        let walls = [within(0.0, 2.0), within(2.0, 3.5), within(3.5, 5.0), within(5.0, 7.0)];
        for (found, probability) in walls.into_iter().zip([0.5, 0.25, 0.125, 0.0625]) {
            assert_share(found, rays.len(), probability, 5);
        }
        assert_share(hits.iter().filter(|h| !h.is_hit()).count(), rays.len(), 0.0625, 5);
    }

    #[test]
    fn the_number_is_uniform_and_is_of_the_ray_and_the_hit() {
        let hit = Hit { t: 1.0, u: 0.5, v: 0.5, geometry: 1, prim: 0, instance: Hit::NO_INSTANCE };
        let rays = rays(20_000, 5);
        let mut numbers: Vec<f64> = rays.iter().map(|r| f64::from(chance(r, &hit))).collect();
        let mut product = Moments::default();
        let other = Hit { prim: 1, ..hit };
        for r in &rays {
            let centred = |hit| f64::from(chance(r, hit)) - 0.5;
            product.push(centred(&hit) * centred(&other));
        }
        let test = kolmogorov_smirnov(&mut numbers, |x| x);
        assert!(test.p_value > sidak(0.01, 2), "{test:?}");
        let test = z_test(product.mean(), product.variance_of_mean(), 0.0);
        assert!(test.p_value > sidak(0.01, 2), "{test:?}");
        let nearer = Ray { t_max: 2.0, ..rays[0] };
        assert_eq!(chance(&nearer, &hit), chance(&rays[0], &hit));
    }

    /// Digest of a picture of a square whose texture is moved on each of `copies` further ones that lie upon it.
    fn digest(copies: usize, material: &str) -> String {
        let (first, further) = ("[0, 1, 2], [0, 2, 3]", ", [4, 5, 6], [4, 6, 7]".repeat(copies));
        let corners = "[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]";
        let text = format!(
            "[render]\nsize = [24, 24]\nspp = 4\n[material.it]\ntype = \"diffuse\"\n{material}\n\
            [texture.checks]\ntype = \"checker\"\nscale = [4, 4]\na = [1, 1, 1]\nb = [0, 0, 0]\n\
            [texture.halves]\ntype = \"checker\"\nscale = [1, 2]\na = [0.2, 0.3, 0.9]\nb = [0.7, 0.2, 0.1]\n\
            [light.sky]\ntype = \"environment\"\n[camera.main]\ntype = \"perspective\"\n\
            position = [0.5, 0.4, 1.5]\ntarget = [0.5, 0.5, 0]\n\
            [shape.squares]\ntype = \"mesh\"\nmaterial = \"it\"\npositions = [{corners}, {corners}]\n\
            uvs = [[0, 0], [1, 0], [1, 1], [0, 1], [0.25, 0], [1.25, 0], [1.25, 1], [0.25, 1]]\n\
            faces = [{first}{further}]"
        );
        let (plan, out) = from_toml(&text);
        rendered(plan.unwrap_or_else(|| panic!("{out:?}"))).image().digest()
    }

    /// One copy is kept as it is, thousands are not: the picture is the same, also where the first one has holes.
    #[test]
    fn triangles_upon_others_are_seen_through_holes_alone() {
        let colors = "color = { texture = \"checks\" }";
        assert_eq!(digest(2000, colors), digest(0, colors));
        let holes = "color = { texture = \"halves\" }\nopacity = { texture = \"checks\" }";
        assert_eq!(digest(2000, holes), digest(1, holes));
        assert_ne!(digest(1, holes), digest(0, holes));
    }
}
