//! Smoothing groups of OBJ files.

use crate::common::counts;
use crate::obj::obj;
use penombre_math::Vec3;

/// Two quads that meet at a right angle along x, in the planes y = 0 and z = 0.
const ROOF: &str = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 1 1 0\nv 0 1 0\n";

fn normals(text: &str) -> Vec<[Option<Vec3>; 3]> {
    let read = obj(&format!("{ROOF}{text}"));
    assert_eq!(counts(&read.out), [0; 3], "{:?}", read.messages());
    let mesh = &read.file().mesh;
    let own = if mesh.normal_indices.is_empty() { &mesh.indices } else { &mesh.normal_indices };
    let of = |i: u32| mesh.normals.get(i as usize).copied();
    own.iter().map(|t| t.map(of)).collect()
}

#[test]
fn without_groups_and_with_one_for_all_the_crease_angle_decides() {
    for text in ["f 1 4 3 2\nf 1 2 5 6\n", "s 3\nf 1 4 3 2\nf 1 2 5 6\n", "s 1\nf 1 4 3 2\ns 1\nf 1 2 5 6\n"]
    {
        assert!(normals(text).iter().flatten().all(Option::is_none), "{text}");
        assert!(obj(&format!("{ROOF}{text}")).file().mesh.normals.is_empty());
    }
}

#[test]
fn off_is_flat() {
    for off in ["s off", "s 0", "s"] {
        let read = obj(&format!("{ROOF}{off}\nf 1 4 3 2\nf 1 2 5 6\n"));
        let mesh = &read.file().mesh;
        // There are normals, so that none are made, but none at any corner.
        assert!(!mesh.normals.is_empty());
        assert!(mesh.normal_indices.iter().flatten().all(|i| *i == u32::MAX));
    }
}

#[test]
fn groups_are_smooth_within_and_sharp_between() {
    // The floor twice, then the wall: all have the corners 1 and 2.
    let (y, z) = (Some(Vec3::Y), Some(Vec3::Z));
    let two = normals("s 1\nf 1 4 3 2\ns 2\nf 1 2 5 6\n");
    assert_eq!(two, [[y; 3], [y; 3], [z; 3], [z; 3]]);
    let diagonal = |weights: [f32; 2]| Some(Vec3::new(0.0, weights[0], weights[1]).normalize());
    let first = normals("f 1 4 3\ns 7\nf 1 4 3 2\nf 1 2 5 6\ns 8\nf 1 3 2\n");
    assert_eq!(first[0], [None; 3]);
    // At corner 1 two triangles of the floor meet two of the wall, at corner 2 one meets one.
    let close = |found: Option<Vec3>, expected: Option<Vec3>| {
        (found.unwrap_or(Vec3::X) - expected.unwrap_or(Vec3::NEG_X)).length() < 1e-6
    };
    let [a, b] = [first[1], first[2]];
    assert!(close(a[0], diagonal([2.0, 2.0])) && close(a[1], y) && close(a[2], y), "{a:?}");
    assert!(
        close(b[0], diagonal([2.0, 2.0])) && close(b[1], y) && close(b[2], diagonal([1.0, 1.0])),
        "{b:?}"
    );
    assert!(first[5].iter().all(|n| close(*n, y)), "{:?}", first[5]);
}

#[test]
fn groups_may_come_again() {
    // Floor and wall take turns: the vertices of each have one normal.
    let read = obj(&format!("{ROOF}s 1\nf 1 4 3\ns 2\nf 1 2 5\ns 1\nf 1 3 2\ns 2\nf 1 5 6\n"));
    let mesh = &read.file().mesh;
    assert_eq!(mesh.normals.len(), 8);
    let [floor, wall, again, other] = &mesh.normal_indices[..] else { panic!("four") };
    assert_eq!((floor[0], wall[0]), (again[0], other[0]));
    assert_eq!((floor[2], wall[2]), (again[1], other[1]));
    let is_up = |i: &u32| mesh.normals[*i as usize] == Vec3::Y;
    assert!(floor.iter().chain(again).all(is_up) && !wall.iter().chain(other).any(is_up));
}

#[test]
fn normals_of_the_file_stay() {
    let found = normals("vn 1 0 0\ns 1\nf 1//1 4//1 3//1\nf 1 3 2\ns off\nf 1 2 5\n");
    assert_eq!(found, [[Some(Vec3::X); 3], [Some(Vec3::Y); 3], [None; 3]]);
}

#[test]
fn what_is_no_group_is_told_once() {
    let read = obj(&format!("{ROOF}s smooth\nf 1 4 3 2\ns flat\nf 1 2 5 6\n"));
    assert_eq!(
        read.only(),
        "warning obj::smoothing m.obj:7:3 found `smooth`, expected a smoothing group or `off`"
    );
    assert!(read.file().mesh.normal_indices.iter().flatten().all(|i| *i == u32::MAX));
}
