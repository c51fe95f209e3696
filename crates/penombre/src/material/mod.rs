//! Materials: how surfaces answer light.
//!
//! One file each; the comment at its top is its manual page.

use crate::registry::{Context, registry};
use crate::texture::{AnyTexture, TexturePoint};
use penombre_math::{Spectrum, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// What a material may look at where a surface was hit.
#[derive(Clone, Copy, Debug)]
pub struct Shade<'a> {
    /// Where textures are looked up.
    pub point: TexturePoint,
    /// Shading normal, unit, on the side from which it is seen.
    pub normal: Vec3,
    /// Toward the viewer, unit.
    pub wo: Vec3,
    /// The mesh's interpolated colour; white where there is none. It multiplies the diffuse colour.
    pub vertex_color: Spectrum,
    /// The scene's textures.
    pub textures: &'a [AnyTexture],
}

/// How the `classic` integrator continues at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// Phong shading, no further rays.
    None,
    /// A perfect mirror.
    Mirror,
    /// Reflects and refracts; the number is the index of refraction of the inside against the outside.
    Glass(f32),
}

/// A material as Phong's model sees it \[Phong1975\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongView {
    /// Factor of the scene's ambient light.
    pub ambient: Spectrum,
    /// Factor of the cosine term.
    pub diffuse: Spectrum,
    /// Factor of the highlight.
    pub specular: Spectrum,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// What the classic integrator does instead of shading, from phase 3 (mirror) or 4 (glass) on.
    pub kind: Specular,
}

/// How a surface answers light.
pub trait Material: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// The material in Phong's terms at a point: textures are read here, once per hit.
    fn phong_view(&self, shade: &Shade<'_>) -> PhongView;

    /// True if [`Material::phong_view`] depends on the surface coordinates.
    fn is_textured(&self) -> bool;
}

/// Declares the materials: the module, then the type. One line is all that a new material needs besides its file.
macro_rules! materials {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any material.
            AnyMaterial: Material { $($module::$type),+ }
        }

        impl AnyMaterial {
            /// The material in Phong's terms at a point.
            pub fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
                match self { $(Self::$type(m) => m.phong_view(shade)),+ }
            }

            /// True if that depends on the surface coordinates.
            pub fn is_textured(&self) -> bool {
                match self { $(Self::$type(m) => m.is_textured()),+ }
            }
        }
    };
}

materials! {
    phong::Phong,
    diffuse::Diffuse,
    mirror::Mirror,
    glass::Glass,
}

impl Default for AnyMaterial {
    fn default() -> Self {
        Self::Diffuse(diffuse::Diffuse::default())
    }
}

const fn diffuse_param(default: f32) -> ParamSpec {
    ParamSpec::with_default(
        "diffuse",
        Kind::ColorTexture(Range::NON_NEGATIVE),
        ParamDefault::Color([default; 3]),
        "Factor of the cosine term; the whole colour in phase 1 of `classic`.",
    )
}

const fn specular_param(default: f32) -> ParamSpec {
    ParamSpec::with_default(
        "specular",
        Kind::ColorTexture(Range::NON_NEGATIVE),
        ParamDefault::Color([default; 3]),
        "Factor of the highlight.",
    )
}

const AMBIENT: ParamSpec = ParamSpec::with_default(
    "ambient",
    Kind::ColorTexture(Range::NON_NEGATIVE),
    ParamDefault::Color([0.0; 3]),
    "Factor of the scene's ambient light.",
);

const SHININESS: ParamSpec = ParamSpec::with_default(
    "shininess",
    Kind::Float(Range::NON_NEGATIVE),
    ParamDefault::Float(16.0),
    "Exponent of the highlight: larger is smaller and sharper.",
);
