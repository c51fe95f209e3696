//! The classes of differences, and who is right in each.

use super::oracle::{Crossing, Oracle};
use penombre_bvh::{Hit, Ray};

/// Distances that differ by a smaller share are the same: four units in the last place.
pub const SAME: f64 = 1.0 / (1u64 << 21) as f64;
/// An answer whose distance is off by a smaller share is right.
const RIGHT: f64 = 1e-5;
/// Margins that rounding explains, in [`super::oracle::UNIT`]s.
const ROUNDING: f64 = 8.0;

/// Who gives the true answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Right {
    pub we: usize,
    pub they: usize,
    pub both: usize,
    pub neither: usize,
}

impl Right {
    fn count(&mut self, we: bool, they: bool) {
        match (we, they) {
            (true, false) => self.we += 1,
            (false, true) => self.they += 1,
            (true, true) => self.both += 1,
            (false, false) => self.neither += 1,
        }
    }

    /// As in tables.
    pub fn text(&self) -> String {
        format!("{}/{}/{}/{}", self.we, self.they, self.both, self.neither)
    }
}

/// How far answers of one side are from the truth.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Largest error of a distance where both sides hit the same triangle and differ, as a share of the distance …
    pub distance: f64,
    /// … and the largest distance of such a hit from the triangle's plane, in [`super::oracle::UNIT`]s.
    pub plane: f64,
    /// Answers that are not true, by how much rounding would have to change the ray; the largest.
    pub margin: f64,
    /// Untrue answers that rounding does not explain.
    pub unexplained: usize,
}

/// What was found on one buffer of rays.
#[derive(Clone, Debug, Default)]
pub struct Classes {
    pub rays: usize,
    /// The same triangle at the same distance, or both miss.
    pub same: usize,
    /// The same triangle, distances apart by more than [`SAME`].
    pub distance: Right,
    /// Two triangles with a common corner, at the same distance.
    pub tie_of_neighbours: usize,
    /// Two other triangles that the ray meets at the same distance.
    pub tie_of_others: usize,
    /// Two triangles at different distances.
    pub surface: Right,
    /// We hit, Embree misses.
    pub only_we: Right,
    /// Embree hits, we miss.
    pub only_they: Right,
    pub our_errors: Errors,
    pub their_errors: Errors,
    /// Answers of ours that a loop over all triangles would not have given.
    pub faults: Vec<Ray>,
}

impl Classes {
    /// Adds a ray for which the closest hit was asked for.
    pub fn closest(&mut self, oracle: &Oracle<'_>, ray: &Ray, ours: &Hit, theirs: &Hit) {
        self.rays += 1;
        match (ours.is_hit(), theirs.is_hit()) {
            (false, false) => self.same += 1,
            (true, true) if ours.prim == theirs.prim => self.same_triangle(oracle, ray, ours, theirs),
            (true, true) => self.other_triangle(oracle, ray, ours, theirs),
            _ => self.examine(oracle, ray, ours, theirs),
        }
    }

    /// Adds a ray for which any hit was asked for.
    pub fn occluded(&mut self, oracle: &Oracle<'_>, ray: &Ray, ours: bool, theirs: bool) {
        self.rays += 1;
        if ours == theirs {
            self.same += 1;
            return;
        }
        let crossings = oracle.crossings(ray);
        let truth = crossings.iter().any(Crossing::is_hit);
        // A true hit that is denied is as clear as the clearest of all, one that is made up as the most likely.
        let hits = crossings.iter().filter(|c| c.is_hit()).map(Crossing::margin).fold(0.0, f64::max);
        let misses =
            crossings.iter().filter(|c| !c.is_hit()).map(Crossing::margin).fold(f64::INFINITY, f64::min);
        let margin = if truth { hits } else { misses };
        self.hit_or_miss(ours).count(ours == truth, theirs == truth);
        self.errors_of(ours == truth, theirs == truth, [margin; 2]);
        if oracle.alone(&crossings, ray).is_hit() != ours {
            self.faults.push(*ray);
        }
    }

