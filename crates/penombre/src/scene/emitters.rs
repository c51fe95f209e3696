//! What shines: the lights and the shapes that emit, and which of them to sample.

mod find;
mod shape;

use super::light_samples::ShiningRectangle;
use super::{Named, Scene, SurfacePoint};
use crate::light::sampling::LightChoice;
use crate::light::sampling::quick::QuickRectangle;
use crate::light::{AnyLight, Escaped, LightSample};
use find::Finder;
use penombre_math::{Spectrum, Vec2, Vec3};
use shape::ShapeEmitter;

/// No emitter.
pub const NO_EMITTER: u32 = u32::MAX;

/// All that shines in a scene. An emitter's index is that of its light; the shapes that shine follow, each appearance on its
/// own.
#[derive(Clone, Debug, Default)]
pub(super) struct Emitters {
    choice: Choice,
    /// Lights at infinity.
    infinite: Vec<u32>,
    /// By emitter, shapes left out: those that are rectangles and shine on one side.
    rectangles: Vec<Option<ShiningRectangle>>,
    shapes: Vec<ShapeEmitter>,
    /// For each geometry of the upper level its place in `shapes`, or [`NO_EMITTER`]; empty if there are none.
    of_placed: Vec<u32>,
}

/// Which emitter to sample.
#[derive(Clone, Debug, Default)]
enum Choice {
    /// There is none.
    #[default]
    None,
    /// There is no other.
    Only(usize),
    ByPower(LightChoice),
}

impl Choice {
    fn new(powers: &[f32]) -> Self {
        let mut shining = powers.iter().enumerate().filter(|(_, p)| **p > 0.0 || p.is_nan());
        match (shining.next(), shining.next()) {
            (None, _) => Self::None,
            (Some((only, _)), None) => Self::Only(only),
            _ => LightChoice::new(powers).map_or(Self::None, Self::ByPower),
        }
    }

    /// The emitter and its probability.
    #[inline]
    fn sample(&self, u: f32) -> Option<(usize, f32)> {
        match self {
            Self::None => None,
            Self::Only(index) => Some((*index, 1.0)),
            Self::ByPower(choice) => {
                let chosen = choice.sample(u);
                Some((chosen.index, chosen.probability))
            }
        }
    }

    #[inline]
    fn probability(&self, index: usize) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Only(only) => f32::from(u8::from(*only == index)),
            Self::ByPower(choice) => choice.probability(index),
        }
    }
}

impl Emitters {
    /// The emitters of a scene whose other parts are built. Shapes are among them if lights are surfaces, which is where
    /// light is physical.
    pub fn of(scene: &Scene, solid_lights: bool) -> Self {
        let bounds = scene.bounds();
        let size = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length();
        let radius = if bounds.is_empty() { 1.0 } else { (0.5 * size).min(f64::from(f32::MAX)) as f32 };
        let (shapes, of_placed) =
            if solid_lights { Finder::new(scene).all() } else { (Vec::new(), Vec::new()) };
        let mut powers: Vec<f32> = scene.lights.iter().map(|l| l.value.power(radius)).collect();
        powers.extend(shapes.iter().map(|s| s.power));
        let far: Vec<usize> =
            (0..scene.lights.len()).filter(|i| scene.lights[*i].value.is_infinite()).collect();
        halve(&mut powers, &far);
        let infinite = scene.lights.iter().zip(0..);
        let infinite = infinite.filter(|(l, _)| l.value.escaped(Vec3::Y).is_some()).map(|(_, i)| i);
        let rectangle = |l: &Named<AnyLight>| {
            let (origin, sides) = l.value.parallelogram()?;
            let shape = QuickRectangle::new(origin, sides)?;
            let [front, back] =
                [1.0, -1.0].map(|side| l.value.emitted(shape.normal(), shape.normal() * side));
            back.is_black().then_some(ShiningRectangle { shape, radiance: front })
        };
        Self {
            choice: Choice::new(&powers),
            infinite: infinite.collect(),
            rectangles: scene.lights.iter().map(rectangle).collect(),
            shapes,
            of_placed,
        }
    }

    /// The emitter of a geometry of the upper level whose material shines, counted from the first shape that does, or
    /// [`NO_EMITTER`].
    #[inline]
    fn of_shape(&self, placed: u32) -> u32 {
        self.of_placed.get(placed as usize).copied().unwrap_or(NO_EMITTER)
    }
}

/// Leaves the lights at infinity at most half of the choice. Their power is that on the sphere around the scene, and a
/// large ground, most of which nobody sees, would leave nothing for the lamps that stand on it.
fn halve(powers: &mut [f32], far: &[usize]) {
    let all: f64 = powers.iter().map(|p| f64::from(*p)).sum();
    let infinite: f64 = far.iter().map(|i| f64::from(powers[*i])).sum();
    let near = all - infinite;
    if near > 0.0 && infinite > near {
        far.iter().for_each(|i| powers[*i] = (f64::from(powers[*i]) * (near / infinite)) as f32);
    }
}

