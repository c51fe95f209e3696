//! `path`: unidirectional path tracing.
//!
//! At each surface point light is gathered twice: from a direction towards a chosen light (next-event estimation) and
//! where the path goes on by chance; the two are weighed by the power heuristic \[Veach1997\]. Paths end by Russian
//! roulette on the square root of their throughput, or after `max_depth` segments.
//!
//! ```toml
//! [integrator.path]
//! roulette_depth = 5      # segments before Russian roulette begins
//! caustics = true         # light is sought by way of perfect mirror and glass spheres
//! clamp = 10              # largest radiance of indirect light per sample; none unless given
//! ```

mod caustic;
mod connect;
mod tube;

use super::shadow::shadow_ray_to;
use super::wavefront::Batched;
use super::{AnyIntegrator, Arrival, Arrivals, Integrator, PathPlace, Step};
use crate::bsdf::{Bsdf, BsdfSample, Scatter, Transport};
use crate::light::{Escaped, LightSample};
use crate::registry::Context;
use crate::sampler::{self, Dimension, Series};
use crate::scene::{LightSamples, NO_EMITTER, Scene, SurfacePoint};
use caustic::{Chain, Sought, Turn};
use penombre_bvh::Ray;
use penombre_math::{Frame, Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, Node, ParamDefault, ParamSpec, Range, Role};
use penombre_sys::{Vectorizable, vectorize};

/// Survival by Russian roulette is no more probable than this, so that paths between white walls end.
const MOST_SURVIVAL: f32 = 0.99;

/// The path tracer.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTracer {
    max_depth: u32,
    roulette_depth: u32,
    clamp: f32,
    caustics: bool,
}

/// What a path remembers between bounces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathState {
    throughput: Spectrum,
    /// Where the ray left the last surface.
    from: Vec3,
    /// Density of the ray's direction, 1/sr.
    pdf: f32,
    /// Segments, this one included.
    depth: u32,
    /// Product of the squares of relative indices of refraction that radiance was scaled by.
    eta_square: f32,
    /// True if lights could not have been sampled in this direction.
    is_delta: bool,
    refracted: bool,
    /// How it came by way of a ball.
    chain: Chain,
}

/// Uses of sample points at a vertex.
mod uses {
    /// Direction towards the light.
    pub const LIGHT: u32 = 0;
    /// Direction of the BSDF.
    pub const BSDF: u32 = 1;
    /// Which light; which lobe.
    pub const CHOICES: u32 = 2;
    /// Which model of a mix; Russian roulette.
    pub const FATE: u32 = 3;
    /// Which ball, for caustics.
    pub const BALL: u32 = 4;
    /// Which point of the light.
    pub const BALL_LIGHT: u32 = 5;
}

impl PathTracer {
    /// Its name in scene files.
    pub const NAME: &'static str = "path";

