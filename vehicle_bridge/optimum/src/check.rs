//! The solution driven by the simulated car.

use std::sync::Arc;

use vehicle_model::{CarParams, Input, ModelError, Plant, PlantParams, State, Track};

use crate::interval::{Interval, Node};

/// Steps of the plant in one interval; the last one is cut into as many again, so that little of
/// the last look-up of the curvature falls behind the interval's end.
const STEPS: u32 = 150;

/// Deviations of the plant from the end of each interval it drives from its beginning:
/// [v_x, v_y, omega_z, e_psi, s, e_y].
pub(crate) fn deviations(
    car: &CarParams,
    track: &Arc<Track>,
    intervals: &[Interval],
    nodes: &[Node],
    times: &[f64],
) -> Result<Vec<[f64; 6]>, ModelError> {
    // A delay shifts commands in time, which the lap does not see.
    let car = CarParams { actuator_delay: 0.0, ..car.clone() };
    let params = PlantParams { substep: f64::MAX, ..PlantParams::new(car.clone()) };
    let mut plant = Plant::new(params, Arc::clone(track), State::default())?;
    let n = nodes.len();
    Ok((0..n)
        .map(|k| {
            let (begin, end) = (&nodes[k], &nodes[(k + 1) % n]);
            let interval = &intervals[k];
            drive(&mut plant, &car, interval, [begin, end], times[k]);
            let reached = plant.unwrapped();
            let place = interval.s + interval.length;
            [
                reached.v_x - end[0],
                reached.v_y - end[1],
                reached.omega_z - end[2],
                reached.e_psi - end[3],
                reached.s - place,
                reached.e_y - end[4],
            ]
        })
        .collect())
}

/// Drives one interval with commands that keep the actuators where the solution has them.
fn drive(plant: &mut Plant, car: &CarParams, interval: &Interval, z: [&Node; 2], time: f64) {
    let [begin, end] = z;
    let initial = State {
        v_x: begin[0],
        v_y: begin[1],
        omega_z: begin[2],
        e_psi: begin[3],
        s: interval.s,
        e_y: begin[4],
    };
    plant.reset_at(initial, Input { a: begin[5], delta: begin[6] });
    let mut position = [begin[5], begin[6]];
    let rates = [car.a_rate_max, car.delta_rate_max];
    let step = time / f64::from(STEPS);
    let last = (0..STEPS).map(|_| step / f64::from(STEPS));
    for dt in (1..STEPS).map(|_| step).chain(last) {
        // Inputs are linear in s: the middle of the step, with the pace of its beginning.
        let now = plant.unwrapped();
        let road = &interval.road[1];
        let level = road.surface.map_or(1.0, |surface| surface.slope.cos());
        let ahead = (now.v_x * now.e_psi.cos() - now.v_y * now.e_psi.sin()) * level
            / (1.0 - road.kappa * now.e_y);
        let at = |time: f64| (now.s + ahead * time - interval.s) / interval.length;
        let mut command = [0.0; 2];
        for i in 0..2 {
            let wanted = |time: f64| begin[5 + i] + at(time) * (end[5 + i] - begin[5 + i]);
            if car.actuator_lag > 0.0 {
                let kept = (-dt / car.actuator_lag).exp();
                command[i] = (wanted(dt) - position[i] * kept) / (1.0 - kept);
                position[i] = wanted(dt);
            } else {
                let mean = wanted(0.5 * dt);
                command[i] = rates[i].map_or(mean, |rate| ramp(position[i], mean, rate * dt));
                position[i] = command[i];
            }
        }
        plant.apply(Input { a: command[0], delta: command[1] }, dt);
    }
}

/// Where an actuator that moves at most `most` in a step, at full rate first, must go for its mean
/// position to be `mean`.
fn ramp(from: f64, mean: f64, most: f64) -> f64 {
    let way = mean - from;
    let left = (1.0 - 2.0 * way.abs() / most).max(0.0);
    from + way.signum() * most * (1.0 - left.sqrt())
}
