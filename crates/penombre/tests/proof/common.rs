//! Scenes rendered and compared.

use penombre::{Event, Observer, Plan, Render};
use penombre_image::Image;
use penombre_lab::{Moments, TestResult, welch_t_test};
use penombre_scene::load::{LoadOptions, load};
use penombre_scene::toml::read_toml;
use penombre_scene::{Assets, Diagnostics, FileId, Node, Role, SceneDescription, Severity, Value};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// True for the full-sized run.
pub fn slow() -> bool {
    std::env::var_os("PENOMBRE_SLOW").is_some_and(|v| v == "1")
}

/// One of the two, by the size of the run.
pub fn by_size<T>(normal: T, long: T) -> T {
    if slow() { long } else { normal }
}

struct Quiet;

impl Observer for Quiet {
    fn on(&self, _: Event<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// A scene with its files.
#[derive(Clone)]
pub struct Subject {
    pub description: SceneDescription,
    assets: Assets,
}

impl Subject {
    /// From TOML without its version; must be without fault.
    pub fn new(text: &str) -> Self {
        let mut out = Diagnostics::default();
        let read = read_toml(&format!("penombre = 1\n{text}"), FileId(0), &mut out);
        assert!(!out.has_errors(), "{out:?}\n{text}");
        Self { description: read.description, assets: Assets::default() }
    }

    /// From a file; `file` is a parameter and the path that it gets. Must be without fault.
    pub fn file(path: &Path, file: Option<(&str, &Path)>) -> Self {
        let options = LoadOptions {
            asset_roots: file.iter().filter_map(|(_, f)| f.parent()).map(Path::to_path_buf).collect(),
            sets: file.iter().map(|(name, f)| format!("{name}={:?}", f.to_string_lossy())).collect(),
        };
        let loaded = load(&path.to_string_lossy(), &options);
        assert!(!loaded.diagnostics.has_errors(), "{:?}", loaded.diagnostics);
        Self { description: loaded.description, assets: loaded.assets }
    }

    /// The same with a parameter of `[render]`, or of the integrator of that name, set.
    pub fn with(&self, table: &str, param: &str, value: impl Into<Value>) -> Self {
        let mut subject = self.clone();
        let (role, name) = if table == "render" { (Role::Render, "") } else { (Role::Integrator, table) };
        let d = &mut subject.description;
        let id = d.find(role, name).unwrap_or_else(|| d.add(Node::new(role, table, name)));
        d.node_mut(id).set(param, value.into());
        subject
    }

    /// The same seen by another camera, given as TOML.
    pub fn with_camera(&self, camera: &str) -> Self {
        let mut subject = self.clone();
        let other = Self::new(camera).description;
        let camera = other.of_role(Role::Camera).next().unwrap().1;
        let id = subject.description.of_role(Role::Camera).next().unwrap().0;
        *subject.description.node_mut(id) = camera.clone();
        subject
    }

    /// Its image, in which no sample may be lost. Warnings are faults, too.
    pub fn render(&self) -> Image {
        self.render_on(2)
    }

    /// The same on so many threads.
    pub fn render_on(&self, threads: usize) -> Image {
        let mut out = Diagnostics::default();
        let plan = Plan::new(&self.description, &self.assets, &mut out);
        let said = |d: &&penombre_scene::Diagnostic| d.severity != Severity::Advice;
        assert!(!out.iter().any(|d| said(&d)), "{out:?}");
        let mut render = Render::new(plan.unwrap());
        render.run(threads, &Quiet);
        let found = render.statistics();
        assert_eq!(found.non_finite, 0, "{:?}", found.dropped);
        render.image()
    }

    /// Block means over so many seeds.
    pub fn blocks(&self, edge: u32, seeds: u64) -> Blocks {
        let mut blocks = Blocks::default();
        for seed in 1..=seeds {
            blocks.push(&block_means(&self.with("render", "seed", seed as i64).render(), edge));
        }
        blocks
    }
}

/// Mean red, green and blue of each square of `edge` pixels, row by row.
pub fn block_means(image: &Image, edge: u32) -> Vec<[f64; 3]> {
    let columns = image.width() / edge;
    let mut sums = vec![[0.0; 3]; (columns * (image.height() / edge)) as usize];
    for (i, rgb) in image.rgb_pixels().enumerate() {
        let (x, y) = (i as u32 % image.width(), i as u32 / image.width());
        let sum = &mut sums[(y / edge * columns + x / edge) as usize];
        (0..3).for_each(|c| sum[c] += f64::from(rgb[c]) / f64::from(edge * edge));
    }
    sums
}

/// Means of blocks and their scatter from seed to seed.
#[derive(Default)]
pub struct Blocks {
    /// Red, green and blue of each block.
    pub list: Vec<[Moments; 3]>,
    /// Mean of all.
    pub whole: Moments,
}

impl Blocks {
    fn push(&mut self, means: &[[f64; 3]]) {
        self.list.resize_with(means.len(), Default::default);
        for (moments, mean) in self.list.iter_mut().zip(means) {
            (0..3).for_each(|c| moments[c].push(mean[c]));
        }
        self.whole.push(means.iter().flatten().sum::<f64>() / (3 * means.len()) as f64);
    }

    /// What differs most from another image: Welch's test of each block's green, and of the whole. Left out are blocks below
    /// a quarter of the brightest one, to which few samples bring what light there is: their scatter is not the normal
    /// distribution's.
    pub fn difference(&self, other: &Self) -> Difference {
        let bright = |a: &Self, i: usize| a.list[i][1].mean();
        let brightest = (0..other.list.len()).map(|i| bright(other, i)).fold(0.0, f64::max);
        let lit = (0..other.list.len()).filter(|i| bright(other, *i) > 0.25 * brightest);
        let test = |i: usize| (i, welch_t_test(&self.list[i][1], &other.list[i][1]));
        let tests: Vec<(usize, TestResult)> = lit.map(test).collect();
        let (block, worst) =
            tests.iter().copied().min_by(|a, b| a.1.p_value.total_cmp(&b.1.p_value)).unwrap();
        let relative = |a: &Moments, b: &Moments| a.mean() / b.mean() - 1.0;
        Difference {
            whole: welch_t_test(&self.whole, &other.whole),
            whole_relative: relative(&self.whole, &other.whole),
            block,
            worst,
            worst_relative: relative(&self.list[block][1], &other.list[block][1]),
            tests: tests.len() + 1,
        }
    }
}

/// How two images differ.
#[derive(Debug)]
pub struct Difference {
    pub whole: TestResult,
    pub whole_relative: f64,
    /// The block that differs most in standard errors.
    pub block: usize,
    pub worst: TestResult,
    pub worst_relative: f64,
    pub tests: usize,
}

impl Difference {
    /// The smallest probability that chance explains a difference.
    pub fn p_value(&self) -> f64 {
        self.worst.p_value.min(self.whole.p_value)
    }
}

/// A file or folder of the large test data, if it is there; says loudly if it is not.
pub fn test_data(part: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let root = std::env::var_os("PENOMBRE_TESTDATA").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = root.join(part);
    if path.exists() {
        return Some(path);
    }
    eprintln!("NOT RUN: the test data {part} is not there; set PENOMBRE_TESTDATA to its folder");
    None
}
