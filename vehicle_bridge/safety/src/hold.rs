//! The brake that holds a car which does not drive: pressed harder where the car moves on against it,
//! by a throttle that is off or on a slope.

use lcm_types::MonoTime;
use vehicle_model::{Input, State};

use super::rules::Rules;

/// Slower than this, the brake stays pressed. \[m/s\]
const HOLD_BELOW: f64 = 0.5;
/// How hard, as a share of full braking. \[-\]
const HOLD: f64 = 0.2;
/// Slower than this, a car that moves on gets all the brake there is, \[m/s\]
const PRESS_BELOW: f64 = 2.0;
/// or slower than full braking takes away in this time: there the safe stop brakes with less, as the car
/// becomes slower. \[s\]
const FADES: f64 = 0.5;
/// So many times as long as the brake that holds it needs from [`HOLD_BELOW`] to a stand the car may
/// still move, \[-\]
const PATIENCE: f64 = 2.0;
/// and this long more, for the braking before. \[s\]
const BRAKED: f64 = 2.0;

/// How the car obeys the brake that holds it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Hold {
    /// Since when it is slow and still moves, and the slowest it was. \[m/s\]
    slow: Option<(MonoTime, f64)>,
    /// All the brake there is.
    pressed: bool,
    /// It moved on though it was held.
    creeps: bool,
}

impl Hold {
    /// A throttle or brake is doubted: the usual brake may be weaker than what is off.
    pub(super) fn press(&mut self) {
        self.pressed = true;
    }

    /// Whether the car moved on though the brake held it.
    pub(super) fn creeps(&self) -> bool {
        self.creeps
    }

    /// A state of a car that does not drive.
    pub(super) fn on_state(&mut self, rules: &Rules, x: &State, now: MonoTime) {
        // A car that rolls backwards is left out: more deceleration holds it only where it is a brake,
        // and not a reverse drive.
        if x.v_x < rules.still {
            self.slow = None;
            return;
        }
        let (since, slowest) = match self.slow {
            Some((since, slowest)) => (since, slowest.min(x.v_x)),
            None if x.v_x < press_below(rules) => (now, x.v_x),
            None => return,
        };
        self.slow = Some((since, slowest));
        let patience = PATIENCE * HOLD_BELOW / (HOLD * rules.limiter.a_min.abs()) + BRAKED;
        let faster = slowest < HOLD_BELOW && x.v_x > slowest + rules.still;
        if faster || now.ns_since(since) as f64 * 1e-9 > patience {
            (self.pressed, self.creeps) = (true, true);
        }
    }

    /// What is asked for at this speed \[m/s\], at least as hard as the car has to be held.
    pub(super) fn apply(&self, rules: &Rules, v_x: f64, asked: Input) -> Input {
        let held = match self.pressed {
            true if v_x < press_below(rules) => rules.limiter.a_min,
            _ if v_x < HOLD_BELOW => HOLD * rules.limiter.a_min,
            _ => return asked,
        };
        Input { a: asked.a.min(held), ..asked }
    }
}

fn press_below(rules: &Rules) -> f64 {
    PRESS_BELOW.max(FADES * rules.limiter.a_min.abs())
}
