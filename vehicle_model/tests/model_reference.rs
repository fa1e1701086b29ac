//! The models against numbers of an independent implementation.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use serde::Deserialize;
use vehicle_model::{
    CarParams, Discretized, Input, Model, ModelKind, NU, NX, PoseConvention, Secant, Segment,
    State, Track, Tyre, params::GRAVITY,
};

const EXACT: f64 = 1e-10;
const JACOBIAN: f64 = 1e-6;
/// Numbers below this are compared absolutely: a relative error of what ought to be 0 says nothing.
const SMALL: f64 = 1e-3;

#[derive(Deserialize)]
struct Pairs {
    params: Vehicle,
    dt: f64,
    rk4_substeps: usize,
    rows: Vec<Row>,
}

#[derive(Deserialize)]
#[allow(non_snake_case, reason = "keys of the reference file")]
struct Vehicle {
    m: f64,
    Iz: f64,
    lf: f64,
    lr: f64,
    g: f64,
    pacejka_B: f64,
    pacejka_C: f64,
}

impl Vehicle {
    /// The reference's car, its blend off.
    fn car(&self, mu: f64) -> CarParams {
        assert_eq!(self.g, GRAVITY);
        let tyre = Tyre { b: self.pacejka_B, c: self.pacejka_C, mu, secant: Secant::default() };
        CarParams {
            mass: self.m,
            inertia_z: self.Iz,
            l_f: self.lf,
            l_r: self.lr,
            tyre_front: tyre,
            tyre_rear: tyre,
            ..CarParams::builtin("barc").unwrap().without_blend()
        }
    }

    /// Half of a on the steered front axle, without its yaw moment.
    fn all_wheel_drive(&self, mu: f64) -> CarParams {
        CarParams { drive_front: 0.5, brake_front: 0.5, front_force_yaw: false, ..self.car(mu) }
    }
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
    // A relative folder counts from the workspace, wherever the test is started.
    let named = std::env::var_os("LMPC_REFERENCE_DIR");
    let named = named.map_or_else(|| PathBuf::from("tests/data/reference"), PathBuf::from);
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(named);
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

fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        let error = (a - b).abs() / b.abs().max(SMALL);
        assert!(error <= tolerance, "{what}[{i}]: found {a}, expected {b}, error {error:e}");
    }
}

fn dynamic(car: CarParams) -> Model {
    Model::new(ModelKind::Dynamic, car)
}

#[test]
fn reference_derivatives() {
    let pairs = pairs();
    for row in &pairs.rows {
        let rates = |car| dynamic(car).derivative(&row.state(), &row.input(), row.kappa);
        close(&rates(pairs.params.car(0.9)), &row.dxdt_dyn_mu09, EXACT, "mu 0.9");
        close(&rates(pairs.params.car(1.2)), &row.dxdt_dyn_mu12, EXACT, "mu 1.2");
        close(&rates(pairs.params.all_wheel_drive(0.9)), &row.dxdt_dyn_awd_mu09, EXACT, "awd");
    }
}

#[test]
fn reference_next_states_of_the_dynamic_model() {
    let pairs = pairs();
    let track = reference_track();
    let next = |row: &Row, car, dt, substeps| {
        let step = Discretized { model: dynamic(car), dt, substeps };
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
        check(next(row, pairs.params.car(0.9), dt, n), &row.next_dyn_mu09, EXACT, "mu 0.9");
        check(next(row, pairs.params.car(1.2), dt, n), &row.next_dyn_mu12, EXACT, "mu 1.2");
        check(
            next(row, pairs.params.all_wheel_drive(0.9), dt, n),
            &row.next_dyn_awd_mu09,
            EXACT,
            "awd",
        );
        check(
            next(row, pairs.params.car(0.9), 0.01, 1),
            &row.next_dyn_mu09_1substep_h0p01,
            EXACT,
            "one",
        );
        // A hundred times finer: the value the scheme converges to, where it is not stiff.
        if let Some(exact) = row.next_dyn_mu09_exact.filter(|_| row.x[0] > 1.0) {
            check(next(row, pairs.params.car(0.9), dt, 100 * n), &exact, 1e-8, "exact");
        }
    }
}

#[test]
fn reference_jacobians() {
    let pairs = pairs();
    let track = reference_track();
    let step = Discretized {
        model: dynamic(pairs.params.car(0.9)),
        dt: pairs.dt,
        substeps: pairs.rk4_substeps,
    };
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
            let model = Model { pose, ..Model::new(ModelKind::Kinematic, pairs.params.car(0.9)) };
            let step = Discretized { model, dt: pairs.dt, substeps: pairs.rk4_substeps };
            let next = step.next(&row.state(), &row.input(), |s| track.kappa(s));
            let found = State { s: track.wrap(next.s), ..next }.to_vector();
            let mut expected = *expected;
            expected[4] = track.wrap(expected[4]);
            close(found.as_slice(), &expected, EXACT, "kinematic");
        }
    }
}
