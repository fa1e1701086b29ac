//! Inputs by inverse dynamics: what must have acted on a car whose states alone are known.

use nalgebra::{Matrix2, Vector2};
use vehicle_model::{Discretized, Input, State, Track};

/// Scales of the residuals of v_x, v_y \[m/s\] and omega_z \[rad/s\], as in the fit of the grip.
const SCALES: [f64; 3] = [0.05, 0.05, 0.3];
/// Gauss-Newton steps at most.
const STEPS: usize = 12;
/// A step smaller than this, relative to the limits of the inputs, ends the iteration.
const DONE: f64 = 1e-9;
/// Weight of the pull towards the first guess: decides where the states say nothing, as of the
/// steering of a car that stands.
const PULL: f64 = 1e-6;
/// Grip factors of a road: the range of the search, and how often it is narrowed.
const GRIP: (f64, f64) = (0.3, 2.5);
const SECTIONS: usize = 14;
/// Periods that decide on the grip, at most.
const FIT_PERIODS: usize = 1000;
/// A fitted grip has to leave less than this share of what the model's own misses.
const WORTH: f64 = 0.95;

/// One period of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Period {
    /// State at its beginning.
    pub x: State,
    /// Velocities [v_x, v_y, omega_z] at its end \[m/s, m/s, rad/s\].
    pub next: [f64; 3],
    /// Steering angle, where it was measured \[rad\].
    pub delta: Option<f64>,
}

/// The constant input that leads the velocities through a period best in the least-squares sense,
/// inside the limits of the car, by Gauss-Newton on the model; and what it misses, squared and in
/// units of the scales of the fit of the grip.
///
/// Three velocities, at most two unknowns: what is left over shows how far the model is from the car.
#[must_use]
pub fn input(model: &Discretized, track: &Track, period: &Period) -> (Input, f64) {
    let (x, next) = (&period.x, &period.next);
    let car = &model.model.params;
    let limits = Vector2::new(car.a_max.max(-car.a_min), car.delta_max);
    let clamp = |u: Vector2<f64>| {
        let delta = period.delta.unwrap_or_else(|| u.y.clamp(-car.delta_max, car.delta_max));
        Vector2::new(u.x.clamp(car.a_min, car.a_max), delta)
    };
    // As if the wheels rolled where they point.
    let omega_z = 0.5 * (x.omega_z + next[2]);
    let rolling = libm::atan(car.wheelbase() * omega_z / x.v_x.max(1e-3));
    let guess = clamp(Vector2::new((next[0] - x.v_x) / model.dt - omega_z * x.v_y, rolling));
    let mut u = guess;
    let (mut missed, mut best) = cost(model, track, period, u, guess, limits);
    let mut damping = 0.0;
    for _ in 0..STEPS {
        let step = model.linearize(x, &Input::from_vector(&u), track.road());
        let mut hessian = Matrix2::identity() * PULL;
        let mut gradient = (guess - u).component_div(&limits) * PULL;
        for row in 0..3 {
            let mut slope = step.b.row(row).transpose().component_mul(&limits) / SCALES[row];
            if period.delta.is_some() {
                slope.y = 0.0;
            }
            hessian += slope * slope.transpose();
            gradient += slope * ((next[row] - step.next[row]) / SCALES[row]);
        }
        let damped = hessian + Matrix2::identity() * damping;
        let Some(change) = damped.cholesky().map(|factor| factor.solve(&gradient)) else { break };
        let tried = clamp(u + change.component_mul(&limits));
        let (misses, found) = cost(model, track, period, tried, guess, limits);
        if found.is_nan() || found > best {
            // Past the peak of the tyre a full step overshoots.
            damping = (10.0 * damping).max(1e-3 * hessian.trace());
            continue;
        }
        (u, missed, best, damping) = (tried, misses, found, 0.1 * damping);
        if change.amax() < DONE {
            break;
        }
    }
    (Input::from_vector(&u), missed)
}

/// What an input misses, without and with the pull towards the first guess.
fn cost(
    model: &Discretized,
    track: &Track,
    period: &Period,
    u: Vector2<f64>,
    guess: Vector2<f64>,
    limits: Vector2<f64>,
) -> (f64, f64) {
    let reached = model.next(&period.x, &Input::from_vector(&u), track.road());
    let reached = [reached.v_x, reached.v_y, reached.omega_z];
    let miss = |row: usize| (period.next[row] - reached[row]) / SCALES[row];
    let missed: f64 = (0..3).map(|row| miss(row) * miss(row)).sum();
    (missed, missed + PULL * (u - guess).component_div(&limits).norm_squared())
}

