//! The safe stop: braking along the track, on the latest or the dead-reckoned state.

use vehicle_model::{Input, State};

use super::rules::Rules;

/// Slower than this, the brake stays pressed. \[m/s\]
const HOLD_BELOW: f64 = 0.5;
/// How hard, as a share of full braking. \[-\]
const HOLD: f64 = 0.2;

/// What brings the car to a stand on the track.
pub(super) fn brake(rules: &Rules, x: &State) -> Input {
    let wanted = rules.tracker.brake(x, &rules.track);
    if x.v_x < HOLD_BELOW {
        return Input { a: wanted.a.min(HOLD * rules.limiter.a_min), ..wanted };
    }
    wanted
}

/// Where the car will be after `dt` \[s\]: a kinematic car, for the time without states.
pub(super) fn reckon(rules: &Rules, x: &State, u: Input, dt: f64) -> State {
    let rates = rules.model.derivative(x, &u, rules.track.kappa(x.s));
    let rates = vehicle_model::State::from_vector(&rates.into());
    let next = State::from_vector(&(x.to_vector() + rates.to_vector() * dt));
    if !next.is_finite() {
        return *x;
    }
    State { v_x: next.v_x.max(0.0), s: rules.track.wrap(next.s), ..next }
}
