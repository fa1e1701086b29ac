//! Preparation of the FHOCP (4) along the shifted plan z_bar, and its solution from a measured state.
//!
//! ```text
//! A_t, B_t, C_t   (6) + nominal, at z_bar_t          `linearize`, `regress`
//! X, J            (3), at the end of the plan        safe set, `aim`
//! r = c_du (w_a, w_delta) / dt^2                     `weigh`: c_du counts rates per second
//! lane, slip, speed bounds of each stage             `linearize`, `bound_speed`
//! u_t = u*_0                                         `solve`
//! ```

use nalgebra::{Vector2, Vector6};
use vehicle_model::{CarParams, Discretized, Input, Outline, State, Track};

use crate::config::Config;
use crate::controller::Setup;
use crate::fhocp::{Affine, Fhocp, FhocpSolver, Slacks, Solution, SolveReport, Solver};
use crate::lane;
use crate::learned_model;
use crate::learning::regression::Scratch;
use crate::learning::safe_set::{Query, SafeSet};
use crate::learning::speed_limit::SpeedLimit;
use crate::memory::Memory;
use crate::slip::{self, Dissipation};
use crate::status::{Phase, Probe};

/// Share of the brakes with which a plan slows down to a speed cap.
const CAP_BRAKE: f64 = 0.5;

/// Share of the brakes with which a plan slows down where the road is slippery.
const ROAD_BRAKE: f64 = 0.5;

/// Share of the horizon in which the reserve of the slip guards grows to its full size.
const RESERVED: f64 = 1.0 / 3.0;

/// Cost of a solution, in steps.
pub(crate) struct Cost {
    /// All of it.
    pub(crate) total: f64,
    /// Interpolated cost-to-go, J' lambda.
    pub(crate) to_go: f64,
    /// e' E e.
    pub(crate) terminal_slack: f64,
}

/// Problem, solver and memory that is reused from step to step.
pub(crate) struct Workspace {
    problem: Fhocp,
    solution: Solution,
    /// Where the problem's s counts from [m].
    origin: f64,
    /// States and acting inputs the model is linearised at.
    points: Vec<(State, Input)>,
    /// The nominal model where the car was measured last, and where that was: the filter needs it at the
    /// next measurement, and here it takes a lane that is left over.
    measured: Option<(State, Input, Affine)>,
    /// The body, if it counts.
    outline: Option<Outline>,
    /// Speed cap; infinite for none [m/s].
    speed_cap: f64,
    /// Limits of track and car.
    limit: SpeedLimit,
    /// On the heap: a controller is moved while it is made, and a host's stack may be small.
    pub(crate) solver: Box<Solver>,
    pub(crate) slacks: Slacks,
    progress: f64,
    pub(crate) safe_set: SafeSet,
    pub(crate) supports: Vec<f64>,
    pub(crate) scratch: Scratch,
    /// The nominal model, for hypotheses on the grip.
    pub(crate) probe: Discretized,
}

/// Change of a far rear slip angle from plan to plan that is still small, as a share of its guard.
const SMALL: f64 = 0.2;

impl Workspace {
    pub(crate) fn new(
        config: &Config,
        car: &CarParams,
        track: &Track,
        model: &Discretized,
    ) -> Self {
        let (n, hull) = (config.horizon.steps, config.safe_set.neighbors * config.safe_set.laps);
        let mut problem = Fhocp::new(n, hull);
        let (cost, dt) = (&config.cost, config.horizon.period);
        problem.input_cost = Vector2::new(cost.input_acceleration, cost.input);
        problem.u_min = Vector2::new(car.a_min, -car.delta_max);
        problem.u_max = Vector2::new(car.a_max, car.delta_max);
        problem.du_max = Vector2::new(rate(car.a_rate_max, dt), rate(car.delta_rate_max, dt));
        // The second stage must be able to leave the reserve, wherever the actuators stand.
        let limits = &config.limits;
        let spared = |share: f64, most: f64, i: usize| (share * most).min(0.5 * problem.du_max[i]);
        let brakes = spared(limits.brake_reserve, -car.a_min, 0);
        let steering = spared(limits.steering_reserve, car.delta_max, 1);
        problem.reserve = [Vector2::new(brakes, steering), Vector2::new(0.0, steering)];
        problem.lane_linear = cost.lane_linear;
        problem.lane_quadratic = cost.lane_quadratic;
        problem.front_max = bound(config.limits.front_slip);
        problem.rear_max = bound(config.limits.rear_slip);
        problem.slip_linear = cost.slip;
        problem.speed_linear = cost.speed;
        problem.terminal_slack_weight = Vector6::from(cost.terminal_slack);
        Self {
            problem,
            solution: Solution::new(n, hull),
            origin: 0.0,
            outline: config.limits.body.then(|| Outline::new(car)),
            speed_cap: bound(config.limits.speed_cap),
            limit: SpeedLimit::new(car, track, config.envelope.brake_share),
            points: Vec::with_capacity(n + 1),
            measured: None,
            solver: Box::new(config.solver.solver()),
            slacks: Slacks::default(),
            progress: 1.0,
            safe_set: SafeSet::default(),
            supports: Vec::with_capacity(n),
            scratch: Scratch::new(&config.regression, n),
            probe: model.clone(),
        }
    }

