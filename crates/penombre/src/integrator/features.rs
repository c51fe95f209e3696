//! Features of first hits: for layers, and for the image of `aov`.

use super::CameraSample;
use crate::bsdf::Scatter;
use crate::camera::View;
use crate::film::Feature;
use crate::sampler::Dimension;
use crate::scene::Scene;
use penombre_bvh::{Hit, Ray};
use penombre_math::{Frame, Spectrum};

/// Finds what camera rays meet first.
#[derive(Debug, Default)]
pub(crate) struct Gatherer {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
}

impl Gatherer {
    /// The features of each sample in their order; `None` for those that meet nothing.
    pub fn features<'a>(
        &'a mut self,
        scene: &'a Scene,
        view: &'a View,
        samples: &'a [CameraSample],
    ) -> impl Iterator<Item = Option<Feature>> + 'a {
        self.rays.clear();
        self.rays.extend(samples.iter().map(|s| s.ray));
        self.hits.clear();
        self.hits.resize(samples.len(), Hit::MISS);
        scene.closest_batch(&self.rays, &mut self.hits);
        samples.iter().zip(&self.hits).map(|(sample, hit)| feature(scene, view, sample, hit))
    }
}

/// The features of the surface at a hit.
fn feature(scene: &Scene, view: &View, sample: &CameraSample, hit: &Hit) -> Option<Feature> {
    let at = scene.surface(&sample.ray, hit)?;
    let bsdf = scene.bsdf(&at, sample.sampler.get_2d(Dimension::FEATURES).x);
    let scattered = bsdf.albedo(Frame::from_z(at.ns).to_local(at.wo)).to_rgb();
    let emitted = scene.emitted(&at).to_rgb();
    let albedo = std::array::from_fn(|c| (scattered[c] + emitted[c]).min(1.0));
    let object = if hit.instance == Hit::NO_INSTANCE { hit.geometry } else { hit.instance };
    Some(Feature {
        albedo: Spectrum::from_rgb(albedo),
        normal: at.facing_normal(),
        position: at.p,
        depth: (at.p - view.position).dot(view.forward),
        uv: at.uv,
        object: object + 1,
        material: at.material + 1,
    })
}
