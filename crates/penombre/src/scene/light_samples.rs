//! Light samples for many points at once.

use super::{NO_EMITTER, Scene, SurfacePoint};
use crate::light::LightSample;
use crate::light::sampling::CapAround;
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
    /// Radius of the ball around `from` for which it is; 0 for the point itself.
    around: f64,
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
        self.sample_lights_around(requests.map(|(from, choice, u)| (from, 0.0, choice, u)), samples);
    }

    /// The same for all points of balls, given by their middles and radii: lights that are balls are sampled as
    /// [`CapAround`] does, others as seen from the middle.
    pub fn sample_lights_around(
        &self,
        requests: impl Iterator<Item = (Vec3, f64, f32, Vec2)>,
        samples: &mut LightSamples,
    ) {
        samples.wanted.clear();
        samples.by_emitter.clear();
        samples.answers.clear();
        for (from, around, choice, u) in requests {
            let chosen = self.choose_emitter(choice);
            let (emitter, probability) = chosen.unwrap_or((usize::MAX, 0.0));
            samples.by_emitter.push((emitter as u32, samples.wanted.len() as u32));
            samples.wanted.push(Wanted { from, u, probability, around });
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
                        by_area: false,
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

    /// An emitter that is a ball, seen from all of another one: with its centre and radiance.
    fn ball_around(&self, emitter: usize, from: Vec3, around: f64) -> Option<(CapAround, Vec3, Spectrum)> {
        let (center, radius, radiance) =
            if around > 0.0 { self.emitting_ball(emitter)? } else { return None };
        Some((CapAround::new(from, around, center, radius)?, center, radiance))
    }

    /// Density per area, 1/m², with which [`sample_lights_around`](Self::sample_lights_around) gives the point `at` of an
    /// emitter, for a ball of that middle and radius.
    pub fn light_pdf_around(&self, at: &SurfacePoint, from: Vec3, around: f64) -> f32 {
        if at.emitter == NO_EMITTER {
            return 0.0;
        }
        if let Some((seen, ..)) = self.ball_around(at.emitter as usize, from, around) {
            return seen.pdf(at.p) * self.probability_of(at.emitter as usize);
        }
        let to = at.p - from;
        let distance = to.length();
        let wi = to * (1.0 / distance);
        let cos = -wi.dot(at.ng);
        // Samples shine to the side on which the middle lies.
        if cos * at.wo.dot(at.ng) <= 0.0 {
            return 0.0;
        }
        self.light_pdf(at, from, wi, distance) * cos.abs() / (distance * distance)
    }

    fn sample_wanted(&self, emitter: usize, w: &Wanted) -> Option<LightSample> {
        let sample = match self.ball_around(emitter, w.from, w.around) {
            Some((seen, center, radiance)) => {
                let sample = seen.sample(w.u);
                let normal = (sample.point - center).normalize_or_zero();
                LightSample { by_area: true, ..LightSample::of_shape(sample, normal, radiance) }
            }
            None => self.sample_emitter(emitter, w.from, w.u)?,
        };
        Some(LightSample { pdf: sample.pdf * w.probability, ..sample })
    }
}
