use super::*;
use std::fmt::Write;
use std::fs;

/// A height field of n × n squares, two triangles each, in some format.
fn field(n: u32, name: &str) -> Vec<u8> {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let points: Vec<[f64; 2]> = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y)])).collect();
    let square = |x: u32, y: u32| {
        let i = y * (n + 1) + x;
        [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y))).collect();
    let (vertices, faces) = (points.len(), triangles.len());
    let ply = |format: &str, list: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar {list} vertex_indices\nend_header\n"
        )
    };
    let mut text = String::new();
    let mut binary = Vec::new();
    let floats = |out: &mut Vec<u8>, [x, y]: [f64; 2]| {
        [x as f32, y as f32, 0.5].iter().for_each(|v| out.extend(v.to_le_bytes()));
    };
    match name {
        "m.obj" | "attributes.obj" => {
            let more = name != "m.obj";
            points.iter().for_each(|[x, y]| _ = writeln!(text, "v {x:.4} {y:.4} 0.5"));
            if more {
                points.iter().for_each(|[x, y]| _ = writeln!(text, "vt {x:.3} {y:.3}\nvn 0 0 1"));
            }
            for triangle in &triangles {
                let corner =
                    |i: &u32| if more { format!(" {i}/{i}/{i}", i = i + 1) } else { format!(" {}", i + 1) };
                _ = writeln!(text, "f{}", triangle.iter().map(corner).collect::<String>());
            }
        }
        "m.off" | "text.ply" => {
            text = if name == "m.off" { format!("OFF\n{vertices} {faces} 0\n") } else { ply("ascii", "int") };
            points.iter().for_each(|[x, y]| _ = writeln!(text, "{x:.4} {y:.4} 0.5"));
            triangles.iter().for_each(|[a, b, c]| _ = writeln!(text, "3 {a} {b} {c}"));
        }
        "text.stl" => {
            text = "solid\n".to_owned();
            for triangle in &triangles {
                text += "facet normal 0 0 1\nouter loop\n";
                for [x, y] in triangle.map(|i| points[i as usize]) {
                    _ = writeln!(text, "vertex {x:.4} {y:.4} 0.5");
                }
                text += "endloop\nendfacet\n";
            }
            text += "endsolid\n";
        }
        "m.stl" => {
            binary.extend([0; 80]);
            binary.extend((faces as u32).to_le_bytes());
            for triangle in &triangles {
                binary.extend([0; 12]);
                triangle.iter().for_each(|i| floats(&mut binary, points[*i as usize]));
                binary.extend([0; 2]);
            }
        }
        _ => {
            binary.extend(ply("binary_little_endian", "int").bytes());
            points.iter().for_each(|p| floats(&mut binary, *p));
            for triangle in &triangles {
                binary.push(3);
                triangle.iter().for_each(|i| binary.extend(i.to_le_bytes()));
            }
        }
    }
    binary.extend(text.bytes());
    binary
}

/// The weight of a file, and what its reader finds.
fn weights(name: &str, bytes: &[u8]) -> (MeshWeight, [u64; 2]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("written");
    let format = MeshFormat::of_path(&path).expect("known");
    let weight = weigh(&path, format, bytes.len() as u64).expect("readable");
    let unpacked =
        if is_packed(bytes) { super::super::unpack(bytes).expect("packed") } else { bytes.to_vec() };
    let (mut sources, mut out) = Default::default();
    let folders = super::super::Folders::default();
    let (prefix, sources, out) = ("m", &mut sources, &mut out);
    let mut source = super::super::MeshSource { path: &path, name, prefix, folders: &folders, sources, out };
    let mesh = super::super::read_mesh(format, &unpacked, &mut source).expect("sound").mesh;
    let bytes = 12
        * (mesh.positions.len() + mesh.indices.len() + mesh.normals.len() + mesh.normal_indices.len())
        + 12 * mesh.uv_indices.len()
        + 8 * mesh.uvs.len()
        + 4 * mesh.slots.len();
    (weight, [mesh.indices.len() as u64, bytes as u64])
}

#[test]
fn estimates_are_near_what_the_readers_find() {
    let names = ["m.obj", "attributes.obj", "m.off", "text.ply", "m.ply", "text.stl", "m.stl"];
    for (name, n) in names.iter().flat_map(|name| [(name, 7), (name, 200)]) {
        let (weight, [triangles, bytes]) = weights(name, &field(n, name));
        let ratio = |a: u64, b: u64| a as f64 / b as f64;
        let (many, much) = (ratio(weight.triangles, triangles), ratio(weight.bytes, bytes));
        assert!((0.95..1.2).contains(&many), "{name} {n}: {weight:?} {triangles} triangles");
        // Lists of indices that equal those of positions are left out in the end.
        let most = if weight.has_normals { 2.1 } else { 1.6 };
        assert!((0.95..most).contains(&much), "{name} {n}: {weight:?} {bytes} bytes");
        assert_eq!(weight.has_normals, *name == "attributes.obj");
    }
}

#[test]
fn packed_files_are_weighed_unpacked() {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write as _;
    for name in ["m.ply", "m.stl", "m.off"] {
        let plain = field(60, name);
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&plain).expect("packed");
        let packed = encoder.finish().expect("packed");
        let (weight, [triangles, bytes]) = weights(&format!("{name}.gz"), &packed);
        assert!(weight.text_bytes >= plain.len() as u64, "{name}");
        assert!(weight.bytes >= bytes && weight.triangles < 5 * triangles, "{name}: {weight:?} {triangles}");
    }
}

#[test]
fn what_a_file_claims_and_does_not_hold_weighs_nothing() {
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n\
               property float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n";
    let mut stl = vec![0; 84];
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files: [(&str, &[u8]); 5] = [
        ("a.ply", ply.as_bytes()),
        ("b.stl", &stl),
        ("c.obj", b""),
        ("d.off", b"OFF 4000000000 1 0"),
        ("e.ply", b""),
    ];
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("written");
        let format = MeshFormat::of_path(&path).expect("known");
        let weight = weigh(&path, format, bytes.len() as u64).expect("readable");
        assert!(weight.bytes < 1000 && weight.triangles < 10, "{name}: {weight:?}");
    }
    // Elements without properties, and lengths that no disk has.
    let empty = "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nelement face 9\nend_header\n";
    let faces = "ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uchar uchar vertex_indices\nproperty int a\n\
                 end_header\n";
    let all: [(&str, &str); 5] = [
        ("f.ply", empty),
        ("g.ply", faces),
        ("h.stl", "solid\n"),
        ("i.obj", "f 1 2 3\n"),
        ("j.off", "OFF\n3 0 1 2\n"),
    ];
    for (name, text) in all {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        let format = MeshFormat::of_path(&path).expect("known");
        let weight = weigh(&path, format, 1 << 42).expect("readable");
        assert!(weight.shape_bytes() >= weight.bytes, "{name}: {weight:?}");
    }
    assert!(weigh(&folder.path().join("none.obj"), MeshFormat::Obj, 1 << 40).is_err());
}
