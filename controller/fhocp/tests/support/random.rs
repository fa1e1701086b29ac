//! Random FHOCPs: feasible by construction, every combination of parts.

use fhocp::{Affine, Fhocp, SlipRow};
use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};
use rand::SeedableRng;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;

/// Source of numbers in [-1, 1].
pub struct Random(Pcg64Mcg, Uniform<f64>);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed), Uniform::new(-1.0, 1.0).unwrap())
    }

    pub fn next(&mut self) -> f64 {
        self.1.sample(&mut self.0)
    }

    /// In [0, 1].
    pub fn share(&mut self) -> f64 {
        0.5 * (self.next() + 1.0)
    }
}

/// A random problem; bits 0..7 of `parts` switch on the rate limits of a and delta, the front and
/// rear guard, the speed cap, the actuators' lag and the heading in the lane.
pub fn random(seed: u64, horizon: usize, hull: usize, parts: u32) -> Fhocp {
    let r = &mut Random::new(seed);
    let mut problem = Fhocp::new(horizon, hull);
    let on = |bit: u32, value: f64| if parts >> bit & 1 == 1 { value } else { f64::INFINITY };
    problem.x_0 = Vector6::from_fn(|_, _| r.next());
    problem.x_0[4] = 100.0 * r.next();
    problem.u_prev = Vector2::new(r.next(), 0.3 * r.next());
    for model in &mut problem.model {
        *model = Affine {
            a: Matrix6::identity() * 0.97 + Matrix6::from_fn(|_, _| 0.08 * r.next()),
            b: Matrix6x2::from_fn(|_, _| 0.3 * r.next()),
            c: Vector6::from_fn(|_, _| 0.05 * r.next()),
        };
        // Nothing depends on where along the track the car is.
        model.a.set_column(4, &Vector6::ith(4, 1.0));
    }
    problem.lag = if parts >> 5 & 1 == 1 { 0.8 * r.share() } else { 0.0 };
    problem.input_cost = Vector2::new(0.01 + 0.1 * r.share(), 0.01 + 0.1 * r.share());
    problem.rate_cost = Vector2::new(r.share(), 10.0 * r.share());
    problem.u_max = Vector2::new(1.0 + r.share(), 0.3 + 0.2 * r.share());
    problem.u_min = -problem.u_max;
    problem.du_max = Vector2::new(on(0, 0.3 + r.share()), on(1, 0.1 + 0.2 * r.share()));
    for t in 0..horizon {
        problem.e_y_max[t] = 0.3 + 0.5 * r.share();
        problem.e_y_min[t] = -0.3 - 0.5 * r.share();
        problem.lane_heading[t] = if parts >> 6 & 1 == 1 { r.next() } else { 0.0 };
        problem.front[t] = slip(r, 1.0);
        problem.rear[t] = slip(r, 0.0);
        problem.rear_share[t] = 0.5 + 0.5 * r.share();
        problem.front_share[t] = 1.5 - problem.rear_share[t];
    }
    problem.lane_linear = 20.0 * r.share();
    problem.lane_quadratic = 1.0 + 100.0 * r.share();
    problem.front_max = on(2, 0.05 + 0.2 * r.share());
    problem.rear_max = on(3, 0.05 + 0.2 * r.share());
    problem.slip_linear = 10.0 + 200.0 * r.share();
    let speed = on(4, r.share());
    problem.speed_max.iter_mut().for_each(|max| *max = speed + 0.2 * r.share());
    problem.speed_linear = 1.0 + 20.0 * r.share();
    for j in 0..hull {
        problem.hull[j] = Vector6::from_fn(|_, _| r.next());
        problem.hull[j][4] += problem.x_0[4];
        problem.hull_cost[j] = 10.0 * r.share();
    }
    problem.terminal_slack_weight = Vector6::from_fn(|_, _| 1.0 + 40.0 * r.share());
    // Within reach of the rate limits, so that the second stage can leave it.
    let most = (0.2 * problem.u_max).inf(&(0.5 * problem.du_max));
    problem.reserve = [0; 2].map(|_| most.map(|most| most * r.share()));
    problem
}

fn slip(r: &mut Random, steering: f64) -> SlipRow {
    SlipRow {
        velocity: [0.05 * r.next(), -0.5 * r.share(), -0.1 * r.share()],
        steering,
        offset: 0.05 * r.next(),
        weight: 20.0 * r.share(),
        reference: 0.05 * r.next(),
    }
}
