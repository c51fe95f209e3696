//! The table against quadrature, and its making.

use super::super::check::is_slow;
use super::super::{Masking, RoughDielectric, Scatter, Transport, fresnel};
use super::*;
use penombre_lab::Pcg32;
use penombre_math::{Spectrum, Vec3};
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
    /// Most of them near the horizon and the critical angle, and smooth.
    fn random(rng: &mut Pcg32, metal: bool) -> Self {
        let eta = if metal { f32::INFINITY } else { index_at(0.01 + 0.99 * rng.next_f32()) };
        let u = rng.next_f32();
        let alpha = 1e-3 + 0.999 * if rng.next_f32() < 0.5 { u * u * u } else { u };
        let dense = !metal && rng.next_f32() < 0.7;
        let critical = (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt();
        let [from, beyond] = [rng.next_f32(), 4.0 * alpha * rng.next_f32()];
        let cos = match (4.0 * rng.next_f32()) as u32 {
            0 => beyond,
            1 if dense => critical + beyond - 2.0 * alpha,
            _ => from,
        };
        Self { eta, alpha, dense, cos: if (0.0..1.0).contains(&cos) { cos } else { from } }
    }

    fn losses(&self) -> Losses {
        let ggx = Ggx::new([self.alpha; 2]);
        if self.eta.is_finite() { Losses::dielectric(&ggx, self.eta) } else { Losses::conductor(&ggx) }
    }

    /// 1 − E by a midpoint rule of `n`² visible normals on one side of the plane of `wo`, denser where they tilt most. It
    /// is good to 10⁻⁴ for `n` = 128, to 10⁻³ for 64.
    fn exact(&self, n: u32) -> f64 {
        let ggx = Ggx::new([self.alpha; 2]);
        let eta = if self.dense { 1.0 / self.eta } else { self.eta };
        let wo = Vec3::new((1.0 - self.cos * self.cos).max(0.0).sqrt(), 0.0, self.cos);
        let so = ggx.projected(wo);
        let kept = |wi: Vec3, share: f32| {
            let masking = ggx.masking(Masking::Correlated, (wo.z, so), (wi.z.abs(), ggx.projected(wi)));
            f64::from(share * masking * (wo.z + so))
        };
        let (mut sum, mut weights) = (0.0, 0.0);
        let (rows, columns) = (4 * n, n / 4);
        for i in 0..rows {
            let v = (f64::from(i) + 0.5) / f64::from(rows);
            let (u, weight) = ((1.0 - (1.0 - v).powi(3)) as f32, 3.0 * (1.0 - v).powi(2));
            weights += weight;
            for j in 0..columns {
                let turn = 0.5 * (f64::from(j) + (f64::from(i) * 0.618_034).fract()) / f64::from(columns);
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
        1.0 - sum / (weights * f64::from(columns))
    }
}

/// The index at a share in [0, 1] of the dielectric nodes.
fn index_at(x: f32) -> f32 {
    let x = x * x * 0.6;
    (1.0 + x) / (1.0 - x)
}

fn alpha_at(place: f32) -> f32 {
    (FIRST + (1.0 - FIRST) * place / (ALPHAS - 1) as f32).powi(2).min(1.0)
}

/// The surface of a place among the indices and the α.
fn surface(place: [f32; 2]) -> (f32, f32, Losses) {
    let alpha = alpha_at(place[1]);
    let metal = place[0] > (INDICES - 2) as f32;
    let eta = if metal { f32::INFINITY } else { index_at(place[0] / (INDICES - 2) as f32) };
    let mut losses = Place { eta, alpha, dense: false, cos: 1.0 }.losses();
    [losses.index, losses.alpha] = place; // without rounding
    (eta, alpha, losses)
}

/// The pieces of the cosine of a side: their first column, their nodes and their ends, the fine one first.
fn pieces(losses: &Losses, dense: bool) -> Vec<(usize, usize, [f32; 2])> {
    let c = losses.critical;
    if !dense {
        return vec![(0, COSINES, [0.0, 1.0])];
    }
    let ends = [[0.0, 0.5 * c], [c, 0.5 * c], [c, 1.0]];
    (0..3).map(|i| (COSINES + i * PIECE, PIECE, ends[i])).collect()
}

/// The cosine at a share of the nodes of a piece with given ends.
fn cosine_at(t: f32, [from, to]: [f32; 2], s: f32) -> f32 {
    let (t, length) = (t * t, (to - from).abs());
    let distance = t * s / (1.0 + s / length.max(1e-4) - t);
    from + distance.min(length) * (to - from).signum()
}

/// Energy after compensation as the lobe gives it: E + l·(mean of l)/L.
fn compensated(place: Place, exact_loss: f64) -> f64 {
    let losses = place.losses();
    let at = |i: i32| ((i as f32 + 0.5) / 2000.0) * ((i as f32 + 0.5) / 2000.0); // fine near the horizon
    let mean: f32 =
        (0..2000).map(|i| 4.0 * at(i) * at(i).sqrt() * losses.at(place.dense, at(i)) / 2000.0).sum();
    1.0 - exact_loss
        + f64::from(losses.at(place.dense, place.cos) * mean / losses.mean(place.dense).max(1e-9))
}

/// Glasses and metal keep all but a few thousandths; nothing gains.
#[test]
fn the_table_agrees_with_quadrature() {
    let mut rng = Pcg32::new(70);
    let mut range = [[1.0f64; 2]; 2];
    for i in 0..if is_slow() { 20_000 } else { 1000 } {
        let mut place = Place::random(&mut rng, i % 5 == 0);
        if place.eta.is_finite() {
            place.eta = 1.1 + 1.9 * rng.next_f32();
        }
        let energy = compensated(place, place.exact(128));
        let rough = usize::from(place.alpha > 0.3);
        let least = [0.998, 0.996][rough];
        assert!(energy > least && energy < 1.001, "{place:?}: {energy}");
        range[rough] = [range[rough][0].min(energy), range[rough][1].max(energy)];
    }
    println!("energy after compensation, α up to 0.3 and above: {range:.4?}");
}

/// Light that goes round in a ball of white glass comes out: by sphericity, it meets the surface always at the angle at
/// which it left. Without roulette, and with bounces enough for what is caught beyond the critical angle to get out.
#[test]
fn light_goes_round_in_a_ball_and_comes_out() {
    let mut rng = Pcg32::new(72);
    for eta in [1.1, 1.33, 1.5, 2.0, 2.5] {
        for alpha in [0.002, 0.005, 0.02, 0.05, 0.1, 0.3, 1.0] {
            let white = Spectrum::WHITE;
            let glass = RoughDielectric::new([alpha; 2], eta, white, white, Masking::Compensated);
            let paths = if is_slow() { 1_000_000 } else { 20_000 };
            let mut sums = [0.0; 2];
            for k in 0..paths {
                let cos = ((f64::from(k) + 0.5) / f64::from(paths)).sqrt() as f32;
                let power = through_ball(&glass, cos, &mut rng);
                sums = [sums[0] + power, sums[1] + power * power];
            }
            let [mean, square] = sums.map(|s| s / f64::from(paths));
            let error = ((square - mean * mean) / f64::from(paths)).sqrt();
            println!("index {eta}, α {alpha}: {mean:.4} ± {error:.4}");
            // 3.6 standard errors: a hundredth for all 70 bounds.
            assert!((mean - 0.998).abs() < 0.003 + 3.6 * error, "{eta} {alpha}: {mean} ± {error}");
        }
    }
}

/// Power of a path that comes to a ball at an angle, once it leaves.
fn through_ball(glass: &RoughDielectric, mut cos: f32, rng: &mut Pcg32) -> f64 {
    let (mut side, mut power) = (1.0, 1.0);
    for _ in 0..100_000 {
        let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos * side);
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let Some(sample) = glass.sample(wo, u, Transport::Importance) else { return 0.0 };
        power *= f64::from(sample.weight[0]);
        if sample.wi.z > 0.0 {
            return power;
        }
        (side, cos) = (-1.0, -sample.wi.z);
    }
    0.0
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
    let table = losses_table();
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
    add(
        "Losses: a line for each index and two α.",
        "LOSS: [u16; LEN]",
        &mut table.chunks(2 * COLUMNS).map(losses),
    );
    let per_line = 2 * MEANS[1];
    add("Means divided by s².", "MEAN: [f32; MEAN_LEN]", &mut means(&table).chunks(per_line).map(values));
    text
}

/// The losses as they are stored.
fn losses_table() -> Vec<u16> {
    let mut table = vec![0.0; LEN];
    // At index 1 the boundary vanishes: the losses fade out towards it.
    for (i, a) in (1..INDICES).flat_map(|i| (0..ALPHAS).map(move |a| (i, a))) {
        let (eta, alpha, losses) = surface([i as f32, a as f32]);
        for dense in [false, true].into_iter().take(if eta.is_finite() { 2 } else { 1 }) {
            for (column, nodes, ends) in pieces(&losses, dense) {
                for c in 0..nodes {
                    let cos = cosine_at(c as f32 / (nodes - 1) as f32, ends, losses.spread());
                    let stored = Place { eta, alpha, dense, cos }.exact(128) / scale(&losses, column, cos);
                    table[(i * ALPHAS + a) * COLUMNS + column + c] = stored.clamp(0.0, 65_535.0);
                }
            }
        }
    }
    lower(&mut table);
    table.iter().map(|v| *v as u16).collect()
}

/// Loss per stored value at a cosine within the piece with a given first column.
fn scale(losses: &Losses, column: usize, cos: f32) -> f64 {
    let s = losses.spread();
    let distance = if column <= COSINES { cos } else { (cos - losses.critical).abs() };
    let near = 1.0 / (distance + s);
    f64::from(UNIT * if column > COSINES { kink(s) * near.sqrt() } else { 0.25 * s * s * near * near })
}

/// Power that interpolation may give too much.
const GRANTED: f64 = 2e-4;

/// Lowers nodes around places where interpolation gives more than the true loss: the middles of all cells, and many others.
fn lower(table: &mut [f64]) {
    for (i, a) in
        (0..INDICES - 2).flat_map(|i| (0..ALPHAS - 1).map(move |a| (i as f32 + 0.5, a as f32 + 0.5)))
    {
        let (eta, alpha, losses) = surface([i, a]);
        for dense in [false, true] {
            for (_, nodes, ends) in pieces(&losses, dense) {
                for c in 0..nodes - 1 {
                    let cos = cosine_at((c as f32 + 0.5) / (nodes - 1) as f32, ends, losses.spread());
                    lower_at(table, Place { eta, alpha, dense, cos });
                }
            }
        }
    }
    let mut rng = Pcg32::new(71);
    (0..150_000).for_each(|i| lower_at(table, Place::random(&mut rng, i % 6 == 0)));
}

fn lower_at(table: &mut [f64], place: Place) {
    let losses = place.losses();
    let spot = losses.spot(place.dense, place.cos);
    let cell = |v: f32, nodes: usize| {
        let low = (v as usize).min(nodes - 2);
        [(low, 1.0 - f64::from(v - low as f32)), (low + 1, f64::from(v - low as f32))]
    };
    let beyond = f64::from(spot.beyond);
    let mut corners = Vec::new();
    for (i, wi) in cell(losses.index, INDICES) {
        for (a, wa) in cell(losses.alpha, ALPHAS) {
            for (c, wc) in [(spot.column, 1.0 - beyond), (spot.column + 1, beyond)] {
                corners.push(((i * ALPHAS + a) * COLUMNS + c, wi * wa * wc));
            }
        }
    }
    let unit = f64::from(UNIT * losses.share * spot.scale);
    let interpolated: f64 = corners.iter().map(|&(at, w)| w * table[at]).sum();
    let excess = interpolated - (place.exact(96).max(0.0) + GRANTED) / unit;
    if excess > 0.0 {
        // The least change of the nodes that mends it.
        let squares: f64 = corners.iter().map(|c| c.1 * c.1).sum();
        corners.iter().for_each(|&(at, w)| table[at] = (table[at] - excess * w / squares).max(0.0));
    }
}

/// The means of the table as it interpolates, divided by s².
fn means(table: &[u16]) -> Vec<f64> {
    let mut means = Vec::with_capacity(MEAN_LEN);
    for (i, a) in (0..MEANS[0]).flat_map(|i| (0..MEANS[1]).map(move |a| (i, a))) {
        let (_, _, losses) = surface([i as f32 / FINER[0] as f32, a as f32 / FINER[1] as f32]);
        for dense in [false, true] {
            means.push(mean_of(table, &losses, dense) / f64::from(losses.spread()).powi(2));
        }
    }
    means
}

/// ∫ 2μ·l(μ) dμ over steps that are fine where the pieces are.
fn mean_of(table: &[u16], losses: &Losses, dense: bool) -> f64 {
    let mut mean = 0.0;
    for (_, nodes, ends) in pieces(losses, dense) {
        let steps = 40 * (nodes - 1);
        let cosine = |k: f64| f64::from(cosine_at((k / steps as f64) as f32, ends, losses.spread()));
        for k in 0..steps {
            let [low, middle, high] = [0.0, 0.5, 1.0].map(|d| cosine(k as f64 + d));
            mean += f64::from(losses.at_in(table, dense, middle as f32)) * (high * high - low * low).abs();
        }
    }
    mean
}
