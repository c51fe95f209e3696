//! The light that single scattering loses.
//!
//! Smith's masking throws away light that meets the microsurface again: up to two thirds of it at α = 1. \[Kulla2017\]
//! puts it back by a diffuse lobe in proportion to the losses of both directions. The lost share, 1 − E with E the
//! power that leaves after one bounce (reflected and refracted, F included), stands in a table over the relative index,
//! α, the side of the boundary and the cosine; metal with F = 1 has rows of its own. Indices η above 4 get 4/η of the
//! losses of 4.
//!
//! The table is made by quadrature and lowered where interpolation would exceed the true loss: no energy is gained.
//! `PENOMBRE_BLESS=1 cargo test -p penombre energy` writes it anew (after a change of its size, with tables of zeros in
//! its place). Coordinates in which nodes are equal steps: √((η − 1)/(η + 1)), at the lower end of which the losses
//! fade out with the boundary; α^(3/4); √(μ(1 + s)/(μ + s)) with s = 3α, because the loss near the horizon is a
//! function of μ/α. Measured at 20 000 random places, metal and indices from 1.3 to 3: with its compensation, a surface
//! scatters 0.9916 to 1.0012 of white light.
//!
//! The losses of an anisotropic surface depend on the azimuth as well; for it, the loss of α = √((αx² + αy²)/2) is
//! taken times the smaller α over the larger one. This gives back a part and never too much.

use super::Ggx;
use super::energy_table::{LOSS, MEAN};

/// Nodes of the index (the last for metal), of α, of the cosine.
const INDICES: usize = 18;
const ALPHAS: usize = 16;
const COSINES: usize = 24;
/// The length of the table of losses.
pub(super) const LEN: usize = INDICES * ALPHAS * 2 * COSINES;
/// Means per step of α: with α, the weights of the cosines change as well.
const FINER: usize = 9;
/// Nodes of α of the means.
const MEAN_ALPHAS: usize = (ALPHAS - 1) * FINER + 1;
/// The length of the table of means.
pub(super) const MEAN_LEN: usize = INDICES * MEAN_ALPHAS * 2;
/// (η − 1)/(η + 1) of the largest index, 4.
const LARGEST: f32 = 0.6;
/// The unit of the losses.
const UNIT: f32 = 1e-4;

/// The losses of one surface: its place in the table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Place among the indices, in [0, INDICES − 1].
    index: f32,
    /// Place among the α.
    alpha: f32,
    /// s.
    spread: f32,
    /// Factor of the loss.
    share: f32,
}

impl Losses {
    /// Of metal that reflects everything.
    #[inline]
    pub fn conductor(ggx: &Ggx) -> Self {
        Self::new(ggx, (INDICES - 1) as f32)
    }

    /// Of a boundary with the relative index `eta` or its inverse.
    #[inline]
    pub fn dielectric(ggx: &Ggx, eta: f32) -> Self {
        let eta = eta.max(1.0 / eta);
        let place = ((eta - 1.0) / (eta + 1.0) / LARGEST).min(1.0).sqrt();
        let losses = Self::new(ggx, place * (INDICES - 2) as f32);
        Self { share: losses.share * (4.0 / eta).min(1.0), ..losses }
    }

    #[inline]
    fn new(ggx: &Ggx, index: f32) -> Self {
        let [ax, ay] = ggx.alpha();
        let alpha = if ax == ay { ax } else { (0.5 * (ax * ax + ay * ay)).sqrt() };
        let root = alpha.sqrt();
        Self {
            index,
            alpha: root * root.sqrt() * (ALPHAS - 1) as f32,
            spread: 3.0 * alpha,
            share: ax.min(ay) / ax.max(ay),
        }
    }

    /// Share of light lost from a direction with |z| = `cos` on the rarer or the denser side, in [0, 1].
    #[inline]
    pub fn at(&self, dense: bool, cos: f32) -> f32 {
        let t = (cos * (1.0 + self.spread) / (cos + self.spread)).min(1.0).sqrt() * (COSINES - 1) as f32;
        let column = (t as usize).min(COSINES - 2);
        let f = t - column as f32;
        self.share
            * UNIT
            * self.blend(self.alpha, ALPHAS, |i, a| {
                let row = loss_row(i, a, dense) + column;
                let (low, high) = (f32::from(LOSS[row]), f32::from(LOSS[row + 1]));
                low + f * (high - low)
            })
    }

    /// Its mean over cosine-weighted directions.
    #[inline]
    pub fn mean(&self, dense: bool) -> f32 {
        let alpha = self.spread * (1.0 / 3.0);
        let at = |i, a| MEAN[mean_place(i, a, dense)];
        self.share * alpha * alpha.sqrt() * self.blend(self.alpha * FINER as f32, MEAN_ALPHAS, at)
    }

    /// Interpolates between nodes of the index and of α.
    #[inline]
    fn blend(&self, alpha: f32, alphas: usize, at: impl Fn(usize, usize) -> f32) -> f32 {
        let (i, a) = ((self.index as usize).min(INDICES - 2), (alpha as usize).min(alphas - 2));
        let (di, da) = (self.index - i as f32, alpha - a as f32);
        let low = at(i, a) + da * (at(i, a + 1) - at(i, a));
        let high = at(i + 1, a) + da * (at(i + 1, a + 1) - at(i + 1, a));
        low + di * (high - low)
    }
}

#[inline]
fn loss_row(index: usize, alpha: usize, dense: bool) -> usize {
    ((index * ALPHAS + alpha) * 2 + usize::from(dense)) * COSINES
}

#[inline]
fn mean_place(index: usize, alpha: usize, dense: bool) -> usize {
    (index * MEAN_ALPHAS + alpha) * 2 + usize::from(dense)
}

#[cfg(test)]
mod tests;
