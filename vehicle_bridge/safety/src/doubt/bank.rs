//! Whether the wheels follow the commands: a bank of hypotheses about grip and lag.
//!
//! Under each hypothesis the one-step model turns the measured change of the yaw rate into the
//! steering angle that explains it, and the change of speed into an acceleration. Over a short window
//! the explained value is a line of the one sent: slope 1 is an actuator that follows, slope 0 one that
//! is stuck, and the line's height is its bias. An actuator is doubted only if no hypothesis lets it
//! follow, whatever the noise: the slope counts with three of its own standard errors.

use vehicle_model::{Input, State};

use super::super::rules::Rules;
use super::response::{GRIPS, LAGS, ResponseModels};
use super::{DoubtFinding, DoubtLimits, Suspicion};
use crate::stop;

/// The window's time constant. \[s\]
const WINDOW: f64 = 0.3;
/// Longest step of the models. \[s\]
const STEP: f64 = 0.005;
/// A step this long says nothing. \[s\]
const GAP: f64 = 0.1;
/// By this the models' steering angle is moved to learn what it does. \[rad\]
const PROBE: f64 = 0.01;
/// An actuator that follows by less than this share is stuck. \[-\]
const FOLLOWS: f64 = 0.4;
/// Standard errors allowed for. \[-\]
const SIGMAS: f64 = 3.0;
/// States before a line means something. \[-\]
const FEW: f64 = 8.0;
/// Highest sum. \[-\]
const MOST: f64 = 1.5;

/// Sums of a weighted line with forgetting.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Line {
    count: f64,
    weight: f64,
    x: f64,
    z: f64,
    xx: f64,
    xz: f64,
    zz: f64,
}

/// A line through what was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fit {
    slope: f64,
    /// Standard error of the slope.
    error: f64,
    /// Standard deviation of what was sent.
    spread: f64,
    /// Mean of what is explained less what was sent.
    offset: f64,
    /// Standard deviation of what the line leaves.
    rest: f64,
}

impl Line {
    fn add(&mut self, x: f64, z: f64, weight: f64, kept: f64) {
        let new =
            [1.0, weight, weight * x, weight * z, weight * x * x, weight * x * z, weight * z * z];
        let sums = [
            &mut self.count,
            &mut self.weight,
            &mut self.x,
            &mut self.z,
            &mut self.xx,
            &mut self.xz,
            &mut self.zz,
        ];
        sums.into_iter().zip(new).for_each(|(sum, new)| *sum = kept * *sum + new);
    }

    fn fit(&self) -> Option<Fit> {
        if self.count < FEW || self.weight <= 0.0 {
            return None;
        }
        let (x, z) = (self.x / self.weight, self.z / self.weight);
        let spread = self.xx / self.weight - x * x;
        let together = self.xz / self.weight - x * z;
        let whole = self.zz / self.weight - z * z;
        if spread.is_nan() || spread <= 1e-12 {
            let rest = whole.max(0.0).sqrt();
            return Some(Fit { slope: 1.0, error: 0.0, spread: 0.0, offset: z - x, rest });
        }
        let slope = together / spread;
        let rest = (whole - slope * together).max(0.0);
        let error = (rest / (self.count * spread)).sqrt();
        Some(Fit { slope, error, spread: spread.sqrt(), offset: z - x, rest: rest.sqrt() })
    }
}

impl Fit {
    /// Whether what was sent moved by `least` and what came did not follow.
    fn is_stuck(&self, least: f64) -> bool {
        self.spread > least && self.slope + SIGMAS * self.error < FOLLOWS
    }
}

/// What is wrong with the steering, for the stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Steering {
    /// It does not move: nothing is left but to brake.
    Stuck,
    /// It is off by this; a stop can steer against it. \[rad\]
    Biased(f64),
}

/// The hypotheses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bank {
    steering: [[Line; LAGS.len()]; GRIPS.len()],
    drive: [Line; LAGS.len()],
    stuck: f64,
    biased: f64,
    runaway: f64,
}

