//! State estimation: an extended Kalman filter between the sensors and the controller.
//!
//! Prediction with the model the controller plans with, nominal plus learned error, linearised at
//! the estimate; measurement of the whole state, or of the pose alone:
//!
//! ```text
//! x^- = f(x, u)          P^- = A P A' + Q
//! K   = P^- H' (H P^- H' + R)^-1
//! x   = x^- + K (z - H x^-)          P = (I - K H) P^- (I - K H)' + K R K'      (Joseph form)
//! ```
//!
//! R and Q are estimated while driving ([`noise`]). Measurements without noise pass as they are.
//! A closed lap is smoothed before anything is learned from it ([`smooth`]).

mod noise;
mod smooth;

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};
use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, State, Track};

use crate::config::FilterConfig;
use crate::derive::Scales;
use noise::{Noise, Variances};
pub(crate) use smooth::{Smoothing, Step};

/// Variance of a velocity nobody measured, in squared speeds sqrt(mu g l) of the car.
const UNKNOWN: f64 = 4.0;
/// Noise of the targets at which the ridge weight is 1, as a share of the speed mu g dt that grip gives in a
/// period: what the model gets wrong in a period is a part of that.
const RIDGE_NOISE: f64 = 0.026;

/// What the filter knows of the car and its sensors.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    config: FilterConfig,
    scales: Scales,
    /// Sampling period \[s\].
    dt: f64,
}

/// The state one period later, and how it depends on the state now.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prediction {
    /// A.
    pub(crate) a: Matrix6<f64>,
    /// x^-.
    pub(crate) next: Vector6<f64>,
}

/// What the filter carries from one measurement to the next.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Estimate {
    /// Covariance of the last estimate; none while measurements pass as they are.
    p: Option<[[f64; 6]; 6]>,
    /// The last measurement.
    pub(crate) raw: State,
    /// Variances of its v_y and omega_z about their predictions by the noise of both, the model being right.
    pub(crate) expected: [f64; 2],
    noise: Noise,
    /// The lap in progress, to be smoothed: one step for each sample, or none.
    pub(crate) steps: Vec<Step>,
    /// Memory for those of the next lap.
    #[serde(skip)]
    pub(crate) spare: Vec<Step>,
}

impl Filter {
    pub(crate) fn new(config: &FilterConfig, car: &CarParams, dt: f64) -> Self {
        Self { config: config.clone(), scales: Scales::new(car), dt }
    }

    /// Whether velocities are not measured.
    pub(crate) fn blind(&self) -> bool {
        !self.config.velocities
    }

    /// First measured row: 0, or 3 if velocities are not measured.
    fn first(&self) -> usize {
        if self.config.velocities { 0 } else { 3 }
    }

    /// R and Q, if there is noise.
    fn variances(&self, estimate: &Estimate) -> Option<Variances> {
        estimate.noise.variances(self)
    }

    /// Standard deviations of the measurement's noise; 0 for what is not measured, none while
    /// measurements pass as they are.
    pub(crate) fn noise_sigma(&self, estimate: &Estimate) -> Option<[f64; 6]> {
        estimate.p?;
        let Variances { noise, .. } = self.variances(estimate)?;
        let first = self.first();
        Some(std::array::from_fn(|i| if i < first { 0.0 } else { noise[i].sqrt() }))
    }

    /// Variances of the velocities as measured: none for exact ones.
    pub(crate) fn velocity_noise(&self, estimate: &Estimate) -> [f64; 3] {
        let Some(Variances { noise, .. }) = self.variances(estimate) else { return [0.0; 3] };
        if self.blind() {
            // They come from differences of poses.
            let twice = 2.0 / (self.dt * self.dt);
            return [twice * noise[4], twice * noise[5], twice * noise[3]];
        }
        [noise[0], noise[1], noise[2]]
    }

    /// Ridge weight that the noise of the measured velocities asks for. Measurements that pass as they are
    /// may be noisy all the same.
    pub(crate) fn ridge(&self, estimate: &Estimate) -> f64 {
        let noise = match self.variances(estimate) {
            Some(_) => self.velocity_noise(estimate),
            None => estimate.noise.rough(),
        };
        ridge_of(noise, &self.scales, self.dt)
    }

    /// The estimate of a measurement connected with nothing before.
    pub(crate) fn begin(&self, estimate: &mut Estimate, measured: &State) -> State {
        estimate.noise.interrupt();
        estimate.raw = *measured;
        estimate.p = None;
        let Some(Variances { noise, .. }) = self.variances(estimate) else { return *measured };
        let mut p = Matrix6::from_diagonal(&noise);
        let mut x = measured.to_vector();
        let still = UNKNOWN * self.scales.speed * self.scales.speed;
        for row in 0..self.first() {
            x[row] = 0.0;
            p[(row, row)] =
                if row == 2 { still / (self.scales.length * self.scales.length) } else { still };
        }
        estimate.p = Some(p.into());
        State::from_vector(&x)
    }

