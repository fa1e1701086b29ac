//! The operator's orders to the service: start, stop, emergency stop, speed cap. Pure.

use controller::Controller;
use lcm_types::{ActuationCommand, Heartbeat, OperatorCommand};
use vehicle_model::{Input, Limiter};

/// Share of the operator's cap that is driven: bends and slopes change the speed between two states,
/// and the bridge sees that before the controller does. \[-\]
const BELOW: f64 = 0.98;

/// The controller's input, cut where it would take the car past the operator's cap.
///
/// The cap is in the controller's plans too, but there it is soft, and warm-up laps have none. The
/// limiter of the bridge approaches the cap at every tick of its own; what is sent here for a whole
/// period keeps below that until the period ends, so that the bridge has nothing left to cut.
/// `before` is the input that was sent last.
#[must_use]
pub fn capped(
    input: Input,
    before: Input,
    v_x: f64,
    cap: Option<f64>,
    controller: &Controller,
) -> Input {
    let Some(cap) = cap else { return input };
    let (car, period) = (controller.car(), controller.config().horizon.period);
    // Until the command acts, the car follows the one before.
    let ahead = period + car.actuator_delay + 2.0 * car.actuator_lag;
    let room = BELOW * cap - (v_x + before.a.max(0.0) * ahead);
    let time = Limiter::CAP_TIME + if room > 0.0 { ahead } else { 0.0 };
    let jerk = car.a_rate_max.map_or(f64::INFINITY, |rate| rate * period);
    let most = (room / time).max(before.a - jerk).max(car.a_min);
    Input { a: input.a.min(most), ..input }
}

/// What the controller's plans keep to: the operator's cap or, without, that of its configuration,
/// whichever is lower. 0 is none. \[m/s\]
#[must_use]
pub fn plan_cap(cap: Option<f64>, controller: &Controller) -> f64 {
    let configured = controller.config().limits.speed_cap;
    match cap {
        Some(cap) if configured > 0.0 => (BELOW * cap).min(configured),
        Some(cap) => BELOW * cap,
        None => configured,
    }
}

/// Highest speed cap taken, that of the configuration. \[m/s\]
const MAX_CAP: f64 = 1000.0;

/// What the operator last decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Authority {
    /// One of the states of [`Heartbeat`].
    pub state: i8,
    /// Speed not to be passed; none unless ordered. \[m/s\]
    pub speed_cap: Option<f64>,
}

impl Authority {
    /// Drives at once, or waits for the order to.
    #[must_use]
    pub fn new(wait_for_start: bool) -> Self {
        let state = if wait_for_start { Heartbeat::IDLE } else { Heartbeat::RUNNING };
        Self { state, speed_cap: None }
    }

    /// The `MODE_…` of the commands to send.
    #[must_use]
    pub fn mode(&self) -> i8 {
        match self.state {
            Heartbeat::RUNNING => ActuationCommand::MODE_DRIVE,
            Heartbeat::ESTOP => ActuationCommand::MODE_ESTOP,
            Heartbeat::SAFE_STOP => ActuationCommand::MODE_SAFE_STOP,
            _ => ActuationCommand::MODE_OFF,
        }
    }

    /// Obeys an order; `speed` is the car's, if known \[m/s\].
    ///
    /// # Errors
    /// Why it is not obeyed.
    pub fn obey(&mut self, order: &OperatorCommand, speed: Option<f64>) -> Result<(), String> {
        let stopped = self.state == Heartbeat::ESTOP;
        match order.command {
            OperatorCommand::ESTOP => self.state = Heartbeat::ESTOP,
            OperatorCommand::ESTOP_RESET if !stopped => {
                return Err("there is no emergency stop to end".to_owned());
            }
            OperatorCommand::ESTOP_RESET => match speed {
                Some(speed) if speed.abs() < 0.1 => self.state = Heartbeat::IDLE,
                Some(speed) => return Err(format!("the car moves at {speed:.2} m/s")),
                None => return Err("the speed of the car is not known".to_owned()),
            },
            _ if stopped => {
                return Err("emergency stop: only ESTOP_RESET at standstill ends it".to_owned());
            }
            OperatorCommand::START => self.state = Heartbeat::RUNNING,
            OperatorCommand::STOP => self.state = Heartbeat::SAFE_STOP,
            OperatorCommand::SET_SPEED_CAP if order.value > 0.0 && order.value <= MAX_CAP => {
                self.speed_cap = Some(order.value);
            }
            // 0 takes it away, as in the configuration.
            OperatorCommand::SET_SPEED_CAP if order.value == 0.0 => self.speed_cap = None,
            OperatorCommand::SET_SPEED_CAP => {
                return Err(format!("speed cap {}: expected 0 to {MAX_CAP} [m/s]", order.value));
            }
            other => return Err(format!("order {other} is not known here")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(command: i8, value: f64) -> OperatorCommand {
        OperatorCommand { command, value, ..OperatorCommand::default() }
    }

    #[test]
    fn an_emergency_stop_ends_only_at_standstill() {
        let mut authority = Authority::new(true);
        let mut say = |command, speed| authority.obey(&order(command, 0.0), speed).is_ok();
        assert!(say(OperatorCommand::START, None));
        assert!(say(OperatorCommand::ESTOP, Some(3.0)));
        assert!(!say(OperatorCommand::START, Some(0.0)));
        assert!(!say(OperatorCommand::ESTOP_RESET, Some(3.0)));
        assert!(!say(OperatorCommand::ESTOP_RESET, None));
        assert!(say(OperatorCommand::ESTOP_RESET, Some(0.0)));
        assert_eq!(authority.mode(), ActuationCommand::MODE_OFF);
    }

    #[test]
    fn a_speed_cap_is_a_positive_number_or_none() {
        let mut authority = Authority::new(false);
        assert!(authority.obey(&order(OperatorCommand::SET_SPEED_CAP, 1.5), None).is_ok());
        assert!(authority.obey(&order(OperatorCommand::SET_SPEED_CAP, f64::NAN), None).is_err());
        assert!(authority.obey(&order(OperatorCommand::SET_SPEED_CAP, -1.0), None).is_err());
        assert_eq!(authority.speed_cap, Some(1.5));
        assert!(authority.obey(&order(OperatorCommand::SET_SPEED_CAP, 0.0), None).is_ok());
        assert_eq!(authority.speed_cap, None);
    }
}
