//! The vehicle's variables.

use std::f64::consts::{FRAC_PI_2, PI};

use vehicle_model::CarParams;

use super::car::CarSlots;
use crate::files::{CAR, TRACK};
use crate::table::{Integer, Real, Text, VariableTable};
use crate::unit;
use crate::variable::{Role, Variable};

/// Where everything is in the table.
#[derive(Debug)]
pub(crate) struct Slots {
    /// Inputs a, delta.
    pub(crate) command: [Real; 2],
    pub(crate) track: Text,
    pub(crate) car_name: Text,
    pub(crate) car: CarSlots,
    pub(crate) substep: Real,
    pub(crate) seed: Integer,
    /// Initial v_x, v_y, omega_z, e_psi, s, e_y.
    pub(crate) initial: [Real; 6],
    /// Sensor noise of the six states.
    pub(crate) noise: [Real; 6],
    /// Process noise of v_x, v_y, omega_z.
    pub(crate) process: [Real; 3],
    /// Forces forward and left, then along X and Y.
    pub(crate) force: [Real; 4],
    /// Grip factors front and rear.
    pub(crate) grip: [Real; 2],
    /// Measured state, then measured x, y, psi.
    pub(crate) measured: [Real; 9],
    /// True state, then true x, y, psi.
    pub(crate) truth: [Real; 9],
    /// Acting a, delta.
    pub(crate) applied: [Real; 2],
    /// Longitudinal and lateral force, load, slip, utilisation; front and rear of each.
    pub(crate) tyres: [[Real; 2]; 5],
    /// Lap, progress, curvature.
    pub(crate) way: [Real; 3],
}

/// Forward speed at the start: about that of a 1/10-scale car's initial laps [m/s].
const START_SPEED: f64 = 1.2;

/// Name, unit and meaning of the six states and the global pose.
const STATE: [(&str, unit::Unit, &str); 9] = [
    ("v_x", unit::M_PER_S, "longitudinal velocity, body frame"),
    ("v_y", unit::M_PER_S, "lateral velocity, body frame, positive left"),
    ("omega_z", unit::RAD_PER_S, "yaw rate, positive left"),
    ("e_psi", unit::RAD, "heading relative to the centre line, positive left"),
    ("s", unit::M, "arc length along the centre line, wrapped into the lap"),
    ("e_y", unit::M, "lateral deviation from the centre line, positive left"),
    ("x", unit::M, "global position, x"),
    ("y", unit::M, "global position, y"),
    ("psi", unit::RAD, "global heading, positive left from x"),
];

const NONE: f64 = f64::INFINITY;

/// What bounds the variables that have bounds whatever car and track are.
const BOUNDS: [(&str, f64, f64); 15] = [
    ("noise.v_x", 0.0, NONE),
    ("noise.v_y", 0.0, NONE),
    ("noise.omega_z", 0.0, NONE),
    ("noise.e_psi", 0.0, NONE),
    ("noise.s", 0.0, NONE),
    ("noise.e_y", 0.0, NONE),
    ("process_noise.v_x", 0.0, NONE),
    ("process_noise.v_y", 0.0, NONE),
    ("process_noise.omega_z", 0.0, NONE),
    ("vehicle.e_psi", -PI, PI),
    ("truth.e_psi", -PI, PI),
    ("vehicle.s", 0.0, NONE),
    ("truth.s", 0.0, NONE),
    ("tyre.front.utilisation", 0.0, NONE),
    ("tyre.rear.utilisation", 0.0, NONE),
];