    /// The parameters of `[integrator.path]`.
    pub const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "roulette_depth",
            Kind::Int(Range::closed(1.0, 65536.0)),
            ParamDefault::Int(5),
            "Path segments before Russian roulette may end a path.",
        ),
        ParamSpec::with_default(
            "caustics",
            Kind::Bool,
            ParamDefault::Bool(true),
            "Light is sought by way of spheres that mirror or refract perfectly.",
        ),
        ParamSpec::optional(
            "clamp",
            Kind::Float(Range::POSITIVE),
            "Largest radiance of a sample's indirect light: fewer bright specks, but a darker image.",
        )
        .unit("W/(sr m²)"),
    ];

    /// Decodes the `[integrator.path]` node, or takes the defaults if there is none.
    pub fn build(context: &mut Context<'_, '_>, max_depth: u32) -> Box<dyn AnyIntegrator> {
        let default = Node::new(Role::Integrator, Self::NAME, Self::NAME);
        let found = context.description.find(Role::Integrator, Self::NAME);
        let node = found.map_or(&default, |id| context.description.node(id));
        let p: Params = context.decode(node, Self::SCHEMA);
        let path = Self {
            max_depth,
            roulette_depth: p.int("roulette_depth") as u32,
            caustics: p.bool("caustics"),
            clamp: p.opt_f32("clamp").unwrap_or(f32::INFINITY),
        };
        Box::new(Batched(path, Self::NAME))
    }

    /// Adds light that reached the sample after `depth` segments.
    #[inline]
    fn limited(&self, radiance: Spectrum, depth: u32) -> Spectrum {
        let most = radiance.max_component();
        if depth > 2 && most > self.clamp { radiance * (self.clamp / most) } else { radiance }
    }

    /// Adds what the surface that was met emits.
    #[inline]
    fn add_emitted(&self, scene: &Scene, path: &PathState, at: &SurfacePoint, out: &mut Step<'_, PathState>) {
        let emitted = scene.emitted(at);
        if emitted.is_black() {
            return;
        }
        let weight = if path.chain.is_complete() {
            self.weight_of_met(scene, &path.chain, at)
        } else if path.is_delta {
            1.0
        } else {
            power_heuristic(path.pdf, scene.light_pdf(at, path.from, -at.wo, at.t))
        };
        out.add(self.limited(path.throughput * emitted * weight, path.depth));
    }

    /// Adds what comes from infinity along `dir`.
    fn add_escaped(&self, scene: &Scene, path: &PathState, dir: Vec3, out: &mut Step<'_, PathState>) {
        for Escaped { radiance, pdf } in scene.escaped(dir) {
            let weight = if path.chain.is_complete() {
                self.weight_of_escaped(scene, &path.chain, pdf)
            } else if path.is_delta {
                1.0
            } else {
                power_heuristic(path.pdf, pdf)
            };
            let radiance = path.throughput * radiance * weight;
            if !radiance.is_black() {
                out.add(self.limited(radiance, path.depth));
            }
        }
    }

    /// Asks for the light of one emitter from one direction.
    #[inline(always)]
    fn add_light(
        &self,
        path: &PathState,
        v: &Vertex<'_>,
        light: &LightSample,
        out: &mut Step<'_, PathState>,
    ) {
        let Some(origin) = v.at.leave(light.wi) else { return };
        let eval = v.bsdf.eval(v.wo, v.frame.to_local(light.wi), Transport::Radiance);
        let weight = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, eval.pdf) };
        let radiance = path.throughput * eval.f_cos * light.radiance * (weight / light.pdf);
        if radiance.is_black() {
            return;
        }
        let ray = if light.distance == f32::INFINITY {
            Ray::new(origin, light.wi, 0.0, f32::INFINITY)
        } else {
            shadow_ray_to(origin, light)
        };
        out.add_if_visible(self.limited(radiance, path.depth + 1), |rays| rays.push(ray));
    }

    /// Chooses where the path goes on, if it does.
    #[inline(always)]
    fn extend(&self, scene: &Scene, path: &PathState, v: &Vertex<'_>, out: &mut Step<'_, PathState>) {
        let Some(s) = v.bsdf.sample(v.wo, [v.u.x, v.u.y, v.choices.y], Transport::Radiance) else { return };
        let wi = v.frame.to_world(s.wi);
        let origin = if s.is_delta {
            (!crosses(&s, v.at, wi)).then(|| v.at.origin_toward(wi))
        } else {
            v.at.leave(wi)
        };
        let Some(origin) = origin else { return };
        let mut next = PathState {
            throughput: path.throughput * s.weight,
            from: v.at.p,
            pdf: s.pdf,
            depth: path.depth + 1,
            eta_square: path.eta_square * s.eta * s.eta,
            is_delta: s.is_delta,
            refracted: s.is_transmission,
            chain: self.chain(scene, path, v, &s),
        };
        if next.throughput.is_black() || !self.survives(&mut next, v) {
            return;
        }
        out.follow(next, Ray::new(origin, wi, 0.0, f32::INFINITY));
    }

    /// How the next ray goes on by way of a ball.
    #[inline]
    fn chain(&self, scene: &Scene, path: &PathState, v: &Vertex<'_>, s: &BsdfSample) -> Chain {
        if !self.caustics || scene.specular_spheres().is_empty() {
            return Chain::NONE;
        }
        if !s.is_delta {
            return if v.asks_light { Chain::begin(s.pdf, v.caustics) } else { Chain::NONE };
        }
        let turn = Turn {
            cos: v.wo.z.abs(),
            cos_t: s.wi.z.abs(),
            eta: s.eta,
            transmitted: s.is_transmission,
            probability: s.pdf,
        };
        path.chain.extend(scene, v.at, &turn)
    }

    /// Russian roulette: a path survives with the square root of what it can still bring, scaled back to what it was before
    /// refractions. (Measured against the throughput itself: 6 to 10 % less error in the same time.)
    #[inline]
    fn survives(&self, next: &mut PathState, v: &Vertex<'_>) -> bool {
        if next.depth <= self.roulette_depth {
            return true;
        }
        let survival = (next.throughput.max_component() * next.eta_square).sqrt().min(MOST_SURVIVAL);
        if v.fate >= survival {
            return false;
        }
        next.throughput = next.throughput * (1.0 / survival);
        true
    }

    /// What paths do where they are: emitted light is added, and those that go on become vertices.
    #[inline(always)]
    fn arrive<'a>(
        &self,
        scene: &Scene,
        arrivals: &'a Arrivals<'_, PathState>,
        vertices: &mut Vec<Vertex<'a>>,
        out: &mut Step<'_, PathState>,
    ) {
        let samples_light = scene.samples_light();
        for index in 0..arrivals.len() {
            let Arrival { path, ray, at, sampler } = arrivals.get(index, out);
            let Some(at) = at else {
                self.add_escaped(scene, path, ray.dir, out);
                continue;
            };
            if at.emitter != NO_EMITTER {
                self.add_emitted(scene, path, at, out);
            }
            if path.depth >= self.max_depth {
                continue;
            }
            let number = |of| sampler.get_2d(Dimension::of_node(path.depth, of));
            let fate = if scene.has_mixes() || path.depth >= self.roulette_depth {
                number(uses::FATE)
            } else {
                Vec2::ZERO
            };
            let bsdf = scene.bsdf(at, fate.x);
            let frame = Frame::from_z(at.ns);
            let asks_light = samples_light && !bsdf.is_delta_only();
            let chooses = bsdf.uses_lobe_choice() || asks_light && scene.has_several_emitters();
            vertices.push(Vertex {
                at,
                frame,
                wo: at.local_wo(&frame),
                bsdf,
                index: index as u32,
                asks_light,
                fate: fate.y,
                choices: if chooses { number(uses::CHOICES) } else { Vec2::ZERO },
                u: Vec2::ZERO,
                caustics: (path.throughput.max_component() * path.eta_square).min(1.0),
            });
        }
    }

    /// Directions towards lights and of BSDFs for all vertices at once.
    fn draw(&self, arrivals: &Arrivals<'_, PathState>, vertices: &mut [Vertex<'_>], memory: &mut PathMemory) {
        let PathMemory { series, points, .. } = memory;
        series.clear();
        points.clear();
        for v in vertices.iter() {
            let (path, sampler) = arrivals.origin(v.index as usize);
            let one = |of| (sampler.series(Dimension::of_node(path.depth, of), 1), 1);
            series.extend([one(uses::BSDF), one(uses::LIGHT)]);
        }
        sampler::fill(series, points);
        for (v, points) in vertices.iter_mut().zip(points.as_chunks::<2>().0) {
            v.u = Vec2::from(points[0]);
        }
    }

    /// Balls and lights for the caustics of all vertices at once.
    fn draw_caustics(
        &self,
        scene: &Scene,
        arrivals: &Arrivals<'_, PathState>,
        vertices: &[Vertex<'_>],
        memory: &mut PathMemory,
    ) {
        let PathMemory { series, points, sought, lights, seen, ball_lights } = memory;
        sought.clear();
        ball_lights.clear();
        let spheres = scene.specular_spheres();
        if !self.caustics || spheres.is_empty() {
            return;
        }
        series.clear();
        points.clear();
        let asking = || vertices.iter().filter(|v| v.asks_light);
        for v in asking() {
            let (path, sampler) = arrivals.origin(v.index as usize);
            let one = |of| (sampler.series(Dimension::of_node(path.depth, of), 1), 1);
            series.extend([one(uses::BALL), one(uses::BALL_LIGHT)]);
        }
        sampler::fill(series, points);
        let points = points.as_chunks::<2>().0;
        let choose = |(v, [choice, _]): (&Vertex<'_>, &[[f32; 2]; 2])| {
            Sought::choose(spheres, Vec2::from(*choice), v.caustics)
        };
        sought.extend(asking().zip(points).map(choose));
        // From infinity light comes from the same direction wherever one is.
        let is_far = |light: &Option<LightSample>| light.is_some_and(|l| l.distance == f32::INFINITY);
        let near = asking().zip(lights.answers()).zip(sought.iter().zip(points));
        let unknown = |light: &Option<LightSample>, sought: &Sought| !is_far(light) && sought.is_tried;
        let wanted = near.filter(|((_, light), (sought, _))| unknown(light, sought)).map(
            |((v, _), (sought, [_, u]))| {
                let ball = &spheres[sought.sphere as usize];
                (ball.center.as_vec3(), ball.radius, v.choices.x, Vec2::from(*u))
            },
        );
        scene.sample_lights_around(wanted, seen);
        let mut seen = seen.answers().iter();
        ball_lights.extend(lights.answers().iter().zip(sought.iter()).map(|(light, sought)| {
            if unknown(light, sought) { *seen.next()? } else { light.filter(|_| sought.is_tried) }
        }));
    }
}

