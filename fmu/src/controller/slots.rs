//! The controller's variables.

use super::settings::Settings;
use crate::files::{CAR, TRACK};
use crate::table::{Boolean, Integer, Real, Text, VariableTable};
use crate::unit::{self, Unit};
use crate::variable::{Role, Variable};

/// Points of the plan that are outputs; a longer horizon is cut, a shorter one holds its end.
pub(crate) const PLAN: usize = 20;

/// Where everything is in the table.
#[derive(Debug)]
pub(crate) struct Slots {
    /// Inputs v_x, v_y, omega_z, e_psi, s, e_y, x, y, psi.
    pub(crate) vehicle: [Real; 9],
    /// Inputs a, delta as they act on the car.
    pub(crate) applied: [Real; 2],
    pub(crate) global_pose: Boolean,
    pub(crate) use_applied: Boolean,
    pub(crate) track: Text,
    pub(crate) car: Text,
    /// Grip the controller believes in; 0 as the car's.
    pub(crate) nominal_mu: Real,
    pub(crate) preset: Text,
    pub(crate) config: Text,
    pub(crate) load: Text,
    pub(crate) save: Text,
    /// 0 as the preset, 1 error, 2 full, 3 nominal.
    pub(crate) regression_mode: Integer,
    pub(crate) settings: Settings,
    /// Outputs a, delta.
    pub(crate) command: [Real; 2],
    /// Action, reason, solver status, iterations, solve time, clipped, step counter, solver.
    pub(crate) status: [Real; 8],
    /// Lap in progress, laps finished, last lap time, best lap time, last lap valid.
    pub(crate) laps: [Real; 5],
    /// Frenet state used.
    pub(crate) frenet: [Real; 6],
    /// Cost, lane, front, rear, speed, terminal slack.
    pub(crate) slack: [Real; 6],
    /// Data support, least and mean; fitted grip front and rear.
    pub(crate) learned: [Real; 4],
    /// v_x, e_psi, s, e_y along the plan.
    pub(crate) plan: [Vec<Real>; 4],
    pub(crate) road_grip: Real,
    /// Delay, lag, whether they were found, change of the delay.
    pub(crate) response: [Real; 4],
    pub(crate) recovering: Real,
    pub(crate) filtered: Real,
    /// Standard deviations of the estimated state and of the measurement's noise, in state order.
    pub(crate) state_sigma: [Real; 6],
    pub(crate) noise_sigma: [Real; 6],
}

const VEHICLE: [(&str, Unit, &str); 9] = [
    ("v_x", unit::M_PER_S, "Longitudinal velocity, body frame"),
    ("v_y", unit::M_PER_S, "Lateral velocity, body frame, positive left"),
    ("omega_z", unit::RAD_PER_S, "Yaw rate, positive left"),
    ("e_psi", unit::RAD, "Heading relative to the centre line (unless param.global_pose)"),
    ("s", unit::M, "Arc length along the centre line (unless param.global_pose)"),
    ("e_y", unit::M, "Lateral deviation, positive left (unless param.global_pose)"),
    ("x", unit::M, "Global position, x (with param.global_pose)"),
    ("y", unit::M, "Global position, y (with param.global_pose)"),
    ("psi", unit::RAD, "Global heading, positive left from x (with param.global_pose)"),
];

const NONE: f64 = f64::INFINITY;

