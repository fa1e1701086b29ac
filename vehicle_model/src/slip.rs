//! Slip angles and their gradients, for the slip guards of the controller.

use nalgebra::Vector3;

use crate::model::slip_speed;
use crate::params::CarParams;
use crate::state::{Input, State};

/// Slip angles of both axles, positive when the tyre force points left \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipAngles {
    /// alpha_f = delta - atan((v_y + l_f omega_z)/v_x) \[rad\].
    pub front: f64,
    /// alpha_r = -atan((v_y - l_r omega_z)/v_x) \[rad\].
    pub rear: f64,
    /// Gradient of `front` with respect to [v_x, v_y, omega_z]; that by delta is 1.
    pub front_gradient: Vector3<f64>,
    /// Gradient of `rear` with respect to [v_x, v_y, omega_z]; that by delta is 0.
    pub rear_gradient: Vector3<f64>,
}

impl SlipAngles {
    /// Slip angles of a state; v_x is floored at 0.05 m/s, where its gradient becomes 0.
    #[must_use]
    pub fn new(x: &State, u: &Input, car: &CarParams) -> Self {
        let speed = slip_speed(x.v_x);
        let by_speed = if speed == x.v_x { 1.0 } else { 0.0 };
        // -atan(p/v) and its gradient, p = v_y + arm omega_z.
        let axle = |arm: f64| {
            let lateral = x.v_y + arm * x.omega_z;
            let norm = speed * speed + lateral * lateral;
            let gradient =
                Vector3::new(by_speed * lateral / norm, -speed / norm, -arm * speed / norm);
            (-libm::atan(lateral / speed), gradient)
        };
        let (front, front_gradient) = axle(car.l_f);
        let (rear, rear_gradient) = axle(-car.l_r);
        Self { front: u.delta + front, rear, front_gradient, rear_gradient }
    }
}
