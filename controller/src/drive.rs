//! What a step decides: initial lap (data D^0 of the paper), learned control, or what is left when that fails.
//!
//! ```text
//! D^0:      a = a_track(x) + n_a,   delta = delta_track(x) + n_delta      n normal: excitation for the regression
//! learned:  u = u*_0 of the FHOCP (4), its steering through the inverse tyre (nominal.inverse_tyre)
//! else:     u of the shifted plan z_bar, then a_track and delta_track, then braking along the centre line
//! ```

use vehicle_model::normal::standard_normal;
use vehicle_model::{Input, Limiter, State};

use crate::controller::{Controller, Setup};
use crate::derive::Scales;
use crate::fhocp::{Fhocp, greatest};
use crate::learned_model::LearnedModel;
use crate::observe::Observation;
use crate::slip;
use crate::status::{Action, Phase, Probe, Reason, Status};

/// Speed below which a car stands, in speeds sqrt(mu g l).
const STANDING_SHARE: f64 = 0.17;

/// Share of the driven speed below which a car is far slower than before.
const FAR_SLOWER: f64 = 0.5;

/// Share of the drive with which such a car is taken to speed up again.
const RUN_UP: f64 = 0.7;

/// Share of the way of the driven laps in one period below which the end of a plan stays where it is.
const STILL: f64 = 0.25;

impl Controller {
    /// Drives from a believed state.
    pub(crate) fn drive(
        &mut self,
        seen: &Observation,
        status: &mut Status,
        probe: &mut impl Probe,
    ) -> Input {
        status.state = seen.state;
        status.finished = seen.finished;
        status.reason = seen.reason;
        if seen.crossed {
            let length = self.setup.track.length();
            self.memory.plan.cross_line(length);
            self.memory.query_s -= length;
            self.work.cross_line(length);
        }
        if self.setup.config.recovery.active
            && let Some(input) = self.recovered(&seen.state, status)
        {
            return input;
        }
        if !self.memory.learning || !self.memory.learned {
            return self.warm_up(&seen.state, status);
        }
        if let Some(reason) = self.unfit(&seen.state) {
            self.memory.drop_plan();
            status.reason = reason;
            return self.recover(&seen.state, status);
        }
        self.learned(&seen.state, status, probe)
    }

    /// An initial lap: centre-line tracking with excitation.
    fn warm_up(&mut self, x: &State, status: &mut Status) -> Input {
        if let Some(reason) = self.unfit(x).filter(|reason| *reason != Reason::Standstill) {
            status.reason = reason;
            return self.recover(x, status);
        }
        status.action = Action::WarmUp;
        let config = &self.setup.config.warm_up;
        let mut noise = || -> f64 { standard_normal(&mut self.memory.rng) };
        let (noise_a, noise_delta) = (config.noise_a * noise(), config.noise_delta * noise());
        let Input { a, delta } = self.setup.tracker.track(x, &self.setup.track, config.speed);
        Input { a: a + noise_a, delta: delta + noise_delta }
    }

    /// Why the learned controller cannot drive from here, if so.
    pub(crate) fn unfit(&self, x: &State) -> Option<Reason> {
        let (left, right) = (self.setup.track.width_left(x.s), self.setup.track.width_right(x.s));
        let outside = (x.e_y - left).max(-right - x.e_y);
        if x.e_psi.abs() > std::f64::consts::FRAC_PI_2 {
            return Some(Reason::WrongWay);
        }
        // Just outside, the soft lane of the FHOCP knows the way back best.
        if outside > 0.25 * (left + right) {
            return Some(Reason::OffTrack);
        }
        (x.v_x < self.standing()).then_some(Reason::Standstill)
    }

    /// Speed below which a car stands \[m/s\]: far below that of any bend it can take at all.
    pub(crate) fn standing(&self) -> f64 {
        let least = STANDING_SHARE * Scales::new(&self.setup.car).speed;
        least.min(0.25 * self.setup.config.warm_up.speed).min(0.5 * self.work.speed_cap())
    }

    /// Speed at which the car is driven by tracking \[m/s\].
    pub(crate) fn tracking_speed(&self) -> f64 {
        self.setup.config.warm_up.speed.min(self.work.speed_cap())
    }

    /// Tracking back to the track, or braking where that is hopeless.
    fn recover(&mut self, x: &State, status: &mut Status) -> Input {
        let far = x.e_y.abs()
            > 2.0 * (self.setup.track.width_left(x.s) + self.setup.track.width_right(x.s));
        if far || status.reason == Reason::WrongWay {
            status.action = Action::Braking;
            return self.setup.tracker.brake(x, &self.setup.track);
        }
        status.action = Action::Tracking;
        self.setup.tracker.track(x, &self.setup.track, self.tracking_speed())
    }

