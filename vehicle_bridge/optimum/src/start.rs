//! Where a solution starts: a line between the edges and speeds that a point mass could drive.

use vehicle_model::params::GRAVITY;
use vehicle_model::{CarParams, RoadPoint};

use crate::interval::{Interval, Node};

/// Rounds of the speed profile, so that its end fits its beginning.
const ROUNDS: usize = 3;

/// Half the length over which the curvature is averaged, in widths of the lane.
const REACH: f64 = 3.0;

/// A line that goes to the inside of bends by the share `inside` of the room between the edges
/// [right, left].
pub(crate) fn line(intervals: &[Interval], edges: &[[f64; 2]], inside: f64) -> Vec<f64> {
    let n = intervals.len();
    let length: f64 = intervals.iter().map(|i| i.length).sum();
    let width = edges.iter().map(|e| e[1] - e[0]).sum::<f64>() / n as f64;
    let count = ((REACH * width / length * n as f64).ceil() as usize).clamp(1, n / 2);
    let average = |values: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|k| {
                let near = (0..=2 * count).map(|i| values[(k + n + i - count) % n]);
                near.sum::<f64>() / (2 * count + 1) as f64
            })
            .collect()
    };
    let bends = average(&intervals.iter().map(|i| i.road[1].kappa).collect::<Vec<f64>>());
    let sharp = bends.iter().fold(f64::MIN_POSITIVE, |most, kappa| kappa.abs().max(most));
    let wanted: Vec<f64> = (0..n)
        .map(|k| {
            let part = inside * (2.0 * bends[k] / sharp).clamp(-1.0, 1.0);
            0.0_f64.clamp(edges[k][0], edges[k][1]) + 0.5 * part * (edges[k][1] - edges[k][0])
        })
        .collect();
    let smooth = average(&wanted);
    (0..n).map(|k| smooth[k].clamp(edges[k][0], edges[k][1])).collect()
}

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
        let scale = 1.0 - intervals[k].road[1].kappa * f64::midpoint(e_y[k], e_y[after(k)]);
        heading[k] = slope.atan2(scale);
        length[k] = intervals[k].length * slope.hypot(scale);
    }
    for k in 0..n {
        let turn = heading[k] - heading[before(k)];
        let road = 0.5
            * (intervals[k].length * intervals[k].road[0].kappa
                + intervals[before(k)].length * intervals[before(k)].road[2].kappa);
        kappa[k] = (turn + road) / f64::midpoint(length[k], length[before(k)]);
    }
    let roads: Vec<RoadPoint> = intervals.iter().map(|i| i.road[0]).collect();
    let speed = speeds(car, &kappa, &roads, &length, share, stops);
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
    roads: &[RoadPoint],
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
        .zip(roads)
        .map(|(kappa, road)| {
            // v^2 kappa = share mu (g + down v^2)
            let left = kappa.abs() - share * mu * down;
            let flat =
                if left > 1e-9 { (share * mu * GRAVITY / left).sqrt() } else { f64::INFINITY };
            let corner = match road.surface {
                None => flat,
                Some(_) => road.corner_speed(*kappa, share * mu, down),
            };
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
