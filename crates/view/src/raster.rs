//! A small software rasteriser: which object is where, and how deep.
//!
//! It draws what a graphics card would, triangle by triangle with a depth buffer, and holds the preview against
//! the ray tracer: tests compare silhouettes, a window may ask what lies under the mouse.

use crate::camera::{CourseCamera, Lens};
use crate::preview::PreviewMesh;
use penombre_math::{DVec2, DVec3, float};

/// A pixel on the edge of two triangles belongs to one of them at least, whatever rounding does.
const EDGE_SLACK: f64 = 1e-9;

/// No object.
pub const NOTHING: u32 = u32::MAX;

/// What is seen in each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Index of the shape at the middle of each pixel, or [`NOTHING`]; top row first.
    pub objects: Vec<u32>,
    /// Depth along the viewing direction, metres; infinite where nothing is.
    pub depths: Vec<f64>,
}

impl Frame {
    /// Draws a preview. Triangles are cut at the near plane, and seen from both sides.
    pub fn draw(mesh: &PreviewMesh, camera: &CourseCamera, size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        let mut frame = Self { size, objects: vec![NOTHING; pixels], depths: vec![f64::INFINITY; pixels] };
        let projection = Projection::new(camera, size);
        let corners: Vec<DVec3> =
            mesh.vertices.iter().map(|v| projection.eye(v.position.map(f64::from))).collect();
        for (triangle, object) in mesh.indices.chunks_exact(3).zip(&mesh.objects) {
            let polygon = projection.clip([0, 1, 2].map(|i| corners[triangle[i] as usize]));
            let points: Vec<DVec3> = polygon.into_iter().map(|p| projection.screen(p)).collect();
            for i in 2..points.len() {
                frame.fill([points[0], points[i - 1], points[i]], *object, &projection);
            }
        }
        frame
    }

    /// Fills the pixels whose middles lie in a triangle. Corners: x, y in pixels, then what is linear on the screen.
    fn fill(&mut self, [a, b, c]: [DVec3; 3], object: u32, projection: &Projection) {
        let cross = |o: DVec3, p: DVec3, x: f64, y: f64| (p.x - o.x) * (y - o.y) - (p.y - o.y) * (x - o.x);
        let area = cross(a, b, c.x, c.y);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let range = |values: [f64; 3], edge: u32| {
            let lo = values.iter().fold(f64::INFINITY, |m, v| m.min(*v)) - 0.5;
            let hi = values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v)) + 0.5;
            lo.clamp(0.0, f64::from(edge)) as u32..hi.clamp(0.0, f64::from(edge)) as u32
        };
        for y in range([a.y, b.y, c.y], self.size[1]) {
            for x in range([a.x, b.x, c.x], self.size[0]) {
                let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let u = cross(b, c, px, py) / area;
                let v = cross(c, a, px, py) / area;
                let w = 1.0 - u - v;
                if u.min(v).min(w) < -EDGE_SLACK {
                    continue;
                }
                let depth = projection.depth(u * a.z + v * b.z + w * c.z);
                let pixel = y as usize * self.size[0] as usize + x as usize;
                if depth < self.depths[pixel] && depth <= projection.far {
                    (self.depths[pixel], self.objects[pixel]) = (depth, object);
                }
            }
        }
    }
}

/// From world space to pixels.
struct Projection {
    view: [[f64; 4]; 4],
    near: f64,
    far: f64,
    perspective: bool,
    /// Pixels per unit of the screen at depth 1, or of eye space for parallel rays.
    scale: f64,
    middle: DVec2,
}

impl Projection {
    fn new(camera: &CourseCamera, [width, height]: [u32; 2]) -> Self {
        let planes = camera.planes();
        let (perspective, half) = match camera.lens() {
            Lens::Perspective { fov } => (true, float::tan_degrees(fov * 0.5)),
            Lens::Orthographic { height } => (false, height * 0.5),
        };
        Self {
            view: camera.view_matrix().map(|column| column.map(f64::from)),
            near: planes.near,
            far: planes.far,
            perspective,
            scale: 0.5 * f64::from(height) / half,
            middle: DVec2::new(f64::from(width), f64::from(height)) * 0.5,
        }
    }

    /// x to the right, y up, z the depth.
    fn eye(&self, p: [f64; 3]) -> DVec3 {
        let row = |r: usize| (0..3).map(|c| self.view[c][r] * p[c]).sum::<f64>() + self.view[3][r];
        DVec3::new(row(0), row(1), -row(2))
    }

