//! Which units of a job have come, and those that wait for the rest of their pass.

use super::UnitResult;
use std::collections::BTreeSet;

/// The units of a job in their fixed order: done or not, in the film or waiting.
#[derive(Clone, Debug)]
pub(super) struct Intake {
    /// Units in a pass over the film.
    tiles: usize,
    /// True: results wait until their pass is whole.
    whole_passes: bool,
    /// All units before this one are done.
    below: usize,
    /// Units beyond it that are done.
    beyond: BTreeSet<usize>,
    waiting: Vec<(usize, UnitResult)>,
}

impl Intake {
    /// Nothing has come.
    pub fn new(tiles: usize, whole_passes: bool) -> Self {
        Self { tiles, whole_passes, below: 0, beyond: BTreeSet::new(), waiting: Vec::new() }
    }

    /// True if that unit is done.
    pub fn is_done(&self, index: usize) -> bool {
        index < self.below || self.beyond.contains(&index)
    }

    /// All units before this one are done.
    pub fn below(&self) -> usize {
        self.below
    }

    /// Takes in the result of a unit and gives back what enters the film now. Repeated units are left out.
    pub fn take(&mut self, index: usize, result: UnitResult) -> Vec<UnitResult> {
        if self.is_done(index) {
            return Vec::new();
        }
        self.beyond.insert(index);
        while self.beyond.remove(&self.below) {
            self.below += 1;
        }
        if !self.whole_passes {
            return vec![result];
        }
        self.waiting.push((index, result));
        let whole = self.whole();
        if index >= whole {
            return Vec::new();
        }
        let (enter, wait) = std::mem::take(&mut self.waiting).into_iter().partition(|(i, _)| *i < whole);
        self.waiting = wait;
        Self::in_order(enter)
    }

    /// After a run was stopped: gives back what enters the film nevertheless. That is nothing if it has a whole pass:
    /// the waiting units count as not done. Within the first pass it is all that there is.
    pub fn stop(&mut self) -> Vec<UnitResult> {
        if !self.whole_passes {
            return Vec::new();
        }
        let waiting = std::mem::take(&mut self.waiting);
        if self.whole() == 0 {
            return Self::in_order(waiting);
        }
        self.below = self.whole();
        self.beyond.clear();
        Vec::new()
    }

    /// Units in whole passes that are done.
    fn whole(&self) -> usize {
        self.below - self.below % self.tiles
    }

    fn in_order(mut results: Vec<(usize, UnitResult)>) -> Vec<UnitResult> {
        results.sort_by_key(|(index, _)| *index);
        results.into_iter().map(|(_, result)| result).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Tile, TileSums};
    use crate::render::WorkUnit;

    fn unit(index: usize) -> UnitResult {
        let tile = Tile { x0: 0, y0: 0, x1: 1, y1: 1 };
        let unit = WorkUnit { tile_index: index % 3, tile, first_sample: (index / 3) as u32, count: 1 };
        UnitResult { unit, sums: TileSums::default(), rays: 0, non_finite: 0, dropped: Vec::new() }
    }

    fn take(intake: &mut Intake, index: usize) -> Vec<usize> {
        indices(&intake.take(index, unit(index)))
    }

    fn indices(results: &[UnitResult]) -> Vec<usize> {
        results.iter().map(|r| r.unit.first_sample as usize * 3 + r.unit.tile_index).collect()
    }

    #[test]
    fn units_enter_at_once_and_only_once() {
        let mut intake = Intake::new(3, false);
        for index in [4, 0, 2, 1] {
            assert_eq!(take(&mut intake, index), [index]);
            assert!(take(&mut intake, index).is_empty() && intake.is_done(index));
        }
        assert_eq!((intake.below(), intake.is_done(3)), (3, false));
        assert_eq!(take(&mut intake, 3), [3]);
        assert_eq!(intake.below(), 5);
        assert!(intake.stop().is_empty());
    }

    #[test]
    fn whole_passes_enter_whole() {
        let mut intake = Intake::new(3, true);
        for index in [3, 1, 4, 2] {
            assert!(take(&mut intake, index).is_empty());
        }
        assert_eq!(take(&mut intake, 0), [0, 1, 2]);
        assert!(take(&mut intake, 7).is_empty());
        // A stop forgets what waited: it is to be done again.
        assert!(intake.stop().is_empty());
        assert_eq!(intake.below(), 3);
        for index in [5, 4, 7] {
            assert!(!intake.is_done(index) && take(&mut intake, index).is_empty());
        }
        assert_eq!(take(&mut intake, 3), [3, 4, 5]);
    }

    #[test]
    fn a_stop_within_the_first_pass_keeps_what_there_is() {
        let mut intake = Intake::new(3, true);
        for index in [2, 0, 4] {
            assert!(take(&mut intake, index).is_empty());
        }
        assert_eq!(indices(&intake.stop()), [0, 2, 4]);
        assert!(intake.is_done(2) && !intake.is_done(1));
    }
}
