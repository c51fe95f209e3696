//! `image`: an image file over the surface coordinates.
//!
//! u runs to the right and v *up* the image, so (0, 0) is its lower left corner and (1, 1) its upper right one. A point
//! of the surface is looked up at `scale` · (u, v) + `offset`. What is found there, v, becomes `base` + `gain` · v.
//! Unless `encoding` says otherwise, values of 8- and 16-bit files are decoded from sRGB, those of float files are
//! linear; images that hold no colours (roughness, masks) want `encoding = "linear"`. A `channel` other than `color`
//! gives grey: that channel alone.
//!
//! ```toml
//! [texture.label]
//! type = "image"
//! file = "label.png"
//! wrap = "repeat"
//! filter = "bilinear"
//! scale = [2, 1]
//! offset = [0.5, 0]
//! ```

use super::{Texture, TexturePoint};
use crate::registry::Context;
use penombre_image::{Image, Pixel};
use penombre_math::color::luminance;
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
    Black,
}

/// Which of an image's samples are looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Color,
    /// Red, green or blue, by number.
    One(usize),
    Alpha,
    Luminance,
}

/// An image with a way to look up between and beyond its pixels.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    image: Arc<Image>,
    wrap: Wrap,
    bilinear: bool,
    channel: Channel,
    scale: Vec2,
    offset: Vec2,
    base: f32,
    gain: f32,
}

impl Texture for ImageTexture {
    const TYPE_NAME: &'static str = "image";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::required("file", Kind::File, "The image file."),
        ParamSpec::with_default(
            "wrap",
            Kind::Choice(&["repeat", "clamp", "mirror", "black"]),
            ParamDefault::Text("repeat"),
            "What lies outside 0..1: the image again and again, its outermost pixels, the image mirrored at each border, or nothing.",
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
        ParamSpec::with_default(
            "offset",
            Kind::Vec2(Range::ANY),
            ParamDefault::Vec2([0.0, 0.0]),
            "What is added to u and v after `scale`: 1 is the whole image.",
        ),
        ParamSpec::with_default(
            "encoding",
            Kind::Choice(&["auto", "srgb", "linear"]),
            ParamDefault::Text("auto"),
            "How the file's values tell of light; `auto` is sRGB for 8 and 16 bits and linear for floats.",
        ),
        ParamSpec::with_default(
            "channel",
            Kind::Choice(&["color", "red", "green", "blue", "alpha", "luminance", "mask"]),
            ParamDefault::Text("color"),
            "What is looked up; `mask` is alpha if any of it is below 1, else luminance.",
        ),
        ParamSpec::with_default(
            "base",
            Kind::Float(Range::ANY),
            ParamDefault::Float(0.0),
            "What is added to each value, after `gain`.",
        ),
        ParamSpec::with_default(
            "gain",
            Kind::Float(Range::ANY),
            ParamDefault::Float(1.0),
            "Factor of each value; with `gain = -1` and `base = 1` it is inverted.",
        ),
    ];

    fn build(p: &Params, context: &mut Context<'_, '_>) -> Option<Self> {
        // A missing image was reported when the assets were loaded.
        let image = context.assets.image(context.node)?.clone();
        let wrap = match p.choice("wrap") {
            "clamp" => Wrap::Clamp,
            "mirror" => Wrap::Mirror,
            "black" => Wrap::Black,
            _ => Wrap::Repeat,
        };
        let channel = Channel::of(p.choice("channel"), &image);
        Some(Self {
            image,
            wrap,
            bilinear: p.choice("filter") == "bilinear",
            channel,
            scale: p.vec2("scale"),
            offset: p.vec2("offset"),
            base: p.f32("base"),
            gain: p.f32("gain"),
        })
    }

    fn color(&self, at: &TexturePoint) -> Spectrum {
        let found = self.lookup(at.uv * self.scale + self.offset);
        if self.gain == 1.0 && self.base == 0.0 {
            found
        } else {
            found * self.gain + Spectrum::splat(self.base)
        }
    }
}

