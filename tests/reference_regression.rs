//! The regression against weighted ridge problems solved by an independent implementation.

use controller::config::Features;
use controller::learning::regression::{Weighted, epanechnikov, ridge};
use lmpc_tests::read_reference;
use serde::Deserialize;

#[derive(Deserialize)]
struct File {
    rows: Vec<Row>,
}

#[derive(Deserialize)]
#[allow(non_snake_case)]
struct Row {
    h: f64,
    eps: f64,
    Q: [f64; 5],
    zbar: [f64; 5],
    neighbours_z: Vec<[f64; 5]>,
    targets: Vec<[f64; 3]>,
    u_dist: Vec<f64>,
    weights: Vec<f64>,
    Gamma_vx: [f64; 5],
    Gamma_vy: [f64; 5],
    Gamma_wz: [f64; 5],
}

#[test]
fn reference_regression() {
    let file: File = read_reference("regression.json");
    assert!(!file.rows.is_empty());
    for (k, row) in file.rows.iter().enumerate() {
        let mut samples = Vec::new();
        for (i, (z, y)) in row.neighbours_z.iter().zip(&row.targets).enumerate() {
            let u: f64 = (0..5).map(|j| row.Q[j] * (z[j] - row.zbar[j]).powi(2)).sum();
            assert!((u - row.u_dist[i]).abs() <= 1e-10 * u.max(1.0), "row {k}: distance {i}");
            let weight = epanechnikov(u, row.h);
            assert!((weight - row.weights[i]).abs() <= 1e-10, "row {k}: weight {i}");
            samples.push(Weighted { z: *z, y: *y, weight });
        }
        let gamma = ridge(&samples, row.eps, Features::Own).0;
        for (ours, theirs, input) in
            [(gamma[0], row.Gamma_vx, 3), (gamma[1], row.Gamma_vy, 4), (gamma[2], row.Gamma_wz, 4)]
        {
            let columns = [0, 1, 2, input, 5];
            for (column, expected) in columns.into_iter().zip(theirs) {
                let error = (ours[column] - expected).abs() / expected.abs().max(1.0);
                assert!(error < 1e-8, "row {k}: {ours:?} != {theirs:?}");
            }
        }
    }
}
