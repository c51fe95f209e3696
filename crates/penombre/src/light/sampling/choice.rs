//! Choosing one light among many.

use penombre_math::distribution::{DiscreteSample, Distribution1D};

/// A choice among lights, with probabilities in proportion to their power.
///
/// A light with any power can be chosen, however dim it is beside the others (among up to 2²² lights); one of
/// power 0 never is, unless all are.
#[derive(Clone, Debug, PartialEq)]
pub struct LightChoice {
    powers: Distribution1D,
}

impl LightChoice {
    /// From the lights' powers in any one unit (see [`power`](super::power)). Negative ones count as 0; a NaN
    /// tells nothing, so that light counts as strong as an infinite one. `None` if there are no lights.
    pub fn new(powers: &[f32]) -> Option<Self> {
        let known: Vec<f32> = powers.iter().map(|p| if p.is_nan() { f32::MAX } else { *p }).collect();
        Distribution1D::new(&known).map(|powers| Self { powers })
    }

    /// Number of lights, at least 1.
    pub fn lights(&self) -> usize {
        self.powers.bins()
    }

    /// The light for `u` ∈ [0, 1): its index, its probability, above 0, and a uniform number to use again.
    pub fn sample(&self, u: f32) -> DiscreteSample {
        self.powers.sample_discrete(u)
    }

    /// Probability that [`sample`](Self::sample) chooses that light; 0 if there is none.
    pub fn probability(&self, index: usize) -> f32 {
        self.powers.probability(index)
    }
}