/// True if a mirrored or refracted direction is on the wrong side of the true surface, which interpolated normals can bring
/// about.
#[inline]
fn crosses(s: &BsdfSample, at: &SurfacePoint, wi: Vec3) -> bool {
    (wi.dot(at.ng) * at.wo.dot(at.ng) < 0.0) != s.is_transmission
}

/// The power heuristic with exponent 2 for one sample of each of two densities \[Veach1997\]. `own` is above 0.
#[inline]
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// A surface point of a path with what scatters there.
struct Vertex<'a> {
    at: &'a SurfacePoint,
    frame: Frame,
    wo: Vec3,
    bsdf: Bsdf,
    /// Which arrival it is.
    index: u32,
    /// False where no light can be sampled.
    asks_light: bool,
    /// For Russian roulette.
    fate: f32,
    /// Which light; which lobe.
    choices: Vec2,
    /// For the direction.
    u: Vec2,
    /// Probability with which light by way of balls is sought.
    caustics: f32,
}

/// The first half of shading, as work for wider instruction sets.
struct Arriving<'w, 'a, 's, 'o> {
    tracer: &'w PathTracer,
    scene: &'w Scene,
    arrivals: &'a Arrivals<'s, PathState>,
    vertices: &'w mut Vec<Vertex<'a>>,
    out: &'w mut Step<'o, PathState>,
}

