//! `aov`: one feature of the first surfaces as the image, for a look at a scene.
//!
//! What `penombre render --aov` writes beside the image, in colours that show it:
//!
//! | `layer` | colour |
//! |---|---|
//! | `normal` | ½ + ½·n of the shading normal on the viewer's side, world space: +x red, +y green, +z blue |
//! | `albedo` | itself: the share of light that the surface scatters, plus what it emits, at most 1 |
//! | `depth` | c / (c + depth): white near, ½ as far as the middle of the scene's box, c metres along the viewing direction |
//! | `position` | the place in the scene's box, from 0 to 1 along each axis |
//! | `uv` | red and green: the part of the surface coordinates behind the point |
//! | `object-id`, `material-id` | a colour of its own for each number |
//!
//! With `raw` the values themselves, as in the layers: metres, numbers. Each pixel is the mean of its samples, so numbers
//! are whole inside objects only, unless `pixel_jitter` is off. Where nothing is, the image is black.
//!
//! ```toml
//! [integrator.aov]
//! layer = "normal"
//! raw = false
//! ```

use super::features::Gatherer;
use super::{AnyIntegrator, CameraSample, LightRecord, PathPlace, PathRecord, VertexRecord, Worker};
use crate::camera::View;
use crate::film::{Feature, FilmLayer};
use crate::registry::Context;
use crate::scene::Scene;
use penombre_math::{Spectrum, Vec3, hash};
use penombre_scene::params::Params;
use penombre_scene::{Kind, Node, ParamDefault, ParamSpec, Role};

/// Rays that are traced between two questions whether to stop.
const TOGETHER: usize = 1024;

/// A feature as the image.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureImage {
    layer: FilmLayer,
    raw: bool,
    /// Index of the camera, along whose viewing direction depths are measured.
    camera: usize,
}

impl FeatureImage {
    /// Its name in scene files.
    pub const NAME: &'static str = "aov";

    /// The parameters of `[integrator.aov]`.
    pub const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "layer",
            Kind::Choice(&["normal", "albedo", "depth", "position", "uv", "object-id", "material-id"]),
            ParamDefault::Text("normal"),
            "Which feature of the first surface is shown.",
        ),
        ParamSpec::with_default(
            "raw",
            Kind::Bool,
            ParamDefault::Bool(false),
            "Its values themselves, not colours that show them.",
        ),
    ];

    /// Decodes the `[integrator.aov]` node, or takes the defaults if there is none. `camera`: index of the camera.
    pub fn build(context: &mut Context<'_, '_>, camera: u32) -> Box<dyn AnyIntegrator> {
        let default = Node::new(Role::Integrator, Self::NAME, Self::NAME);
        let found = context.description.find(Role::Integrator, Self::NAME);
        let node = found.map_or(&default, |id| context.description.node(id));
        let p: Params = context.decode(node, Self::SCHEMA);
        let layer = FilmLayer::from_name(p.choice("layer")).unwrap_or(FilmLayer::Normal);
        Box::new(Self { layer, raw: p.bool("raw"), camera: camera as usize })
    }

    /// The values of the layer, idle channels 0.
    fn values(&self, f: &Feature) -> [f32; 3] {
        match self.layer {
            FilmLayer::Albedo => f.albedo.to_rgb(),
            FilmLayer::Depth => [f.depth; 3],
            FilmLayer::Position => f.position.to_array(),
            FilmLayer::Uv => [f.uv.x, f.uv.y, 0.0],
            FilmLayer::ObjectId => [f.object as f32; 3],
            FilmLayer::MaterialId => [f.material as f32; 3],
            _ => f.normal.to_array(),
        }
    }

    /// Colours that show them.
    fn colors(&self, f: &Feature, stage: &Stage) -> [f32; 3] {
        let values = self.values(f);
        match self.layer {
            FilmLayer::Albedo => values,
            FilmLayer::Depth => values.map(|v| stage.middle / (stage.middle + v.max(0.0))),
            FilmLayer::Position => {
                let place = (f.position - stage.least) / stage.extent;
                place.clamp(Vec3::ZERO, Vec3::ONE).to_array()
            }
            FilmLayer::Uv => values.map(|v| v - v.floor()),
            FilmLayer::ObjectId => of_number(f.object),
            FilmLayer::MaterialId => of_number(f.material),
            _ => values.map(|v| 0.5 + 0.5 * v),
        }
    }
}

