//! Where a solution starts: a line between the edges and speeds that a point mass could drive.

use vehicle_model::CarParams;
use vehicle_model::params::GRAVITY;

use crate::interval::{Interval, Node};

/// Rounds of the speed profile, so that its end fits its beginning.
const ROUNDS: usize = 3;

/// Nodes of a drive along `e_y` that uses this share of grip, engine and brakes.
pub(crate) fn drive(
    car: &CarParams,
    intervals: &[Interval],
    e_y: &[f64],
    share: f64,
    stops: &[[f64; 2]; 2],
) -> Vec<Node> {
    let n = intervals.len();
    let after = |k: usize| (k + 1) % n;
    let before = |k: usize| (k + n - 1) % n;
    // Length, heading and curvature of the line.
    let mut heading = vec![0.0; n];
    let mut kappa = vec![0.0; n];
    let mut length = vec![0.0; n];
    for k in 0..n {
        let slope = (e_y[after(k)] - e_y[k]) / intervals[k].length;
        let scale = 1.0 - intervals[k].kappa[1] * f64::midpoint(e_y[k], e_y[after(k)]);
        heading[k] = slope.atan2(scale);
        length[k] = intervals[k].length * slope.hypot(scale);
    }
    for k in 0..n {
        let turn = heading[k] - heading[before(k)];
        let road = 0.5
            * (intervals[k].length * intervals[k].kappa[0]
                + intervals[before(k)].length * intervals[before(k)].kappa[2]);
        kappa[k] = (turn + road) / f64::midpoint(length[k], length[before(k)]);
    }
    let speed = speeds(car, &kappa, &length, share, stops);
    let stiffness = |tyre: &vehicle_model::Tyre| tyre.b * tyre.c * tyre.mu * GRAVITY;
    (0..n)
        .map(|k| {
            let (v, bend) = (speed[k], kappa[k]);
            let rear = v * v * bend / stiffness(&car.tyre_rear);
            let front = v * v * bend / stiffness(&car.tyre_front);
            let v_y = v * (car.l_r * bend - rear);
            let along = f64::midpoint(heading[k], heading[before(k)]);
            let a = (speed[after(k)].powi(2) - v * v) / (2.0 * length[k]);
            let delta = car.wheelbase() * bend + front - rear;
            Node::from([v, v_y, v * bend, along - v_y / v, e_y[k], a, delta])
        })
        .collect()
}

/// Speeds of a point mass on a line of this curvature.
fn speeds(
    car: &CarParams,
    kappa: &[f64],
    length: &[f64],
    share: f64,
    stops: &[[f64; 2]; 2],
) -> Vec<f64> {
    let n = kappa.len();
    let mu = car.tyre_front.mu.min(car.tyre_rear.mu);
    let down = 0.5 * car.rho * car.area * (car.cl_front + car.cl_rear) / car.mass;
    let drag = 0.5 * car.rho * car.area * car.cd / car.mass;
    let [least, most] = stops[0];
    let fastest = if drag > 0.0 { (most / drag).sqrt() } else { f64::INFINITY };
    let mut v: Vec<f64> = kappa
        .iter()
        .map(|kappa| {
            // v^2 kappa = share mu (g + down v^2)
            let left = kappa.abs() - share * mu * down;
            let corner =
                if left > 1e-9 { (share * mu * GRAVITY / left).sqrt() } else { f64::INFINITY };
            corner.min(0.95 * fastest).min((2.0 * most * 1000.0 * length[0] * 1e3).sqrt())
        })
        .collect();
    for _ in 0..ROUNDS {
        for k in 0..n {
            let next = (k + 1) % n;
            let gain = share * most - drag * v[k] * v[k];
            v[next] = v[next].min((v[k] * v[k] + 2.0 * gain.max(0.0) * length[k]).sqrt());
        }
        for k in (0..n).rev() {
            let next = (k + 1) % n;
            let loss = share * least.abs();
            v[k] = v[k].min((v[next] * v[next] + 2.0 * loss * length[k]).sqrt());
        }
    }
    v
}
