//! The table against quadrature, and its making.

use super::super::check::is_slow;
use super::super::{Masking, fresnel};
use super::*;
use penombre_lab::Pcg32;
use penombre_math::Vec3;
use std::fmt::Write;

/// A place in the table's range: relative index (infinite for metal), α, side, cosine.
#[derive(Clone, Copy, Debug)]
struct Place {
    eta: f32,
    alpha: f32,
    dense: bool,
    cos: f32,
}

impl Place {
    fn random(rng: &mut Pcg32, metal: bool) -> Self {
        let eta = if metal { f32::INFINITY } else { index_at(0.01 + 0.99 * rng.next_f32()) };
        let alpha =
            if rng.next_f32() < 0.3 { 1e-3 + 0.1 * rng.next_f32() } else { 0.01 + 0.99 * rng.next_f32() };
        let cos = if rng.next_f32() < 0.3 { 0.1 * rng.next_f32() } else { rng.next_f32() };
        Self { eta, alpha, dense: !metal && rng.next_f32() < 0.5, cos }
    }

    fn losses(&self) -> Losses {
        let ggx = Ggx::new([self.alpha; 2]);
        if self.eta.is_finite() { Losses::dielectric(&ggx, self.eta) } else { Losses::conductor(&ggx) }
    }

    /// 1 − E by a midpoint rule of `n` × `n` visible normals, denser where they tilt most.
    fn exact(&self, n: u32) -> f64 {
        let ggx = Ggx::new([self.alpha; 2]);
        let eta = if self.dense { 1.0 / self.eta } else { self.eta };
        let wo = Vec3::new((1.0 - self.cos * self.cos).max(0.0).sqrt(), 0.0, self.cos);
        let so = ggx.projected(wo);
        let kept = |wi: Vec3, share: f32| {
            let masking = ggx.masking(Masking::Correlated, (wo.z, so), (wi.z.abs(), ggx.projected(wi)));
            f64::from(share * masking * (wo.z + so))
        };
        let mut sum = 0.0;
        for i in 0..n {
            let v = (f64::from(i) + 0.5) / f64::from(n);
            let (u, weight) = ((1.0 - (1.0 - v) * (1.0 - v)) as f32, 2.0 * (1.0 - v));
            for j in 0..n {
                let turn = (f64::from(j) + (f64::from(i) * 0.618_034).fract()) / f64::from(n);
                let m = ggx.sample_visible(wo, [u, turn as f32]);
                let c = wo.dot(m).clamp(0.0, 1.0);
                let (f, cos_t) = if eta.is_finite() && self.eta.is_finite() {
                    fresnel::dielectric(c, eta)
                } else {
                    (1.0, 0.0)
                };
                let r = m * (2.0 * c) - wo;
                let t = m * (c / eta - cos_t) - wo / eta;
                sum += if r.z > 0.0 { weight * kept(r, f) } else { 0.0 };
                sum += if f < 1.0 && t.z < 0.0 { weight * kept(t, 1.0 - f) } else { 0.0 };
            }
        }
        1.0 - sum / f64::from(n * n)
    }
}

/// The index at a share in [0, 1] of the dielectric nodes.
fn index_at(x: f32) -> f32 {
    let x = x * x * 0.6;
    (1.0 + x) / (1.0 - x)
}

fn alpha_at(node: usize) -> f32 {
    (node as f32 / (ALPHAS - 1) as f32).powf(4.0 / 3.0).max(2e-4)
}

/// Inverse of the cosine's coordinate.
fn cosine_at(t: f32, alpha: f32) -> f32 {
    let (t, s) = (t * t, 3.0 * alpha);
    (t * s / (1.0 + s - t)).min(1.0)
}

