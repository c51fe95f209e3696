//! Materials as a rasteriser takes them: Phong's factors, and textures baked into pixels.

use penombre::Scene;
use penombre::material::PhongView;
use penombre_math::{Spectrum, Vec2, color::srgb_encode_u8};

/// Edge of a baked texture, texels, where memory allows.
const LARGEST_EDGE: u32 = 512;
/// Edge below which no texture goes.
const SMALLEST_EDGE: u32 = 16;

/// A material in Phong's terms.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewMaterial {
    /// Factor of the ambient light, linear; the mean over a texture.
    pub ambient: [f32; 3],
    /// Factor of the cosine term, linear; a factor of the texture where there is one.
    pub diffuse: [f32; 3],
    /// Factor of the highlight, linear.
    pub specular: [f32; 3],
    /// Exponent of the highlight.
    pub shininess: f32,
    /// Diffuse colours over the surface coordinates.
    pub texture: Option<PreviewTexture>,
}

/// A texture over the unit square of surface coordinates, repeated outside.
///
/// Texel (i, j) of row j holds the colour at ((i + ½)/edge, (j + ½)/edge): rows go with v, so that a graphics card
/// looks it up at (u, v) as it stands. What repeats at other periods than 1 is approximate.
#[derive(Clone, PartialEq)]
pub struct PreviewTexture {
    /// Width and height, texels.
    pub edge: u32,
    /// Red, green, blue (sRGB-encoded) and 255, row by row.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for PreviewTexture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PreviewTexture {{ {0} × {0} }}", self.edge)
    }
}

/// All materials of a scene, with the scene's indices; textures take at most so many bytes, unless the smallest that
/// make sense take more.
pub fn all(scene: &Scene, texture_bytes: usize) -> Vec<PreviewMaterial> {
    let textured = scene.materials().iter().filter(|m| m.value.is_textured()).count();
    let mut edge = LARGEST_EDGE;
    while edge > SMALLEST_EDGE && textured * (edge * edge * 4) as usize > texture_bytes {
        edge /= 2;
    }
    let material = |(i, m): (usize, &penombre::scene::Named<penombre::material::AnyMaterial>)| {
        if m.value.is_textured() { baked(scene, i as u32, edge) } else { plain(scene, i as u32) }
    };
    scene.materials().iter().enumerate().map(material).collect()
}

fn plain(scene: &Scene, index: u32) -> PreviewMaterial {
    let view = scene.material_view(index, Vec2::splat(0.5));
    PreviewMaterial {
        ambient: view.ambient.to_rgb(),
        diffuse: view.diffuse.to_rgb(),
        specular: view.specular.to_rgb(),
        shininess: view.shininess,
        texture: None,
    }
}

fn baked(scene: &Scene, index: u32, edge: u32) -> PreviewMaterial {
    let at = |i: u32| (i as f32 + 0.5) / edge as f32;
    let grid = (0..edge).flat_map(|j| (0..edge).map(move |i| Vec2::new(at(i), at(j))));
    let views: Vec<PhongView> = grid.map(|uv| scene.material_view(index, uv)).collect();
    let mean = |part: fn(&PhongView) -> Spectrum| {
        let sum = views.iter().fold(Spectrum::BLACK, |sum, view| sum + part(view));
        (sum * (1.0 / views.len() as f32)).to_rgb()
    };
    // Colours above 1 are scaled into the range of bytes.
    let brightest = views.iter().flat_map(|view| view.diffuse.to_rgb()).fold(1.0f32, f32::max);
    let texel = |view: &PhongView| {
        let [r, g, b] = view.diffuse.to_rgb().map(|c| srgb_encode_u8(c / brightest));
        [r, g, b, 255]
    };
    PreviewMaterial {
        ambient: mean(|view| view.ambient),
        diffuse: [brightest; 3],
        specular: mean(|view| view.specular),
        shininess: views[views.len() / 2 + edge as usize / 2].shininess,
        texture: Some(PreviewTexture { edge, rgba: views.iter().flat_map(texel).collect() }),
    }
}
