//! Caustics of spheres: light that reaches a surface by way of a perfectly smooth sphere.
//!
//! A path finds a small light behind a glass or mirror ball by luck alone. Here a point of a light is chosen first, then the
//! ways from the surface to it by way of a ball are computed: off its outside, or straight through it ([`connect`]). The
//! density of such a way's first direction follows from that of the light's point and the widening of the bundle of rays
//! around it ([`Tube`]), so both techniques are weighed by the power heuristic like any others. Sources: manifold
//! next-event estimation \[Hanika2015\], of which this is the case with closed forms.

use super::connect::{self, Target, Through};
use super::tube::Tube;
use super::{PathState, PathTracer, Vertex, power_heuristic};
use crate::bsdf::{Scatter, Transport};
use crate::integrator::Step;
use crate::integrator::shadow::{ray_before, shadow_ray_to};
use crate::light::LightSample;
use crate::scene::{NOT_SPECULAR, Scene, SpecularSphere, SurfacePoint};
use penombre_bvh::Ray;
use penombre_math::rounding::{UNIT_ROUNDOFF, offset_origin};
use penombre_math::{DVec3, Spectrum, Vec2, Vec3};

/// How far a path has come by way of a ball since the last surface that scatters diffusely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    stage: Stage,
    sphere: u32,
    tube: Tube,
    /// Density of the way's first direction and of what was chosen since, 1/sr.
    pdf: f32,
    /// Probability with which ways were sought from the surface.
    share: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Not by way of a ball, or by another way than those that are sought.
    Other,
    /// Straight from the surface.
    Begun,
    /// Within the ball.
    Inside,
    /// Off the outside of the ball.
    Mirrored,
    /// Through the ball.
    Through,
}

impl Chain {
    /// None.
    pub const NONE: Self =
        Self { stage: Stage::Other, sphere: NOT_SPECULAR, tube: Tube::ZERO, pdf: 0.0, share: 0.0 };

    /// Of a path that leaves a surface at which ways were sought with the probability `share`.
    pub fn begin(pdf: f32, share: f32) -> Self {
        Self { stage: Stage::Begun, pdf, share, ..Self::NONE }
    }

    /// True if the light that the path meets now may have been found from the surface, too.
    #[inline]
    pub fn is_complete(&self) -> bool {
        matches!(self.stage, Stage::Mirrored | Stage::Through)
    }

    /// After a delta reflection or transmission at a surface; `probability` is that of the choice, `cos` and `cos_t` those
    /// of the angles before and behind.
    pub fn extend(self, scene: &Scene, at: &SurfacePoint, turn: &Turn) -> Self {
        let index = scene.specular_sphere_of(at.shape);
        if index == NOT_SPECULAR || self.stage == Stage::Other {
            return Self::NONE;
        }
        let sphere = &scene.specular_spheres()[index as usize];
        let radius = sphere.radius as f32;
        let Turn { cos, cos_t, eta, transmitted, probability } = *turn;
        let pdf = self.pdf * probability;
        let start = Tube::start(at.t);
        let (stage, tube) = match (self.stage, transmitted, at.outside()) {
            (Stage::Begun, false, true) => (Stage::Mirrored, start.mirrored(cos, radius)),
            (Stage::Begun, true, true) => (Stage::Inside, start.refracted(cos, cos_t, eta, radius)),
            (Stage::Inside, true, false) if index == self.sphere => {
                (Stage::Through, self.tube.advance(at.t).refracted(cos, cos_t, eta, -radius))
            }
            _ => return Self::NONE,
        };
        Self { stage, sphere: index, tube, pdf, ..self }
    }
}

/// A delta reflection or transmission.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    pub cos: f32,
    pub cos_t: f32,
    /// Index behind over that before.
    pub eta: f32,
    pub transmitted: bool,
    pub probability: f32,
}

/// The density of a way's first direction, 1/sr, from that of the light's point per area of its surface, 1/m²; `cos` is that of
/// the angle at which the way meets the surface.
fn by_area(pdf: f32, cos: f32, tube: &Tube) -> f32 {
    pdf * tube.area() / cos.abs()
}

impl PathTracer {
    /// The weight of light from a surface that a path met by way of a ball.
    pub(super) fn weight_of_met(&self, scene: &Scene, chain: &Chain, at: &SurfacePoint) -> f32 {
        let sphere = &scene.specular_spheres()[chain.sphere as usize];
        let from = sphere.center.as_vec3();
        let pdf = scene.light_pdf_around(at, from, sphere.radius);
        let pdf = pdf * chain.share * probability(scene, sphere, chain.stage == Stage::Through);
        power_heuristic(chain.pdf, by_area(pdf, at.wo.dot(at.ng), &chain.tube.advance(at.t)))
    }

    /// The same of light from infinity.
    pub(super) fn weight_of_escaped(&self, scene: &Scene, chain: &Chain, pdf: f32) -> f32 {
        let sphere = &scene.specular_spheres()[chain.sphere as usize];
        let pdf = pdf * chain.share * probability(scene, sphere, chain.stage == Stage::Through);
        power_heuristic(chain.pdf, pdf * chain.tube.solid_angle())
    }