impl ImageTexture {
    fn lookup(&self, uv: Vec2) -> Spectrum {
        let (width, height) = (self.image.width(), self.image.height());
        // Continuous pixel coordinates, y downwards; pixel centres lie at halves.
        let (x, y) = (uv.x * width as f32, (1.0 - uv.y) * height as f32);
        if !(x.is_finite() && y.is_finite()) {
            return Spectrum::BLACK;
        }
        if !self.bilinear {
            return self.pixel(self.wrap.index(x.floor(), width), self.wrap.index(y.floor(), height));
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let columns = [x0, x0 + 1.0].map(|x| self.wrap.index(x, width));
        let rows = [y0, y0 + 1.0].map(|y| self.wrap.index(y, height));
        let row = |y| self.pixel(columns[0], y) * (1.0 - fx) + self.pixel(columns[1], y) * fx;
        row(rows[0]) * (1.0 - fy) + row(rows[1]) * fy
    }

    /// What is looked up at a pixel, if there is one.
    fn pixel(&self, x: Option<u32>, y: Option<u32>) -> Spectrum {
        let (Some(x), Some(y)) = (x, y) else { return Spectrum::BLACK };
        match self.channel {
            Channel::Color => Spectrum::from_rgb(self.image.rgb(x, y)),
            Channel::One(i) => Spectrum::splat(self.image.rgb(x, y)[i]),
            Channel::Alpha => Spectrum::splat(alpha(self.image.pixel(x, y))),
            Channel::Luminance => Spectrum::splat(luminance(self.image.rgb(x, y))),
        }
    }
}

impl Channel {
    /// The channel by its word in scene files.
    fn of(word: &str, image: &Image) -> Self {
        match word {
            "red" => Self::One(0),
            "green" => Self::One(1),
            "blue" => Self::One(2),
            "alpha" => Self::Alpha,
            "luminance" => Self::Luminance,
            "mask" if is_cut_out(image) => Self::Alpha,
            "mask" => Self::Luminance,
            _ => Self::Color,
        }
    }
}

/// True if some pixel is not entirely there.
fn is_cut_out(image: &Image) -> bool {
    image.channels().is_multiple_of(2) && image.pixels().any(|pixel| alpha(pixel) < 1.0)
}

/// Alpha; 1 where there is none.
fn alpha(pixel: Pixel) -> f32 {
    pixel.alpha().unwrap_or(1.0)
}

impl Wrap {
    /// The pixel index that stands at the whole number `i` of a row of `n` pixels, if there is one.
    fn index(self, i: f32, n: u32) -> Option<u32> {
        let last = f64::from(n - 1);
        let (i, n) = (f64::from(i), f64::from(n));
        let inside = match self {
            Self::Clamp => i,
            Self::Repeat => i - (i / n).floor() * n,
            Self::Mirror => {
                let in_pair = i - (i / (2.0 * n)).floor() * 2.0 * n;
                if in_pair < n { in_pair } else { 2.0 * n - 1.0 - in_pair }
            }
            Self::Black if !(0.0..n).contains(&i) => return None,
            Self::Black => i,
        };
        Some(inside.clamp(0.0, last) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(wrap: Wrap, bilinear: bool) -> ImageTexture {
        // Upper row black and white, lower row 0.25 and 0.5.
        let data = [0.0, 1.0, 0.25, 0.5].iter().flat_map(|v| [*v; 3]).collect();
        let image = Image::from_data(2, 2, 3, data).unwrap();
        of_image(image, wrap, bilinear)
    }

    fn of_image(image: Image, wrap: Wrap, bilinear: bool) -> ImageTexture {
        let (scale, offset) = (Vec2::ONE, Vec2::ZERO);
        let image = Arc::new(image);
        ImageTexture { image, wrap, bilinear, channel: Channel::Color, scale, offset, base: 0.0, gain: 1.0 }
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
        assert_eq!(red(&texture(Wrap::Black, false), 0.75, 0.75), 1.0);
        assert_eq!(red(&texture(Wrap::Black, false), -0.25, 0.75), 0.0);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp, Wrap::Black] {
            assert!(red(&texture(wrap, true), 1e30, -1e30).is_finite());
        }
    }

    /// Against whole numbers, on both sides of zero and as far out as single precision counts every pixel.
    #[test]
    fn pixels_beyond_the_image_are_those_of_the_wrap() {
        let far = [-16_777_216, -9_999_991, 9_999_991, 16_777_216];
        for (i, n) in (-40..40).chain(far).flat_map(|i| (1..9).map(move |n| (i, n))) {
            let pair = i64::rem_euclid(i, 2 * n);
            let expected = [
                (Wrap::Repeat, Some(i.rem_euclid(n))),
                (Wrap::Mirror, Some(pair.min(2 * n - 1 - pair))),
                (Wrap::Clamp, Some(i.clamp(0, n - 1))),
                (Wrap::Black, Some(i).filter(|i| (0..n).contains(i))),
            ];
            for (wrap, pixel) in expected {
                let found = wrap.index(i as f32, n as u32).map(i64::from);
                assert_eq!(found, pixel, "{wrap:?} {i} {n}");
            }
        }
    }

    /// The border between a picture and its next copy is a mean of both, the same from either side of the plane.
    #[test]
    fn coordinates_wrap_alike_near_and_far() {
        for (wrap, period) in [(Wrap::Repeat, 1.0), (Wrap::Mirror, 2.0)] {
            for (u, far) in
                (0..32).flat_map(|i| [-1024.0, -2.0, 2.0, 1024.0].map(|far| (i as f32 / 16.0, far)))
            {
                let t = texture(wrap, true);
                assert_eq!(red(&t, u, 0.3), red(&t, u + far * period, 0.3), "{wrap:?} {u} {far}");
            }
        }
        let edge = |wrap| red(&texture(wrap, true), 1.0, 0.75);
        assert_eq!([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp, Wrap::Black].map(edge), [0.5, 1.0, 1.0, 0.5]);
    }

    #[test]
    fn is_scaled_then_shifted() {
        let scaled = ImageTexture {
            scale: Vec2::new(2.0, 1.0),
            offset: Vec2::new(0.5, -0.5),
            ..texture(Wrap::Repeat, false)
        };
        let plain = texture(Wrap::Repeat, false);
        for (u, v) in [(0.1, 0.6), (0.3, 0.9), (0.9, 0.2), (-0.2, 1.4)] {
            assert_eq!(red(&scaled, u, v), red(&plain, 2.0 * u + 0.5, v - 0.5), "{u} {v}");
        }
    }

    #[test]
    fn values_are_scaled_and_inverted() {
        let inverted = ImageTexture { base: 1.0, gain: -1.0, ..texture(Wrap::Clamp, false) };
        assert_eq!(red(&inverted, 0.25, 0.75), 1.0);
        assert_eq!(red(&inverted, 0.25, 0.25), 0.75);
        // Beyond all numbers it is black, and then shifted as any other value.
        assert_eq!(red(&inverted, f32::MAX, f32::INFINITY), 1.0);
    }

    #[test]
    fn channels_by_name() {
        let pixels = |a: f32| vec![0.25, 0.5, 0.75, 1.0, 1.0, 0.0, 0.0, a];
        let image = |a| Image::from_data(2, 1, 4, pixels(a)).unwrap();
        let value = |word: &str, a: f32, u: f32| {
            let channel = Channel::of(word, &image(a));
            let t = ImageTexture { channel, ..of_image(image(a), Wrap::Repeat, false) };
            let rgb = t.color(&TexturePoint { uv: Vec2::new(u, 0.5) }).to_rgb();
            assert!(word == "color" || (rgb[0] == rgb[1] && rgb[1] == rgb[2]));
            rgb[0]
        };
        let first = ["color", "red", "green", "blue", "alpha"].map(|word| value(word, 0.125, 0.25));
        assert_eq!(first, [0.25, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(value("luminance", 0.125, 0.25), luminance([0.25, 0.5, 0.75]));
        // A mask is alpha where that says anything.
        assert_eq!(value("mask", 0.125, 0.75), 0.125);
        assert_eq!(value("mask", 1.0, 0.75), luminance([1.0, 0.0, 0.0]));
        let grey = Image::from_data(1, 1, 1, vec![0.5]).unwrap();
        assert_eq!(Channel::of("mask", &grey), Channel::Luminance);
        let with_alpha = Image::from_data(1, 1, 2, vec![0.5, 0.25]).unwrap();
        assert_eq!((alpha(grey.pixel(0, 0)), alpha(with_alpha.pixel(0, 0))), (1.0, 0.25));
    }
}
