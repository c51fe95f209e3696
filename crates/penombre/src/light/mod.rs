//! Lights.
//!
//! In the `classic` integrator a light's shape is no surface: rays do not see it, it hides nothing, it shines to
//! both sides, and its light does not fall off with distance.
//!
//! [`sampling`] holds what the physically based integrators need: directions towards lights and their densities.

pub mod sampling;

use crate::registry::{Context, registry};
use crate::shape::AnyShape;
use penombre_math::rounding::gamma;
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};
use sampling::DirectionSample;
use sampling::punctual::PunctualSample;

/// What lights with an extent have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// In `classic`.
    color: Spectrum,
    /// W/(sr·m²)
    radiance: Spectrum,
    /// It shines against its normal, too.
    two_sided: bool,
    shadow_samples: u32,
}

impl Lamp {
    /// From the parameters `color`, `radiance` and `shadow_samples`.
    fn one_sided(p: &Params) -> Self {
        Self {
            color: Spectrum::from_rgb(p.color("color")),
            radiance: Spectrum::from_rgb(p.color("radiance")),
            two_sided: false,
            shadow_samples: p.int("shadow_samples") as u32,
        }
    }

    /// From these and `two_sided`.
    fn of_sides(p: &Params) -> Self {
        Self { two_sided: p.bool("two_sided"), ..Self::one_sided(p) }
    }

    /// Radiance towards `wo` where the surface has that normal, W/(sr·m²).
    fn emitted(&self, normal: Vec3, wo: Vec3) -> Spectrum {
        if self.two_sided || normal.dot(wo) > 0.0 { self.radiance } else { Spectrum::BLACK }
    }
}

/// A source of light.
pub trait Light: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// Its colour in the `classic` integrator.
    fn classic_color(&self) -> Spectrum;

    /// That colour as seen from a point: less beside the beam of a light that has one.
    fn classic_color_at(&self, _from: Vec3) -> Spectrum {
        self.classic_color()
    }

    /// Its middle, world space, metres: where shadow rays of `classic` end. Of directional light a point so far away that
    /// the directions towards it are alike.
    fn center(&self) -> Vec3;

    /// What it has in common with others that have an extent.
    fn lamp(&self) -> Option<&Lamp> {
        None
    }

    /// Number of shadow rays per shaded point in the `classic` integrator; 0: the light is a point.
    fn shadow_samples(&self) -> u32 {
        self.lamp().map_or(0, |lamp| lamp.shadow_samples)
    }

    /// The point of the light for `u` in the unit square, uniform over its area.
    fn sample_point(&self, _u: Vec2) -> Vec3 {
        self.center()
    }

    /// Corner and sides, for those whose [`sample_point`](Self::sample_point) is the corner and shares of the sides.
    fn parallelogram(&self) -> Option<(Vec3, [Vec3; 2])> {
        None
    }

    /// The surface that physically based integrators see; `None` for lights without extent and from infinity.
    fn surface(&self) -> Option<AnyShape> {
        None
    }

    /// Centre, radius and radiance, for a ball that shines evenly to the outside.
    fn ball(&self) -> Option<(Vec3, f32, Spectrum)> {
        None
    }

    /// A direction from which its light reaches a point, drawn by the uniform point `u` ∈ [0, 1)². `None`: none does.
    fn sample_towards(&self, from: Vec3, u: Vec2) -> Option<LightSample>;

    /// Density with which [`sample_towards`](Self::sample_towards) gives the unit direction `wi`, 1/sr: of a direction that
    /// is known to meet its surface first at `distance` metres. 0 for lights without extent; see [`Escaped`] for those at
    /// infinity.
    fn pdf_towards(&self, _from: Vec3, _wi: Vec3, _distance: f32) -> f32 {
        0.0
    }

    /// Radiance that leaves its surface from the side of `normal`'s surface on which `wo` lies, W/(sr·m²). `normal` is
    /// the geometric one, `wo` points away from the surface.
    fn emitted(&self, _normal: Vec3, _wo: Vec3) -> Spectrum {
        Spectrum::BLACK
    }

    /// What comes from infinity against the unit direction `dir` of a ray that leaves the scene; `None` for lights that
    /// stand somewhere.
    fn escaped(&self, _dir: Vec3) -> Option<Escaped> {
        None
    }

    /// True if what it sends depends on the direction: then [`classic_color_at`](Self::classic_color_at) is to be asked.
    fn is_directed(&self) -> bool {
        false
    }

    /// True if it comes from infinity: its power grows with the scene.
    fn is_infinite(&self) -> bool {
        false
    }

    /// Its luminous power for the choice among lights, in watts of luminance; `scene_radius` in metres, for light from
    /// infinity. 0: it need not be sampled, as it is black or scattered rays find it better.
    fn power(&self, scene_radius: f32) -> f32;
}

