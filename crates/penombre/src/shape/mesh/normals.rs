//! Vertex normals of meshes that have none.

use super::{Indexed, NONE};
use penombre_math::Vec3;
use penombre_math::float;

/// A vertex at which more different face normals meet than this is smoothed as a whole: comparing each pair
/// would take quadratic time.
const MOST_NORMALS: usize = 64;

/// Normals at the corners of triangles: the normalised sum of the unit normals of those faces around the vertex
/// that meet the corner's face at no more than `crease_angle` degrees. Faces without area count for nothing.
/// Empty at 0 degrees: every face is flat.
pub fn smooth(positions: &[Vec3], indices: &[[u32; 3]], crease_angle: f32) -> Indexed<Vec3> {
    if crease_angle <= 0.0 {
        return Indexed::default();
    }
    let faces: Vec<Vec3> = indices.iter().map(|t| face_normal(positions, t)).collect();
    if crease_angle >= 180.0 {
        return smooth_everywhere(positions.len(), indices, &faces);
    }
    let cosine = float::cos(crease_angle.to_radians());
    let around = Incidence::new(positions.len(), indices);
    let mut result = Indexed { values: Vec::new(), indices: vec![[NONE; 3]; indices.len()] };
    for vertex in 0..positions.len() {
        smooth_vertex(around.corners(vertex), &faces, cosine, &mut result);
    }
    result
}

fn face_normal(positions: &[Vec3], triangle: &[u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

fn smooth_everywhere(vertices: usize, indices: &[[u32; 3]], faces: &[Vec3]) -> Indexed<Vec3> {
    let mut sums = vec![Vec3::ZERO; vertices];
    for (triangle, normal) in indices.iter().zip(faces) {
        for i in triangle {
            sums[*i as usize] += *normal;
        }
    }
    Indexed { values: sums.into_iter().map(Vec3::normalize_or_zero).collect(), indices: Vec::new() }
}

/// Gives the corners around one vertex their normals.
fn smooth_vertex(corners: &[u32], faces: &[Vec3], cosine: f32, result: &mut Indexed<Vec3>) {
    let mut distinct: Vec<(Vec3, f32, Option<u32>)> = Vec::new();
    for corner in corners {
        let n = faces[*corner as usize / 3];
        match distinct.iter().position(|(other, _, _)| *other == n) {
            Some(i) => distinct[i].1 += 1.0,
            None if distinct.len() <= MOST_NORMALS => distinct.push((n, 1.0, None)),
            None => {}
        }
    }
    let cosine = if distinct.len() > MOST_NORMALS { -2.0 } else { cosine };
    for corner in corners {
        let n = faces[*corner as usize / 3];
        let found = distinct.iter().position(|(other, _, _)| *other == n);
        let value = match found.and_then(|i| distinct[i].2) {
            Some(value) => value,
            None => {
                let near = distinct.iter().filter(|(other, _, _)| other.dot(n) >= cosine);
                let sum: Vec3 = near.map(|(other, count, _)| *other * *count).sum();
                result.values.push(sum.normalize_or_zero());
                let value = result.values.len() as u32 - 1;
                if let Some(i) = found {
                    distinct[i].2 = Some(value);
                }
                value
            }
        };
        result.indices[*corner as usize / 3][*corner as usize % 3] = value;
    }
}

/// The corners (3·triangle + 0, 1 or 2) around each vertex, in order.
struct Incidence {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Incidence {
    fn new(vertices: usize, indices: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; vertices + 1];
        for i in indices.iter().flatten() {
            starts[*i as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![0u32; indices.len() * 3];
        for (corner, i) in indices.iter().flatten().enumerate() {
            corners[next[*i as usize] as usize] = corner as u32;
            next[*i as usize] += 1;
        }
        Self { starts, corners }
    }

    fn corners(&self, vertex: usize) -> &[u32] {
        &self.corners[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}
