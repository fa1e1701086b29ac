//! The models against numbers of an independent implementation.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use serde::Deserialize;
use vehicle_model::{
    CarParams, Discretized, Input, Model, ModelKind, NU, NX, PoseConvention, Segment, State, Track,
};

const EXACT: f64 = 1e-10;
const JACOBIAN: f64 = 1e-6;

#[derive(Deserialize)]
struct Pairs {
    dt: f64,
    rk4_substeps: usize,
    rows: Vec<Row>,
}

#[derive(Deserialize)]
#[allow(non_snake_case, reason = "keys of the reference file")]
struct Row {
    x: [f64; NX],
    u: [f64; NU],
    kappa: f64,
    dxdt_dyn_mu09: [f64; NX],
    dxdt_dyn_mu12: [f64; NX],
    dxdt_dyn_awd_mu09: [f64; NX],
    next_dyn_mu09: [f64; NX],
    next_dyn_mu12: [f64; NX],
    next_dyn_awd_mu09: [f64; NX],
    next_dyn_mu09_1substep_h0p01: [f64; NX],
    A_dyn_mu09: [[f64; NX]; NX],
    B_dyn_mu09: [[f64; NU]; NX],
    next_kin_alg: [f64; NX],
    next_kin_zoh: [f64; NX],
    next_kin_lin: [f64; NX],
    next_dyn_mu09_exact: Option<[f64; NX]>,
}

impl Row {
    fn state(&self) -> State {
        State::from_vector(&self.x.into())
    }

    fn input(&self) -> Input {
        Input { a: self.u[0], delta: self.u[1] }
    }
}

/// The track the rows lie on, as the reference stores it.
#[derive(Deserialize)]
struct TrackFile {
    segments_len: Vec<f64>,
    segments_kappa: Vec<f64>,
    width: f64,
}

fn read<T: serde::de::DeserializeOwned>(name: &str) -> T {
    let folder = std::env::var_os("LMPC_REFERENCE_DIR").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/data/reference"),
        PathBuf::from,
    );
    serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

fn pairs() -> Pairs {
    let pairs: Pairs = read("dynamics_pairs.json");
    assert!(!pairs.rows.is_empty());
    pairs
}

fn reference_track() -> Track {
    let file: TrackFile = read("l_track.json");
    let segments: Vec<Segment> = std::iter::zip(file.segments_len, file.segments_kappa)
        .map(|(length, kappa)| Segment { kappa, ..Segment::straight(length) })
        .collect();
    Track::from_segments("reference", &segments, 0.5 * file.width, 0.5 * file.width).unwrap()
}

/// The paper's car, its blend off.
fn car(mu: f64) -> CarParams {
    CarParams::builtin("barc").unwrap().with_mu(mu).without_blend()
}

/// Half of a on the steered front axle, without its yaw moment.
fn all_wheel_drive(mu: f64) -> CarParams {
    CarParams { drive_front: 0.5, brake_front: 0.5, front_force_yaw: false, ..car(mu) }
}

fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        let error = (a - b).abs() / b.abs().max(1.0);
        assert!(error <= tolerance, "{what}[{i}]: found {a}, expected {b}, error {error:e}");
    }
}

fn dynamic(car: CarParams) -> Model {
    Model::new(ModelKind::Dynamic, car)
}

#[test]
fn reference_derivatives() {
    for row in pairs().rows {
        let rates = |params| dynamic(params).derivative(&row.state(), &row.input(), row.kappa);
        close(&rates(car(0.9)), &row.dxdt_dyn_mu09, EXACT, "mu 0.9");
        close(&rates(car(1.2)), &row.dxdt_dyn_mu12, EXACT, "mu 1.2");
        close(&rates(all_wheel_drive(0.9)), &row.dxdt_dyn_awd_mu09, EXACT, "awd");
    }
}

#[test]
fn reference_next_states_of_the_dynamic_model() {
    let pairs = pairs();
    let track = reference_track();
    let next = |row: &Row, params, dt, substeps| {
        let step = Discretized { model: dynamic(params), dt, substeps };
        let mut x = step.next(&row.state(), &row.input(), |s| track.kappa(s));
        x.s = track.wrap(x.s);
        <[f64; NX]>::from(x.to_vector())
    };
    for row in &pairs.rows {
        let wrapped = |expected: &[f64; NX]| {
            let mut expected = *expected;
            expected[4] = track.wrap(expected[4]);
            expected
        };
        let (dt, n) = (pairs.dt, pairs.rk4_substeps);
        let check = |found: [f64; NX], expected: &[f64; NX], tolerance, what: &str| {
            close(&found, &wrapped(expected), tolerance, what);
        };
        check(next(row, car(0.9), dt, n), &row.next_dyn_mu09, EXACT, "mu 0.9");
        check(next(row, car(1.2), dt, n), &row.next_dyn_mu12, EXACT, "mu 1.2");
        check(next(row, all_wheel_drive(0.9), dt, n), &row.next_dyn_awd_mu09, EXACT, "awd");
        check(next(row, car(0.9), 0.01, 1), &row.next_dyn_mu09_1substep_h0p01, EXACT, "one");
        // A hundred times finer: the value the scheme converges to, where it is not stiff.
        if let Some(exact) = row.next_dyn_mu09_exact.filter(|_| row.x[0] > 1.0) {
            check(next(row, car(0.9), dt, 100 * n), &exact, 1e-9, "exact");
        }
    }
}

#[test]
fn reference_jacobians() {
    let pairs = pairs();
    let track = reference_track();
    let step = Discretized { model: dynamic(car(0.9)), dt: pairs.dt, substeps: pairs.rk4_substeps };
    for row in &pairs.rows {
        let found = step.linearize(&row.state(), &row.input(), |s| track.kappa(s));
        for i in 0..NX {
            let a: Vec<f64> = found.a.row(i).iter().copied().collect();
            let b: Vec<f64> = found.b.row(i).iter().copied().collect();
            close(&a, &row.A_dyn_mu09[i], JACOBIAN, "A");
            close(&b, &row.B_dyn_mu09[i], JACOBIAN, "B");
        }
    }
}

#[test]
fn reference_next_states_of_the_kinematic_model() {
    let pairs = pairs();
    let track = reference_track();
    for row in &pairs.rows {
        for (pose, expected) in [
            (PoseConvention::Algebraic, &row.next_kin_alg),
            (PoseConvention::Held, &row.next_kin_zoh),
            (PoseConvention::Interpolated, &row.next_kin_lin),
        ] {
            let model = Model { pose, ..Model::new(ModelKind::Kinematic, car(0.9)) };
            let step = Discretized { model, dt: pairs.dt, substeps: pairs.rk4_substeps };
            let next = step.next(&row.state(), &row.input(), |s| track.kappa(s));
            close(next.to_vector().as_slice(), expected, EXACT, "kinematic");
        }
    }
}
