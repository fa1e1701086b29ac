//! With which share of the fitted grip each sample was driven.

use serde::{Deserialize, Serialize};

/// A sample: its lap and its place in that lap.
type Place = (usize, usize);

/// Where another share began, oldest first.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct ShareHistory(Vec<(Place, f64)>);

impl ShareHistory {
    /// The share of a sample.
    pub(crate) fn at(&self, lap: usize, sample: usize) -> f64 {
        let began = self.0.iter().rev().find(|(place, _)| *place <= (lap, sample));
        began.map_or(1.0, |(_, share)| *share)
    }

    /// The same if the share since the last fall had been `revised`.
    pub(crate) fn at_revised(&self, lap: usize, sample: usize, revised: Option<f64>) -> f64 {
        match (revised, self.last_fall()) {
            (Some(share), Some(fall)) if self.0[fall].0 <= (lap, sample) => share,
            _ => self.at(lap, sample),
        }
    }

    /// The first lap that was driven wholly since the last fall.
    pub(crate) fn first_lap_since_fall(&self) -> Option<usize> {
        let (lap, sample) = self.0[self.last_fall()?].0;
        Some(if sample == 0 { lap } else { lap + 1 })
    }

    /// Another share from this sample on.
    pub(super) fn change(&mut self, share: f64, place: Place) {
        while self.0.last().is_some_and(|last| last.0 >= place) {
            self.0.pop();
        }
        self.0.push((place, share));
    }

    /// Another share of all samples since the last fall.
    pub(super) fn revise(&mut self, share: f64) {
        if let Some(fall) = self.last_fall() {
            self.0.truncate(fall + 1);
            self.0[fall].1 = share;
        }
    }

    fn last_fall(&self) -> Option<usize> {
        let before = |i: usize| if i == 0 { 1.0 } else { self.0[i - 1].1 };
        (0..self.0.len()).rev().find(|i| self.0[*i].1 < before(*i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_holds_from_its_sample_on_and_is_revised_since_the_last_fall() {
        let mut history = ShareHistory::default();
        assert_eq!((history.at(3, 0), history.first_lap_since_fall()), (1.0, None));
        for (share, place) in [(0.8, (3, 5)), (0.85, (4, 0)), (0.6, (6, 9)), (0.61, (7, 1))] {
            history.change(share, place);
        }
        let shares = |history: &ShareHistory| {
            [(3, 4), (3, 5), (5, 0), (6, 8), (6, 9), (8, 0)].map(|(lap, k)| history.at(lap, k))
        };
        assert_eq!(shares(&history), [1.0, 0.8, 0.85, 0.85, 0.6, 0.61]);
        assert_eq!(history.first_lap_since_fall(), Some(7));
        assert_eq!(history.at_revised(6, 8, Some(0.7)), 0.85);
        assert_eq!(history.at_revised(9, 0, Some(0.7)), 0.7);
        history.revise(0.7);
        assert_eq!(shares(&history), [1.0, 0.8, 0.85, 0.85, 0.7, 0.7]);
        // A share that begins again before another takes its place.
        history.change(0.5, (6, 9));
        assert_eq!(history.at(8, 0), 0.5);
    }

    #[test]
    fn a_fall_at_the_first_sample_of_a_lap_leaves_that_lap_whole() {
        let mut history = ShareHistory::default();
        history.change(0.7, (2, 0));
        assert_eq!(history.first_lap_since_fall(), Some(2));
    }
}