    /// The FHOCP's first input; if there is none, the shifted plan, then tracking, then braking.
    fn learned(&mut self, x: &State, status: &mut Status, probe: &mut impl Probe) -> Input {
        let (x_0, next) = self.predict(x);
        if self.memory.plan.is_empty() {
            self.first_plan(&x_0);
            self.work.prepare(&self.setup, &self.memory, probe);
        }
        if self.work.safe_set.points.is_empty() {
            status.reason = Reason::NoSafeSet;
            return self.recover(x, status);
        }
        probe.begin(Phase::Solve);
        let mut report = self.work.solve(&x_0, &mut self.memory);
        if self.memory.road.fresh > 0 && report.status.usable() {
            // The plan that the problem was linearised along was made for another road.
            self.work.prepare(&self.setup, &self.memory, &mut ());
            report = self.work.solve(&x_0, &mut self.memory);
        }
        if !report.status.usable() || self.work.diverged() {
            report = self.replan(&x_0).unwrap_or(report);
        }
        probe.end(Phase::Solve);
        status.solve = report.status;
        status.solver = Some(report.backend);
        status.iterations = report.iterations;
        let supports = &self.work.supports;
        status.data_support_min = supports.iter().copied().fold(f64::INFINITY, f64::min);
        status.data_support_mean = supports.iter().sum::<f64>() / supports.len() as f64;
        if !report.status.usable() {
            status.reason = Reason::SolverFailed;
            return self.fall_back(x, status);
        }
        let cost = self.work.cost();
        let slacks = &self.work.slacks;
        status.action = Action::Learned;
        status.cost = cost.total;
        status.cost_to_go = cost.to_go;
        status.terminal_slack_cost = cost.terminal_slack;
        status.lane_slack = greatest(&slacks.lane);
        status.front_slip_slack = greatest(&slacks.front);
        status.rear_slip_slack = greatest(&slacks.rear);
        status.speed_slack = greatest(&slacks.speed);
        self.steer(&x_0);
        let input = self.memory.plan.u[0];
        self.memory.prediction_error.expect(&next.unwrap_or(self.memory.plan.x[1]));
        if self.waits(x) {
            // Planned anew from the car's own speed, the end lies where the car can get.
            self.memory.drop_plan();
        }
        input
    }

    /// Turns the first steering angle of the plan into that of the force, where the tyres move the car.
    fn steer(&mut self, x_0: &State) {
        let Setup { config, car, model, .. } = &self.setup;
        if !config.nominal.inverse_tyre || x_0.v_x < car.blend_speed_high {
            return;
        }
        let Fhocp { front, front_max, .. } = self.work.problem();
        let (tyre, first) = (&model.model.params.tyre_front, &mut self.memory.plan.u[0]);
        let planned = (&x_0.to_vector(), first.delta);
        first.delta = slip::steering(tyre, &front[0], planned, *front_max);
    }

    /// Whether a car far slower than it has been here has a plan whose end does not move on.
    ///
    /// A terminal state that the car cannot reach in the time of the horizon, but could later, makes it wait:
    /// a step lost costs no more at the horizon's end than now. The plan's end then stays in one place, and
    /// the car stops short of it.
    fn waits(&self, x: &State) -> bool {
        x.v_x < FAR_SLOWER * self.former_speed(x.s) && self.work.progress() < STILL
    }

    /// No solution: the shifted plan while it is young, then tracking, then braking.
    fn fall_back(&mut self, x: &State, status: &mut Status) -> Input {
        self.memory.plan_age += 1;
        let (age, n) = (self.memory.plan_age as usize, self.setup.config.horizon.steps);
        if age <= n / 2 {
            status.action = Action::ShiftedPlan;
            self.memory.query_s = self.memory.plan.x[n].s;
            return self.memory.plan.u[0];
        }
        // A new plan from here may succeed where the old one led nowhere.
        self.memory.plan.clear();
        if age <= 3 * n {
            status.action = Action::Tracking;
            return self.setup.tracker.track(x, &self.setup.track, self.tracking_speed());
        }
        status.action = Action::Braking;
        self.setup.tracker.brake(x, &self.setup.track)
    }