impl Slots {
    pub(crate) fn new(t: &mut VariableTable) -> Self {
        // The shipped car always reads; were it broken, all would be 0 and refused at the start.
        let car = CarParams::builtin(CAR).ok();
        // A description serves every car, so no car's limits bound the inputs in it.
        let command = [
            t.real(
                "cmd.a",
                Role::Input,
                unit::M_PER_S2,
                "Commanded acceleration, cut to car.a_min and car.a_max",
            ),
            t.add_real(
                Variable::real(
                    "cmd.delta",
                    Role::Input,
                    unit::RAD,
                    "Commanded steering, left positive, cut to car.delta_max on each side",
                )
                .range(-FRAC_PI_2, FRAC_PI_2),
            ),
        ];
        let track = t.add_text(Variable::text(
            "param.track",
            Role::Fixed,
            TRACK,
            "Track: a name that ships (l, road_course) or a file (TOML or CSV)",
        ));
        let car_name = t.add_text(Variable::text(
            "param.car",
            Role::Fixed,
            "",
            "Car: a name that ships (barc, iac, kart, mini, f1tenth, formula_student, road) or a file; empty: barc; car.* override it",
        ));
        let substep = t.add_real(
            Variable::real("param.substep", Role::Fixed, unit::S, "Longest integration step")
                .start(0.01)
                .at_least(1e-6),
        );
        let seed = t.add_integer(
            Variable::integer("param.seed", Role::Fixed, "Seed of all noise")
                .range(0.0, 2147483647.0),
        );
        let mut state = |prefix: &str, role: Role, what: &str, n: usize| {
            let rows = STATE[..n].iter().map(|(name, unit, text)| {
                let (path, text) = (format!("{prefix}.{name}"), format!("{what}: {text}"));
                let variable = Variable::real(&path, role, *unit, &text);
                let moving = path == "initial.v_x";
                t.add_real(variable.start(if moving { START_SPEED } else { 0.0 }))
            });
            rows.collect::<Vec<Real>>()
        };
        let initial = six(&state("initial", Role::Fixed, "At the start", 6));
        let noise = six(&state("noise", Role::Fixed, "Standard deviation of the sensor noise", 6));
        let process = {
            let rows = state("process_noise", Role::Fixed, "Process noise per 0.1 s, std", 3);
            [rows[0], rows[1], rows[2]]
        };
        let measured = nine(&state("vehicle", Role::Output, "Measured", 9));
        let truth = nine(&state("truth", Role::Output, "True", 9));
        let start = car;
        let mut car = CarSlots::new(t, start.as_ref());
        let push = |t: &mut VariableTable, name: &str, text: &str| {
            t.real(name, Role::Fixed, unit::N, text)
        };
        let force = [
            push(t, "force.forward", "Constant force on the car, forward"),
            push(t, "force.left", "Constant force on the car, to the left"),
            push(t, "force.x", "Constant force along global x, a wind"),
            push(t, "force.y", "Constant force along global y, a wind"),
        ];
        let mut grip = |name: &str, text: &str| {
            let variable = Variable::real(name, Role::Tunable, unit::ONE, text);
            t.add_real(variable.start(1.0).at_least(0.0))
        };
        let grip = [
            grip("grip.front", "Factor on the front friction, may change while stepping"),
            grip("grip.rear", "Factor on the rear friction, may change while stepping"),
        ];
        let applied = [
            t.real(
                "applied.a",
                Role::Output,
                unit::M_PER_S2,
                "Acceleration that acts, after lag and delay",
            ),
            t.real(
                "applied.delta",
                Role::Output,
                unit::RAD,
                "Steering that acts, after lag and delay",
            ),
        ];
        let mut axles = |name: &str, unit: unit::Unit, text: &str| {
            ["front", "rear"].map(|axle| {
                let text = format!("{text}, {axle} axle");
                t.real(&format!("tyre.{axle}.{name}"), Role::Output, unit, &text)
            })
        };
        let tyres = [
            axles("force_x", unit::N, "Force along the wheel"),
            axles("force_y", unit::N, "Force across the wheel, positive left"),
            axles("load", unit::N, "Vertical load"),
            axles("slip", unit::RAD, "Slip angle, positive when the force points left"),
            axles("utilisation", unit::ONE, "Share of the peak force in use"),
        ];
        let way = [
            t.real(
                "vehicle.lap",
                Role::Discrete,
                unit::ONE,
                "Number of times the line was crossed",
            ),
            t.real(
                "vehicle.progress",
                Role::Output,
                unit::M,
                "True way along the track since lap 0",
            ),
            t.real(
                "vehicle.kappa",
                Role::Output,
                unit::RAD_PER_M,
                "Curvature of the centre line here",
            ),
        ];
        car.add_later(t, start.as_ref());
        t.bound(&BOUNDS);
        Self {
            command,
            track,
            car_name,
            car,
            substep,
            seed,
            initial,
            noise,
            process,
            force,
            grip,
            measured,
            truth,
            applied,
            tyres,
            way,
        }
    }
}

fn six(slots: &[Real]) -> [Real; 6] {
    std::array::from_fn(|i| slots[i])
}

fn nine(slots: &[Real]) -> [Real; 9] {
    std::array::from_fn(|i| slots[i])
}