    /// Asks for the light of one emitter by way of one ball.
    #[inline(always)]
    pub(super) fn add_caustics(
        &self,
        scene: &Scene,
        path: &PathState,
        v: &Vertex<'_>,
        sought: Sought,
        light: &LightSample,
        out: &mut Step<'_, PathState>,
    ) {
        if light.is_delta && light.is_directed {
            return;
        }
        let sphere = &scene.specular_spheres()[sought.sphere as usize];
        let probability = v.caustics * probability(scene, sphere, sought.through);
        let way = Way { sphere, light, v, pdf: light.pdf * probability };
        if !sought.through && path.depth + 2 <= self.max_depth {
            way.mirrored(|found| self.add_way(path, v, &found, out));
        }
        if sought.through && path.depth + 3 <= self.max_depth {
            way.through(|found| self.add_way(path, v, &found, out));
        }
    }

    /// Asks for the light of a way.
    fn add_way(&self, path: &PathState, v: &Vertex<'_>, found: &Found<'_>, out: &mut Step<'_, PathState>) {
        let Some(origin) = v.at.leave(found.wi) else { return };
        let eval = v.bsdf.eval(v.wo, v.frame.to_local(found.wi), Transport::Radiance);
        let own = found.pdf;
        // Also false for NaN.
        if !(own > 0.0 && own < f32::INFINITY) || eval.f_cos.is_black() {
            return;
        }
        let weight = if found.is_delta { 1.0 } else { power_heuristic(own, eval.pdf * found.probability) };
        let radiance = path.throughput * eval.f_cos * found.radiance * (weight / own);
        if radiance.is_black() || !radiance.is_finite() {
            return;
        }
        let first = found.first.ray_from(origin);
        let radiance = self.limited(radiance, path.depth + 2);
        out.add_if_all_visible(radiance, [first].into_iter().chain(found.rays.iter().copied()));
    }
}

/// What is sought: light by way of which ball, and through it or off its outside.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sought {
    pub sphere: u32,
    pub through: bool,
    pub is_tried: bool,
}

/// Share of the tries that seek a way off the outside of a ball of glass: little light goes there.
const MIRRORED_SHARE: f32 = 0.2;

impl Sought {
    /// With the probability `share` and by two numbers in [0, 1): all balls alike.
    #[inline]
    pub fn choose(spheres: &[SpecularSphere], u: Vec2, share: f32) -> Self {
        let scaled = u.x * spheres.len() as f32;
        let index = (scaled as usize).min(spheres.len() - 1);
        let rest = scaled - index as f32;
        let through = spheres[index].ior.is_some() && rest >= MIRRORED_SHARE;
        Self { sphere: index as u32, through, is_tried: u.y < share }
    }
}

/// Probability with which [`Sought::choose`] chooses a ball and the way through it or off it.
#[inline]
fn probability(scene: &Scene, sphere: &SpecularSphere, through: bool) -> f32 {
    let share = match (sphere.ior, through) {
        (None, through) => f32::from(u8::from(!through)),
        (Some(_), false) => MIRRORED_SHARE,
        (Some(_), true) => 1.0 - MIRRORED_SHARE,
    };
    share / scene.specular_spheres().len() as f32
}

/// A way that was found, before it is weighed.
struct Found<'a> {
    /// First direction, unit.
    wi: Vec3,
    /// Where it meets the ball.
    first: BallPoint,
    /// What must be free beyond.
    rays: &'a [Ray],
    /// Density of the first direction, 1/sr.
    pdf: f32,
    /// What the light's radiance becomes on its way.
    radiance: Spectrum,
    /// Probability with which a path takes the same turns.
    probability: f32,
    is_delta: bool,
}

/// A point of a ball.
#[derive(Clone, Copy)]
struct BallPoint {
    p: Vec3,
    /// Bound per axis on how far it lies off the ball, metres.
    error: Vec3,
    /// To the outside, unit.
    normal: Vec3,
}

impl BallPoint {
    fn origin_toward(&self, dir: Vec3) -> Vec3 {
        offset_origin(self.p, self.error, self.normal, dir)
    }

    /// The ray that ends here.
    fn ray_from(&self, origin: Vec3) -> Ray {
        ray_before(origin, self.p, self.error, self.normal)
    }
}

/// The ball and light between which ways are sought.
struct Way<'a> {
    sphere: &'a SpecularSphere,
    light: &'a LightSample,
    v: &'a Vertex<'a>,
    /// Density of the light's direction from the centre, all choices included, 1/sr.
    pdf: f32,
}

