//! What the regression has to explain, (5) of the paper: the measured successor of a sample is the nominal
//! model's and an error.
//!
//! ```text
//! x_{k+1} = f(x_k, u_k) + e(x_k, u_k)                        (5)
//! y_k     = x_{k+1} - f(x_k, u_k)     mode = "error"         target of the velocity rows
//! y_k     = x_{k+1}                   mode = "full"
//! ```
//!
//! y_k does not depend on where the regression is asked, so each lap's targets are computed once.

use std::ops::Range;

use vehicle_model::{Input, State};

use crate::config::RegressionMode;
use crate::controller::Setup;
use crate::learning::dataset::{Lap, Sample};
use crate::learning::regression::{RegressionData, Target, leap_order};

impl Setup {
    /// Adds the samples of `lap` that stand at the places `range` of its order.
    pub(super) fn add(
        &self,
        data: &mut RegressionData,
        lap: &Lap,
        range: Range<usize>,
        (grip, share): ([f64; 2], &dyn Fn(usize) -> f64),
        (points, targets): (&mut Vec<(State, Input)>, &mut Vec<[f64; 3]>),
    ) {
        let order = leap_order(lap.samples.len(), range);
        let samples = order.map(|i| (&lap.samples[i], share(i)));
        self.targets(samples, grip, points, targets);
        for ((x, u), y) in points.iter().zip(targets) {
            if y.iter().all(|v| v.is_finite()) {
                data.add(Target::new(x, u, *y));
            }
        }
    }

    /// What the regression has to explain of the samples whose successor is known: in full mode their
    /// next velocities, in error mode what the nominal model gets wrong of them with their share of
    /// this grip.
    pub(crate) fn targets<'a>(
        &self,
        samples: impl Iterator<Item = (&'a Sample, f64)>,
        grip: [f64; 2],
        points: &mut Vec<(State, Input)>,
        targets: &mut Vec<[f64; 3]>,
    ) {
        points.clear();
        targets.clear();
        let mut shares = Vec::new();
        for (sample, share) in samples {
            let Some(next) = sample.next else { continue };
            points.push((sample.x, sample.u));
            targets.push(next);
            shares.push(share);
        }
        if self.config.regression.mode == RegressionMode::Error {
            let mut model = self.model.clone();
            let (mut begin, road) = (0, self.track.road());
            for same in shares.chunk_by(|a, b| a == b) {
                let end = begin + same.len();
                model.model.grip = grip.map(|grip| same[0] * grip);
                model.velocities_all(&points[begin..end], &road, &mut |i, expected| {
                    for (target, expected) in targets[begin + i].iter_mut().zip(expected) {
                        *target -= expected;
                    }
                });
                begin = end;
            }
        }
    }
}
