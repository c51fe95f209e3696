//! Samplers: numbers in the unit square as pure functions of seed, pixel, sample and dimension.
//!
//! Nothing comes from a thread or a tile, and sample k is the same whatever the number of samples asked for:
//! longer, sliced and resumed renders are parts of one run.

mod stratified;

use penombre_math::sobol::{self, Sobol2dRun};
use penombre_math::{Vec2, hash};
use penombre_sys::{Vectorizable, vectorize};

pub use stratified::{STRATA, stratified_2d};

/// The families of sample points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// Padded Owen-scrambled Sobol points \[Burley2020\].
    #[default]
    Sobol,
    /// Independent uniform points.
    Independent,
    /// Jittered points, one in each cell of a 4 × 4 grid for every [`STRATA`] samples.
    Stratified,
}

impl SamplerKind {
    /// Names in scene files, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["sobol", "independent", "stratified"];

    /// The kind of that name; Sobol for any other.
    pub fn from_name(name: &str) -> Self {
        match name {
            "independent" => Self::Independent,
            "stratified" => Self::Stratified,
            _ => Self::Sobol,
        }
    }

    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// One request for sample points: "which number is this?" Integrators derive them from the place in the ray tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension(pub u32);

impl Dimension {
    /// Where in the pixel the ray goes.
    pub const FILM: Self = Self(0);
    /// Which of several models of a surface the features of the first hit take.
    pub const FEATURES: Self = Self(1);

    /// The dimension for the `k`-th use at the node of the ray tree with that number.
    pub fn of_node(node: u32, k: u32) -> Self {
        Self(hash::combine(node, k))
    }
}

/// Any word: what sets the keys of [`Sampler::rescrambled`] apart.
const OTHER_SCRAMBLING: u32 = 0x5eed_b0b5;

/// The sample points of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    key: u32,
    index: u32,
}

impl Sampler {
    /// The points of sample `index` of a pixel.
    #[inline]
    pub fn new(kind: SamplerKind, seed: u64, pixel: [u32; 2], index: u32) -> Self {
        let key = hash::hash_words(&[seed as u32, (seed >> 32) as u32, pixel[0], pixel[1]]) as u32;
        Self { kind, key, index }
    }

    /// The points of another sample of the same pixel.
    #[inline]
    pub fn of_sample(self, index: u32) -> Self {
        Self { index, ..self }
    }

    /// The same sample with another, independent scrambling of all its points.
    #[inline]
    pub fn rescrambled(self) -> Self {
        Self { key: hash::combine(self.key, OTHER_SCRAMBLING), ..self }
    }

    /// The point of this sample in that dimension.
    #[inline]
    pub fn get_2d(&self, dimension: Dimension) -> Vec2 {
        self.series(dimension, 1).get(0)
    }

    /// `count` points for this sample in that dimension. Those of all samples of the pixel form one sequence, so
    /// that they are spread well together.
    #[inline]
    pub fn series(&self, dimension: Dimension, count: u32) -> Series {
        let key = hash::combine(self.key, dimension.0);
        Series { kind: self.kind, key, first: self.index.wrapping_mul(count) }
    }
}

/// Several points of one dimension.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    kind: SamplerKind,
    key: u32,
    first: u32,
}

impl Series {
    /// Point `i` in the unit square.
    #[inline]
    pub fn get(&self, i: u32) -> Vec2 {
        let index = self.first.wrapping_add(i);
        Vec2::from(match self.kind {
            SamplerKind::Sobol => sobol::sobol_2d(index, self.key),
            SamplerKind::Independent => sobol::independent_2d(index, self.key),
            SamplerKind::Stratified => stratified_2d(index, self.key),
        })
    }
}

/// Appends the first points of several series, so many of each, one series after the other: what [`Series::get`] gives one by
/// one, faster.
pub fn fill(series: &[(Series, u32)], points: &mut Vec<[f32; 2]>) {
    if series.iter().all(|(series, _)| series.kind == SamplerKind::Sobol) {
        vectorize(SobolRuns { series, points });
        return;
    }
    for (series, count) in series {
        points.extend((0..*count).map(|i| series.get(i).to_array()));
    }
}

/// Sobol points as work for wide vectors.
struct SobolRuns<'a> {
    series: &'a [(Series, u32)],
    points: &'a mut Vec<[f32; 2]>,
}

impl Vectorizable for SobolRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let run = |(series, count): &(Series, u32)| Sobol2dRun {
            first: series.first,
            seed: series.key,
            count: *count,
        };
        sobol::sobol_2d_runs(self.series.iter().map(run), self.points);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_depend_on_every_word_of_the_key_and_on_nothing_else() {
        let base = Sampler::new(SamplerKind::Sobol, 1, [3, 4], 5);
        let d = Dimension::of_node(1, 0);
        assert_eq!(base.get_2d(d), Sampler::new(SamplerKind::Sobol, 1, [3, 4], 5).get_2d(d));
        let others = [
            Sampler::new(SamplerKind::Sobol, 2, [3, 4], 5),
            Sampler::new(SamplerKind::Sobol, 1 << 40, [3, 4], 5),
            Sampler::new(SamplerKind::Sobol, 1, [4, 3], 5),
            Sampler::new(SamplerKind::Sobol, 1, [3, 4], 6),
            Sampler::new(SamplerKind::Independent, 1, [3, 4], 5),
            Sampler::new(SamplerKind::Stratified, 1, [3, 4], 5),
            base.rescrambled(),
        ];
        for other in others {
            assert_ne!(base.get_2d(d), other.get_2d(d));
        }
        assert_ne!(base.get_2d(d), base.get_2d(Dimension::of_node(1, 1)));
        assert_ne!(base.get_2d(d), base.get_2d(Dimension::FILM));
    }

    #[test]
    fn filled_points_are_those_one_by_one() {
        for kind in SamplerKind::NAMES.iter().map(|name| SamplerKind::from_name(name)) {
            let series =
                |pixel, count| (Sampler::new(kind, 5, [pixel, 2], 3).series(Dimension(4), count), count);
            let all = [series(1, 37), series(2, 0), series(3, 4), series(4, 4), series(5, 1), series(6, 8)];
            let mut points = vec![[0.5; 2]];
            fill(&all, &mut points);
            let expected =
                all.iter().flat_map(|(series, count)| (0..*count).map(|i| series.get(i).to_array()));
            assert!(points[1..].iter().copied().eq(expected));
        }
    }

    #[test]
    fn kinds_have_the_names_they_are_found_by() {
        for name in SamplerKind::NAMES {
            assert_eq!(SamplerKind::from_name(name).name(), *name);
        }
    }

    /// 4 samples of 4 points each fill each of the 16 cells of a 4 × 4 grid once.
    #[test]
    fn series_of_all_samples_are_stratified_together() {
        for kind in [SamplerKind::Sobol, SamplerKind::Stratified] {
            let mut cells = [0; 16];
            for index in 0..4 {
                let series = Sampler::new(kind, 9, [10, 20], index).series(Dimension(77), 4);
                for i in 0..4 {
                    let p = series.get(i) * 4.0;
                    cells[p.x as usize + 4 * p.y as usize] += 1;
                }
            }
            assert_eq!(cells, [1; 16], "{kind:?}");
        }
    }
}
