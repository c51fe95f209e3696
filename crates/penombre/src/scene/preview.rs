//! What a raster preview draws: the same surfaces and materials as rays see.

use super::Scene;
use crate::material::{PhongView, Shade};
use crate::shape::{Detail, Tessellation};
use crate::texture::TexturePoint;
use penombre_math::{Spectrum, Transform, Vec2, Vec3};

/// One appearance of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Index of the shape.
    pub shape: u32,
    /// The map from the space of its tessellation, or none if that is world space.
    pub to_world: Option<Transform>,
}

impl Scene {
    /// Number of shapes, the surfaces of lights left out.
    pub fn shapes(&self) -> usize {
        self.shapes.own()
    }

    /// Triangles that look like a shape.
    pub fn tessellate(&self, shape: u32, detail: &Detail) -> Tessellation {
        self.shapes.list[shape as usize].value.tessellate(detail)
    }

    /// Index of the material of each slot of a shape; never empty. Slots beyond the last have the last one's.
    pub fn shape_materials(&self, shape: u32) -> &[u32] {
        &self.slots[shape as usize]
    }

    /// All appearances of all shapes.
    pub fn placements(&self) -> impl Iterator<Item = Placement> {
        self.shapes.placed_shapes().iter().map(|p| Placement { shape: p.shape, to_world: p.to_world })
    }

    /// A material in Phong's terms at surface coordinates, for a white vertex colour, seen from right above.
    pub fn material_view(&self, material: u32, uv: Vec2) -> PhongView {
        let point = TexturePoint { uv };
        let (normal, wo) = (Vec3::Z, Vec3::Z);
        let shade = Shade {
            point,
            normal,
            wo,
            outside: true,
            vertex_color: Spectrum::WHITE,
            textures: &self.textures,
            materials: &self.materials,
            u: 0.0,
        };
        self.materials[material as usize].value.phong_view(&shade)
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;
    use crate::shape::Detail;
    use crate::testing::{builtin, plan, set};
    use penombre_bvh::Ray;
    use penombre_math::Vec3;
    use penombre_scene::{Node, Role};

    /// Every vertex of every tessellation lies on the surface that rays meet, and its normal is the surface's.
    fn assert_on_surface(scene: &Scene, tolerance: f32) {
        for placement in scene.placements() {
            let tessellation = scene.tessellate(placement.shape, &Detail::FULL);
            assert!(!tessellation.triangles.is_empty());
            for (p, n) in tessellation.positions.iter().zip(&tessellation.normals).step_by(7) {
                let (p, n) = match placement.to_world {
                    Some(map) => (map.point(*p), map.normal(*n).normalize()),
                    None => (*p, *n),
                };
                assert!((n.length() - 1.0).abs() < 1e-4);
                // From outside along the normal, aimed a little inward so that edges are met too.
                let inward = (scene.bounds().center() - p) * 1e-3;
                let target = p + (inward - n * inward.dot(n));
                let ray = Ray::new(target + n * 0.05, -n, 0.0, 0.1);
                let hit = scene.closest(&ray);
                let at = scene.surface(&ray, &hit);
                let met = at.is_some_and(|at| (at.t - 0.05).abs() < tolerance && at.ns.dot(n).abs() > 0.99);
                assert!(met, "{} at {p}: {at:?}", scene.shape_name(placement.shape));
            }
        }
    }

    #[test]
    fn tessellations_lie_on_the_surfaces() {
        assert_on_surface(&plan(&builtin("sphere")).scene, 2e-3);
        assert_on_surface(&plan(&builtin("square")).scene, 1e-4);
        let mut d = builtin("sphere");
        let stretch = penombre_scene::Value::from([("scale", [1.0, 2.0, 0.5].into())]);
        let name = d.of_role(Role::Shape).next().unwrap().1.name.clone();
        set(&mut d, Role::Shape, &name, "transform", vec![stretch]);
        assert_on_surface(&plan(&d).scene, 2e-3);
        let mut d = builtin("sphere");
        let id = d.find(Role::Shape, &name).unwrap();
        *d.node_mut(id) = Node::new(Role::Shape, "disk", &name).with("normal", [0.3, 1.0, 0.2]);
        assert_on_surface(&plan(&d).scene, 2e-3);
    }

    #[test]
    fn material_views_are_those_of_hits() {
        let scene = plan(&builtin("cornell")).scene;
        for (index, material) in scene.materials().iter().enumerate() {
            assert!(!material.value.is_textured());
            let view = scene.material_view(index as u32, penombre_math::Vec2::splat(0.3));
            assert!(view.diffuse.is_finite());
        }
        let shape = scene.placements().next().unwrap().shape;
        assert!(!scene.shape_materials(shape).is_empty());
        assert!(scene.tessellate(shape, &Detail::FULL).positions.iter().all(|p| Vec3::is_finite(*p)));
    }
}