    /// How far the end of the plan moved on in the last step, as a share of what the driven laps moved on there.
    pub(crate) fn progress(&self) -> f64 {
        self.progress
    }

    pub(crate) fn problem(&self) -> &Fhocp {
        &self.problem
    }

    /// Actuators of another response.
    pub(crate) fn set_lag(&mut self, carried: f64) {
        if self.problem.lag != carried {
            self.problem.lag = carried;
            self.solver.forget();
        }
    }

    pub(crate) fn set_speed_cap(&mut self, config: &Config) {
        self.speed_cap = bound(config.limits.speed_cap);
        self.solver.forget();
    }

    /// Speed cap; infinite for none \[m/s\].
    pub(crate) fn speed_cap(&self) -> f64 {
        self.speed_cap
    }

    /// The car crosses the line: s counts on from it.
    pub(crate) fn cross_line(&mut self, length: f64) {
        self.safe_set.cross_line(length);
        self.origin -= length;
    }

    /// Everything that does not need the measurement: model, safe set, lane and guards.
    pub(crate) fn prepare(&mut self, setup: &Setup, memory: &Memory, probe: &mut impl Probe) {
        probe.begin(Phase::Linearize);
        self.linearize(setup, memory);
        probe.end(Phase::Linearize);
        probe.begin(Phase::Regress);
        self.regress(setup, memory);
        probe.end(Phase::Regress);
        probe.begin(Phase::SafeSet);
        let query = Query {
            s: memory.query_s,
            length: setup.track.length(),
            period: setup.config.horizon.period,
            learned: memory.lap_end.learned,
        };
        let config = &setup.config.safe_set;
        self.safe_set.fill(&memory.dataset, &memory.selected, &query, config);
        let road = &memory.derived.road_speed;
        if self.speed_cap.is_finite() || road.bounds() {
            let slowest = match self.speed_cap.is_finite() {
                true => self.problem.speed_max.last().copied().unwrap_or(f64::INFINITY),
                false => f64::INFINITY,
            };
            self.safe_set.slow_down(|s| slowest.min(road.at(s)), setup.car.l_r);
        }
        probe.end(Phase::SafeSet);
        self.weigh(&setup.config, memory);
        probe.begin(Phase::Solve);
        if !self.safe_set.points.is_empty() {
            self.aim(memory);
            self.solver.prepare(&self.problem);
        }
        probe.end(Phase::Solve);
    }