/// Light from infinity along one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Escaped {
    /// W/(sr·m²)
    pub radiance: Spectrum,
    /// Density with which [`Light::sample_towards`] gives the direction from which it comes, 1/sr; 0 if that samples
    /// nothing.
    pub pdf: f32,
}

/// Light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Direction towards it, unit.
    pub wi: Vec3,
    /// The point from which it comes, world space, metres: aim shadow rays at it. Of no meaning at infinity.
    pub point: Vec3,
    /// Distance, metres; infinite for light from infinity.
    pub distance: f32,
    /// W/(sr·m²); for a light without extent its irradiance across `wi`, W/m².
    pub radiance: Spectrum,
    /// Density of `wi` per solid angle, 1/sr; 1 for a light without extent. Per area, 1/m², if `by_area`.
    pub pdf: f32,
    /// True if the density is that of the point per area of the surface.
    pub by_area: bool,
    /// Geometric normal of its surface at the point, unit; zero where there is none.
    pub normal: Vec3,
    /// How far the point may lie off its surface beside the rounding of its coordinates, metres: what the test of rays against
    /// the surface adds.
    pub aside: f32,
    /// True for a light without extent: no ray can meet it by chance.
    pub is_delta: bool,
    /// True if what it sends depends on the direction otherwise than by the cosine at its surface.
    pub is_directed: bool,
}

/// Declares the lights: the module, then the type.
macro_rules! lights {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any light.
            AnyLight: Light { $($module::$type),+ }
        }

        impl AnyLight {
            /// Its colour in the `classic` integrator.
            pub fn classic_color(&self) -> Spectrum {
                match self { $(Self::$type(l) => l.classic_color()),+ }
            }

            /// See [`Light::classic_color_at`].
            pub fn classic_color_at(&self, from: Vec3) -> Spectrum {
                match self { $(Self::$type(l) => l.classic_color_at(from)),+ }
            }

            /// See [`Light::center`].
            pub fn center(&self) -> Vec3 {
                match self { $(Self::$type(l) => l.center()),+ }
            }

            /// Number of shadow rays per shaded point in the `classic` integrator; 0: the light is a point.
            pub fn shadow_samples(&self) -> u32 {
                match self { $(Self::$type(l) => l.shadow_samples()),+ }
            }

            /// See [`Light::parallelogram`].
            #[inline]
            pub fn parallelogram(&self) -> Option<(Vec3, [Vec3; 2])> {
                match self { $(Self::$type(l) => l.parallelogram()),+ }
            }

            /// See [`Light::surface`].
            pub fn surface(&self) -> Option<AnyShape> {
                match self { $(Self::$type(l) => l.surface()),+ }
            }

            /// See [`Light::ball`].
            pub fn ball(&self) -> Option<(Vec3, f32, Spectrum)> {
                match self { $(Self::$type(l) => l.ball()),+ }
            }

            /// See [`Light::sample_towards`].
            #[inline]
            pub fn sample_towards(&self, from: Vec3, u: Vec2) -> Option<LightSample> {
                match self { $(Self::$type(l) => l.sample_towards(from, u)),+ }
            }

            /// See [`Light::pdf_towards`].
            #[inline]
            pub fn pdf_towards(&self, from: Vec3, wi: Vec3, distance: f32) -> f32 {
                match self { $(Self::$type(l) => l.pdf_towards(from, wi, distance)),+ }
            }

            /// See [`Light::emitted`].
            #[inline]
            pub fn emitted(&self, normal: Vec3, wo: Vec3) -> Spectrum {
                match self { $(Self::$type(l) => l.emitted(normal, wo)),+ }
            }

            /// See [`Light::escaped`].
            #[inline]
            pub fn escaped(&self, dir: Vec3) -> Option<Escaped> {
                match self { $(Self::$type(l) => l.escaped(dir)),+ }
            }

            /// See [`Light::is_directed`].
            pub fn is_directed(&self) -> bool {
                match self { $(Self::$type(l) => l.is_directed()),+ }
            }

            /// See [`Light::is_infinite`].
            pub fn is_infinite(&self) -> bool {
                match self { $(Self::$type(l) => l.is_infinite()),+ }
            }

            /// See [`Light::power`].
            pub fn power(&self, scene_radius: f32) -> f32 {
                match self { $(Self::$type(l) => l.power(scene_radius)),+ }
            }

            /// The point of the light for `u` in the unit square, uniform over its area.
            pub fn sample_point(&self, u: Vec2) -> Vec3 {
                match self { $(Self::$type(l) => l.sample_point(u)),+ }
            }
        }
    };
}

