//! Light samples for many points at once.

use super::Scene;
use crate::light::LightSample;
use crate::light::sampling::quick::{Directions, QuickRectangle, Requests};
use penombre_math::{Spectrum, Vec2, Vec3};
use penombre_sys::{Vectorizable, vectorize};

/// Requests for light samples, and the answers in their order.
#[derive(Debug, Default)]
pub struct LightSamples {
    wanted: Vec<Wanted>,
    /// Requests by emitter.
    by_emitter: Vec<(u32, u32)>,
    answers: Vec<Option<LightSample>>,
    requests: Requests,
    directions: Directions,
}

#[derive(Clone, Copy, Debug)]
struct Wanted {
    from: Vec3,
    u: Vec2,
    probability: f32,
}

/// A rectangle that shines on its front alone.
#[derive(Clone, Copy, Debug)]
pub struct ShiningRectangle {
    /// Its shape.
    pub shape: QuickRectangle,
    /// W/(sr·m²).
    pub radiance: Spectrum,
}

impl LightSamples {
    /// The answers to the requests of the last call of [`Scene::sample_lights`].
    pub fn answers(&self) -> &[Option<LightSample>] {
        &self.answers
    }
}

/// One emitter's requests, as work for wide vectors.
struct Rectangles<'a>(&'a QuickRectangle, &'a Requests, &'a mut Directions);

impl Vectorizable for Rectangles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.sample_all(self.1, self.2);
    }
}

impl Scene {
    /// For each point, number for the choice of an emitter and point of the unit square: what
    /// [`sample_light`](Self::sample_light) gives one by one, but faster, and within rounding.
    pub fn sample_lights(
        &self,
        requests: impl Iterator<Item = (Vec3, f32, Vec2)>,
        samples: &mut LightSamples,
    ) {
        samples.wanted.clear();
        samples.by_emitter.clear();
        samples.answers.clear();
        for (from, choice, u) in requests {
            let chosen = self.choose_emitter(choice);
            let (emitter, probability) = chosen.unwrap_or((usize::MAX, 0.0));
            samples.by_emitter.push((emitter as u32, samples.wanted.len() as u32));
            samples.wanted.push(Wanted { from, u, probability });
            samples.answers.push(None);
        }
        if self.has_several_emitters() {
            samples.by_emitter.sort_unstable();
        }
        let LightSamples { wanted, by_emitter, answers, requests, directions } = samples;
        for group in by_emitter.chunk_by(|a, b| a.0 == b.0) {
            let emitter = group[0].0 as usize;
            if emitter == u32::MAX as usize {
                continue;
            }
            let Some(rectangle) = self.quick_rectangle(emitter) else {
                for (_, index) in group {
                    answers[*index as usize] = self.sample_wanted(emitter, &wanted[*index as usize]);
                }
                continue;
            };
            requests.clear();
            group.iter().map(|(_, i)| wanted[*i as usize]).for_each(|w| requests.push(w.from, w.u));
            vectorize(Rectangles(&rectangle.shape, requests, directions));
            for (k, (_, index)) in group.iter().enumerate() {
                let (w, answer) = (&wanted[*index as usize], &mut answers[*index as usize]);
                if let Some(d) = directions.get(&rectangle.shape, k) {
                    *answer = Some(LightSample {
                        wi: d.wi,
                        point: d.point,
                        distance: d.distance,
                        radiance: rectangle.radiance,
                        pdf: d.pdf * w.probability,
                        normal: rectangle.shape.normal(),
                        aside: 0.0,
                        is_delta: false,
                        is_directed: false,
                    });
                } else if !directions.is_behind(k) {
                    *answer = self.sample_wanted(emitter, w);
                }
            }
        }
    }

    fn sample_wanted(&self, emitter: usize, w: &Wanted) -> Option<LightSample> {
        let sample = self.sample_emitter(emitter, w.from, w.u)?;
        Some(LightSample { pdf: sample.pdf * w.probability, ..sample })
    }
}
