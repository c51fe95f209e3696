//! The meshes: files, and those that are hard in ways of their own.

use crate::files;
use crate::rays::direction;
use penombre_bvh::{Geometry, Triangles};
use penombre_lab::Pcg32;
use penombre_math::hash::{combine, unit_f32};
use penombre_math::{Bounds3, Vec3, float};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Makes a mesh, or says why it cannot.
type Maker = fn() -> Result<Mesh, String>;

/// The built-in meshes by name.
pub const BUILT_IN: [(&str, Maker); 7] = [
    ("bunny", bunny),
    ("spot", spot),
    ("stadium", stadium),
    ("clusters", clusters),
    ("soup", soup),
    ("sphere", sphere),
    ("terrain", terrain),
];

const BUNNY: &str = "scenes/obj/common-3d/stanford-bunny.obj";

/// Where the camera stands and the light hangs.
#[derive(Clone, Copy, Debug, Default)]
pub struct View {
    /// The camera.
    pub eye: Vec3,
    /// What it looks at.
    pub at: Vec3,
    /// Centre of a horizontal square light.
    pub light: Vec3,
    /// Length of its sides.
    pub light_side: f32,
}

/// Triangles and how they are seen.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Three of them for each triangle.
    pub indices: Vec<[u32; 3]>,
    /// Camera and light.
    pub view: View,
}

impl Mesh {
    /// What our builder takes.
    pub fn geometry(&self) -> Geometry {
        let (positions, indices) = (Arc::from(&*self.positions), Arc::from(&*self.indices));
        Geometry::Triangles(Triangles { positions, indices })
    }

    /// Whether all triangles name vertices that there are.
    pub fn has_valid_indices(&self) -> bool {
        self.indices.iter().flatten().all(|i| (*i as usize) < self.positions.len())
    }

    /// Adds a polygon as triangles around its first corner.
    pub fn fan(&mut self, corners: &[u32]) {
        for pair in corners.windows(2).skip(1) {
            self.indices.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// Unit normal of a triangle, upward for one without area.
    pub fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.indices[triangle as usize].map(|i| self.positions[i as usize]);
        (b - a).cross(c - a).try_normalize().unwrap_or(Vec3::Y)
    }

    /// Puts the mesh into a closed room with a light below the ceiling, seen from a little above.
    pub fn in_room(mut self) -> Self {
        let (centre, size, floor) = self.enclose();
        self.view = View {
            eye: centre + Vec3::new(0.2, 0.25, 1.45) * size,
            at: centre,
            light: Vec3::new(centre.x, floor + 1.85 * size, centre.z),
            light_side: size,
        };
        self
    }

    /// Adds the 12 triangles of the room. Returns the middle of what stands in it, the longest side of its box, and
    /// the floor's height.
    fn enclose(&mut self) -> (Vec3, f32, f32) {
        let bounds = Bounds3::of_points(self.positions.iter().copied());
        let (centre, size) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min).max_element());
        let low = Vec3::new(centre.x - size, bounds.min.y - 0.001 * size, centre.z - size);
        let high = Vec3::new(centre.x + size, bounds.min.y + 1.9 * size, centre.z + 1.6 * size);
        let first = self.positions.len() as u32;
        for corner in 0..8u32 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            self.positions.push(Vec3::new(pick(0), pick(1), pick(2)));
        }
        for wall in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
            self.fan(&wall.map(|corner| first + corner));
        }
        (centre, size, bounds.min.y)
    }

    /// Adds a grid of `columns × rows` quads, each cut in two; `place` gives the point at two coordinates from 0 to
    /// 1. In a closed grid the last column joins the first. Triangles without three distinct corners are left out.
    fn grid(&mut self, columns: u32, rows: u32, closed: bool, place: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len() as u32;
        let across = if closed { columns } else { columns + 1 };
        for row in 0..=rows {
            for column in 0..across {
                self.positions.push(place(column as f32 / columns as f32, row as f32 / rows as f32));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let at = |c: u32, r: u32| first + (row + r) * across + (column + c) % across;
                self.triangle([at(0, 0), at(1, 0), at(1, 1)]);
                self.triangle([at(0, 0), at(1, 1), at(0, 1)]);
            }
        }
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.positions[i as usize]);
        if a != b && b != c && c != a {
            self.indices.push(corners);
        }
    }

    /// A ball of latitudes and longitudes around `centre`; `radius` by direction.
    fn ball(&mut self, [columns, rows]: [u32; 2], centre: Vec3, radius: impl Fn(Vec3) -> f32) {
        self.grid(columns, rows, true, |u, v| {
            let dir = match v {
                0.0 => Vec3::Y,
                1.0 => Vec3::NEG_Y,
                _ => {
                    let ((s, c), (s2, c2)) = (float::sin_cos(PI * v), float::sin_cos(TAU * u));
                    Vec3::new(s * c2, c, s * s2)
                }
            };
            centre + dir * radius(dir)
        });
    }

    /// Each triangle cut into four at the middles of its sides.
    fn subdivided(mut self) -> Self {
        let mut middles = HashMap::new();
        let mut indices = Vec::with_capacity(4 * self.indices.len());
        for &[a, b, c] in &self.indices {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let point = (self.positions[i as usize] + self.positions[j as usize]) * 0.5;
                    self.positions.push(point);
                    self.positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            indices.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        self.indices = indices;
        self
    }
}

