//! Textures: colours and numbers that vary over a surface.

mod source;

use crate::registry::{Context, registry};
use penombre_math::{Spectrum, Vec2};
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

pub use source::{ColorSource, FloatSource};

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePoint {
    /// Surface coordinates; v points up in image textures.
    pub uv: Vec2,
}

/// A colour that varies over a surface.
pub trait Texture: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// The colour at a point, linear Rec. 709.
    fn color(&self, at: &TexturePoint) -> Spectrum;
}

/// Declares the textures: the module, then the type.
macro_rules! textures {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any texture.
            AnyTexture: Texture { $($module::$type),+ }
        }

        impl AnyTexture {
            /// The colour at a point, linear Rec. 709.
            pub fn color(&self, at: &TexturePoint) -> Spectrum {
                match self { $(Self::$type(t) => t.color(at)),+ }
            }
        }
    };
}

textures! {
    checker::Checker,
    image::ImageTexture,
}
