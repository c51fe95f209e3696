//! Materials: how surfaces answer light.
//!
//! One file each; the comment at its top is its manual page.

mod common;

use crate::bsdf::{Black, Bsdf};
use crate::registry::{Context, Named, registry};
use crate::texture::{AnyTexture, TexturePoint};
use penombre_math::{Spectrum, Vec3};
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

pub use common::{Common, Facets};

/// What a material may look at where a surface was hit.
#[derive(Clone, Copy, Debug)]
pub struct Shade<'a> {
    /// Where textures are looked up.
    pub point: TexturePoint,
    /// Shading normal, unit, on the side from which it is seen.
    pub normal: Vec3,
    /// Toward the viewer, unit.
    pub wo: Vec3,
    /// True if it is seen from the outside, the side of the geometric normal.
    pub outside: bool,
    /// The mesh's interpolated colour; white where there is none. It multiplies the diffuse colour.
    pub vertex_color: Spectrum,
    /// The scene's textures.
    pub textures: &'a [AnyTexture],
    /// The scene's materials, for those that are made of others.
    pub materials: &'a [Named<AnyMaterial>],
    /// A uniform number in [0, 1) for the choice among several models.
    pub u: f32,
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

    /// The parameters that it shares with all others.
    fn common(&self) -> &Common;

    /// Share of the surface that is there, in [0, 1]. Looks at nothing in `shade` but the place, textures and materials.
    fn opacity(&self, shade: &Shade<'_>) -> f32 {
        self.common().opacity(shade)
    }

    /// True if the surface may not be entirely there.
    fn has_opacity(&self) -> bool {
        self.common().has_opacity()
    }

    /// The material in Phong's terms at a point: textures are read here, once per hit.
    fn phong_view(&self, shade: &Shade<'_>) -> PhongView;

    /// How it scatters light at a point, for the physically based integrators: textures are read here, once per hit.
    /// The local frame has the shading normal, on the outside, at +z.
    fn bsdf(&self, shade: &Shade<'_>) -> Bsdf;

    /// Radiance that it emits, W/(sr·m²), to the outside or the inside.
    fn emitted(&self, shade: &Shade<'_>, outside: bool) -> Spectrum {
        self.common().emitted(shade, outside)
    }

    /// True if it may emit light.
    fn is_emissive(&self) -> bool {
        self.common().is_emissive()
    }

    /// True if what it emits depends on the surface coordinates.
    fn has_textured_emission(&self) -> bool {
        self.common().emission().is_texture()
    }

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
            /// The material in Phong's terms at a point; black on the inside of what is one-sided.
            pub fn phong_view(&self, shade: &Shade<'_>) -> PhongView {
                match self {
                    $(Self::$type(m) if m.common().hides(shade) => common::BLACK_VIEW,
                    Self::$type(m) => m.phong_view(shade)),+
                }
            }

            /// Share of the surface that is there, in [0, 1].
            pub fn opacity(&self, shade: &Shade<'_>) -> f32 {
                match self { $(Self::$type(m) => m.opacity(shade)),+ }
            }

            /// True if the surface may not be entirely there.
            pub fn has_opacity(&self) -> bool {
                match self { $(Self::$type(m) => m.has_opacity()),+ }
            }

            /// Radiance that it emits, W/(sr·m²), to the outside or the inside.
            pub fn emitted(&self, shade: &Shade<'_>, outside: bool) -> Spectrum {
                match self { $(Self::$type(m) => m.emitted(shade, outside)),+ }
            }

            /// True if it may emit light.
            pub fn is_emissive(&self) -> bool {
                match self { $(Self::$type(m) => m.is_emissive()),+ }
            }

            /// True if what it emits depends on the surface coordinates.
            pub fn has_textured_emission(&self) -> bool {
                match self { $(Self::$type(m) => m.has_textured_emission()),+ }
            }

            /// How it scatters light at a point; not at all on the inside of what is one-sided.
            pub fn bsdf(&self, shade: &Shade<'_>) -> Bsdf {
                match self {
                    $(Self::$type(m) if m.common().hides(shade) => Black.into(),
                    Self::$type(m) => m.bsdf(shade)),+
                }
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
    rough_glass::RoughGlass,
    metal::Metal,
    mix::Mix,
    emissive::Emissive,
}

impl Default for AnyMaterial {
    fn default() -> Self {
        Self::Diffuse(diffuse::Diffuse::default())
    }
}
