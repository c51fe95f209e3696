//! `image`: an image file over the surface coordinates.
//!
//! u runs to the right and v *up* the image, so (0, 0) is its lower left corner and (1, 1) its upper right one.
//! Values of 8- and 16-bit files are decoded from sRGB, those of float files are linear.
//!
//! ```toml
//! [texture.label]
//! type = "image"
//! file = "label.png"
//! wrap = "repeat"
//! filter = "bilinear"
//! ```

use super::{Texture, TexturePoint};
use crate::registry::Context;
use penombre_image::Image;
use penombre_math::{Spectrum, Vec2};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};
use std::sync::Arc;

/// What lies outside the unit square of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrap {
    Repeat,
    Clamp,
    Mirror,
}

/// An image with a way to look up between and beyond its pixels.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    image: Arc<Image>,
    wrap: Wrap,
    bilinear: bool,
    scale: Vec2,
}

impl Texture for ImageTexture {
    const TYPE_NAME: &'static str = "image";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("file", Kind::File, "The image file."),
        ParamSpec::with_default(
            "wrap",
            Kind::Choice(&["repeat", "clamp", "mirror"]),
            ParamDefault::Text("repeat"),
            "What lies outside 0..1.",
        ),
        ParamSpec::with_default(
            "filter",
            Kind::Choice(&["bilinear", "nearest"]),
            ParamDefault::Text("bilinear"),
            "How to look up between pixels.",
        ),
        ParamSpec::with_default(
            "scale",
            Kind::Vec2(Range::ANY),
            ParamDefault::Vec2([1.0, 1.0]),
            "Repetitions per unit of u and of v.",
        ),
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        // A missing image was reported when the assets were loaded.
        let image = context.assets.image(context.node)?.clone();
        let wrap = match p.choice("wrap") {
            "clamp" => Wrap::Clamp,
            "mirror" => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        Some(Self { image, wrap, bilinear: p.choice("filter") == "bilinear", scale: p.vec2("scale") })
    }

    fn color(&self, at: &TexturePoint) -> Spectrum {
        let uv = at.uv * self.scale;
        let (w, h) = (self.image.width() as f32, self.image.height() as f32);
        // Continuous pixel coordinates, y downwards; pixel centres lie at halves.
        let (x, y) = (uv.x * w, (1.0 - uv.y) * h);
        if !(x.is_finite() && y.is_finite()) {
            return Spectrum::BLACK;
        }
        if !self.bilinear {
            return self.pixel(x.floor(), y.floor());
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let row = |y| self.pixel(x0, y) * (1.0 - fx) + self.pixel(x0 + 1.0, y) * fx;
        row(y0) * (1.0 - fy) + row(y0 + 1.0) * fy
    }
}

impl ImageTexture {
    fn pixel(&self, x: f32, y: f32) -> Spectrum {
        let (w, h) = (self.image.width(), self.image.height());
        Spectrum::from_rgb(self.image.rgb(self.wrap.index(x, w), self.wrap.index(y, h)))
    }
}

impl Wrap {
    /// The pixel index that stands at the whole number `i` of a row of `n` pixels.
    fn index(self, i: f32, n: u32) -> u32 {
        let last = f64::from(n - 1);
        let (i, n) = (f64::from(i), f64::from(n));
        let inside = match self {
            Self::Clamp => i,
            Self::Repeat => i - (i / n).floor() * n,
            Self::Mirror => {
                let in_pair = i - (i / (2.0 * n)).floor() * 2.0 * n;
                if in_pair < n { in_pair } else { 2.0 * n - 1.0 - in_pair }
            }
        };
        inside.clamp(0.0, last) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(wrap: Wrap, bilinear: bool) -> ImageTexture {
        // Upper row black and white, lower row 0.25 and 0.5.
        let data = [0.0, 1.0, 0.25, 0.5].iter().flat_map(|v| [*v; 3]).collect();
        let image = Image::from_data(2, 2, 3, data).unwrap();
        ImageTexture { image: Arc::new(image), wrap, bilinear, scale: Vec2::ONE }
    }

    fn red(t: &ImageTexture, u: f32, v: f32) -> f32 {
        t.color(&TexturePoint { uv: Vec2::new(u, v) }).to_rgb()[0]
    }

    #[test]
    fn v_points_up_and_pixel_centres_are_exact() {
        let t = texture(Wrap::Clamp, true);
        assert_eq!(red(&t, 0.25, 0.75), 0.0);
        assert_eq!(red(&t, 0.75, 0.75), 1.0);
        assert_eq!(red(&t, 0.25, 0.25), 0.25);
        assert_eq!(red(&t, 0.75, 0.25), 0.5);
        assert_eq!(red(&t, 0.5, 0.5), 0.4375);
    }

    #[test]
    fn wraps_as_told() {
        assert_eq!(red(&texture(Wrap::Repeat, false), 1.25, 0.75), 0.0);
        assert_eq!(red(&texture(Wrap::Mirror, false), 1.25, 0.75), 1.0);
        assert_eq!(red(&texture(Wrap::Clamp, false), 7.0, 0.75), 1.0);
        assert_eq!(red(&texture(Wrap::Repeat, false), -0.25, -0.25), 1.0);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            assert!(red(&texture(wrap, true), 1e30, -1e30).is_finite());
        }
    }
}
