//! What acts on the car beside its inputs: process noise, changing grip, forces.

use serde::{Deserialize, Serialize};

use super::noise::{NoiseStream, not_negative};
use crate::params::ParamProblem;
use crate::state::State;

/// Control step the process noise is stated for [s].
const NOISE_STEP: f64 = 0.1;
/// Process noise is clipped at this many standard deviations.
const CLIP: f64 = 3.0;

/// Disturbances of a simulated car; all off by default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Standard deviation of the noise added to [v_x, v_y, omega_z] in a step of 0.1 s, clipped
    /// at 3 sigma; for other steps it grows with the root of their length [m/s, m/s, rad/s].
    pub process_std: [f64; 3],
    /// Changes of grip; where several hold, their factors multiply.
    pub grip: Vec<GripChange>,
    /// Constant force in the body frame, forward and left \[N\].
    pub force_body_n: [f64; 2],
    /// Constant force in the global frame, a wind: along X and Y \[N\].
    pub force_global_n: [f64; 2],
}

/// Other grip in a window of time, of the track, or of both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripChange {
    /// Factors on the friction coefficient of the front and rear axle [-].
    pub factor: [f64; 2],
    /// Window of time, from and to; absent: always \[s\].
    #[serde(default)]
    pub time_s: Option<[f64; 2]>,
    /// Window of s, from and to; from > to spans the line; absent: everywhere \[m\].
    #[serde(default)]
    pub s_m: Option<[f64; 2]>,
}

impl GripChange {
    fn holds(&self, time: f64, s: f64) -> bool {
        let in_time = self.time_s.is_none_or(|[from, to]| time >= from && time < to);
        let in_s =
            self.s_m.is_none_or(
                |[from, to]| {
                    if from <= to { s >= from && s < to } else { s >= from || s < to }
                },
            );
        in_time && in_s
    }
}

impl Disturbance {
    pub(super) fn validate(&self) -> Vec<ParamProblem> {
        let [v_x, v_y, omega_z] = self.process_std;
        let mut problems: Vec<_> = not_negative(
            "plant.disturbance",
            [("process_std", v_x), ("process_std", v_y), ("process_std", omega_z)],
        )
        .collect();
        for change in &self.grip {
            let [front, rear] = change.factor;
            problems.extend(not_negative(
                "plant.disturbance.grip",
                [("factor", front), ("factor", rear)],
            ));
        }
        let forces = [("force_body_n", self.force_body_n), ("force_global_n", self.force_global_n)];
        for (key, force) in forces {
            if !force.iter().all(|value| value.is_finite()) {
                problems.push(ParamProblem {
                    section: "plant.disturbance",
                    key,
                    found: format!("{force:?}"),
                    expected: "finite numbers",
                    line: None,
                });
            }
        }
        problems
    }

    /// Factors on the friction coefficients at a time and place.
    pub(super) fn grip(&self, time: f64, s: f64) -> [f64; 2] {
        self.grip.iter().filter(|change| change.holds(time, s)).fold([1.0, 1.0], |grip, change| {
            [grip[0] * change.factor[0], grip[1] * change.factor[1]]
        })
    }

    /// Whether a force acts.
    pub(super) fn pushes(&self) -> bool {
        self.force_body_n != [0.0; 2] || self.force_global_n != [0.0; 2]
    }

    /// Acceleration by the forces in the body frame of a car with this heading [m/s^2].
    pub(super) fn acceleration(&self, heading: f64, mass: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(heading);
        let [east, north] = self.force_global_n;
        [
            (self.force_body_n[0] + east * cos + north * sin) / mass,
            (self.force_body_n[1] - east * sin + north * cos) / mass,
        ]
    }

    /// Adds the process noise of a step.
    pub(super) fn kick(&self, stream: &mut NoiseStream, x: &mut State, dt: f64) {
        if self.process_std == [0.0; 3] {
            return;
        }
        let scale = (dt / NOISE_STEP).sqrt();
        let mut kick = |std: f64| std * scale * stream.normal().clamp(-CLIP, CLIP);
        x.v_x += kick(self.process_std[0]);
        x.v_y += kick(self.process_std[1]);
        x.omega_z += kick(self.process_std[2]);
    }
}
