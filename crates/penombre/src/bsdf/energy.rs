//! The light that single scattering loses.
//!
//! Smith's masking throws away light that meets the microsurface again: up to two thirds of it at α = 1. \[Kulla2017\]
//! puts it back by a diffuse lobe in proportion to the losses of both directions. The lost share, 1 − E with E the
//! power that leaves after one bounce (reflected and refracted, F included), stands in a table over the relative index,
//! α, the side of the boundary and the cosine; metal with F = 1 has rows of its own. Indices η above 4 get 4/η of the
//! losses of 4.
//!
//! The table's coordinates, in which nodes are equal steps, are √((η − 1)/(η + 1)), at whose lower end the losses fade
//! out with the boundary, and √α. On the rarer side the loss is a function of μ/α near the horizon and falls as (α/μ)²
//! from there; the coordinate of the cosine is √(μ(1 + s)/(μ + s)) with s = 3α, and the loss over (s/(μ + s))² is stored:
//! it changes little, even where light is caught for hundreds of bounces, each with a loss of some α². The denser side
//! has a second feature at the critical cosine √(1 − 1/η²): three pieces meet there and at half of it, each with the same
//! coordinate of the distance from its fine end. About the critical cosine losses are in proportion to α²/√(distance + s).
//!
//! The table is made by quadrature and lowered where interpolation exceeds the true loss by more than 2·10⁻⁴.
//! `PENOMBRE_BLESS=1 cargo test -p penombre energy` writes it anew (after a change of its size, with tables of zeros in
//! its place; it takes two or three minutes). Measured at 20 000 random places, metal and indices from 1.1 to 3: with its
//! compensation, a surface scatters 0.998 to 1.0004 of white light for α up to 0.3, and 0.9965 to 1.0006 beyond. Of 10⁶
//! paths into a ball of glass with an index from 1.1 to 2.5, 0.999 to 1.001 come back for α up to 0.1, and 0.997 to 1.005
//! (± 0.003) up to 1.
//!
//! The losses of an anisotropic surface depend on the azimuth as well; for it, the loss of α = √((αx² + αy²)/2) is
//! taken times the smaller α over the larger one. This gives back a part and never too much.

use super::Ggx;
use super::energy_table::{LOSS, MEAN};

/// Nodes of the index (the last for metal).
const INDICES: usize = 22;
/// Nodes of α.
const ALPHAS: usize = 32;
/// Nodes of the cosine on the rarer side, and in each of the three pieces of the denser side.
const COSINES: usize = 32;
const PIECE: usize = 20;
/// All cosines of an index and an α.
const COLUMNS: usize = COSINES + 3 * PIECE;
/// The length of the table of losses.
pub(super) const LEN: usize = INDICES * ALPHAS * COLUMNS;
/// Means per step of the index and of α, with which the weights of the cosines change as well.
const FINER: [usize; 2] = [2, 8];
/// Nodes of the index and of α of the means.
const MEANS: [usize; 2] = [(INDICES - 1) * FINER[0] + 1, (ALPHAS - 1) * FINER[1] + 1];
/// The length of the table of means.
pub(super) const MEAN_LEN: usize = MEANS[0] * MEANS[1] * 2;
/// The largest index, and its (η − 1)/(η + 1).
const LARGEST: [f32; 2] = [4.0, 0.6];
/// √α of the first node.
const FIRST: f32 = 0.031_622_78;
/// The unit of the losses.
const UNIT: f32 = 1.0 / 8192.0;

/// The losses of one surface: its place in the table, in few bytes, for each material holds it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Place among the indices, in [0, INDICES − 1].
    index: f32,
    /// Place among the α.
    alpha: f32,
    /// Factor of the loss.
    share: f32,
    /// The cosine on the denser side below which reflection is total.
    critical: f32,
}