    fn linearize(&mut self, setup: &Setup, memory: &Memory) {
        self.points.clear();
        let period = setup.config.horizon.period;
        let ahead = memory.prediction_error.covariance(memory.plan.x[0].v_x, period);
        let covariance = memory.estimate.covariance().unwrap_or(ahead);
        let sigmas = setup.config.limits.uncertainty;
        let aside = lane::unsure(setup, &covariance) + lane::untried(setup, memory.learned_laps);
        for (t, (x, u)) in memory.plan.x.iter().zip(&memory.plan.u).enumerate() {
            self.points.push((*x, setup.actuators.mean(before(memory, t), *u)));
            self.problem.front[t] = slip::front(&setup.car, x, u);
            let stages = setup.config.horizon.steps - t;
            let dissipation = Dissipation::new(setup, setup.model.model.grip, stages);
            let row = &mut self.problem.front[t];
            row.weight = dissipation.weight(x.v_x, 0, row.reference);
            // The lane and the rear guard bind the state at the stage's end.
            let next = &memory.plan.x[t + 1];
            self.problem.rear[t] = slip::rear(&setup.car, next);
            let row = &mut self.problem.rear[t];
            row.weight = dissipation.weight(next.v_x, 1, row.reference);
            // What is near may use all of it: a plan that runs wide is corrected at once.
            let far = (t as f64 / (RESERVED * setup.config.horizon.steps as f64)).min(1.0);
            let share = 1.0 - setup.config.limits.slip_reserve * far;
            let rear_load = setup.config.limits.rear_load;
            let load = if rear_load { slip::rear_share(&setup.car, next.v_x, u.a) } else { 1.0 };
            let problem = &mut self.problem;
            let room = sigmas * slip::deviation(&covariance, &problem.front[t]);
            problem.front_share[t] = slip::left(share, room, problem.front_max);
            // Room for the noise itself made cars slower that were off the track as often.
            let room = sigmas * slip::deviation(&ahead, &problem.rear[t]);
            problem.rear_share[t] = slip::left(share * load, room, problem.rear_max);
            lane::bounds(setup, self.outline.as_ref(), next, aside).bound(&mut self.problem, t);
        }
        self.bound_speed(setup, memory);
        let models = &mut self.problem.model;
        let last = memory.last.filter(|_| setup.filter.is_some());
        let acting = memory.dataset.current.samples.last();
        self.measured =
            last.zip(acting).map(|(last, acting)| (last.state, acting.u, Affine::default()));
        self.points.extend(self.measured.map(|(x, u, _)| (x, u)));
        let mode = setup.config.regression.mode;
        let (points, measured) = (&self.points, &mut self.measured);
        // The next plan ends where the safe set is asked for.
        let stages = memory.plan.u.len();
        let end = memory.plan.x.last().map_or(0.0, |end| (memory.query_s - end.s).abs());
        let far = |t: usize| if t < stages { end * t as f64 / stages as f64 } else { 0.0 };
        learned_model::nominal_all(
            &setup.model,
            mode,
            &setup.track,
            points,
            far,
            |i, found| match (models.get_mut(i), measured.as_mut()) {
                (Some(stage), _) => *stage = found,
                (None, Some((_, _, model))) => *model = found,
                (None, None) => {}
            },
        );
        self.points.truncate(memory.plan.u.len());
    }

    /// The nominal model at a state and input, if it is the one that was prepared.
    pub(crate) fn prepared_model(&self, x: &State, u: &Input) -> Option<Affine> {
        self.measured.filter(|(at, acting, _)| at == x && acting == u).map(|(_, _, model)| model)
    }

    /// Greatest speed of each stage's end: envelope, limits and cap. A cap below the present speed is
    /// approached with a part of the brakes, so that the plan stays on the line.
    fn bound_speed(&mut self, setup: &Setup, memory: &Memory) {
        let slower = CAP_BRAKE * setup.car.a_min.abs() * setup.config.horizon.period;
        let mut approach = memory.plan.x.first().map_or(0.0, |x| x.v_x);
        let harder = ROAD_BRAKE * setup.car.a_min.abs() * setup.config.horizon.period;
        let mut slippery = approach;
        for (most, next) in self.problem.speed_max.iter_mut().zip(memory.plan.x.iter().skip(1)) {
            approach -= slower;
            slippery -= harder;
            let road = memory.derived.road_speed.at(next.s).max(slippery);
            let limit = self.limit.at(next.s).min(self.speed_cap.max(approach)).min(road);
            *most = memory.supported_speed(next.s, setup.track.length()).min(limit);
        }
    }

    fn regress(&mut self, setup: &Setup, memory: &Memory) {
        let (data, config) = (&memory.derived.regression, &setup.regression);
        self.supports.clear();
        for (t, (x, acting)) in self.points.iter().enumerate() {
            let (error, support) =
                learned_model::error(data, config, t, (x, acting), &mut self.scratch);
            let model = &mut self.problem.model[t];
            *model = *model + error;
            // The problem knows the mean of positions alone.
            let ramp = setup.actuators.on_the_way(before(memory, t), memory.plan.u[t]);
            model.c += model.b * ramp.to_vector();
            self.supports.push(support);
        }
    }

