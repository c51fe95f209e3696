//! Mesh files: readers, materials and assets, from outside the crate.

mod common;
mod corpus;
mod mutated;
mod obj;
mod off;

#[test]
fn zz_speed() {
    let n = 400;
    let mut obj = String::new();
    let mut off = format!("OFF\n{} {} 0\n", n * n, (n - 1) * (n - 1) * 2);
    for i in 0..n * n {
        let v = format!(
            "{} {} {}",
            (i % n) as f32 * 0.123457,
            (i / n) as f32 * 0.0912347,
            ((i * 7919) % 1000) as f32 * 0.00123
        );
        obj += &format!("v {v}\nvn 0.123 0.456 0.789\nvt 0.5 0.25\n");
        off += &format!("{v}\n");
    }
    for y in 0..n - 1 {
        for x in 0..n - 1 {
            let a = y * n + x;
            for t in [[a, a + 1, a + n], [a + 1, a + n + 1, a + n]] {
                off += &format!("3 {} {} {}\n", t[0], t[1], t[2]);
                let c = t.map(|i| format!("{0}/{0}/{0}", i + 1));
                obj += &format!("f {} {} {}\n", c[0], c[1], c[2]);
            }
        }
    }
    use penombre_scene::readers::MeshFormat;
    for (f, t) in [(MeshFormat::Obj, obj), (MeshFormat::Off, off)] {
        for _ in 0..3 {
            let b = std::time::Instant::now();
            let r = common::read_in(std::path::Path::new("."), f, t.as_bytes());
            let s = b.elapsed().as_secs_f64();
            eprintln!(
                "SPEED {f:?} {} tris {:.1} MB/s",
                r.file().mesh.indices.len(),
                t.len() as f64 / 1e6 / s
            );
        }
    }
}