    /// No believable measurement: the plan knows best where the car is.
    pub(crate) fn hold_on(&mut self, reason: Reason, status: &mut Status) -> Input {
        status.reason = reason;
        if reason == Reason::TimeNotAdvancing {
            status.action = if self.memory.learning { Action::ShiftedPlan } else { Action::WarmUp };
            status.state = self.memory.last.map(|last| last.state).unwrap_or_default();
            return self.memory.command;
        }
        self.memory.dataset.interrupt();
        self.memory.plan_age += 1;
        let n = self.setup.config.horizon.steps;
        if !self.memory.plan.is_empty() && (self.memory.plan_age as usize) < n {
            status.action = Action::ShiftedPlan;
            status.state = self.memory.plan.x[0];
            self.memory.query_s = self.memory.plan.x[n].s;
            return self.memory.plan.u[0];
        }
        // Dead reckoning on the last good state, braking along the line.
        let Some(last) = &mut self.memory.last else {
            status.action = Action::Braking;
            return Input::default();
        };
        status.action = Action::Braking;
        status.state = last.state;
        self.setup.tracker.brake(&last.state, &self.setup.track)
    }

    /// The input inside the car's limits, box and rates.
    pub(crate) fn limited(&self, wanted: Input, status: &mut Status) -> Input {
        let dt = self.setup.config.horizon.period;
        let limiter = Limiter::new(&self.setup.car);
        let limited = limiter.limit(wanted, self.memory.u_prev, status.state.v_x, dt);
        status.clipped = limited.bits != 0;
        limited.sent
    }

    /// Turns the wanted input into a command; what it makes act is queued, and what leaves the
    /// queue acts in the coming period.
    pub(crate) fn commit(&mut self, wanted: Input) -> Input {
        let memory = &mut self.memory;
        let (command, reached) = self.setup.actuators.lead(memory.u_prev, wanted);
        let mean = self.setup.actuators.mean(memory.u_prev, reached);
        if self.setup.config.delay.estimates() && !memory.learned {
            let current = &memory.dataset.current.samples;
            let sample = current.len().checked_sub(1).filter(|i| current[*i].next.is_none());
            memory.actuation.commanded(command, sample.map(|i| (memory.dataset.laps.len(), i)));
        }
        memory.queue.push_back(mean);
        let acting = memory.queue.pop_front().unwrap_or(mean);
        if let Some(sample) = memory.dataset.current.samples.last_mut().filter(|s| s.next.is_none())
        {
            sample.u = acting;
        }
        memory.u_prev = reached;
        memory.command = command;
        memory.shifted = false;
        memory.learned_piece = false;
        self.prepared = false;
        command
    }

    /// The state at which the coming command will act, through the queued inputs, and that after the
    /// first of them.
    fn predict(&mut self, x: &State) -> (State, Option<State>) {
        let (mut x, mut next) = (*x, None);
        for u in &self.memory.queue {
            let data = &self.memory.derived.regression;
            let model = LearnedModel::at(&self.setup, data, &x, u, &mut self.work.scratch);
            x = State::from_vector(&model.sum().apply(&x.to_vector(), &u.to_vector()));
            next.get_or_insert(x);
        }
        (x, next)
    }

    /// A trajectory to linearise about where no plan exists: tracking at the present speed or, as bends
    /// allow, that of the driven laps.
    fn first_plan(&mut self, x_0: &State) {
        let reach = self.reach(x_0);
        let slowest = x_0.v_x.max(self.setup.config.warm_up.speed);
        let mut x = *x_0;
        let mut plan = std::mem::take(&mut self.memory.plan);
        plan.clear();
        plan.x.push(x);
        for _ in 0..self.setup.config.horizon.steps {
            let speed = slowest.max(self.former_speed(x.s));
            let u = self.setup.tracker.track(&x, &self.setup.track, speed);
            x = self.setup.model.next(&x, &u, self.setup.track.road());
            plan.u.push(u);
            plan.x.push(x);
            self.memory.plan_tail = u;
        }
        self.memory.plan = plan;
        self.memory.query_s = x.s.max(reach);
        self.memory.shifted = true;
    }

    /// Greatest speed of the driven laps at s, below the speed cap; 0 where it is not known \[m/s\].
    fn former_speed(&self, s: f64) -> f64 {
        let driven = self.memory.derived.envelope.driven_at(s);
        if driven.is_finite() { driven.min(self.work.speed_cap()) } else { 0.0 }
    }

    /// Where a car that is far slower than it was here gets within the horizon if it drives on to its former
    /// speed \[m\]; else its own place. An end of the plan that is nearer asks for a run-up, and the car
    /// would brake for it.
    fn reach(&self, x_0: &State) -> f64 {
        let (mut s, mut v) = (x_0.s, x_0.v_x);
        if v >= FAR_SLOWER * self.former_speed(s) {
            return s;
        }
        let horizon = &self.setup.config.horizon;
        let gained = RUN_UP * self.setup.car.a_max * horizon.period;
        for _ in 0..horizon.steps {
            v = (v + gained).min(self.former_speed(s));
            s += v * horizon.period;
        }
        s
    }
}
