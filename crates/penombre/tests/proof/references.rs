//! The pictures of another renderer, from the large test data: its README says how they were made.

use super::common::{Subject, by_size, slow, test_data};
use penombre_image::Image;
use penombre_math::float::sin_cos_degrees;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Edge of the blocks whose means are compared, pixels.
const EDGE: usize = 32;

/// A scene of the repository with one of its files named.
fn subject(name: &str, file: Option<(&str, &Path)>) -> Subject {
    let path = format!("{}/../../tests/scenes/references/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Subject::file(Path::new(&path), file)
}

/// Sums over a block and channel.
#[derive(Clone, Copy, Default)]
struct Block {
    found: f64,
    expected: f64,
    /// Variance of the difference.
    variance: f64,
}

/// Compares the mean of two seeds with a reference whose remaining noise is known: means within 0.3 %, block means within
/// the larger of 2 % and three standard errors.
fn compare(name: &str, subject: &Subject, spp: i64, noise: f64) {
    let Some(path) = test_data(&format!("references/{name}.exr")) else { return };
    let reference = penombre_image::load(&path).unwrap();
    let seeds = [1, 2].map(|seed| subject.with("render", "spp", spp).with("render", "seed", seed).render());
    let columns = reference.width() as usize / EDGE;
    let mut blocks = vec![[Block::default(); 3]; columns * columns];
    let pixel = |image: &Image, i: usize| image.rgb(i as u32 % image.width(), i as u32 / image.width());
    for i in 0..reference.pixel_count() {
        let (x, y) = (i % reference.width() as usize, i / reference.width() as usize);
        let [a, b, r] = [&seeds[0], &seeds[1], &reference].map(|image| pixel(image, i).map(f64::from));
        for c in 0..3 {
            let block = &mut blocks[y / EDGE * columns + x / EDGE][c];
            block.found += 0.5 * (a[c] + b[c]);
            block.expected += r[c];
            block.variance += 0.25 * (a[c] - b[c]) * (a[c] - b[c]) + noise * (r[c] * r[c] + 0.01);
        }
    }
    let sum = |of: fn(&Block) -> f64| blocks.iter().flatten().map(of).sum::<f64>();
    let mean = sum(|b| b.found) / sum(|b| b.expected) - 1.0;
    let (mut worst, mut most) = (0.0f64, 0.0f64);
    for (i, block) in blocks.iter().enumerate() {
        for b in block {
            let (difference, error) = ((b.found - b.expected).abs(), b.variance.sqrt());
            worst = worst.max(difference / b.expected);
            most = most.max(difference / error);
            let allowed = (0.02 * b.expected).max(3.0 * error);
            assert!(difference <= allowed, "{name}: block {i}: {} for {}", b.found, b.expected);
        }
    }
    let (percent, worst) = (100.0 * mean, 100.0 * worst);
    println!("{name}: mean {percent:+.3} %, blocks at most {worst:.2} %, {most:.1} standard errors");
    assert!(mean.abs() < 0.003, "{name}: mean differs by {mean}");
}

#[test]
fn cornell_agrees() {
    compare("cornell", &subject("cornell", None), by_size(8, 256), 6.6e-6);
}

#[test]
fn course_agrees() {
    compare("course", &subject("course", None), by_size(8, 256), 4.9e-5);
}

/// The other renderer puts the first and the last row of an environment's image onto the poles, not half a row beside them:
/// its sun is 0.4 % taller, its ground 0.2 % brighter.
#[test]
fn materials_agree() {
    let Some(sky) = test_data("references/sky.exr") else { return };
    let subject = subject("materials", Some(("light.environment.file", &sky)));
    compare("materials", &subject, by_size(8, 256), 7.3e-6);
}

/// 64 tori of 32768 triangles, by the recipe of the reference.
fn tori(path: &Path) {
    const N: usize = 128;
    let turn = |i: f64| sin_cos_degrees(360.0 * i / N as f64);
    let sin_cos = |radians: f64| sin_cos_degrees(radians.to_degrees());
    let mut text = format!("OFF\n{} {} 0\n", 64 * N * N, 128 * N * N);
    for n in 0..64 {
        let (row, column) = (f64::from(n / 8), f64::from(n % 8));
        let ((s1, c1), (s2, c2)) = (sin_cos(2.399963 * f64::from(n)), sin_cos(1.3247 * f64::from(n)));
        for (i, j) in (0..N * N).map(|k| ((k / N) as f64, (k % N) as f64)) {
            let (sa, ca) = turn(i);
            let (sb, cb) = turn(j);
            let phase = sin_cos_degrees(360.0 * 9.0 * i / N as f64 + f64::from(n).to_degrees()).0;
            let r = 0.11 + 0.02 * phase * turn(7.0 * j).0;
            let (x, y, z) = ((0.3 + r * cb) * ca, r * sb, (0.3 + r * cb) * sa);
            let (y, z) = (c1 * y - s1 * z, s1 * y + c1 * z);
            let (x, z) = (c2 * x + s2 * z, c2 * z - s2 * x);
            let up = 0.45 + 0.1 * sin_cos(1.7 * f64::from(n)).0;
            writeln!(
                text,
                "{:?} {:?} {:?}",
                (x + 0.85 * (column - 3.5)) as f32,
                (y + up) as f32,
                (z + 0.85 * (row - 3.5)) as f32
            )
            .unwrap();
        }
    }
    for n in 0..64 {
        for (i, j) in (0..N * N).map(|k| (k / N, k % N)) {
            let at = |i: usize, j: usize| n * N * N + i % N * N + j % N;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            writeln!(text, "3 {a} {c} {b}\n3 {a} {d} {c}").unwrap();
        }
    }
    std::fs::write(path, text).unwrap();
}

/// A folder that goes when the test ends.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn mesh_agrees() {
    if !slow() {
        println!("NOT RUN: the scene of two million triangles; PENOMBRE_SLOW=1 runs it");
        return;
    }
    let folder = Folder(std::env::temp_dir().join(format!("penombre-tori-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0).unwrap();
    let file = folder.0.join("tori.off");
    tori(&file);
    compare("mesh", &subject("mesh", Some(("shape.tori.file", &file))), 64, 4.0e-5);
}
