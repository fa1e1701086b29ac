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

/// The input as the actuators have it `dt` \[s\] after `acting`, when `u` is sent meanwhile.
pub(super) fn follow(rules: &Rules, acting: Input, u: Input, dt: f64) -> Input {
    let car = &rules.rolling.params;
    let lag = car.actuator_lag + car.actuator_delay;
    if lag <= 0.0 {
        return u;
    }
    let share = 1.0 - (-dt / lag).exp();
    let towards = |from: f64, to: f64| from + share * (to - from);
    Input { a: towards(acting.a, u.a), delta: towards(acting.delta, u.delta) }
}

/// Where the car will be after `dt` \[s\], and what its actuators have by then, for the time without
/// states: `u` is sent, the actuators come from `acting`.
pub(super) fn reckon(
    rules: &Rules,
    x: &State,
    (acting, u): (Input, Input),
    dt: f64,
) -> (State, Input) {
    let (mut next, mut acting) = (*x, acting);
    let steps = (dt / STEP).ceil().clamp(1.0, 1000.0);
    let h = dt / steps;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1000")]
    for _ in 0..steps as usize {
        let middle = follow(rules, acting, u, 0.5 * h);
        let kappa = rules.track.kappa(next.s);
        next = roll(rules, &rules.sliding[0], &next, middle, (h, STEP), kappa);
        acting = follow(rules, acting, u, h);
    }
    (next, acting)
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