/// Energy after compensation as the lobe gives it: E + l·(mean of l)/L.
fn compensated(place: Place, exact_loss: f64) -> f64 {
    let losses = place.losses();
    let at = |i: i32| ((i as f32 + 0.5) / 400.0) * ((i as f32 + 0.5) / 400.0); // fine near the horizon
    let mean: f32 =
        (0..400).map(|i| 4.0 * at(i) * at(i).sqrt() * losses.at(place.dense, at(i)) / 400.0).sum();
    1.0 - exact_loss
        + f64::from(losses.at(place.dense, place.cos) * mean / losses.mean(place.dense).max(1e-9))
}

/// Common glasses and metal keep all but a hundredth, nothing gains.
#[test]
fn the_table_agrees_with_quadrature() {
    let mut rng = Pcg32::new(70);
    let (mut least, mut most) = (1.0f64, 1.0f64);
    for i in 0..if is_slow() { 20_000 } else { 600 } {
        let mut place = Place::random(&mut rng, i % 2 == 0);
        if place.eta.is_finite() {
            place.eta = 1.3 + 1.7 * rng.next_f32();
        }
        let energy = compensated(place, place.exact(if is_slow() { 96 } else { 48 }));
        assert!(energy > 0.99 && energy < 1.0015, "{place:?}: {energy}");
        (least, most) = (least.min(energy), most.max(energy));
    }
    println!("energy after compensation: {least:.4} to {most:.4}");
}

