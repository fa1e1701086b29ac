//! Outputs of a control step.

use controller::fhocp::Backend;
use controller::{Action, Command, Reason, SolveStatus};
use vehicle_model::State;

use super::slots::PLAN;
use super::{ControllerFmu, slots};
use crate::table::Real;
use crate::values::Values;

fn write<const N: usize>(values: &mut Values, slots: &[Real; N], numbers: [f64; N]) {
    slots.iter().zip(numbers).for_each(|(slot, number)| values.set_real(*slot, number));
}

fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}

/// Codes of the description of `status.action`.
fn action(action: Action) -> f64 {
    match action {
        Action::WarmUp => 0.0,
        Action::Learned => 1.0,
        Action::ShiftedPlan => 2.0,
        Action::Tracking => 3.0,
        Action::Braking => 4.0,
        Action::Recovering => 5.0,
    }
}

/// Codes of the description of `status.reason`.
fn reason(reason: Reason) -> f64 {
    match reason {
        Reason::None => 0.0,
        Reason::SolverFailed => 1.0,
        Reason::NonFinite => 2.0,
        Reason::TimeNotAdvancing => 3.0,
        Reason::TimeGap => 4.0,
        Reason::Jump => 5.0,
        Reason::OffTrack => 6.0,
        Reason::WrongWay => 7.0,
        Reason::Standstill => 8.0,
        Reason::NoSafeSet => 9.0,
        Reason::Spin => 10.0,
        Reason::Askew => 11.0,
    }
}

/// Codes of the description of `status.solve`.
fn solve(solve: SolveStatus) -> f64 {
    match solve {
        SolveStatus::NotRun => 0.0,
        SolveStatus::Solved => 1.0,
        SolveStatus::AlmostSolved => 2.0,
        SolveStatus::MaxIterations => 3.0,
        SolveStatus::Infeasible => 4.0,
        SolveStatus::Numerical => 5.0,
    }
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
    pub(super) fn publish_start(&self, values: &mut Values) {
        let [front, rear] = self.controller.grip();
        write(values, &slots().learned, [0.0, 0.0, front, rear]);
    }

    pub(super) fn publish(&self, values: &mut Values, command: &Command, duration: f64) {
        let (slots, status, laps) = (slots(), &command.status, &self.laps);
        write(values, &slots.command, [command.input.a, command.input.delta]);
        let numbers = [
            action(status.action),
            reason(status.reason),
            solve(status.solve),
            f64::from(status.iterations),
            1e3 * duration,
            flag(status.clipped),
            self.schedule.count() as f64,
            solver(status.solver),
        ];
        write(values, &slots.status, numbers);
        let numbers = [
            f64::from(status.lap),
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
    }

    fn publish_plan(&self, values: &mut Values) {
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
