//! The safe stop: braking along the track, on the latest or the dead-reckoned state.

use vehicle_model::{Input, Model, State};

use super::doubt::Steering;
use super::hold::Hold;
use super::rules::Rules;

/// Share of the grip that is braked with. \[-\]
const BRAKE_SHARE: f64 = 0.9;
/// Slower than this, tyres are taken to roll without slip. \[m/s\]
pub(super) const ROLL_BELOW: f64 = 1.0;
/// Longest step of the reckoning. \[s\]
const STEP: f64 = 0.002;

/// What brings the car to a stand on the track, and holds it there.
pub(super) fn brake(rules: &Rules, x: &State, hold: Hold) -> Input {
    hold.apply(rules, x.v_x, rules.tracker.brake(x, &rules.track))
}

/// The same with a steering that does not follow its commands: against its bias, or, where it is stuck,
/// as hard as the lateral acceleration that the car has leaves grip for.
pub(super) fn brake_without_steering(
    rules: &Rules,
    x: &State,
    hold: Hold,
    steering: Steering,
) -> Input {
    let wanted = brake(rules, x, hold);
    match steering {
        Steering::Biased(bias) => Input { delta: wanted.delta - bias, ..wanted },
        Steering::Stuck => {
            let car = &rules.rolling.params;
            let grip = 9.81 * car.tyre_front.mu.min(car.tyre_rear.mu);
            let lateral = x.v_x * x.omega_z;
            let left = (grip * grip - lateral * lateral).max(0.04 * grip * grip).sqrt();
            Input { a: (-BRAKE_SHARE * left).max(rules.limiter.a_min), ..wanted }
        }
    }
}

/// Where the car will be after `dt` \[s\], for the time without states.
pub(super) fn reckon(rules: &Rules, x: &State, u: Input, dt: f64) -> State {
    let mut next = *x;
    let steps = (dt / STEP).ceil().clamp(1.0, 1000.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1000")]
    for _ in 0..steps as usize {
        next =
            roll(rules, &rules.sliding[0], &next, u, (dt / steps, STEP), rules.track.kappa(next.s));
    }
    next
}

/// The state `dt` \[s\] later, in steps of at most `step` \[s\], on a path of curvature `kappa`: the
/// tyres' model `sliding`, or a car that rolls without slip where it is slow.
pub(super) fn roll(
    rules: &Rules,
    sliding: &Model,
    x: &State,
    u: Input,
    (dt, step): (f64, f64),
    kappa: f64,
) -> State {
    let steps = (dt / step).ceil().clamp(1.0, 100.0);
    let h = dt / steps;
    let mut next = *x;
    let slow_below = ROLL_BELOW.max(rules.rolling.params.blend_speed_high);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 100")]
    for _ in 0..steps as usize {
        let model = if next.v_x < slow_below { &rules.rolling } else { sliding };
        let rate = |x: &State| {
            let rates = model.derivative(x, &u, kappa);
            State::from_vector(&rates.into()).to_vector()
        };
        let first = rate(&next);
        let middle = State::from_vector(&(next.to_vector() + first * (0.5 * h)));
        let after = State::from_vector(&(next.to_vector() + rate(&middle) * h));
        if !after.is_finite() {
            break;
        }
        next = State { v_x: after.v_x.max(0.0), s: rules.track.wrap(after.s), ..after };
    }
    next
}