impl AnyIntegrator for FeatureImage {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn worker<'a>(&'a self, scene: &'a Scene) -> Box<dyn Worker + 'a> {
        let view = *scene.cameras()[self.camera].value.view();
        let stage = Stage::new(scene, &view);
        Box::new(Shower { image: self, scene, view, stage, gatherer: Gatherer::default() })
    }
}

/// A colour for a number from 1: neighbours far apart, none of them dark.
fn of_number(number: u32) -> [f32; 3] {
    let word = hash::hash_words(&[number]);
    [0, 8, 16].map(|shift| 0.1 + 0.9 * ((word >> shift) & 0xff) as f32 / 255.0)
}

/// What colours are measured by.
#[derive(Clone, Copy, Debug)]
struct Stage {
    /// Depth of the middle of the scene's box, metres; above 0.
    middle: f32,
    /// Least corner and edges of the box, metres; edges above 0.
    least: Vec3,
    extent: Vec3,
}

impl Stage {
    fn new(scene: &Scene, view: &View) -> Self {
        let bounds = scene.bounds();
        if bounds.is_empty() {
            return Self { middle: 1.0, least: Vec3::ZERO, extent: Vec3::ONE };
        }
        let extent = (bounds.max - bounds.min).max(Vec3::splat(f32::MIN_POSITIVE));
        let depth = ((bounds.min + bounds.max) * 0.5 - view.position).dot(view.forward);
        // A camera in the middle of the scene, or beyond it, measures by the size of the box.
        let middle = depth.max(0.25 * extent.max_element());
        Self { middle, least: bounds.min, extent }
    }
}

/// Shows a feature of batches of samples.
struct Shower<'a> {
    image: &'a FeatureImage,
    scene: &'a Scene,
    view: View,
    stage: Stage,
    gatherer: Gatherer,
}

impl Shower<'_> {
    fn show(&mut self, samples: &[CameraSample], radiance: &mut [Spectrum]) {
        let Self { image, scene, view, stage, gatherer } = self;
        for (radiance, feature) in radiance.iter_mut().zip(gatherer.features(scene, view, samples)) {
            let color = |f: &Feature| if image.raw { image.values(f) } else { image.colors(f, stage) };
            *radiance = feature.as_ref().map_or(Spectrum::BLACK, |f| Spectrum::from_rgb(color(f)));
        }
    }
}

