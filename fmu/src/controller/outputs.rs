//! Outputs of a control step.

use controller::fhocp::Backend;
use controller::{Action, Command};
use vehicle_model::State;

use super::slots::PLAN;
use super::{ControllerFmu, slots};
use crate::table::Real;
use crate::values::VariableValues;

fn write<const N: usize>(values: &mut VariableValues, slots: &[Real; N], numbers: [f64; N]) {
    slots.iter().zip(numbers).for_each(|(slot, number)| values.set_real(*slot, number));
}

fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}

/// Codes of the description of `status.solver`.
fn solver(solver: Option<Backend>) -> f64 {
    match solver {
        None => 0.0,
        Some(Backend::Structured) => 1.0,
        Some(Backend::Clarabel) => 2.0,
    }
}

impl ControllerFmu {
    /// Outputs before the first step: no command, the grip as configured or loaded.
    pub(super) fn publish_start(&self, values: &mut VariableValues) {
        let [front, rear] = self.controller.grip();
        write(values, &slots().learned, [0.0, 0.0, front, rear]);
        self.publish_estimates(values, &Command::default());
    }

    pub(super) fn publish(&self, values: &mut VariableValues, command: &Command, duration: f64) {
        let (slots, status, laps) = (slots(), &command.status, &self.laps);
        write(values, &slots.command, [command.input.a, command.input.delta]);
        let numbers = [
            status.action.code().into(),
            status.reason.code().into(),
            status.solve.code().into(),
            f64::from(status.iterations),
            1e3 * duration,
            flag(status.clipped),
            self.schedule.count() as f64,
            solver(status.solver),
        ];
        write(values, &slots.status, numbers);
        let numbers = [
            f64::from(status.lap.get()),
            f64::from(laps.finished),
            laps.last_time,
            laps.best_time,
            flag(laps.last_valid),
        ];
        write(values, &slots.laps, numbers);
        let State { v_x, v_y, omega_z, e_psi, s, e_y } = status.state;
        write(values, &slots.frenet, [v_x, v_y, omega_z, e_psi, s, e_y]);
        let numbers = [
            status.cost,
            status.lane_slack,
            status.front_slip_slack,
            status.rear_slip_slack,
            status.speed_slack,
            status.terminal_slack_cost,
        ];
        write(values, &slots.slack, numbers);
        let [front, rear] = self.controller.grip();
        let support = [status.data_support_min, status.data_support_mean];
        write(values, &slots.learned, [support[0], support[1], front, rear]);
        self.publish_plan(values);
        self.publish_estimates(values, command);
    }

    /// What the controller has found out about road, actuators and sensors.
    fn publish_estimates(&self, values: &mut VariableValues, command: &Command) {
        let (slots, controller, status) = (slots(), &self.controller, &command.status);
        values.set_real(slots.road_grip, controller.road_grip());
        let response = controller.response();
        let found = flag(controller.response_found());
        let numbers = [response.delay, response.lag, found, status.delay_change];
        write(values, &slots.response, numbers);
        values.set_real(slots.recovering, flag(status.action == Action::Recovering));
        values.set_real(slots.filtered, flag(controller.covariance().is_some()));
        write(values, &slots.state_sigma, controller.state_sigma().unwrap_or_default());
        write(values, &slots.noise_sigma, controller.noise_sigma().unwrap_or_default());
    }

    fn publish_plan(&self, values: &mut VariableValues) {
        let points = &self.controller.plan().x;
        for k in 0..PLAN {
            let x = points.get(k + 1).or(points.last()).copied().unwrap_or_default();
            let numbers = [x.v_x, x.e_psi, x.s, x.e_y];
            for (slots, number) in slots().plan.iter().zip(numbers) {
                values.set_real(slots[k], number);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::sync::Arc;

    use controller::{Config, Controller, Measurement, Pose, Preset};
    use vehicle_model::{CarParams, Plant, PlantParams, SensorNoise, Track};

    use super::*;
    use crate::log::CallLog;
    use crate::model::{CommunicationStep, FmuModel, Io};

    fn place(name: &str) -> usize {
        let variables = ControllerFmu::description().table.variables();
        variables.iter().position(|v| v.name == name).unwrap()
    }

    #[test]
    fn what_the_controller_has_found_out_is_in_the_outputs() {
        let track = Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let config = Config::derived(Preset::Race, &car, &track);
        let period = config.horizon.period;
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let mut native = Controller::new(config, car.clone(), Arc::clone(&track)).unwrap();
        // The true car answers more slowly than its file says, and its pose has 5 mm of noise.
        let mut params = PlantParams::new(CarParams { actuator_lag: 0.1, ..car });
        let (v_x, v_y, omega_z) = (0.05, 0.05, 0.05);
        params.noise = SensorNoise { v_x, v_y, omega_z, e_psi: 0.005, s: 0.005, e_y: 0.005 };
        let mut plant = Plant::new(params, track, start).unwrap();

        let mut values = VariableValues::start(&ControllerFmu::description().table);
        let mut log = CallLog::default();
        let mut io = Io { values: &mut values, resources: None, log: &mut log };
        let mut fmu = ControllerFmu::start(&mut io).unwrap();
        assert_eq!(io.values.numbers[place("grip.road")], 1.0);
        let (mut filtered, mut found) = (0, 0);
        for k in 0..1100 {
            let x = plant.measure();
            let numbers = [x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y];
            write(io.values, &slots().vehicle[..6].try_into().unwrap(), numbers);
            let time = f64::from(k) * period;
            fmu.step(&mut io, &CommunicationStep { origin: 0.0, begin: time, size: period })
                .unwrap();
            let measurement = Measurement { time, pose: Pose::Frenet(x), applied: None };
            let command = native.step(&measurement);
            let (status, response) = (command.status, native.response());
            let (state, noise) = (native.state_sigma(), native.noise_sigma());
            for (name, expected) in [
                ("cmd.delta", command.input.delta),
                ("grip.road", status.road_grip),
                ("response.delay", response.delay),
                ("response.lag", response.lag),
                ("response.found", flag(native.response_found())),
                ("response.delay_change", status.delay_change),
                ("status.recovering", flag(status.action == Action::Recovering)),
                ("filter.active", flag(native.covariance().is_some())),
                ("filter.state.e_y", state.map_or(0.0, |sigma| sigma[5])),
                ("filter.noise.v_x", noise.map_or(0.0, |sigma| sigma[0])),
            ] {
                assert_eq!(io.values.numbers[place(name)], expected, "{name} in step {k}");
            }
            if let (Some(state), Some(noise)) = (state, noise) {
                filtered += 1;
                assert!(state[5] <= noise[5], "an estimate is worse than its sensor: step {k}");
            }
            found += u32::from(native.response_found());
            native.prepare();
            plant.apply(command.input, period);
        }
        assert!(filtered > 500 && found > 100, "filtered {filtered}, found {found}");
        let found = native.response();
        assert!((found.delay + found.lag - 0.1).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn value_references_of_earlier_outputs_are_where_they_were() {
        assert_eq!(place("plan.e_y[20]") + 1, place("grip.road"));
    }
}
