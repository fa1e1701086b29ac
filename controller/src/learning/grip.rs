//! Grip by least squares: the factors on front and rear mu that explain the measured laps.
//!
//! Gauss-Newton on the scaled one-step velocity residuals r, with robust weights
//! 1 / sqrt(1 + (r/2)^2) and a light pull towards the first guess. Two factors only: fitting the
//! tyre's shape too runs away from slow laps.
//!
//! Of the latest samples those are used in which the tyres push hardest across: the others hardly
//! depend on the grip. The model is linearised by the grip once for all steps that stay near.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};
use vehicle_model::{Discretized, Input, State, Track};

use super::dataset::Sample;

/// Samples looked at, the most recent.
const LATEST: usize = 1500;
/// Samples used.
const USED: usize = 256;
/// Scales of the residuals of v_x, v_y [m/s] and omega_z [rad/s].
pub(crate) const SCALES: [f64; 3] = [0.05, 0.05, 0.3];
/// Weight of the pull towards the first guess.
const PULL: f64 = 0.1;
/// The same where residuals are noise: slow laps say little of the grip, and noise would be taken
/// for it.
const NOISY_PULL: f64 = 10.0;
/// Linearisations at most.
const ROUNDS: u32 = 6;
/// The pull, per cost of the residuals: what the model leaves unexplained is an error that many samples share,
/// as of actuators that it simplifies, and slow laps are explained a little better by almost any grip.
const UNEXPLAINED_PULL: f64 = 10.0;
/// Steps between two linearisations at most.
const STEPS: usize = 6;
/// A step smaller than this ends the iteration.
const DONE: f64 = 1e-4;
/// A linearisation serves this far.
const NEAR: f64 = 0.01;
/// Factors that differ by less than this are the same.
const SAME: f64 = 1e-3;
/// Fitted factors outside this range are rejected: no road has such grip.
const RANGE: (f64, f64) = (0.2, 3.0);

/// A fit in pieces.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Fit {
    points: Vec<(State, Input)>,
    measured: Vec<[f64; 3]>,
    /// Residual of each row of the points linearised so far, and its derivatives by the factors,
    /// scaled.
    rows: Vec<[f64; 3]>,
    /// Grip of the linearisation.
    grip: [f64; 2],
    /// What the pull goes to.
    toward: [f64; 2],
    round: u32,
    /// The best grip linearised so far, and its cost.
    best: Option<([f64; 2], f64)>,
    scales: [f64; 3],
    pull: f64,
}

impl Fit {
    /// Begins at `grip`, with a pull `toward` another, and chooses among `samples`, latest first; `noise`
    /// are the variances of the velocities as measured.
    pub(crate) fn begin<'a>(
        &mut self,
        grip: [f64; 2],
        toward: [f64; 2],
        samples: impl Iterator<Item = &'a Sample>,
        noise: [f64; 3],
    ) {
        self.scales = [0, 1, 2].map(|row| {
            let exact = SCALES[row];
            if noise[row] > 0.0 { (exact * exact + noise[row]).sqrt() } else { exact }
        });
        let share = [0, 1, 2].map(|row| noise[row] / (self.scales[row] * self.scales[row]));
        self.pull = PULL + NOISY_PULL * share.into_iter().fold(0.0, f64::max);
        let force = |sample: &Sample| (sample.x.v_x * sample.x.omega_z).abs();
        let mut chosen: Vec<(&Sample, [f64; 3])> =
            samples.take(LATEST).filter_map(|sample| Some((sample, sample.next?))).collect();
        if chosen.len() > USED {
            // Stable: of equal ones the latest.
            chosen.sort_by(|(a, _), (b, _)| force(b).total_cmp(&force(a)));
            chosen.truncate(USED);
        }
        self.points.clear();
        self.points.extend(chosen.iter().map(|(sample, _)| (sample.x, sample.u)));
        self.measured.clear();
        self.measured.extend(chosen.iter().map(|(_, next)| *next));
        self.rows.clear();
        (self.grip, self.toward, self.round, self.best) = (grip, toward, 0, None);
    }

    /// Linearises `piece` more samples, and solves after the last; gives the number of samples, and the factors
    /// [front, rear] when they are found.
    pub(crate) fn advance(
        &mut self,
        model: &Discretized,
        track: &Track,
        piece: usize,
    ) -> (usize, Option<[f64; 2]>) {
        let begin = self.rows.len() / 3;
        let points = &self.points[begin..(begin + piece).min(self.points.len())];
        let mut model = model.clone();
        model.model.grip = self.grip;
        let (rows, measured, scales) = (&mut self.rows, &self.measured[begin..], &self.scales);
        model.grip_jacobians(points, &track.road(), &mut |i, next, by_grip| {
            for row in 0..3 {
                let scaled = [measured[i][row] - next[row], by_grip[row][0], by_grip[row][1]]
                    .map(|value| value / scales[row]);
                // A row of zeros says nothing.
                let known = scaled.iter().all(|value| value.is_finite());
                rows.push(if known { scaled } else { [0.0; 3] });
            }
        });
        let done = points.len();
        (done, if begin + done == self.points.len() { self.solve() } else { None })
    }

    /// Sum of the robust losses of the residuals and the pull, at the grip of the linearisation.
    fn cost(&self) -> f64 {
        let losses = self.rows.iter().map(|[r, ..]| 4.0 * ((1.0 + 0.25 * r * r).sqrt() - 1.0));
        let away = Vector2::from(self.toward) - Vector2::from(self.grip);
        losses.sum::<f64>() + 0.5 * self.pull * away.norm_squared()
    }

    /// The factors, or none yet: then the model is to be linearised anew.
    fn solve(&mut self) -> Option<[f64; 2]> {
        self.round += 1;
        let (cost, from) = (self.cost(), Vector2::from(self.grip));
        if let Some((best, least)) = self.best
            && cost > least
        {
            // The step was too long.
            self.grip = ((from + Vector2::from(best)) * 0.5).into();
            self.rows.clear();
            return (self.round == ROUNDS).then_some(best);
        }
        self.best = Some((self.grip, cost));
        let pull = self.pull.max(UNEXPLAINED_PULL * cost);
        let mut grip = from;
        for _ in 0..STEPS {
            let mut hessian = Matrix2::identity() * pull;
            let mut gradient = (Vector2::from(self.toward) - grip) * pull;
            for [r, front, rear] in &self.rows {
                let j = Vector2::new(*front, *rear);
                let r = r - j.dot(&(grip - from));
                let weight = 1.0 / (1.0 + 0.25 * r * r).sqrt();
                hessian += j * j.transpose() * weight;
                gradient += j * (weight * r);
            }
            let Some(step) = hessian.cholesky().map(|factor| factor.solve(&gradient)) else {
                break;
            };
            let before = grip;
            grip = (grip + step).map(|factor| factor.clamp(RANGE.0, RANGE.1));
            if (grip - before).amax() < DONE {
                break;
            }
        }
        self.grip = grip.into();
        if (grip - from).amax() < NEAR {
            return Some(self.grip);
        }
        self.rows.clear();
        (self.round == ROUNDS).then_some(from.into())
    }
}

