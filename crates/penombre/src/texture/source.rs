//! Colours and numbers that are constant or come from a texture.

use super::{AnyTexture, TexturePoint};
use crate::registry::Context;
use penombre_math::Spectrum;
use penombre_scene::params::{ColorInput, FloatInput};

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

/// A number parameter of a material: one value, or a texture of the scene. A texture's number is the mean of its red,
/// green and blue, linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatSource {
    /// The same everywhere.
    Constant(f32),
    /// Index into the scene's textures.
    Texture(u32),
}

impl FloatSource {
    /// From a decoded parameter.
    pub fn new(input: FloatInput, context: &Context<'_, '_>) -> Self {
        match input {
            FloatInput::Constant(v) => Self::Constant(v),
            FloatInput::Texture(node) => Self::Texture(context.position(node)),
        }
    }

    /// True if it may vary over a surface.
    pub fn is_texture(self) -> bool {
        matches!(self, Self::Texture(_))
    }

    /// The number at a point; a texture's may lie outside of the parameter's range.
    #[inline]
    pub fn value(self, at: &TexturePoint, textures: &[AnyTexture]) -> f32 {
        match self {
            Self::Constant(v) => v,
            Self::Texture(i) => {
                let [r, g, b] = textures[i as usize].color(at).to_rgb();
                (r + g + b) / 3.0
            }
        }
    }
}