    /// The part of a triangle beyond the near plane: no corner, or three or four.
    fn clip(&self, corners: [DVec3; 3]) -> Vec<DVec3> {
        let mut result = Vec::with_capacity(4);
        for i in 0..3 {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            if from.z >= self.near {
                result.push(from);
            }
            if (from.z >= self.near) != (to.z >= self.near) {
                result.push(from + (to - from) * ((self.near - from.z) / (to.z - from.z)));
            }
        }
        result
    }

    /// Pixel coordinates, y down, and what is linear on the screen: 1/depth, or the depth for parallel rays.
    fn screen(&self, eye: DVec3) -> DVec3 {
        let scale = if self.perspective { self.scale / eye.z } else { self.scale };
        let z = if self.perspective { 1.0 / eye.z } else { eye.z };
        DVec3::new(self.middle.x + eye.x * scale, self.middle.y - eye.y * scale, z)
    }

    fn depth(&self, z: f64) -> f64 {
        if self.perspective { 1.0 / z } else { z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::LookAt;
    use crate::preview::Vertex;
    use penombre_math::Bounds3;

    /// A square in the plane z = `z`, and one that reaches from far in front of the camera to behind it.
    fn squares() -> PreviewMesh {
        let vertex = |x: f32, y: f32, z: f32| Vertex {
            position: [x, y, z],
            normal: [0.0, 0.0, 1.0],
            uv: [0.0; 2],
            color: [1.0; 4],
        };
        let upright = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| vertex(x, y, 0.0));
        let floor = [(-9.0, 9.0), (9.0, 9.0), (9.0, -90.0), (-9.0, -90.0)].map(|(x, z)| vertex(x, -2.0, z));
        PreviewMesh {
            vertices: upright.into_iter().chain(floor).collect(),
            indices: vec![0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7],
            objects: vec![7, 7, 8, 8],
            ..PreviewMesh::default()
        }
    }

    fn camera(lens: Lens) -> CourseCamera {
        let look = LookAt {
            position: DVec3::new(0.0, 0.0, 6.1),
            target: DVec3::ZERO,
            up: DVec3::Y,
            lens,
            near: 4.1,
            far: 50.0,
        };
        CourseCamera::of_look_at(&look, &Bounds3::EMPTY)
    }

    #[test]
    fn the_course_square_covers_190_pixels() {
        let frame = Frame::draw(&squares(), &camera(Lens::Perspective { fov: 45.0 }), [480, 480]);
        let row = &frame.objects[240 * 480..241 * 480];
        assert_eq!(row.iter().filter(|o| **o == 7).count(), 190);
        assert_eq!((row[145], row[334], row[144], row[335]), (7, 7, NOTHING, NOTHING));
        assert!((frame.depths[240 * 480 + 240] - 6.1).abs() < 1e-5);
    }

    /// The floor goes from behind the eye to beyond the far plane. In row y the depth is 2 / tan: both planes cut it.
    #[test]
    fn near_and_far_planes_cut() {
        let mut floor = squares();
        floor.indices.drain(..6);
        floor.objects.drain(..2);
        let frame = Frame::draw(&floor, &camera(Lens::Perspective { fov: 45.0 }), [48, 480]);
        let tangent = |y: usize| (y as f64 + 0.5 - 240.0) / 240.0 * (22.5f64).to_radians().tan();
        let mut seen = 0;
        for y in 0..480 {
            let depth = 2.0 / tangent(y);
            let pixel = y * 48 + 1;
            let expected = depth > 4.1001 && depth < 50.0;
            assert_eq!(frame.objects[pixel] == 8, expected, "row {y}");
            if expected {
                assert!((frame.depths[pixel] - depth).abs() < 1e-3 * depth);
                seen += 1;
            }
        }
        assert!(seen > 100);
        // Turned over, it is seen as well.
        floor.indices.chunks_exact_mut(3).for_each(|t| t.swap(0, 1));
        let turned = Frame::draw(&floor, &camera(Lens::Perspective { fov: 45.0 }), [48, 480]);
        assert_eq!(turned.objects, frame.objects);
    }

    #[test]
    fn parallel_rays_keep_sizes() {
        let frame = Frame::draw(&squares(), &camera(Lens::Orthographic { height: 4.0 }), [100, 100]);
        assert_eq!(frame.objects.iter().filter(|o| **o == 7).count(), 50 * 50);
        assert!((frame.depths[50 * 100 + 50] - 6.1).abs() < 1e-5);
    }
}