lights! {
    point::Point,
    spot::Spot,
    directional::Directional,
    quad::QuadLight,
    disk::DiskLight,
    sphere::SphereLight,
    environment::EnvironmentLight,
}

impl LightSample {
    /// Of a light without extent, from its strength before the falloff.
    fn without_extent(way: PunctualSample, point: Vec3, strength: Spectrum) -> Self {
        let radiance = strength * way.falloff;
        let PunctualSample { wi, distance, .. } = way;
        Self {
            wi,
            point,
            distance,
            radiance,
            pdf: 1.0,
            by_area: false,
            normal: Vec3::ZERO,
            aside: 0.0,
            is_delta: true,
            is_directed: false,
        }
    }

    /// Of a direction towards a shape, from the normal there and its radiance.
    pub(crate) fn of_shape(sample: DirectionSample, normal: Vec3, radiance: Spectrum) -> Self {
        let DirectionSample { wi, point, distance, pdf } = sample;
        Self {
            wi,
            point,
            distance,
            radiance,
            pdf,
            by_area: false,
            normal,
            aside: 0.0,
            is_delta: false,
            is_directed: false,
        }
    }

    /// Bound per axis on how far the point lies off its surface, metres. Points are computed in double precision, and rounded.
    #[inline(always)]
    pub fn p_error(&self) -> Vec3 {
        self.point.abs() * gamma(2) + Vec3::splat(self.aside)
    }
}

const INTENSITY: ParamSpec = ParamSpec::with_default(
    "intensity",
    Kind::Color(Range::NON_NEGATIVE),
    ParamDefault::Color([1.0; 3]),
    "Strength in physically based integrators.",
)
.unit("W/sr");

const RADIANCE: ParamSpec = ParamSpec::with_default(
    "radiance",
    Kind::Color(Range::NON_NEGATIVE),
    ParamDefault::Color([1.0; 3]),
    "Emitted radiance; physically based integrators only.",
)
.unit("W/(sr m²)");

const TWO_SIDED: ParamSpec = ParamSpec::with_default(
    "two_sided",
    Kind::Bool,
    ParamDefault::Bool(false),
    "It shines to the other side, too; physically based integrators only.",
);

const SHADOW_SAMPLES: ParamSpec = ParamSpec::with_default(
    "shadow_samples",
    Kind::Int(Range::closed(1.0, MOST_SHADOW_SAMPLES)),
    ParamDefault::Int(16),
    "Shadow rays per shaded point in `classic`.",
);

/// Most shadow rays per shaded point and light.
const MOST_SHADOW_SAMPLES: f64 = 65536.0;

const COLOR: ParamSpec = ParamSpec::with_default(
    "color",
    Kind::Color(Range::NON_NEGATIVE),
    ParamDefault::Color([1.0; 3]),
    "Colour and strength in the `classic` integrator.",
);

#[cfg(test)]
mod tests;
