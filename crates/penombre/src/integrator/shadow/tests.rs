//! Lamps close before a wall: their own surfaces stop no ray, and what stands between does.

use super::*;
use crate::scene::SurfacePoint;
use crate::testing::from_toml;
use penombre_bvh::Hit;
use penombre_lab::{Moments, Pcg32};
use penombre_math::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Sides of the lamp, metres; the wall's are 2 m.
const SIDES: [f64; 2] = [0.5, 0.4];

/// Where the wall's middle is, and its axes; the last one is its normal.
#[derive(Clone, Copy)]
struct Place {
    middle: DVec3,
    axes: [DVec3; 3],
    scale: f64,
}

impl Place {
    fn new(tilted: bool, scale: f64) -> Self {
        let n = if tilted { DVec3::new(0.48, -0.6, 0.64) } else { DVec3::Y };
        let x = n.cross(DVec3::new(0.3, 0.2, 1.0)).normalize();
        let x = if tilted { x } else { DVec3::Z };
        Self { middle: DVec3::new(1.1, -0.7, 0.9), axes: [x, n.cross(x), n], scale }
    }

    /// A point as TOML, by its coordinates in the frame.
    fn point(&self, at: [f64; 3]) -> String {
        let p = (self.middle + self.offset(at)) * self.scale;
        format!("[{:e}, {:e}, {:e}]", p.x, p.y, p.z)
    }

