//! Spheres that mirror or refract perfectly: light through them can be sought from afar.

use super::Scene;
use crate::bsdf::{Bsdf, Scatter};
use crate::material::Shade;
use crate::shape::AnyShape;
use crate::texture::TexturePoint;
use penombre_math::{DVec3, Spectrum, Vec2, Vec3};

/// A sphere whose surface scatters by delta functions alone, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularSphere {
    /// World space, metres.
    pub center: DVec3,
    /// Metres.
    pub radius: f64,
    /// What it does to light.
    pub bsdf: Bsdf,
    /// Index of the inside relative to the outside; `None` for mirrors.
    pub ior: Option<f64>,
}

/// No such sphere.
pub const NOT_SPECULAR: u32 = u32::MAX;

/// The specular spheres of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct SpecularSpheres {
    list: Vec<SpecularSphere>,
    /// By shape: index into the list, or [`NOT_SPECULAR`].
    of_shape: Vec<u32>,
}

impl SpecularSpheres {
    /// Those of a scene whose other parts are built. A sphere that appears several times, or under a map, is left out.
    pub fn of(scene: &Scene) -> Self {
        let mut found = Self::default();
        let mut appearances = vec![0; scene.shapes.list.len()];
        for placed in &scene.shapes.placed {
            appearances[placed.shape as usize] += if placed.to_world.is_some() { 2 } else { 1 };
        }
        for (index, times) in appearances.into_iter().enumerate() {
            let sphere = if times == 1 { specular(scene, index) } else { None };
            found.of_shape.push(if sphere.is_some() { found.list.len() as u32 } else { NOT_SPECULAR });
            found.list.extend(sphere);
        }
        found
    }
}

fn specular(scene: &Scene, index: usize) -> Option<SpecularSphere> {
    let AnyShape::Sphere(sphere) = &scene.shapes.list[index].value else { return None };
    let material = &scene.materials[scene.slots[index][0] as usize].value;
    if material.is_textured() || material.is_emissive() || material.has_opacity() {
        return None;
    }
    let shade = Shade {
        point: TexturePoint { uv: Vec2::ZERO },
        normal: Vec3::Z,
        wo: Vec3::Z,
        outside: true,
        vertex_color: Spectrum::WHITE,
        textures: &scene.textures,
        materials: &scene.materials,
        u: 0.0,
    };
    let bsdf = material.bsdf(&shade);
    let ior = match &bsdf {
        Bsdf::Mirror(_) => None,
        Bsdf::RoughConductor(b) if b.is_delta_only() => None,
        Bsdf::SmoothDielectric(b) if b.eta() != 1.0 => Some(f64::from(b.eta())),
        _ => return None,
    };
    let (center, radius) = sphere.center_and_radius();
    Some(SpecularSphere { center: center.as_dvec3(), radius: f64::from(radius), bsdf, ior })
}

impl Scene {
    /// The spheres that mirror or refract perfectly.
    #[inline]
    pub fn specular_spheres(&self) -> &[SpecularSphere] {
        &self.specular.list
    }

    /// Index among [`specular_spheres`](Self::specular_spheres) of a shape, or [`NOT_SPECULAR`].
    #[inline]
    pub fn specular_sphere_of(&self, shape: u32) -> u32 {
        self.specular.of_shape.get(shape as usize).copied().unwrap_or(NOT_SPECULAR)
    }
}