impl Worker for Shower<'_> {
    fn trace(&mut self, samples: &[CameraSample], radiance: &mut [Spectrum], stop: &dyn Fn() -> bool) -> u64 {
        let mut traced = 0;
        for (samples, radiance) in samples.chunks(TOGETHER).zip(radiance.chunks_mut(TOGETHER)) {
            if stop() {
                break;
            }
            self.show(samples, radiance);
            traced += samples.len() as u64;
        }
        traced
    }

    fn record(&mut self, sample: &CameraSample) -> PathRecord {
        let mut radiance = [Spectrum::BLACK];
        self.show(std::slice::from_ref(sample), &mut radiance);
        let surface = self.scene.surface(&sample.ray, &self.scene.closest(&sample.ray));
        let [shown] = radiance;
        let light = LightRecord { unoccluded: shown, shadow_rays: 0, visible: 0, added: shown };
        let lights = if surface.is_some() { vec![light] } else { Vec::new() };
        let place = PathPlace { depth: 0, node: 1, weight: Spectrum::WHITE, origin: "camera" };
        let vertices = vec![VertexRecord { place, ray: sample.ray, surface, lights }];
        PathRecord { vertices, radiance: shown, rays: 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::record;
    use crate::testing::{from_toml, plan, rendered, set, small};

    /// The floor y = 0 seen from straight above at 4 m, at u = 0.75, v = 0.5, beside nothing.
    fn seen(parameters: &str) -> [[f32; 3]; 2] {
        let (plan, out) = from_toml(&format!(
            "[render]\nintegrator = \"aov\"\nsize = [3, 1]\npixel_jitter = false\n[integrator.aov]\n{parameters}\n\
             [camera.main]\ntype = \"orthographic\"\nposition = [1, 4, 0]\ntarget = [1, 0, 0]\nup = [0, 0, -1]\nheight = 2\n\
             [material.other]\ntype = \"mirror\"\n\
             [material.it]\ntype = \"diffuse\"\ncolor = [0.5, 0.25, 0.125]\n\
             [shape.floor]\ntype = \"quad\"\norigin = [-2, 0, 2]\nsides = [[4, 0, 0], [0, 0, -4]]\nmaterial = \"it\""
        ));
        let plan = plan.unwrap_or_else(|| panic!("{out:?}"));
        [[1, 0], [2, 0]].map(|p| record(&plan.scene, &*plan.integrator, &plan.job, p, 0).radiance.to_rgb())
    }

    #[test]
    fn values_are_those_of_the_surface_and_nothing_is_black() {
        let raw = [
            ("normal", [0.0, 1.0, 0.0]),
            ("albedo", [0.5, 0.25, 0.125]),
            ("depth", [4.0; 3]),
            ("position", [1.0, 0.0, 0.0]),
            ("uv", [0.75, 0.5, 0.0]),
            ("object-id", [1.0; 3]),
            ("material-id", [2.0; 3]),
        ];
        for (layer, expected) in raw {
            let [floor, nothing] = seen(&format!("layer = \"{layer}\"\nraw = true"));
            let off = floor.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-5);
            assert!(!off, "{layer}: {floor:?}, expected {expected:?}");
            assert_eq!(nothing, [0.0; 3], "{layer}");
        }
    }

    #[test]
    fn colours_lie_between_black_and_white() {
        let shown = [
            ("normal", [0.5, 1.0, 0.5]),
            ("albedo", [0.5, 0.25, 0.125]),
            ("depth", [0.5; 3]),
            ("position", [0.75, 0.0, 0.5]),
            ("uv", [0.75, 0.5, 0.0]),
            ("object-id", of_number(1)),
            ("material-id", of_number(2)),
        ];
        for (layer, expected) in shown {
            let [floor, nothing] = seen(&format!("layer = \"{layer}\""));
            let off = floor.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-5);
            assert!(!off, "{layer}: {floor:?}, expected {expected:?}");
            assert_eq!(nothing, [0.0; 3], "{layer}");
        }
        assert_eq!(seen(""), seen("layer = \"normal\""));
        for (a, b) in (0..50).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let far = of_number(a).iter().zip(of_number(b)).any(|(x, y)| (x - y).abs() > 0.02);
            assert!(far, "{a} and {b} look alike");
        }
    }

    #[test]
    fn batches_and_records_agree() {
        let mut d = small("cornell", 16, 1);
        set(&mut d, Role::Render, "", "integrator", "aov");
        let plan = plan(&d);
        let one = |p| record(&plan.scene, &*plan.integrator, &plan.job, p, 0);
        let paths: Vec<PathRecord> = (0..256).map(|i| one([i % 16, i / 16])).collect();
        let render = rendered(plan);
        let image = render.image();
        for (path, pixel) in paths.iter().zip(image.to_data().chunks(3)) {
            assert_eq!((path.radiance.to_rgb().as_slice(), path.vertices.len()), (pixel, 1));
        }
        assert_eq!(render.statistics().rays, 256);
    }
}