/// The means are those of the losses. In the full-sized run both tables are made again and must be the same; with
/// `PENOMBRE_BLESS` they are written.
#[test]
fn the_tables_are_what_their_generator_makes() {
    let bless = std::env::var_os("PENOMBRE_BLESS").is_some();
    for (mean, expected) in MEAN.iter().zip(means(&LOSS)) {
        assert!(bless || (f64::from(*mean) - expected).abs() <= 1e-4 * expected, "{mean} {expected}");
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf/energy_table.rs");
    if bless {
        std::fs::write(path, generated()).unwrap();
    } else if is_slow() {
        assert!(std::fs::read_to_string(path).unwrap() == generated(), "bless the tables");
    }
}

/// The tables' file.
fn generated() -> String {
    let table: Vec<u16> = lowered(single_losses()).iter().map(|v| (v / f64::from(UNIT)) as u16).collect();
    let mut text = String::from(
        "//! Tables made by the tests of [`super::energy`].\n\nuse super::energy::{LEN, MEAN_LEN};\n",
    );
    let mut add = |doc: &str, name: &str, rows: &mut dyn Iterator<Item = String>| {
        write!(
            text,
            "\n/// {doc}\n#[rustfmt::skip]\n#[allow(clippy::approx_constant)]\npub(super) static {name} = [\n"
        )
        .unwrap();
        rows.for_each(|row| writeln!(text, "{row}").unwrap());
        text.push_str("];\n");
    };
    let losses = |row: &[u16]| row.iter().map(|v| format!("{v},")).collect();
    let values = |row: &[f64]| row.iter().map(|v| format!("{v:.4e},")).collect();
    let doc = "Losses in units of 10⁻⁴: a line of both sides' cosines for each index and α.";
    add(doc, "LOSS: [u16; LEN]", &mut table.chunks(2 * COSINES).map(losses));
    add("Means divided by α^(3/2).", "MEAN: [f32; MEAN_LEN]", &mut means(&table).chunks(22).map(values));
    text
}

/// The losses at the nodes.
fn single_losses() -> Vec<f64> {
    let mut table = vec![0.0; LEN];
    // At index 1 the boundary vanishes: the losses fade out towards it.
    for i in 1..INDICES {
        for a in 0..ALPHAS {
            for dense in [false, true] {
                let start = loss_row(i, a, dense);
                let metal = i == INDICES - 1;
                let eta = if metal { f32::INFINITY } else { index_at(i as f32 / (INDICES - 2) as f32) };
                let alpha = alpha_at(a);
                for c in 0..COSINES {
                    let cos = cosine_at(c as f32 / (COSINES - 1) as f32, alpha);
                    let dense = dense && eta.is_finite();
                    table[start + c] = exact_unclamped(Place { eta, alpha, dense, cos }, 128).max(0.0);
                }
            }
        }
    }
    table
}

/// [`Place::exact`] for α below those of rough surfaces as well: the limit α → 0 is a function of μ/α.
fn exact_unclamped(place: Place, n: u32) -> f64 {
    let factor = (2e-3 / place.alpha).max(1.0);
    Place { alpha: place.alpha * factor, cos: (place.cos * factor).min(1.0), ..place }.exact(n)
}

/// Power that interpolation may give too much.
const GRANTED: f64 = 1e-4;

/// Lowers nodes around places where interpolation gives more than the true loss.
fn lowered(mut table: Vec<f64>) -> Vec<f64> {
    let mut rng = Pcg32::new(71);
    for i in 0..120_000 {
        let place = Place::random(&mut rng, i % 4 == 0);
        let l = place.losses();
        let t =
            (place.cos * (1.0 + l.spread) / (place.cos + l.spread)).min(1.0).sqrt() * (COSINES - 1) as f32;
        let cell = |v: f32, nodes: usize| {
            let low = (v as usize).min(nodes - 2);
            [(low, 1.0 - f64::from(v - low as f32)), (low + 1, f64::from(v - low as f32))]
        };
        let mut corners = Vec::new();
        for (i, wi) in cell(l.index, INDICES) {
            for (a, wa) in cell(l.alpha, ALPHAS) {
                for (c, wc) in cell(t, COSINES) {
                    corners.push((loss_row(i, a, place.dense) + c, wi * wa * wc));
                }
            }
        }
        let interpolated: f64 = corners.iter().map(|&(at, w)| w * table[at]).sum();
        let excess = interpolated - place.exact(64).max(0.0) - GRANTED;
        if excess > 0.0 {
            corners.iter().filter(|c| c.1 > 0.0).for_each(|c| table[c.0] = (table[c.0] - excess).max(0.0));
        }
    }
    table
}

/// The means of the table as it interpolates.
fn means(table: &[u16]) -> Vec<f64> {
    let mut means = vec![0.0; MEAN_LEN];
    for node in 0..MEAN_ALPHAS {
        let place = node as f32 / FINER as f32;
        let alpha = f64::from((place / (ALPHAS - 1) as f32).powf(4.0 / 3.0)).max(1e-3);
        let (a, da) =
            ((place as usize).min(ALPHAS - 2), f64::from(place - (place as usize).min(ALPHAS - 2) as f32));
        for (i, dense) in (0..INDICES * 2).map(|i| (i / 2, i % 2 == 1)) {
            let at = |c: usize| {
                let [low, high] = [a, a + 1].map(|a| f64::from(table[loss_row(i, a, dense) + c]));
                low + da * (high - low)
            };
            let row: Vec<f64> = (0..COSINES).map(at).collect();
            let mean = mean_of(&row, alpha) * f64::from(UNIT) / alpha.powf(1.5);
            means[mean_place(i, node, dense)] = mean;
        }
    }
    means
}

/// ∫ 2μ·l(μ) dμ of a row, over steps that are fine where the row is.
fn mean_of(row: &[f64], alpha: f64) -> f64 {
    let (s, steps) = (3.0 * alpha, 100);
    let mut mean = 0.0;
    for (c, pair) in row.windows(2).enumerate() {
        for k in 0..steps {
            let cosine = |k: f64| {
                let t = ((c as f64 + k / f64::from(steps)) / (row.len() - 1) as f64).powi(2);
                t * s / (1.0 + s - t)
            };
            let (low, high) = (cosine(f64::from(k)), cosine(f64::from(k) + 1.0));
            let f = (f64::from(k) + 0.5) / f64::from(steps);
            mean += (pair[0] + f * (pair[1] - pair[0])) * (high * high - low * low);
        }
    }
    mean
}