    /// Rate weights per step difference, from those per second.
    fn weigh(&mut self, config: &Config, memory: &Memory) {
        let cost = &config.cost;
        let gentle = cost.gentle_start * 0.35_f64.powi(memory.learned_laps.min(1000) as i32);
        let acceleration = cost.control_rate * cost.acceleration_rate.max(gentle);
        let steering = (cost.control_rate * cost.steering_rate).max(cost.steering_rate_floor);
        let dt = config.horizon.period;
        self.problem.rate_cost = Vector2::new(acceleration, steering) / (dt * dt);
    }

    /// Hull, costs and the models' frame. s counts from where the plan expects the car: the numbers stay small
    /// whatever the length of the track.
    fn aim(&mut self, memory: &Memory) {
        self.origin = memory.plan.x[0].s;
        for model in &mut self.problem.model {
            let mut by_s = model.a.column(4).into_owned();
            by_s[4] -= 1.0;
            model.c += by_s * self.origin;
        }
        for (ours, point) in self.problem.hull.iter_mut().zip(&self.safe_set.points) {
            *ours = *point;
            ours[4] -= self.origin;
        }
        self.problem.hull_cost.copy_from_slice(&self.safe_set.cost_to_go);
    }

    /// Solves from `x_0`; on success the plan in `memory` is the new solution.
    pub(crate) fn solve(&mut self, x_0: &State, memory: &mut Memory) -> SolveReport {
        self.problem.x_0 = x_0.to_vector();
        self.problem.x_0[4] -= self.origin;
        self.problem.u_prev = memory.u_prev.to_vector();
        let mut report = self.solver.solve(&self.problem, &mut self.solution);
        if report.status.usable() && !self.solution.is_finite() {
            report.status = crate::fhocp::SolveStatus::Numerical;
        }
        if report.status.usable() {
            self.slacks.fill(&self.problem, &self.solution);
            self.store(memory);
        }
        report
    }

    fn store(&mut self, memory: &mut Memory) {
        let (step, far) = (self.step_length(), self.far());
        let plan = &mut memory.plan;
        for (t, (ours, x)) in plan.x.iter_mut().zip(&self.solution.x).enumerate() {
            let mut x = *x;
            x[4] += self.origin;
            if t > far {
                x = ours.to_vector().lerp(&x, step);
            }
            *ours = State::from_vector(&x);
        }
        for (t, (ours, u)) in plan.u.iter_mut().zip(&self.solution.u).enumerate() {
            let u = if t > far { ours.to_vector().lerp(u, step) } else { *u };
            *ours = Input::from_vector(&u);
        }
        memory.plan_age = 0;
        let query_s = self.safe_set.successor(&self.solution.lambda);
        self.progress = (query_s - memory.query_s) / self.safe_set.advance();
        memory.query_s = query_s;
        memory.plan_tail = Input::from_vector(&self.safe_set.input(&self.solution.lambda));
    }

    /// Stages up to this one follow each solution whole: what is near follows the measurement.
    pub(crate) fn far(&self) -> usize {
        self.problem.horizon() / 4
    }

    /// Share of the way from the plan to its next solution that the far stages go: half of it where a rear
    /// slip angle there moves by more than a part of its guard. A far bend that the linearised tyres show
    /// as possible and impossible in turn would otherwise make every second plan another one.
    fn step_length(&self) -> f64 {
        let moved = (self.far()..self.problem.horizon()).map(|t| {
            let (row, next) = (&self.problem.rear[t], &self.solution.x[t + 1]);
            (row.angle(next, 0.0) - row.reference).abs()
        });
        if moved.fold(0.0, f64::max) > SMALL * self.problem.rear_max { 0.5 } else { 1.0 }
    }

    /// Cost of the last solution and two of its parts.
    pub(crate) fn cost(&self) -> Cost {
        Cost {
            total: self.problem.cost_with(&self.solution, &self.slacks),
            to_go: self.problem.cost_to_go(&self.solution),
            terminal_slack: self.problem.terminal_slack_cost(&self.solution),
        }
    }

    /// Weights lambda of the safe-set points in the last solution.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.solution.lambda
    }
}

/// The planned input before stage `t`.
fn before(memory: &Memory, t: usize) -> Input {
    if t == 0 { memory.u_prev } else { memory.plan.u[t - 1] }
}

/// A limit from the configuration, where 0 switches it off.
fn bound(limit: f64) -> f64 {
    if limit > 0.0 { limit } else { f64::INFINITY }
}

/// Greatest change in one period.
fn rate(limit: Option<f64>, dt: f64) -> f64 {
    limit.map_or(f64::INFINITY, |limit| limit * dt)
}