/// The inputs of a whole drive, and the grip factor of both axles with which they explain it best.
///
/// The rear axle does not steer: its slip and force follow from the states alone, and with them its
/// grip. The front axle's cannot be told from an unknown steering angle; it is taken to be the same.
#[must_use]
pub fn inputs(model: &Discretized, track: &Track, periods: &[Period]) -> (Vec<Input>, f64) {
    let with = |grip: f64| {
        let mut model = model.clone();
        model.model.grip = [grip; 2];
        model
    };
    let every = periods.len().div_ceil(FIT_PERIODS).max(1);
    let missed = |grip: f64| -> f64 {
        let model = with(grip);
        let some = periods.iter().step_by(every);
        // Bumps and jumps of the measurement count less.
        some.map(|period| (1.0 + input(&model, track, period).1).sqrt() - 1.0).sum()
    };
    let fitted = minimum(libm::log(GRIP.0), libm::log(GRIP.1), |x| missed(libm::exp(x)));
    // A car that was driven gently says nothing of its grip.
    let fitted = libm::exp(fitted);
    let grip = if missed(fitted) < WORTH * missed(1.0) { fitted } else { 1.0 };
    let model = with(grip);
    (periods.iter().map(|period| input(&model, track, period).0).collect(), grip)
}

/// Where a function of one valley is least, by golden section.
fn minimum(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let inner = |low: f64, high: f64| (high - ratio * (high - low), low + ratio * (high - low));
    let (mut left, mut right) = inner(low, high);
    let (mut at_left, mut at_right) = (f(left), f(right));
    for _ in 0..SECTIONS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high).0;
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = inner(low, high).1;
            at_right = f(right);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vehicle_model::{CarParams, Model, ModelKind, Plant, PlantParams};

    use super::*;

    /// A car with 3/4 of the grip the model believes in is driven forward by inputs that are known.
    fn driven() -> (Discretized, Arc<Track>, Vec<Period>, Vec<Input>) {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let model = Model::new(ModelKind::Dynamic, car.clone().with_mu(1.2));
        let model = Discretized { model, dt: 0.1, substeps: 10 };
        let start = State { v_x: 1.5, ..State::default() };
        let mut plant =
            Plant::new(PlantParams::new(car.with_mu(0.9)), Arc::clone(&track), start).unwrap();
        let (mut periods, mut known) = (Vec::new(), Vec::new());
        for i in 0..300 {
            let t = 0.1 * f64::from(i);
            let x = plant.truth();
            let delta = (0.3 * (0.9 * t).sin() + 0.1 * (2.3 * t).sin()) / (0.3 + 0.3 * x.v_x);
            let u = Input { a: 0.7 * (0.5 * t).sin() + 0.3 * (2.0 - x.v_x), delta };
            plant.apply(u, 0.1);
            let next = plant.truth();
            let next = [next.v_x, next.v_y, next.omega_z];
            periods.push(Period { x, next, delta: None });
            known.push(plant.applied());
        }
        (model, track, periods, known)
    }

    #[test]
    fn known_inputs_and_grip_come_out_of_the_states() {
        let (model, track, periods, known) = driven();
        let (found, grip) = inputs(&model, &track, &periods);
        assert!((grip - 0.75).abs() < 0.01, "{grip}");
        for (found, known) in found.iter().zip(&known) {
            assert!((found.a - known.a).abs() < 0.02, "{found:?} {known:?}");
            assert!((found.delta - known.delta).abs() < 0.02, "{found:?} {known:?}");
        }
    }

    #[test]
    fn a_measured_steering_angle_is_kept() {
        let (model, track, mut periods, known) = driven();
        for (period, u) in periods.iter_mut().zip(&known) {
            period.delta = Some(u.delta);
        }
        let (found, _) = inputs(&model, &track, &periods);
        for (found, known) in found.iter().zip(&known) {
            assert_eq!(found.delta.to_bits(), known.delta.to_bits());
            assert!((found.a - known.a).abs() < 0.02, "{found:?} {known:?}");
        }
    }
}