    fn hit_or_miss(&mut self, ours: bool) -> &mut Right {
        if ours { &mut self.only_we } else { &mut self.only_they }
    }

    fn errors_of(&mut self, we: bool, they: bool, margins: [f64; 2]) {
        let sides = [(we, &mut self.our_errors), (they, &mut self.their_errors)];
        for ((right, errors), margin) in sides.into_iter().zip(margins) {
            if !right {
                errors.margin = errors.margin.max(margin);
                errors.unexplained += usize::from(margin > ROUNDING);
            }
        }
    }

    fn same_triangle(&mut self, oracle: &Oracle<'_>, ray: &Ray, ours: &Hit, theirs: &Hit) {
        if is_same(f64::from(ours.t), f64::from(theirs.t), SAME) {
            self.same += 1;
            return;
        }
        let Some(truth) = oracle.crossing(ours.prim, ray) else {
            self.distance.neither += 1;
            return;
        };
        if !is_bitwise(&oracle.alone(&[truth], ray), ours) {
            self.faults.push(*ray);
        }
        let off = |hit: &Hit| (f64::from(hit.t) / truth.t - 1.0).abs();
        for (hit, errors) in [(ours, &mut self.our_errors), (theirs, &mut self.their_errors)] {
            errors.distance = errors.distance.max(off(hit));
            errors.plane = errors.plane.max((f64::from(hit.t) - truth.t).abs() * truth.pace);
        }
        self.distance.count(off(ours) <= SAME, off(theirs) <= SAME);
    }

    fn other_triangle(&mut self, oracle: &Oracle<'_>, ray: &Ray, ours: &Hit, theirs: &Hit) {
        let of = |hit: &Hit| oracle.crossing(hit.prim, ray).map_or(f64::NAN, |c| c.t);
        if !is_same(of(ours), of(theirs), SAME) {
            self.examine(oracle, ray, ours, theirs);
        } else if oracle.are_neighbours(ours.prim, theirs.prim) {
            self.tie_of_neighbours += 1;
        } else {
            self.tie_of_others += 1;
        }
    }

    /// Compares both answers with the truth.
    fn examine(&mut self, oracle: &Oracle<'_>, ray: &Ray, ours: &Hit, theirs: &Hit) {
        let crossings = oracle.crossings(ray);
        let truth = crossings.iter().find(|c| c.is_hit());
        let judged = [ours, theirs].map(|answer| judge(oracle, ray, answer, truth));
        let [we, they] = judged.map(|j| j.is_none());
        let class = if ours.is_hit() && theirs.is_hit() {
            &mut self.surface
        } else {
            self.hit_or_miss(ours.is_hit())
        };
        class.count(we, they);
        self.errors_of(we, they, judged.map(|j| j.unwrap_or(0.0)));
        if !is_bitwise(&oracle.alone(&crossings, ray), ours) {
            self.faults.push(*ray);
        }
    }
}

/// Nothing if the answer is true; otherwise the margin of the triangle that it owes or invents.
fn judge(oracle: &Oracle<'_>, ray: &Ray, answer: &Hit, truth: Option<&Crossing>) -> Option<f64> {
    let t = f64::from(answer.t);
    match truth {
        None if !answer.is_hit() => None,
        Some(truth) if answer.is_hit() && is_same(t, truth.t, RIGHT) => None,
        Some(truth) if !answer.is_hit() || t > truth.t => Some(truth.margin()),
        _ => Some(oracle.crossing(answer.prim, ray).map_or(f64::INFINITY, |c| invented(&c, t))),
    }
}

/// The margin of a hit that is none, or lies elsewhere on its plane.
fn invented(crossing: &Crossing, t: f64) -> f64 {
    if crossing.is_hit() && !is_same(t, crossing.t, RIGHT) { f64::INFINITY } else { crossing.margin() }
}

fn is_same(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

fn is_bitwise(a: &Hit, b: &Hit) -> bool {
    let bits = |h: &Hit| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim];
    bits(a) == bits(b)
}