/// A scan, 69 k triangles; part of the big test data.
fn bunny() -> Result<Mesh, String> {
    let path = files::test_data(BUNNY);
    let mesh = files::read(&path);
    mesh.map(Mesh::in_room).map_err(|why| {
        format!("{why}; set PENOMBRE_TESTDATA to the folder with the test data, which holds {BUNNY}")
    })
}

fn spot_of_level(level: u32) -> Result<Mesh, String> {
    let coarse = files::read(&files::workspace("assets/meshes/spot.obj"))?;
    Ok((0..level).fold(coarse, |mesh, _| mesh.subdivided()))
}

/// A cow of 1.5 M triangles, many in one plane.
fn spot() -> Result<Mesh, String> {
    spot_of_level(4).map(Mesh::in_room)
}

/// Something fine in the middle of something large and coarse: a cow of 94 k triangles in a bowl of 3 k.
fn stadium() -> Result<Mesh, String> {
    let mut mesh = spot_of_level(2)?;
    let bounds = Bounds3::of_points(mesh.positions.iter().copied());
    let (centre, size) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min).max_element());
    let ground = Vec3::new(centre.x, bounds.min.y, centre.z);
    mesh.grid(64, 24, true, |u, v| {
        let (sin, cos) = float::sin_cos(TAU * u);
        let radius = 40.0 + 140.0 * v;
        ground + Vec3::new(radius * cos, 70.0 * v, radius * sin) * size
    });
    mesh.grid(1, 1, false, |u, v| ground + Vec3::new(u - 0.5, 0.0, v - 0.5) * (90.0 * size));
    mesh.enclose();
    mesh.view = View {
        eye: centre + Vec3::new(0.6, 0.5, 1.9) * size,
        at: centre,
        light: ground + Vec3::Y * (30.0 * size),
        light_side: 20.0 * size,
    };
    Ok(mesh)
}

/// 2500 small balls of 352 triangles each.
fn clusters() -> Result<Mesh, String> {
    let mut rng = Pcg32::new(11);
    let mut mesh = Mesh::default();
    for _ in 0..2500 {
        let centre = in_cube(&mut rng);
        let size = rng.next_f32();
        let radius = 0.01 + 0.05 * size * size;
        mesh.ball([16, 12], centre, |d| radius * (0.7 + 0.6 * noise(d * 3.0 + centre * 50.0)));
    }
    Ok(mesh.in_room())
}

/// 200 k long thin triangles in all directions, whose boxes overlap everywhere.
fn soup() -> Result<Mesh, String> {
    let mut rng = Pcg32::new(7);
    let mut mesh = Mesh::default();
    for first in (0..600_000).step_by(3) {
        let middle = in_cube(&mut rng);
        let (along, aside) = (direction(&mut rng), direction(&mut rng));
        let share = rng.next_f32();
        let half = along * (0.02 + 0.25 * share * share * share);
        mesh.positions.extend([middle - half, middle + half, middle + aside * 0.0015]);
        mesh.indices.push([first, first + 1, first + 2]);
    }
    Ok(mesh.in_room())
}

/// A rough ball of 1 M triangles.
fn sphere() -> Result<Mesh, String> {
    Ok(rough_ball(708).in_room())
}

/// A rough ball of `side` latitudes and longitudes: 2·`side`² triangles, less those that end in a point.
pub fn rough_ball(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ball([side, side], Vec3::ZERO, |d| 0.75 + 0.5 * fractal(d * 2.5 + 9.0, 8));
    mesh
}

/// Mountains of 4 M triangles, seen from above them.
fn terrain() -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    mesh.grid(1414, 1414, false, |u, v| {
        let height = fractal(Vec3::new(6.0 * u, 0.5, 6.0 * v), 10);
        Vec3::new(u, 0.5 * height * height, v)
    });
    let (centre, size, floor) = mesh.enclose();
    mesh.view = View {
        eye: centre + Vec3::new(0.1, 0.25, 0.55) * size,
        at: centre,
        light: Vec3::new(centre.x, floor + 1.85 * size, centre.z),
        light_side: size,
    };
    Ok(mesh)
}

/// Uniform in the cube from −1 to 1.
fn in_cube(rng: &mut Pcg32) -> Vec3 {
    Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
}

/// Noise of several sizes, each half the one before in width and height; between 0 and 1.
fn fractal(point: Vec3, octaves: u32) -> f32 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for _ in 0..octaves {
        scale *= 0.5;
        sum += scale * noise(point / (2.0 * scale));
    }
    sum
}

/// Random values at whole coordinates, smooth between them; from 0 to 1.
fn noise(point: Vec3) -> f32 {
    let base = point.floor();
    let part = point - base;
    let ease = part * part * (3.0 - 2.0 * part);
    let mut sum = 0.0;
    for corner in 0..8u32 {
        let step = Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32);
        let weight = Vec3::ONE - ease + step * (2.0 * ease - 1.0);
        sum += weight.x * weight.y * weight.z * lattice(base + step);
    }
    sum
}

fn lattice(point: Vec3) -> f32 {
    let whole = |x: f32| x as i32 as u32;
    unit_f32(combine(combine(whole(point.x), whole(point.y)), whole(point.z)))
}
