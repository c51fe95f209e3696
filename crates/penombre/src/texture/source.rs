//! Colours that are constant or come from a texture.

use super::{AnyTexture, TexturePoint};
use crate::registry::Context;
use penombre_math::Spectrum;
use penombre_scene::params::ColorInput;

/// A colour parameter of a material: one value, or a texture of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorSource {
    /// The same everywhere.
    Constant(Spectrum),
    /// Index into the scene's textures.
    Texture(u32),
}

impl ColorSource {
    /// From a decoded parameter.
    pub fn new(input: ColorInput, context: &Context<'_, '_>) -> Self {
        match input {
            ColorInput::Constant(rgb) => Self::Constant(Spectrum::from_rgb(rgb)),
            ColorInput::Texture(node) => Self::Texture(context.position(node)),
        }
    }

    /// True if it may vary over a surface.
    pub fn is_texture(self) -> bool {
        matches!(self, Self::Texture(_))
    }

    /// The colour at a point.
    pub fn color(self, at: &TexturePoint, textures: &[AnyTexture]) -> Spectrum {
        match self {
            Self::Constant(c) => c,
            Self::Texture(i) => textures[i as usize].color(at),
        }
    }
}