    /// The estimate from what was predicted at `last` and what is measured.
    pub(crate) fn update(
        &self,
        estimate: &mut Estimate,
        last: &State,
        prediction: &Prediction,
        measured: &State,
        track: &Track,
    ) -> State {
        // As if the last measurement had been the state: its residual tells noise from model error.
        let mut offset = difference(&estimate.raw, &last.to_vector(), track);
        for row in 0..self.first() {
            offset[row] = 0.0;
        }
        let residual = difference(measured, &prediction.next, track) - prediction.a * offset;
        estimate.noise.add(&residual, &prediction.a, self.scales.length);
        estimate.raw = *measured;
        let Some(Variances { noise, process }) = self.variances(estimate) else {
            (estimate.p, estimate.expected) = (None, [0.0; 2]);
            return *measured;
        };
        let Some(before) = estimate.p.map(Matrix6::from) else {
            let raw = estimate.noise.clone();
            let state = self.begin(estimate, measured);
            estimate.noise = raw;
            return state;
        };
        let p = prediction.a * before * prediction.a.transpose() + Matrix6::from_diagonal(&process);
        let mut innovation = difference(measured, &prediction.next, track);
        let mut h = Matrix6::identity();
        for row in 0..self.first() {
            innovation[row] = 0.0;
            h[(row, row)] = 0.0;
        }
        let mut s = h * p * h;
        for row in 0..6 {
            s[(row, row)] += if row < self.first() { 1.0 } else { noise[row] };
        }
        estimate.expected = [1, 2].map(|row| s[(row, row)] - process[row]);
        let Some(factor) = s.cholesky() else { return self.begin(estimate, measured) };
        let gain = factor.solve(&(h * p)).transpose();
        let x = prediction.next + gain * innovation;
        let rest = Matrix6::identity() - gain * h;
        let after =
            rest * p * rest.transpose() + gain * Matrix6::from_diagonal(&noise) * gain.transpose();
        let mut state = State::from_vector(&x);
        if !state.is_finite() || !after.iter().all(|v| v.is_finite()) {
            return self.begin(estimate, measured);
        }
        state.s = track.wrap(state.s);
        state.e_psi = wrap_angle(state.e_psi);
        let after = 0.5 * (after + after.transpose());
        estimate.p = Some(after.into());
        estimate.steps.push(Step::new(prediction, &p, &state, &after));
        state
    }
}

/// Ridge weight for targets with these variances, in a car of these scales with this sampling period.
pub(crate) fn ridge_of([v_x, v_y, omega_z]: [f64; 3], scales: &Scales, dt: f64) -> f64 {
    let Scales { length, speed, time } = scales;
    let most = v_x.max(v_y).max(omega_z * length * length);
    most / (RIDGE_NOISE * speed * dt / time).powi(2)
}

impl Estimate {
    /// Whether measurements are filtered at present.
    pub(crate) fn filters(&self) -> bool {
        self.p.is_some()
    }

    /// Covariance of the last estimate; none where the measurement passed as it was.
    pub(crate) fn covariance(&self) -> Option<Matrix6<f64>> {
        self.p.map(Matrix6::from)
    }
}

/// One state minus another, over the line and the half turn.
fn difference(to: &State, from: &Vector6<f64>, track: &Track) -> Vector6<f64> {
    let mut d = to.to_vector() - from;
    d[3] = wrap_angle(d[3]);
    d[4] -= track.length() * (d[4] / track.length()).round();
    d
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::SeedableRng as _;
    use vehicle_model::normal::standard_normal;

    use super::*;
    use crate::{Config, Preset};

    /// A linear car, whose v_y its yaw rate moves as at 40 m/s, and whose tyres do what the filter expects.
    #[test]
    fn what_noise_makes_of_a_prediction_is_expected() {
        let car = CarParams::builtin("kart").unwrap();
        let track = Track::builtin("l").unwrap();
        let config = Config::derived(Preset::Race, &car, &track).filter;
        let filter = Filter::new(&config, &car, 0.1);
        let mut a = Matrix6::identity();
        (a[(1, 1)], a[(1, 2)], a[(2, 2)]) = (0.3, -4.0, 0.5);
        let (mut estimate, mut x) = (Estimate::default(), State::default());
        let v = config.model_error * filter.scales.speed.powi(2) / filter.scales.length * filter.dt;
        let (process, mut truth) = ([v, v, v / filter.scales.length], Vector6::zeros());
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        let (mut squares, mut expected, mut count) = ([0.0; 2], [0.0; 2], 0.0);
        for n in 0..20_000 {
            let mut draw = |sigma: f64| sigma * standard_normal(&mut random);
            truth = a * truth;
            for row in 0..3 {
                truth[row] += draw(process[row]);
            }
            (truth[3], truth[4], truth[5]) = (0.0, 5.0, 0.0);
            let noise = [0.01, 0.01, 0.01, 0.001, 0.001, 0.001].map(&mut draw);
            let measured = State::from_vector(&(truth + Vector6::from(noise)));
            truth[4] = 0.0;
            if n == 0 {
                x = filter.begin(&mut estimate, &measured);
                continue;
            }
            let mut at = x.to_vector();
            at[4] -= 5.0;
            let mut next = a * at;
            next[4] += 5.0;
            x = filter.update(&mut estimate, &x, &Prediction { a, next }, &measured, &track);
            if n < 5_000 {
                continue;
            }
            count += 1.0;
            for (i, row) in [1, 2].into_iter().enumerate() {
                squares[i] += (measured.to_vector()[row] - next[row]).powi(2);
                expected[i] += estimate.expected[i] + process[row].powi(2);
            }
        }
        assert!(process[1].powi(2) < 0.3 * squares[0] / count, "the noise decides on v_y");
        for i in 0..2 {
            let [seen, expected] = [squares[i] / count, expected[i] / count];
            // What a noisy yaw rate does to v_y looks like an error of the model, too, and counts twice.
            assert!(expected > 0.8 * seen && expected < 4.0 * seen, "row {i}: {expected} {seen}");
        }
    }
}