/// What bounds the outputs that have bounds whatever car and track are.
const BOUNDS: [(&str, f64, f64); 22] = [
    ("status.action", 0.0, 5.0),
    ("status.reason", 0.0, 11.0),
    ("status.solve", 0.0, 5.0),
    ("status.iterations", 0.0, NONE),
    ("status.solve_ms", 0.0, NONE),
    ("status.clipped", 0.0, 1.0),
    ("status.steps", 0.0, NONE),
    ("lap.number", 0.0, NONE),
    ("lap.finished", 0.0, NONE),
    ("lap.last_time", 0.0, NONE),
    ("lap.best_time", 0.0, NONE),
    ("lap.last_valid", 0.0, 1.0),
    ("support.min", 0.0, NONE),
    ("support.mean", 0.0, NONE),
    ("grip.front", 0.0, NONE),
    ("grip.rear", 0.0, NONE),
    ("grip.road", 0.0, NONE),
    ("response.delay", 0.0, NONE),
    ("response.lag", 0.0, NONE),
    ("response.found", 0.0, 1.0),
    ("status.recovering", 0.0, 1.0),
    ("filter.active", 0.0, 1.0),
];

impl Slots {
    pub(crate) fn new(t: &mut VariableTable) -> Self {
        let vehicle = VEHICLE
            .map(|(name, unit, text)| t.real(&format!("vehicle.{name}"), Role::Input, unit, text));
        let applied = [
            t.real(
                "applied.a",
                Role::Input,
                unit::M_PER_S2,
                "Acceleration that acted (with param.use_applied)",
            ),
            t.real(
                "applied.delta",
                Role::Input,
                unit::RAD,
                "Steering that acted (with param.use_applied)",
            ),
        ];
        let mut switch =
            |name: &str, text: &str| t.add_boolean(Variable::boolean(name, Role::Fixed, text));
        let global_pose = switch("param.global_pose", "Read x, y, psi instead of e_psi, s, e_y");
        let use_applied =
            switch("param.use_applied", "The car reports the input that acts, in applied.*");
        let mut text = |name: &str, start: &str, text: &str| {
            t.add_text(Variable::text(name, Role::Fixed, start, text))
        };
        let track =
            text("param.track", TRACK, "Track: a name that ships (l, road_course) or a file");
        let car = text("param.car", CAR, "Nominal car: a name that ships or a file");
        let preset = text(
            "param.preset",
            "race",
            "Preset of all settings: race, with what ships for a named car, or paper",
        );
        let config = text("param.config", "", "Configuration file (TOML); empty: the preset");
        let load = text("param.learned_load", "", "File with learned data to start from");
        let save = text("param.learned_save", "", "File for learned data, written after each lap");
        let nominal_mu = t.add_real(
            Variable::real(
                "param.nominal_mu",
                Role::Fixed,
                unit::ONE,
                "Grip the controller believes in on both axles; 0: the car's own",
            )
            .range(0.0, 10.0),
        );
        let regression_mode = t.add_integer(
            Variable::integer(
                "param.regression.mode",
                Role::Fixed,
                "0 as the preset, 1 error regression, 2 full dynamics, 3 nominal model only",
            )
            .range(0.0, 3.0),
        );
        let settings = Settings::new(t);
        let mut held =
            |name: &str, unit: Unit, text: &str| t.real(name, Role::Discrete, unit, text);
        let one = unit::ONE;
        let command = [
            held("cmd.a", unit::M_PER_S2, "Commanded acceleration"),
            held("cmd.delta", unit::RAD, "Commanded steering, positive left"),
        ];
        let status = [
            held(
                "status.action",
                one,
                "0 initial lap, 1 learned, 2 shifted plan, 3 tracking, 4 braking, 5 recovering",
            ),
            held(
                "status.reason",
                one,
                "0 none, 1 solver failed, 2 not finite, 3 time stands, 4 time gap, 5 jump, 6 off track, 7 wrong way, 8 standstill, 9 no safe set, 10 spin, 11 askew",
            ),
            held(
                "status.solve",
                one,
                "0 not run, 1 solved, 2 almost, 3 iteration limit, 4 infeasible, 5 numerical",
            ),
            held("status.iterations", one, "Iterations of the solver"),
            held(
                "status.solve_ms",
                unit::MS,
                "Wall time of the step; the only output that differs between equal runs",
            ),
            held("status.clipped", one, "1 if the command was cut to the car's limits"),
            held("status.steps", one, "Controller steps so far"),
            held(
                "status.solver",
                one,
                "0 none in this step, 1 structured, 2 Clarabel (it took over, unless chosen)",
            ),
        ];
        let laps = [
            held("lap.number", one, "Lap in progress, from 1; 0 before the line is first crossed"),
            held("lap.finished", one, "Laps finished"),
            held("lap.last_time", unit::S, "Last lap time; 0 before the first"),
            held("lap.best_time", unit::S, "Best valid lap time; 0 before the first"),
            held(
                "lap.last_valid",
                one,
                "1 if the last lap was inside the track with complete data",
            ),
        ];
        let frenet = std::array::from_fn(|i| {
            let (name, unit, _) = VEHICLE[i];
            held(&format!("frenet.{name}"), unit, "State the step used, in the track's frame")
        });
        let slack = [
            held("status.cost", one, "Optimal cost, in steps"),
            held("slack.lane", unit::M, "Largest lane slack along the plan"),
            held("slack.front_slip", unit::RAD, "Largest front slip slack along the plan"),
            held("slack.rear_slip", unit::RAD, "Largest rear slip slack along the plan"),
            held("slack.speed", unit::M_PER_S, "Largest speed-cap slack along the plan"),
            held("slack.terminal", one, "Cost of the terminal slack, in steps"),
        ];
        let learned = [
            held(
                "support.min",
                one,
                "Kernel weights at the worst supported point; 0: nominal model only",
            ),
            held("support.mean", one, "Mean kernel weights over the horizon"),
            held("grip.front", one, "Fitted factor on the front friction"),
            held("grip.rear", one, "Fitted factor on the rear friction"),
        ];
        let plan = [("v_x", unit::M_PER_S), ("e_psi", unit::RAD), ("s", unit::M), ("e_y", unit::M)]
            .map(|(name, unit)| {
                let point =
                    |k| held(&format!("plan.{name}[{k}]"), unit, "Planned state, k periods ahead");
                (1..=PLAN).map(point).collect()
            });
        // New outputs come last: value references are places in the table.
        let road_grip = held(
            "grip.road",
            one,
            "Share of the fitted grip that the road has now, below 1 after a fall; in grip.front and grip.rear already",
        );
        let response = [
            held("response.delay", unit::S, "Pure delay from a command to its effect"),
            held("response.lag", unit::S, "Time constant of the actuators"),
            held(
                "response.found",
                one,
                "1 if delay and lag were estimated in the initial laps, 0 as configured",
            ),
            held(
                "response.delay_change",
                unit::S,
                "Commands act later than response.delay by this, in whole periods; below 0 sooner, 0 while none is clear",
            ),
        ];
        let recovering = held(
            "status.recovering",
            one,
            "1 on the way back to the line after an incident; status.reason names it",
        );
        let filtered = held(
            "filter.active",
            one,
            "1 if the filter estimates the state, 0 while the measurement passes as it is",
        );
        let mut sigma = |group: &str, text: &str| {
            std::array::from_fn(|i| {
                let (name, unit, _) = VEHICLE[i];
                held(&format!("filter.{group}.{name}"), unit, text)
            })
        };
        let state_sigma = sigma(
            "state",
            "Standard deviation of the estimated state; 0 while the measurement passes as it is",
        );
        let noise_sigma = sigma(
            "noise",
            "Standard deviation of the measurement's noise, given or estimated; 0 while it passes as it is",
        );
        t.bound(&BOUNDS);
        Self {
            vehicle,
            applied,
            global_pose,
            use_applied,
            track,
            car,
            nominal_mu,
            preset,
            config,
            load,
            save,
            regression_mode,
            settings,
            command,
            status,
            laps,
            frenet,
            slack,
            learned,
            plan,
            road_grip,
            response,
            recovering,
            filtered,
            state_sigma,
            noise_sigma,
        }
    }
}