    fn vector(&self, of: [f64; 3]) -> String {
        let v = self.offset(of) * self.scale;
        format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z)
    }

    fn offset(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.axes[0] * x + self.axes[1] * y + self.axes[2] * z
    }

    fn quad(&self, name: &str, [a, b]: [f64; 2], height: f64, rest: &str) -> String {
        let corner = self.point([0.5 * a, -0.5 * b, height]);
        let sides = [self.vector([-a, 0.0, 0.0]), self.vector([0.0, b, 0.0])].join(", ");
        format!("[{name}]\ntype = \"quad\"\norigin = {corner}\nsides = [{sides}]\n{rest}\n")
    }

    /// A lamp of each kind at a height above the wall.
    fn lamps(&self, h: f64) -> [(&'static str, String); 5] {
        let [a, b] = SIDES;
        let (l, glow) =
            ("radiance = [1, 1, 1]", "[material.glow]\ntype = \"emissive\"\nradiance = [1, 1, 1]\n");
        let corners = [[0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
        let corners = corners.map(|[x, y]| self.point([x * a, y * b, h])).join(", ");
        let (disk, ball) = (self.point([0.0, 0.0, h]), self.point([0.0, 0.0, h + 0.2]));
        let (r, down) = (0.2 * self.scale, self.vector([0.0, 0.0, -1.0]));
        [
            ("quad", self.quad("light.lamp", SIDES, h, l)),
            ("quad shape", glow.to_owned() + &self.quad("shape.lamp", SIDES, h, "material = \"glow\"")),
            (
                "mesh",
                format!(
                    "{glow}[shape.lamp]\ntype = \"mesh\"\npositions = [{corners}]\nfaces = [[0, 1, 2], [0, 2, 3]]\nmaterial = \"glow\"\n"
                ),
            ),
            (
                "disk",
                format!(
                    "[light.lamp]\ntype = \"disk\"\ncenter = {disk}\nnormal = {down}\nradius = {r:e}\n{l}\n"
                ),
            ),
            ("sphere", format!("[light.lamp]\ntype = \"sphere\"\ncenter = {ball}\nradius = {r:e}\n{l}\n")),
        ]
    }

    fn scene(&self, parts: &str) -> Arc<Scene> {
        let wall = self.quad("shape.wall", [-2.0, 2.0], 0.0, "material = \"matt\"");
        let (plan, out) = from_toml(&format!(
            "[render]\nintegrator = \"path\"\n[camera.main]\ntype = \"perspective\"\nposition = {}\ntarget = {}\n\
             [material.matt]\ntype = \"diffuse\"\n{wall}{parts}",
            self.point([0.3, 0.2, 3.0]),
            self.point([0.0, 0.0, 0.0])
        ));
        plan.unwrap_or_else(|| panic!("{out:?}")).scene
    }

    /// The point of the wall at two coordinates, seen from a small height.
    fn on_wall(&self, scene: &Scene, [x, y]: [f64; 2], height: f64) -> SurfacePoint {
        let origin = (self.middle + self.offset([x, y, height])) * self.scale;
        let ray = Ray::new(origin.as_vec3(), -self.axes[2].as_vec3(), 0.0, f32::INFINITY);
        let hit: Hit = scene.closest(&ray);
        scene.surface(&ray, &hit).unwrap()
    }
}

/// The light of one sample at the wall before its shadow, 1/π of its irradiance, and if it is blocked.
fn one(scene: &Scene, at: &SurfacePoint, normal: Vec3, rng: &mut Pcg32) -> Option<(f64, bool)> {
    let u = Vec2::new(rng.next_f32(), rng.next_f32());
    let light = scene.sample_light(at.p, rng.next_f32(), u)?;
    let origin = at.leave(light.wi)?;
    let mut blocked = [false];
    scene.occluded_batch(&[shadow_ray_to(origin, &light)], &mut blocked);
    Some((f64::from(light.wi.dot(normal) / light.pdf), blocked[0]))
}

/// Places, heights and what they are called.
fn all(mut tell: impl FnMut(&str, Place, f64)) {
    for scale in [1e-3, 1.0, 1e3] {
        for tilted in [false, true] {
            for height in [1e-3, 1e-4] {
                tell(&format!("{scale:e} {tilted} {height:e}"), Place::new(tilted, scale), height);
            }
        }
    }
}

#[test]
fn lamps_close_before_a_wall_do_not_hide_themselves() {
    all(|name, place, height| {
        for (kind, lamp) in place.lamps(height) {
            let free = place.scene(&lamp);
            let screen = place.quad("shape.screen", [3.0, 3.0], 0.5 * height, "material = \"matt\"");
            let hidden = place.scene(&(lamp + &screen));
            let mut rng = Pcg32::new(11);
            let (mut all, mut lost, mut leaked) = (0, 0, 0);
            for _ in 0..2000 {
                let xy = [0, 1].map(|_| 2.0 * rng.next_f64() - 1.0);
                let at = place.on_wall(&free, xy, 0.25 * height);
                let Some((_, blocked)) = one(&free, &at, at.ng, &mut rng) else { continue };
                let Some((_, stopped)) = one(&hidden, &at, at.ng, &mut rng) else { continue };
                all += 1;
                lost += i32::from(blocked);
                leaked += i32::from(!stopped);
            }
            assert!(
                all > 1900 && lost == 0 && leaked == 0,
                "{name}, {kind}: {lost} lost, {leaked} leaked of {all}"
            );
        }
    });
}

/// Under its middle a lamp gives the closed form \[Howell2010\], and where the angle is grazing that of its corners.
#[test]
fn lamps_close_before_a_wall_give_their_irradiance() {
    // Radiance 1, under a corner of a rectangle of a × b at height h.
    let corner = |a: f64, b: f64, h: f64| {
        let (x, y) = (a / h, b / h);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        0.5 * (x / p * (y / p).atan() + y / q * (x / q).atan())
    };
    let [a, b] = SIDES.map(|s| 0.5 * s);
    all(|name, place, height| {
        let scene = place.scene(&place.lamps(height)[0].1);
        for x in [0.0, 0.9 * a, a + 0.02, a + 0.3] {
            let at = place.on_wall(&scene, [x, 0.0], 0.25 * height);
            let mut rng = Pcg32::new(5);
            let sample = |_| {
                one(&scene, &at, at.ng, &mut rng).map_or(0.0, |(e, blocked)| if blocked { 0.0 } else { e })
            };
            let found: Moments = (0..4000).map(sample).collect();
            // Odd in the first length.
            let expected = 2.0 * (corner(a - x, b, height) + corner(a + x, b, height));
            let error = 4.5 * found.variance_of_mean().sqrt() + 2e-3 * expected;
            assert!((found.mean() - expected).abs() < error, "{name} {x}: {found:?}, {expected}");
            assert!(expected < PI);
        }
    });
}
