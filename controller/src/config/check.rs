//! Which values a configuration may have.

use super::{Config, Problem};

impl Config {
    /// Every value that is out of range.
    #[must_use]
    pub fn problems(&self) -> Vec<Problem> {
        let mut check = Check::default();
        check.count("horizon.steps", self.horizon.steps, 2, 200);
        check.range("horizon.period_s", self.horizon.period, 1e-3, 1.0);
        check.count("horizon.substeps", self.horizon.substeps, 1, 200);
        check.count("safe_set.neighbors", self.safe_set.neighbors, 2, 200);
        check.count("safe_set.laps", self.safe_set.laps, 1, 20);
        check.count("regression.neighbors", self.regression.neighbors, 1, 500);
        check.count("regression.laps", self.regression.laps, 0, 100_000);
        check.range("regression.bandwidth", self.regression.bandwidth, 1e-9, 1e9);
        check.range("regression.ridge", self.regression.ridge, 1e-12, 1e6);
        for (name, weight) in
            ["v_x", "v_y", "omega_z", "a", "delta"].iter().zip(self.regression.metric)
        {
            check.range(&format!("regression.metric ({name})"), weight, 0.0, 1e9);
        }
        if self.regression.metric.iter().sum::<f64>() <= 0.0 {
            check.add(
                "regression.metric",
                "all weights are 0; at least one must be positive".into(),
            );
        }
        check.range("nominal.secant", self.nominal.secant, 0.0, 0.4);
        let c = &self.cost;
        check.range("cost.input", c.input, 0.0, 1e6);
        check.range("cost.input_acceleration", c.input_acceleration, 0.0, 1e6);
        check.range("cost.dissipation", c.dissipation, 0.0, 1e3);
        check.range("cost.control_rate", c.control_rate, 0.0, 1e6);
        check.range("cost.acceleration_rate", c.acceleration_rate, 0.0, 1e6);
        check.range("cost.steering_rate", c.steering_rate, 0.0, 1e6);
        check.range("cost.steering_rate_floor", c.steering_rate_floor, 0.0, 1e6);
        check.range("cost.gentle_start", c.gentle_start, 0.0, 1e6);
        for weight in c.terminal_slack {
            check.range("cost.terminal_slack", weight, 1e-9, 1e9);
        }
        check.range("cost.lane_linear", c.lane_linear, 0.0, 1e9);
        check.range("cost.lane_quadratic", c.lane_quadratic, 1e-9, 1e9);
        check.range("cost.slip", c.slip, 0.0, 1e9);
        check.range("cost.speed", c.speed, 0.0, 1e9);
        let e = &self.envelope;
        check.range("envelope.grip_share", e.grip_share, 1e-3, 2.0);
        check.range("envelope.growth_least", e.growth_least, 0.0, 1.0);
        check.range("envelope.growth_most", e.growth_most, e.growth_least, 10.0);
        check.range("envelope.brake_share", e.brake_share, 1e-2, 1.0);
        check.range("limits.lane_margin_m", self.limits.lane_margin, 0.0, 100.0);
        check.range("limits.front_slip_rad", self.limits.front_slip, 0.0, 1.5);
        check.range("limits.rear_slip_rad", self.limits.rear_slip, 0.0, 1.5);
        check.range("limits.speed_cap_mps", self.limits.speed_cap, 0.0, 1000.0);
        check.count("warm_up.laps", self.warm_up.laps, 1, 1000);
        check.range("warm_up.speed_mps", self.warm_up.speed, 0.1, 100.0);
        check.range("warm_up.noise_a_mps2", self.warm_up.noise_a, 0.0, 10.0);
        check.range("warm_up.noise_delta_rad", self.warm_up.noise_delta, 0.0, 0.5);
        check.count("delay.steps", self.delay.steps, 0, 20);
        self.filter.check(&mut check);
        check.range("solver.tolerance", self.solver.tolerance, 1e-12, 1e-2);
        check.count("solver.max_iterations", self.solver.max_iterations as usize, 5, 1000);
        check.problems
    }
}

/// Collects the problems of a configuration.
#[derive(Default)]
pub(super) struct Check {
    problems: Vec<Problem>,
}

impl Check {
    fn add(&mut self, key: &str, message: String) {
        self.problems.push(Problem { key: key.to_owned(), message });
    }

    pub(super) fn range(&mut self, key: &str, found: f64, least: f64, most: f64) {
        if !(least..=most).contains(&found) {
            self.add(key, format!("{found} is out of range; allowed is {least} to {most}"));
        }
    }

    fn count(&mut self, key: &str, found: usize, least: usize, most: usize) {
        if !(least..=most).contains(&found) {
            self.add(key, format!("{found} is out of range; allowed is {least} to {most}"));
        }
    }
}
