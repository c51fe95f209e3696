//! `checker`: two colours in turn.
//!
//! The colour is `a` where ⌊u·sᵤ⌋ + ⌊v·sᵥ⌋ is even, else `b`; (u, v) are the surface coordinates and
//! (sᵤ, sᵥ) = `scale` the number of cells per unit of u and v.
//!
//! ```toml
//! [texture.checks]
//! type = "checker"
//! scale = [8, 8]
//! a = [0.8, 0.8, 0.8]
//! b = "#303030"
//! ```

use super::{Texture, TexturePoint};
use crate::registry::Context;
use penombre_math::{Spectrum, Vec2};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range};

/// A chessboard over the surface coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Checker {
    scale: Vec2,
    colors: [Spectrum; 2],
}

impl Texture for Checker {
    const TYPE_NAME: &'static str = "checker";
    const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "scale",
            Kind::Vec2(Range::ANY),
            ParamDefault::Vec2([8.0, 8.0]),
            "Cells per unit of u and of v.",
        ),
        ParamSpec::with_default(
            "a",
            Kind::Color(Range::NON_NEGATIVE),
            ParamDefault::Color([0.8; 3]),
            "Colour of the cell at the origin.",
        ),
        ParamSpec::with_default(
            "b",
            Kind::Color(Range::NON_NEGATIVE),
            ParamDefault::Color([0.1; 3]),
            "Colour of its neighbours.",
        ),
    ];

    fn build(p: &Params, _: &mut Context<'_, '_>) -> Option<Self> {
        let color = |name| Spectrum::from_rgb(p.color(name));
        Some(Self { scale: p.vec2("scale"), colors: [color("a"), color("b")] })
    }

    fn color(&self, at: &TexturePoint) -> Spectrum {
        let cell = (at.uv * self.scale).floor();
        // The parity of the sum in floating point: right for any magnitude, where integers would overflow.
        let odd = (cell.x + cell.y) * 0.5;
        self.colors[usize::from(odd != odd.floor())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(u: f32, v: f32) -> TexturePoint {
        TexturePoint { uv: Vec2::new(u, v) }
    }

    #[test]
    fn neighbours_differ_and_diagonals_agree() {
        let t = Checker { scale: Vec2::new(4.0, 2.0), colors: [Spectrum::WHITE, Spectrum::BLACK] };
        assert_eq!(t.color(&at(0.1, 0.1)), Spectrum::WHITE);
        assert_eq!(t.color(&at(0.3, 0.1)), Spectrum::BLACK);
        assert_eq!(t.color(&at(0.1, 0.6)), Spectrum::BLACK);
        assert_eq!(t.color(&at(0.3, 0.6)), Spectrum::WHITE);
        assert_eq!(t.color(&at(-0.1, 0.1)), Spectrum::BLACK);
    }
}