impl Bank {
    pub(super) fn on_state(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        (before, x): (&State, &State),
        response: &ResponseModels,
        dt: f64,
    ) -> DoubtFinding {
        let lagged = response.lagged();
        let input = lagged[0];
        if !(dt > 0.0 && dt < GAP) {
            *self = Self::default();
            return DoubtFinding::default();
        }
        let kept = (-dt / WINDOW).exp();
        let moved = Input { delta: input.delta + PROBE, ..input };
        let ahead = |model, u| stop::roll(rules, model, before, u, (dt, STEP), 0.0);
        // Where it rolls slowly the yaw rate is the steering's by geometry, which noise hides.
        let fast = before.v_x > stop::ROLL_BELOW.max(rules.rolling.params.blend_speed_high);
        for ((lines, model), first) in
            self.steering.iter_mut().zip(&rules.sliding).zip([true, false, false])
        {
            let expected = ahead(model, input);
            if first {
                let z = (x.v_x - expected.v_x) / dt + input.a;
                for (line, lagged) in self.drive.iter_mut().zip(lagged) {
                    line.add(lagged.a, z, 1.0, kept);
                }
            }
            if !fast {
                *lines = [Line::default(); LAGS.len()];
                continue;
            }
            let gain = (ahead(model, moved).omega_z - expected.omega_z) / PROBE;
            if gain.abs() < 1e-6 {
                continue;
            }
            let z = (x.omega_z - expected.omega_z) / gain + input.delta;
            for (line, lagged) in lines.iter_mut().zip(lagged) {
                line.add(lagged.delta, z, gain * gain, kept);
            }
        }
        let counts = GRIPS.map(|grip| response.may_have(rules, grip));
        self.judge(rules, limits, counts, dt)
    }

    fn judge(
        &mut self,
        rules: &Rules,
        limits: &DoubtLimits,
        counts: [bool; GRIPS.len()],
        dt: f64,
    ) -> DoubtFinding {
        let steering = self.steering;
        let lines = || {
            let counted = steering.iter().zip(counts).filter(|(_, counts)| *counts);
            counted.flat_map(|(lines, _)| lines)
        };
        let stuck =
            lines().all(|line| line.fit().is_some_and(|fit| fit.is_stuck(0.1 * limits.steer)));
        // Whatever grip and lag are: as far to one side, beyond what noise makes of it.
        let [left, right] = [1.0, -1.0].map(|side| {
            let least = lines().map(|line| {
                let far = |f: Fit| side * f.offset - SIGMAS * f.rest / line.count.sqrt();
                line.fit().map_or(f64::NEG_INFINITY, far)
            });
            least.fold(f64::INFINITY, f64::min) / limits.steer
        });
        let biased = left.max(right).min(3.0);
        // Only more acceleration than was asked for is a danger: less is a hill or a weak drive.
        let accel = rules.limiter.a_max.max(-rules.limiter.a_min);
        let runaway = self.drive.iter().all(|line| {
            line.fit()
                .is_some_and(|fit| fit.is_stuck(0.08 * accel) && fit.offset > 0.5 * limits.accel)
        });
        let step = |sum: f64, is: bool| {
            let by = if is { dt / limits.patience } else { -0.5 * dt / limits.patience };
            (sum + by).clamp(0.0, MOST)
        };
        self.stuck = step(self.stuck, stuck);
        self.runaway = step(self.runaway, runaway);
        self.biased =
            (self.biased + (biased.max(0.0) - 1.0) * dt / limits.patience).clamp(0.0, MOST);
        DoubtFinding { what: Suspicion::Steering, level: self.stuck.max(self.biased) }
            .or(DoubtFinding { what: Suspicion::Drive, level: self.runaway })
    }

    /// What is wrong with a steering that is doubted, by the hypothesis that leaves least.
    pub(super) fn steering(&self) -> Steering {
        let fits = self.steering.iter().flatten().filter_map(Line::fit);
        let best = fits.min_by(|a, b| a.rest.total_cmp(&b.rest));
        match best {
            Some(fit) if self.stuck < 0.5 && fit.slope > FOLLOWS => Steering::Biased(fit.offset),
            _ => Steering::Stuck,
        }
    }
}