/// A place among the cosines.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// The node below.
    column: usize,
    /// Steps from there to the place.
    beyond: f32,
    /// Losses per stored value.
    scale: f32,
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
        let within = eta.min(LARGEST[0]);
        let place = ((within - 1.0) / (within + 1.0) / LARGEST[1]).min(1.0).sqrt();
        let losses = Self::new(ggx, place * (INDICES - 2) as f32);
        let critical = ((within - 1.0) * (within + 1.0)).sqrt() / within;
        Self { share: losses.share * (within / eta), critical, ..losses }
    }

    #[inline]
    fn new(ggx: &Ggx, index: f32) -> Self {
        let [ax, ay] = ggx.alpha();
        let alpha = if ax == ay { ax } else { (0.5 * (ax * ax + ay * ay)).sqrt() };
        let place = ((alpha.sqrt() - FIRST) / (1.0 - FIRST)).max(0.0) * (ALPHAS - 1) as f32;
        Self { index, alpha: place, share: ax.min(ay) / ax.max(ay), critical: 0.0 }
    }

    /// s.
    #[inline]
    fn spread(&self) -> f32 {
        let root = FIRST + self.alpha * ((1.0 - FIRST) / (ALPHAS - 1) as f32);
        3.0 * root * root
    }

    /// Share of light lost from a direction with |z| = `cos` on the rarer or the denser side, in [0, 1].
    #[inline]
    pub fn at(&self, dense: bool, cos: f32) -> f32 {
        self.at_in(&LOSS, dense, cos)
    }

    #[inline]
    fn at_in(&self, table: &[u16], dense: bool, cos: f32) -> f32 {
        let spot = self.spot(dense, cos);
        let stored = blend([self.index, self.alpha], [INDICES, ALPHAS], |i, a| {
            let at = (i * ALPHAS + a) * COLUMNS + spot.column;
            let (low, high) = (f32::from(table[at]), f32::from(table[at + 1]));
            low + spot.beyond * (high - low)
        });
        (self.share * UNIT * spot.scale * stored).min(1.0)
    }

    #[inline]
    fn spot(&self, dense: bool, cos: f32) -> Spot {
        let (s, half) = (self.spread(), 0.5 * self.critical);
        let (first, nodes, distance, length) = if !dense {
            (0, COSINES, cos, 1.0)
        } else if cos < half {
            (COSINES, PIECE, cos, half)
        } else if cos < self.critical {
            (COSINES + PIECE, PIECE, self.critical - cos, half)
        } else {
            (COSINES + 2 * PIECE, PIECE, cos - self.critical, 1.0 - self.critical)
        };
        let length = length.max(1e-4);
        let inverse = 1.0 / ((distance + s) * length);
        let t = (distance * (length + s) * inverse).min(1.0).sqrt() * (nodes - 1) as f32;
        let (below, near) = ((t as usize).min(nodes - 2), length * inverse);
        let scale = if first > COSINES { kink(s) * near.sqrt() } else { 0.25 * s * s * near * near };
        Spot { column: first + below, beyond: t - below as f32, scale }
    }

    /// Its mean over cosine-weighted directions.
    #[inline]
    pub fn mean(&self, dense: bool) -> f32 {
        let place = [self.index * FINER[0] as f32, self.alpha * FINER[1] as f32];
        let stored = blend(place, MEANS, |i, a| MEAN[(i * MEANS[1] + a) * 2 + usize::from(dense)]);
        let s = self.spread();
        self.share * s * s * stored
    }
}

/// Measure of the losses at the critical cosine.
#[inline]
fn kink(s: f32) -> f32 {
    let bounded = s / (1.0 + s);
    bounded * bounded
}

/// Interpolates between nodes of the index and of α.
#[inline]
fn blend(place: [f32; 2], nodes: [usize; 2], at: impl Fn(usize, usize) -> f32) -> f32 {
    let [i, a] = [0, 1].map(|k| (place[k] as usize).min(nodes[k] - 2));
    let (di, da) = (place[0] - i as f32, place[1] - a as f32);
    let low = at(i, a) + da * (at(i, a + 1) - at(i, a));
    let high = at(i + 1, a) + da * (at(i + 1, a + 1) - at(i + 1, a));
    low + di * (high - low)
}

#[cfg(test)]
mod tests;
