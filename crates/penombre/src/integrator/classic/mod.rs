//! `classic`: the ray tracer of the course.
//!
//! Phase 1 gives the diffuse colour of the nearest hit. Phase 2 shades every object by Phong's model with shadows.
//! In phase 3 objects of type `mirror` reflect instead, in phase 4 objects of type `glass` reflect and refract
//! instead. A ray that hits nothing is black.
//!
//! ```toml
//! [integrator.classic]
//! phase = 4
//! hard_shadows = false    # true: area lights act as points at their centre
//! ambient = [0, 0, 0]     # the scene's ambient light
//! max_bounces = 10        # mirror and glass; black beyond
//! ```

pub mod optics;

use super::shadow::{SoftShadow, shadow_ray};
use super::wavefront::Batched;
use super::{AnyIntegrator, Arrivals, Integrator, PathPlace, Step};
use crate::light::AnyLight;
use crate::material::{PhongView, Specular};
use crate::registry::Context;
use crate::sampler::{Dimension, Sampler};
use crate::scene::{Scene, SurfacePoint};
use optics::Refraction;
use penombre_bvh::Ray;
use penombre_math::{Spectrum, Vec3, float};
use penombre_scene::params::Params;
use penombre_scene::{Kind, Node, ParamDefault, ParamSpec, Range, Role};
use penombre_sys::{Vectorizable, vectorize};

/// The course's integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct Classic {
    phase: u8,
    hard_shadows: bool,
    ambient: Spectrum,
    max_bounces: u32,
    /// False if paths may have one segment only: then no light is asked for.
    lights: bool,
}

/// What a path of the course's ray tree remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassicPath {
    weight: Spectrum,
    node: u32,
    depth: u32,
    refracted: bool,
}

/// Shading as work for wider instruction sets.
struct Shading<'w, 's, 'o> {
    classic: &'w Classic,
    scene: &'w Scene,
    lights: &'w [LightView],
    arrivals: &'w Arrivals<'s, ClassicPath>,
    out: &'w mut Step<'o, ClassicPath>,
}

impl Vectorizable for Shading<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for index in 0..self.arrivals.len() {
            let a = self.arrivals.get(index, self.out);
            if let Some(at) = a.at {
                self.classic.step((self.scene, self.lights), a.path, at, a.sampler, self.out);
            }
        }
    }
}

/// What is asked of a light at every point, asked once.
#[derive(Clone, Copy, Debug)]
pub struct LightView {
    center: Vec3,
    /// `None` if it depends on the point.
    color: Option<Spectrum>,
    shadow_samples: u32,
}

impl LightView {
    fn of(light: &AnyLight) -> Self {
        let color = (!light.is_directed()).then(|| light.classic_color());
        Self { center: light.center(), color, shadow_samples: light.shadow_samples() }
    }
}

impl Classic {
    /// Its name in scene files.
    pub const NAME: &'static str = "classic";

