//! What the simulated car has that the controller does not know, as the command line says it.

use vehicle_model::CarParams;

use crate::settings::Usage;

/// Names that may be changed, for messages.
const NAMES: &str = "mu, mu_f, mu_r, mass, iz, b_f, c_f, b_r, c_r, drag, delay, lag, noise, disturb";

/// Sensor noise of velocities is this many times that of position and heading.
pub const VELOCITY_NOISE: f64 = 10.0;

/// The simulated car: its own parameters, noise and disturbance.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantSettings {
    /// Parameters of the car.
    pub car: CarParams,
    /// Standard deviation of the sensor noise on position [m] and heading [rad]; tenfold on
    /// velocities.
    pub noise: f64,
    /// Standard deviation of the velocity disturbance in each period [m/s].
    pub disturb: f64,
}

impl PlantSettings {
    /// The car as it is, without noise.
    #[must_use]
    pub fn new(car: CarParams) -> Self {
        Self { car, noise: 0.0, disturb: 0.0 }
    }

    /// Applies changes given as `name=value`.
    ///
    /// # Errors
    /// [`Usage`] for an unknown name or a value that makes no car.
    pub fn change(&mut self, changes: &[String]) -> Result<(), Usage> {
        for change in changes {
            let usage = |why: String| Usage(format!("--plant {change}: {why}"));
            let (name, value) =
                change.split_once('=').ok_or_else(|| usage("expected NAME=VALUE".to_owned()))?;
            let value: f64 = value.trim().parse().map_err(|_| {
                usage(format!("found `{}`, expected a number", value.trim()))
            })?;
            self.set(name.trim(), value).map_err(usage)?;
        }
        match self.car.validate().first() {
            Some(problem) => Err(Usage(format!("--plant: {problem}"))),
            None => Ok(()),
        }
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), String> {
        let car = &mut self.car;
        let field = match name {
            "mu" => {
                car.tyre_rear.mu = value;
                &mut car.tyre_front.mu
            }
            "mu_f" => &mut car.tyre_front.mu,
            "mu_r" => &mut car.tyre_rear.mu,
            "mass" => &mut car.mass,
            "iz" => &mut car.inertia_z,
            "b_f" => &mut car.tyre_front.b,
            "c_f" => &mut car.tyre_front.c,
            "b_r" => &mut car.tyre_rear.b,
            "c_r" => &mut car.tyre_rear.c,
            "drag" => &mut car.linear_drag,
            "delay" => &mut car.actuator_delay,
            "lag" => &mut car.actuator_lag,
            "noise" => &mut self.noise,
            "disturb" => &mut self.disturb,
            _ => return Err(format!("found `{name}`, expected one of {NAMES}")),
        };
        *field = value;
        let spread_is_negative = self.noise < 0.0 || self.disturb < 0.0;
        if !value.is_finite() || spread_is_negative {
            return Err(format!("found {value}, expected a finite number, 0 or above for noise"));
        }
        Ok(())
    }
}