/// Whether two fits differ enough to matter.
pub(crate) fn differ(a: [f64; 2], b: [f64; 2]) -> bool {
    a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::{RngExt, SeedableRng};
    use vehicle_model::{CarParams, Model, ModelKind};

    use super::*;

    fn car_on_track() -> (Discretized, Track) {
        let model = Model::new(ModelKind::Dynamic, CarParams::builtin("barc").unwrap());
        (Discretized { model, dt: 0.1, substeps: 10 }, Track::builtin("l").unwrap())
    }

    /// Samples of a car that drives as the model does with this grip, faster and faster.
    fn driven(model: &Discretized, track: &Track, grip: [f64; 2], count: usize) -> Vec<Sample> {
        let mut model = model.clone();
        model.model.grip = grip;
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        let mut sample = |i: usize| {
            let mut any = |limit: f64| rng.random_range(-limit..limit);
            let v_x = 1.0 + 2.0 * i as f64 / count as f64;
            let x = State { v_x, v_y: any(0.1), omega_z: any(2.0), ..State::default() };
            let u = Input { a: any(1.0), delta: any(0.3) };
            let next = model.next(&x, &u, track.road());
            Sample { time: 0.0, x, u, next: Some([next.v_x, next.v_y, next.omega_z]) }
        };
        (0..count).map(&mut sample).collect()
    }

    fn fitted(model: &Discretized, track: &Track, samples: &[Sample], piece: usize) -> [f64; 2] {
        let mut fit = Fit::default();
        fit.begin(model.model.grip, [1.0; 2], samples.iter().rev(), [0.0; 3]);
        for _ in 0..10_000 {
            let (done, found) = fit.advance(model, track, piece);
            assert!(done <= piece);
            if let Some(found) = found {
                return found;
            }
        }
        unreachable!("the fit does not end")
    }

    #[test]
    fn the_grip_of_the_driven_car_is_found_whatever_the_pieces() {
        let (model, track) = car_on_track();
        for grip in [[0.75, 0.75], [0.6, 0.9], [1.2, 1.1], [1.0, 1.0]] {
            for count in [40, 2000] {
                let samples = driven(&model, &track, grip, count);
                let found = fitted(&model, &track, &samples, 60);
                for (found, grip) in found.iter().zip(grip) {
                    // The pull takes some of a few samples.
                    assert!((found - grip).abs() < 0.01, "{found} {grip}, {count} samples");
                }
                assert_eq!(found, fitted(&model, &track, &samples, 7));
            }
        }
        assert_eq!(fitted(&model, &track, &[], 60), [1.0, 1.0]);
    }

    /// The steering acts otherwise than the samples say, which no grip explains.
    #[test]
    fn what_no_grip_explains_is_not_taken_for_grip() {
        let (model, track) = car_on_track();
        for seed in 0..20 {
            let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
            let mut samples = driven(&model, &track, [1.0; 2], 300);
            samples.iter_mut().for_each(|sample| sample.u.delta += rng.random_range(-0.1..0.1));
            let found = fitted(&model, &track, &samples, 60);
            assert!(found.iter().all(|grip| (grip - 1.0).abs() < 0.05), "{found:?}, seed {seed}");
        }
    }
}