impl Way<'_> {
    fn target(&self) -> Target {
        if self.light.distance == f32::INFINITY {
            Target::Direction(self.light.wi.as_dvec3())
        } else {
            Target::Point(self.light.point.as_dvec3())
        }
    }

    /// A point of the ball by its normal.
    fn point(&self, n: DVec3) -> BallPoint {
        let s = self.sphere;
        let p = (s.center + n * s.radius).as_vec3();
        let reach = (s.center.abs().max_element() + s.radius) as f32;
        let error = p.abs() * (2.0 * UNIT_ROUNDOFF) + Vec3::splat(reach * UNIT_ROUNDOFF * 1e-3);
        BallPoint { p, error, normal: n.as_vec3() }
    }

    /// The last part of a way: its ray, its length and its direction.
    fn last(&self, from: &BallPoint) -> (Ray, f32, Vec3) {
        if self.light.distance == f32::INFINITY {
            let wi = self.light.wi;
            return (Ray::new(from.origin_toward(wi), wi, 0.0, f32::INFINITY), f32::INFINITY, wi);
        }
        let to = self.light.point - from.p;
        let length = to.length();
        (shadow_ray_to(from.origin_toward(to), self.light), length, to * (1.0 / length))
    }

    /// The density of the first direction, from the bundle before its last part.
    fn density(&self, tube: Tube, (length, wi): (f32, Vec3)) -> f32 {
        let light = self.light;
        if length == f32::INFINITY {
            return self.pdf * tube.solid_angle();
        }
        let square = light.distance * light.distance;
        let (pdf, cos) = if light.normal == Vec3::ZERO {
            (self.pdf / square, 1.0)
        } else {
            let [center, point] = [light.wi, wi].map(|w| -w.dot(light.normal));
            match light.by_area {
                true if point > 0.0 => (self.pdf, point),
                // It shines to the side of the centre.
                false if center * point > 0.0 => (self.pdf * center.abs() / square, point),
                _ => return 0.0,
            }
        };
        by_area(pdf, cos, &tube.advance(length))
    }

    /// By a reflection off the outside.
    #[inline(always)]
    fn mirrored(&self, mut tell: impl FnMut(Found<'_>)) {
        let (s, from) = (self.sphere, self.v.at.p);
        let Some(n) = connect::mirror_point(from.as_dvec3(), self.target(), s.center, s.radius) else {
            return;
        };
        let first = self.point(n);
        let to = first.p - from;
        let distance = to.length();
        let wi = to * (1.0 / distance);
        let cos = -wi.dot(n.as_vec3());
        let Some(lobe) = s.bsdf.delta_lobe(local(cos), false).filter(|_| cos > 0.0) else { return };
        let (ray, length, last) = self.last(&first);
        let tube = Tube::start(distance).mirrored(cos, s.radius as f32);
        tell(Found {
            wi,
            first,
            rays: &[ray],
            pdf: self.density(tube, (length, last)),
            radiance: self.light.radiance * lobe.weight,
            probability: lobe.pdf,
            is_delta: self.light.is_delta,
        });
    }

    /// By two refractions.
    #[inline(always)]
    fn through(&self, mut tell: impl FnMut(Found<'_>)) {
        let (s, from) = (self.sphere, self.v.at.p);
        let Some(ior) = s.ior else { return };
        for way in connect::ways_through(from.as_dvec3(), self.target(), s.center, s.radius, ior) {
            if let Some((found, rays)) = self.passage(&way, from, ior as f32) {
                tell(Found { rays: &rays, ..found });
            }
        }
    }

    fn passage(&self, way: &Through, from: Vec3, ior: f32) -> Option<(Found<'static>, [Ray; 2])> {
        let (s, radius) = (self.sphere, self.sphere.radius as f32);
        let (first, second) = (self.point(way.entry), self.point(way.exit));
        let (entry, exit) = (first.normal, second.normal);
        let (to, across) = (first.p - from, second.p - first.p);
        let (distance, chord) = (to.length(), across.length());
        let (wi, inside) = (to * (1.0 / distance), across * (1.0 / chord));
        let (ray, length, last) = self.last(&second);
        let cosines = [-wi.dot(entry), -inside.dot(entry), inside.dot(exit), last.dot(exit)];
        if cosines.iter().any(|c| *c < 1e-3) {
            return None;
        }
        let [cos_in, cos_within, cos_before, cos_out] = cosines;
        let enter = s.bsdf.delta_lobe(local(cos_in), true)?;
        let leave = s.bsdf.delta_lobe(local(-cos_before), true)?;
        let tube = Tube::start(distance).refracted(cos_in, cos_within, ior, radius);
        let tube = tube.advance(chord).refracted(cos_before, cos_out, 1.0 / ior, -radius);
        let within = second.ray_from(first.origin_toward(inside));
        let found = Found {
            wi,
            first,
            rays: &[],
            pdf: self.density(tube, (length, last)),
            radiance: self.light.radiance * enter.weight * leave.weight,
            probability: enter.pdf * leave.pdf,
            is_delta: self.light.is_delta,
        };
        Some((found, [within, ray]))
    }
}

/// A direction of the local frame with that cosine.
fn local(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}