impl Scene {
    /// Chooses an emitter by `choice` ∈ [0, 1) and a direction from which its light reaches `from` by `u` ∈ [0, 1)². The
    /// density is that of the direction times the probability of the emitter. `None`: no light from there.
    #[inline]
    pub fn sample_light(&self, from: Vec3, choice: f32, u: Vec2) -> Option<LightSample> {
        let (emitter, probability) = self.choose_emitter(choice)?;
        let sample = self.sample_emitter(emitter, from, u)?;
        Some(LightSample { pdf: sample.pdf * probability, ..sample })
    }

    /// An emitter by a number in [0, 1), and its probability.
    #[inline]
    pub(super) fn choose_emitter(&self, choice: f32) -> Option<(usize, f32)> {
        self.emitters.choice.sample(choice)
    }

    /// A direction from which an emitter's light reaches `from`.
    #[inline]
    pub(super) fn sample_emitter(&self, emitter: usize, from: Vec3, u: Vec2) -> Option<LightSample> {
        match self.lights.get(emitter) {
            Some(light) => light.value.sample_towards(from, u),
            None => self.emitters.shapes[emitter - self.lights.len()].sample(self, from, u),
        }
    }

    /// Probability with which an emitter is chosen.
    #[inline]
    pub(super) fn probability_of(&self, emitter: usize) -> f32 {
        self.emitters.choice.probability(emitter)
    }

    /// Centre, radius and radiance of an emitter that is a ball and shines evenly to the outside.
    #[inline]
    pub(super) fn emitting_ball(&self, emitter: usize) -> Option<(Vec3, f32, Spectrum)> {
        match self.lights.get(emitter) {
            Some(light) => light.value.ball(),
            None => self.emitters.shapes[emitter - self.lights.len()].ball(self),
        }
    }

    /// The emitter if it is a light that is a rectangle and shines on one side.
    #[inline]
    pub(super) fn quick_rectangle(&self, emitter: usize) -> Option<&ShiningRectangle> {
        self.emitters.rectangles.get(emitter)?.as_ref()
    }

    /// True if there is an emitter to sample.
    #[inline]
    pub fn samples_light(&self) -> bool {
        !matches!(self.emitters.choice, Choice::None)
    }

    /// True if there is a choice among emitters.
    #[inline]
    pub fn has_several_emitters(&self) -> bool {
        matches!(self.emitters.choice, Choice::ByPower(_))
    }

    /// Density with which [`sample_light`](Self::sample_light) gives the unit direction `wi` from a point through the emitter
    /// at `at`, 1/sr: `at` is where a ray from `from` along `wi` first met a surface, at `distance` metres. 0 where nothing
    /// shines, and for emitters that are found by scattered rays only.
    #[inline]
    pub fn light_pdf(&self, at: &SurfacePoint, from: Vec3, wi: Vec3, distance: f32) -> f32 {
        if at.emitter == NO_EMITTER {
            return 0.0;
        }
        let index = at.emitter as usize;
        let probability = self.emitters.choice.probability(index);
        if probability <= 0.0 {
            return 0.0;
        }
        let pdf = match self.lights.get(index) {
            Some(light) => light.value.pdf_towards(from, wi, distance),
            None => {
                let shape = &self.emitters.shapes[index - self.lights.len()];
                shape.pdf(at.prim, from, wi, distance).unwrap_or(0.0)
            }
        };
        probability * pdf
    }

    /// Radiance that the surface itself sends towards `at.wo`, W/(sr·m²).
    #[inline]
    pub fn emitted(&self, at: &SurfacePoint) -> Spectrum {
        if at.emitter == NO_EMITTER {
            return Spectrum::BLACK;
        }
        match self.lights.get(at.emitter as usize) {
            Some(light) => light.value.emitted(at.ng, at.wo),
            None => self.material_emission(at, at.outside()),
        }
    }

    /// What comes from infinity against the unit direction `dir` of a ray that leaves the scene, for each light there. The
    /// densities are those of [`sample_light`](Self::sample_light).
    #[inline]
    pub fn escaped(&self, dir: Vec3) -> impl Iterator<Item = Escaped> {
        self.emitters.infinite.iter().filter_map(move |i| {
            let Escaped { radiance, pdf } = self.lights[*i as usize].value.escaped(dir)?;
            Some(Escaped { radiance, pdf: pdf * self.emitters.choice.probability(*i as usize) })
        })
    }

    /// What the material at a surface sends to one of its sides.
    fn material_emission(&self, at: &SurfacePoint, outside: bool) -> Spectrum {
        self.materials[at.material as usize].value.emitted(&self.shade(at, 0.0), outside)
    }

    /// The emitter of a geometry of the upper level at a point that is made of that material, or [`NO_EMITTER`].
    #[inline]
    pub(super) fn emitter_at(&self, placed: u32, material: u32) -> u32 {
        let shape = self.emitters.of_shape(placed);
        if shape != NO_EMITTER && self.materials[material as usize].value.is_emissive() {
            return self.lights.len() as u32 + shape;
        }
        self.shapes.emitter_of(placed)
    }

    /// True if a shape is made of a material that may emit.
    pub(super) fn has_emissive_shapes(&self) -> bool {
        let mut used = self.slots.iter().flatten();
        used.any(|m| self.materials[*m as usize].value.is_emissive())
    }
}

#[cfg(test)]
mod tests;