impl Vectorizable for Arriving<'_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.tracer.arrive(self.scene, self.arrivals, self.vertices, self.out);
    }
}

/// The second half.
struct Leaving<'w, 's, 'o> {
    tracer: &'w PathTracer,
    scene: &'w Scene,
    arrivals: &'w Arrivals<'s, PathState>,
    vertices: &'w [Vertex<'w>],
    lights: &'w [Option<LightSample>],
    /// Ways that are sought, and the lights to which.
    caustics: (&'w [Sought], &'w [Option<LightSample>]),
    out: &'w mut Step<'o, PathState>,
}

impl Vectorizable for Leaving<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut lights = self.lights.iter();
        let mut caustics = self.caustics.0.iter().zip(self.caustics.1);
        for v in self.vertices {
            let path = self.arrivals.get(v.index as usize, self.out).path;
            if v.asks_light
                && let Some(Some(light)) = lights.next()
            {
                self.tracer.add_light(path, v, light, self.out);
            }
            if v.asks_light
                && let Some((sought, Some(light))) = caustics.next()
            {
                self.tracer.add_caustics(self.scene, path, v, *sought, light, self.out);
            }
            self.tracer.extend(self.scene, path, v, self.out);
        }
    }
}

/// Lists of [`PathTracer::shade`].
#[derive(Debug, Default)]
pub struct PathMemory {
    series: Vec<(Series, u32)>,
    points: Vec<[f32; 2]>,
    lights: LightSamples,
    sought: Vec<Sought>,
    /// Light samples of those that are not at infinity, from the balls.
    seen: LightSamples,
    ball_lights: Vec<Option<LightSample>>,
}

impl Integrator for PathTracer {
    type Path = PathState;
    type Memory = PathMemory;

    fn start(&self) -> PathState {
        PathState {
            throughput: Spectrum::WHITE,
            from: Vec3::ZERO,
            pdf: 1.0,
            depth: 1,
            eta_square: 1.0,
            is_delta: true,
            refracted: false,
            chain: Chain::NONE,
        }
    }

    fn shade(
        &self,
        scene: &Scene,
        arrivals: &Arrivals<'_, PathState>,
        memory: &mut PathMemory,
        out: &mut Step<'_, PathState>,
    ) {
        let mut vertices = Vec::with_capacity(arrivals.len());
        vectorize(Arriving { tracer: self, scene, arrivals, vertices: &mut vertices, out });
        self.draw(arrivals, &mut vertices, memory);
        let PathMemory { points, lights, .. } = memory;
        let asking = vertices.iter().zip(points.as_chunks::<2>().0).filter(|(v, _)| v.asks_light);
        scene.sample_lights(asking.map(|(v, u)| (v.at.p, v.choices.x, Vec2::from(u[1]))), lights);
        self.draw_caustics(scene, arrivals, &vertices, memory);
        let PathMemory { lights, sought, ball_lights, .. } = memory;
        vectorize(Leaving {
            tracer: self,
            scene,
            arrivals,
            vertices: &vertices,
            lights: lights.answers(),
            caustics: (sought, ball_lights),
            out,
        });
    }

    fn clamp(&self) -> Option<f32> {
        self.clamp.is_finite().then_some(self.clamp)
    }

    fn place(&self, path: &PathState) -> PathPlace {
        let origin = match (path.depth, path.refracted) {
            (1, _) => "camera",
            (_, true) => "refraction",
            (_, false) => "reflection",
        };
        PathPlace { depth: path.depth - 1, node: path.depth, weight: path.throughput, origin }
    }
}