    /// The parameters of `[integrator.classic]`.
    pub const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "phase",
            Kind::Int(Range::closed(1.0, 4.0)),
            ParamDefault::Int(4),
            "1 flat colour, 2 Phong and shadows, 3 and mirrors, 4 and glass.",
        ),
        ParamSpec::with_default(
            "hard_shadows",
            Kind::Bool,
            ParamDefault::Bool(false),
            "Area lights act as points at their centre.",
        ),
        ParamSpec::with_default(
            "ambient",
            Kind::Color(Range::NON_NEGATIVE),
            ParamDefault::Color([0.0; 3]),
            "The scene's ambient light.",
        ),
        ParamSpec::with_default(
            "max_bounces",
            Kind::Int(Range::closed(0.0, 20.0)),
            ParamDefault::Int(10),
            "Most reflections and refractions in a row.",
        ),
    ];

    /// Decodes the `[integrator.classic]` node, or takes the defaults if there is none. `max_depth` limits the
    /// path segments between camera and light: a bounce and the way to the light take one each.
    pub fn build(context: &mut Context<'_, '_>, max_depth: u32) -> Box<dyn AnyIntegrator> {
        let default = Node::new(Role::Integrator, Self::NAME, Self::NAME);
        let found = context.description.find(Role::Integrator, Self::NAME);
        let node = found.map_or(&default, |id| context.description.node(id));
        let p: Params = context.decode(node, Self::SCHEMA);
        let classic = Self {
            phase: p.int("phase") as u8,
            hard_shadows: p.bool("hard_shadows"),
            ambient: Spectrum::from_rgb(p.color("ambient")),
            max_bounces: (p.int("max_bounces") as u32).min(max_depth.saturating_sub(2)),
            lights: max_depth >= 2,
        };
        Box::new(Batched(classic, Self::NAME))
    }

    /// Adds the light of one point by Phong's model.
    #[inline(always)]
    fn light(
        &self,
        (scene, lights): (&Scene, &[LightView]),
        path: &ClassicPath,
        at: &SurfacePoint,
        view: &PhongView,
        sampler: &Sampler,
        out: &mut Step<'_, ClassicPath>,
    ) {
        let ambient = path.weight * view.ambient * self.ambient;
        if !ambient.is_black() {
            out.add(ambient);
        }
        if !self.lights {
            return;
        }
        let normal = at.facing_normal();
        let departure = at.departure();
        for (index, light) in lights.iter().zip(0..).map(|(light, index)| (index, light)) {
            // In double precision: squares of distances overflow single precision from 1e19 on.
            let to_light = (light.center.as_dvec3() - at.p.as_dvec3()).normalize_or_zero().as_vec3();
            let reflectance = phong(view, normal, at.wo, to_light);
            let color = match light.color {
                Some(color) => color,
                None => scene.lights()[index as usize].value.classic_color_at(at.p),
            };
            let radiance = path.weight * color * reflectance;
            if radiance.is_black() {
                continue;
            }
            match light.shadow_samples {
                count if count > 0 && !self.hard_shadows => {
                    let series = sampler.series(Dimension::of_node(path.node, index), count);
                    out.add_softly(radiance, SoftShadow { departure, light: index, series, count });
                }
                _ => out.add_if_visible(radiance, |rays| rays.push(shadow_ray(&departure, light.center))),
            }
        }
    }

    /// Follows the reflected ray with a share of the path's weight.
    fn reflect(&self, path: &ClassicPath, at: &SurfacePoint, share: f32, out: &mut Step<'_, ClassicPath>) {
        let ng = at.facing_geometric_normal();
        let dir = optics::reflect(at.wo, at.facing_normal());
        // An interpolated normal may send the ray into the surface: then the true normal decides.
        let dir = if dir.dot(ng) > 0.0 { dir } else { optics::reflect(at.wo, ng) };
        let next = ClassicPath {
            weight: path.weight * share,
            node: path.node * 2,
            depth: path.depth + 1,
            refracted: false,
        };
        out.follow(next, Ray::new(at.origin_toward(dir), dir, 0.0, f32::INFINITY));
    }

    /// Reflects and refracts by Fresnel's equations.
    fn glass(&self, path: &ClassicPath, at: &SurfacePoint, ior: f32, out: &mut Step<'_, ClassicPath>) {
        let eta = if at.outside() { ior } else { 1.0 / ior };
        let refraction = optics::refract(at.wo, at.facing_normal(), eta);
        let (reflectance, refracted) = match refraction {
            Refraction::Total => (1.0, None),
            Refraction::Partial { reflectance, dir } => (reflectance, Some(dir)),
        };
        if reflectance > 0.0 {
            self.reflect(path, at, reflectance, out);
        }
        if let Some(dir) = refracted.filter(|_| reflectance < 1.0) {
            let next = ClassicPath {
                weight: path.weight * (1.0 - reflectance),
                node: path.node * 2 + 1,
                depth: path.depth + 1,
                refracted: true,
            };
            out.follow(next, Ray::new(at.origin_toward(dir), dir, 0.0, f32::INFINITY));
        }
    }
}

impl Integrator for Classic {
    type Path = ClassicPath;
    type Memory = Vec<LightView>;
    const SMOOTH: bool = false;

    fn start(&self) -> ClassicPath {
        ClassicPath { weight: Spectrum::WHITE, node: 1, depth: 0, refracted: false }
    }

    fn shade(
        &self,
        scene: &Scene,
        arrivals: &Arrivals<'_, ClassicPath>,
        lights: &mut Vec<LightView>,
        out: &mut Step<'_, ClassicPath>,
    ) {
        if lights.is_empty() {
            lights.extend(scene.lights().iter().map(|light| LightView::of(&light.value)));
        }
        vectorize(Shading { classic: self, scene, lights, arrivals, out });
    }

    fn place(&self, path: &ClassicPath) -> PathPlace {
        let origin = match (path.depth, path.refracted) {
            (0, _) => "camera",
            (_, true) => "refraction",
            (_, false) => "reflection",
        };
        PathPlace { depth: path.depth, node: path.node, weight: path.weight, origin }
    }
}

impl Classic {
    /// Shades one point.
    #[inline(always)]
    fn step(
        &self,
        (scene, lights): (&Scene, &[LightView]),
        path: &ClassicPath,
        at: &SurfacePoint,
        sampler: &Sampler,
        out: &mut Step<'_, ClassicPath>,
    ) {
        let view = scene.phong_view(at);
        if self.phase == 1 {
            return out.add(path.weight * view.diffuse);
        }
        match view.kind {
            Specular::Mirror if self.phase >= 3 => {
                if path.depth < self.max_bounces {
                    self.reflect(path, at, 1.0, out);
                }
            }
            Specular::Glass(ior) if self.phase >= 4 => {
                if path.depth < self.max_bounces {
                    self.glass(path, at, ior, out);
                }
            }
            _ => self.light((scene, lights), path, at, &view, sampler, out),
        }
    }
}

/// diffuse·max(0, N·L) + specular·max(0, R·V)^shininess with R = 2(N·L)N − L; nothing where N·L ≤ 0
/// \[Phong1975\]. All vectors are unit vectors.
fn phong(view: &PhongView, normal: Vec3, to_viewer: Vec3, to_light: Vec3) -> Spectrum {
    let cosine = normal.dot(to_light);
    if cosine <= 0.0 {
        return Spectrum::BLACK;
    }
    let mut sum = view.diffuse * cosine;
    if !view.specular.is_black() {
        let mirrored = normal * (2.0 * cosine) - to_light;
        let highlight = float::pow(mirrored.dot(to_viewer).max(0.0), view.shininess);
        sum += view.specular * highlight;
    }
    sum
}
