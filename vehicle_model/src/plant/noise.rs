//! Sensor noise and the generators behind all noise.

use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::normal::standard_normal;
use crate::params::ParamProblem;
use crate::state::State;

/// Standard deviations of white Gaussian noise on what is measured; 0 is off.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorNoise {
    /// Noise of v_x [m/s].
    #[serde(rename = "v_x_mps")]
    pub v_x: f64,
    /// Noise of v_y [m/s].
    #[serde(rename = "v_y_mps")]
    pub v_y: f64,
    /// Noise of omega_z [rad/s].
    #[serde(rename = "omega_z_radps")]
    pub omega_z: f64,
    /// Noise of e_psi \[rad\].
    #[serde(rename = "e_psi_rad")]
    pub e_psi: f64,
    /// Noise of s \[m\].
    #[serde(rename = "s_m")]
    pub s: f64,
    /// Noise of e_y \[m\].
    #[serde(rename = "e_y_m")]
    pub e_y: f64,
}

impl SensorNoise {
    /// Noise of a small-scale laboratory with motion capture: 1 mm and 1 mrad on the pose,
    /// 10 mm/s and 10 mrad/s on velocities filtered from it over a tenth of a second.
    #[must_use]
    pub fn laboratory() -> Self {
        Self { v_x: 0.01, v_y: 0.01, omega_z: 0.01, e_psi: 1e-3, s: 1e-3, e_y: 1e-3 }
    }

    fn channels(&self) -> [(&'static str, f64); 6] {
        [
            ("v_x_mps", self.v_x),
            ("v_y_mps", self.v_y),
            ("omega_z_radps", self.omega_z),
            ("e_psi_rad", self.e_psi),
            ("s_m", self.s),
            ("e_y_m", self.e_y),
        ]
    }

    pub(super) fn validate(&self) -> impl Iterator<Item = ParamProblem> {
        not_negative("plant.noise", self.channels())
    }

    pub(super) fn measure(&self, sensors: &mut NoiseStream, x: &State) -> State {
        let std = self.channels().map(|(_, std)| std);
        if std == [0.0; 6] {
            return *x;
        }
        let mut x = x.to_vector();
        for (value, std) in x.iter_mut().zip(std) {
            *value += std * sensors.normal();
        }
        State::from_vector(&x)
    }
}

/// Problems of standard deviations below 0 or not finite.
pub(super) fn not_negative<const N: usize>(
    section: &'static str,
    values: [(&'static str, f64); N],
) -> impl Iterator<Item = ParamProblem> {
    values.into_iter().filter(|(_, value)| !(value.is_finite() && *value >= 0.0)).map(
        move |(key, value)| ParamProblem {
            section,
            key,
            found: value.to_string(),
            expected: "a number of 0 or above",
            line: None,
        },
    )
}

/// One stream of standard normal numbers. NoiseStream and disturbances have their own, so that
/// measuring more often does not change what the car does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct NoiseStream {
    generator: Pcg64,
}

impl NoiseStream {
    pub(super) fn new(seed: u64, stream: u128) -> Self {
        Self { generator: Pcg64::new(u128::from(seed), stream) }
    }

    pub(super) fn normal(&mut self) -> f64 {
        standard_normal(&mut self.generator)
    }
}
