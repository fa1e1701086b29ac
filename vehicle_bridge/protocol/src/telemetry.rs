//! Telemetry and track as messages.

use controller::{Action, Command, Controller, LapNumber, LapResult as Finished, SolveStatus};
use lcm_types::{Header, LapIndex, LapResult, MpcTelemetry, PredPoint, SeqNumber};
use vehicle_model::{CarParams, NX, State, Track};

use super::convert;
use hosting::rule::{Edges, TrackLimit};
use hosting::timing::{PHASES, StepTime};

/// Nearest samples of a track's message. \[m\]
const TRACK_STEP: f64 = 0.1;
/// Most samples of a track's message; it then fits into one datagram. \[-\]
const TRACK_SAMPLES: f64 = 1000.0;

/// The track, sampled evenly from `s = 0`; the first sample is not repeated at the end.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "a picture in single precision")]
#[expect(clippy::cast_sign_loss, reason = "lengths are positive")]
pub fn track_message(track: &Track) -> lcm_types::Track {
    let count = (track.length() / TRACK_STEP).ceil().clamp(1.0, TRACK_SAMPLES);
    let s: Vec<f64> = (0..count as usize).map(|i| i as f64 * track.length() / count).collect();
    let sampled = |f: &dyn Fn(f64) -> f64| s.iter().map(|&s| f(s) as f32).collect();
    lcm_types::Track {
        h: Header::default(),
        track_id: convert::track_id(track),
        name: track.name().to_owned(),
        length: track.length(),
        closed: true,
        n: count as i32,
        s: sampled(&|s| s),
        x: sampled(&|s| track.position(s).0),
        y: sampled(&|s| track.position(s).1),
        yaw: sampled(&|s| track.heading(s)),
        kappa: sampled(&|s| track.kappa(s)),
        w_left: sampled(&|s| track.width_left(s)),
        w_right: sampled(&|s| track.width_right(s)),
        crc: 0,
    }
}

/// What the host adds to a step's telemetry.
#[derive(Debug, Clone, Copy, Default)]
pub struct HostTelemetry {
    /// Number of the state that was answered. \[-\]
    pub state_seq: SeqNumber,
    /// Times of the step.
    pub time: StepTime,
    /// From the arrival of the state to the command. \[s\]
    pub total: f64,
    /// Steps that took longer than a period. \[-\]
    pub overruns: i32,
}

/// One step, before the controller prepares the next. Without a solution the weights of the safe-set
/// points are not a number.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "telemetry is in single precision")]
pub fn step_message(
    h: Header,
    controller: &Controller,
    command: &Command,
    step: &HostTelemetry,
) -> MpcTelemetry {
    let status = &command.status;
    let (plan, set) = (controller.plan(), controller.safe_set());
    let (period, response) = (controller.config().horizon.period, controller.response());
    let micros = |seconds: f64| (seconds * 1e6).min(f64::from(i32::MAX)) as i32;
    let solve = step.time.phases[PHASES.len() - 1];
    let slack =
        [status.lane_slack, status.front_slip_slack, status.rear_slip_slack, status.speed_slack];
    let solved = status.action == Action::Learned;
    let weight = |&lambda: &f64| if solved { lambda as f32 } else { f32::NAN };
    let at = |(i, x): (usize, &State)| pred_point(controller.track(), i as f64 * period, x);
    MpcTelemetry {
        h,
        state_seq: step.state_seq.get(),
        lap: lap_index(status.lap).get(),
        status: status_code(status.action, status.solve),
        action: status.action.code() as i8,
        reason: status.reason.code() as i8,
        iters: i32::try_from(status.iterations).unwrap_or(i32::MAX),
        sqp_steps: i32::from(status.solve != SolveStatus::NotRun),
        build_us: micros(step.time.phases[..PHASES.len() - 1].iter().sum()),
        solve_us: micros(solve),
        total_us: micros(step.total),
        deadline_us: micros(period),
        overruns: step.overruns,
        cost: status.cost,
        terminal_cost: status.cost_to_go,
        terminal_slack_cost: status.terminal_slack_cost,
        support_min: status.data_support_min as f32,
        support_mean: status.data_support_mean as f32,
        grip: controller.grip().map(|factor| factor as f32),
        road_grip: status.road_grip as f32,
        delay: response.delay as f32,
        lag: response.lag as f32,
        response_found: controller.response_found(),
        delay_change: status.delay_change as f32,
        filtered: controller.covariance().is_some(),
        state_sigma: controller.state_sigma().unwrap_or_default().map(|sigma| sigma as f32),
        noise_sigma: controller.noise_sigma().unwrap_or_default().map(|sigma| sigma as f32),
        n_slack: slack.len() as i16,
        slack: slack.iter().map(|&s| s as f32).collect(),
        n_pred: plan.x.len() as i16,
        pred: plan.x.iter().enumerate().map(at).collect(),
        n_u: plan.u.len() as i16,
        u: plan.u.iter().map(|u| [u.a as f32, u.delta as f32]).collect(),
        n_x: NX as i16,
        n_ss: set.points.len() as i16,
        ss: set.points.iter().map(|x| x.iter().map(|&v| v as f32).collect()).collect(),
        ss_cost: set.cost_to_go.iter().map(|&cost| cost as f32).collect(),
        ss_lambda: controller
            .safe_set_weights()
            .iter()
            .take(set.points.len())
            .map(weight)
            .collect(),
    }
}

/// The end of a lap.
#[must_use]
pub fn lap_message(h: Header, track_id: i64, lap: &Finished, seen: &LapSeen) -> LapResult {
    LapResult {
        h,
        track_id,
        lap: lap_index(lap.lap).get(),
        lap_time: lap.lap_time,
        best_time: if seen.best_time.is_finite() { seen.best_time } else { f64::NAN },
        valid: lap.valid,
        in_safe_set: lap.valid,
        min_margin: seen.min_margin,
        n_violations: seen.violations,
        n_fallback: seen.fallbacks,
        n_late: seen.late,
        max_slack: seen.max_slack,
        store_key: seen.store_key.clone(),
    }
}

/// What the host saw of a lap.
#[derive(Debug, Clone, PartialEq)]
pub struct LapSeen {
    edges: Edges,
    /// Shortest valid lap so far; infinite before the first. \[s\]
    pub best_time: f64,
    /// Smallest distance of the car's body to the edge of the track; negative is beyond it. \[m\]
    pub min_margin: f64,
    /// Steps in which a part of the body was off the track. \[-\]
    pub violations: i32,
    /// Steps that neither warmed up nor applied a solution. \[-\]
    pub fallbacks: i32,
    /// Steps that took longer than a period. \[-\]
    pub late: i32,
    /// Largest lane slack. \[m\]
    pub max_slack: f64,
    /// File the lap is saved in.
    pub store_key: String,
}

impl LapSeen {
    /// Nothing yet of this car's lap.
    #[must_use]
    pub fn new(car: &CarParams, store_key: String) -> Self {
        Self::begin(Edges::new(car, TrackLimit::Body), store_key)
    }

    fn begin(edges: Edges, store_key: String) -> Self {
        Self {
            edges,
            best_time: f64::INFINITY,
            min_margin: f64::INFINITY,
            violations: 0,
            fallbacks: 0,
            late: 0,
            max_slack: 0.0,
            store_key,
        }
    }

    /// Takes a step in.
    pub fn add(&mut self, track: &Track, command: &Command, late: bool) {
        let (x, status) = (&command.status.state, &command.status);
        let margin = -self.edges.beyond(track, x);
        self.min_margin = self.min_margin.min(margin);
        self.violations += i32::from(margin < 0.0);
        self.fallbacks += i32::from(!matches!(status.action, Action::Learned | Action::WarmUp));
        self.late += i32::from(late);
        self.max_slack = self.max_slack.max(status.lane_slack);
    }

    /// Begins the next lap after this one.
    pub fn close(&mut self, lap: &Finished) {
        let best = if lap.valid { lap.lap_time } else { f64::INFINITY };
        let best_time = self.best_time.min(best);
        let next = Self::begin(self.edges, std::mem::take(&mut self.store_key));
        *self = Self { best_time, ..next };
    }
}

/// Laps of the network are counted from 0, the controller's from 1.
fn lap_index(lap: LapNumber) -> LapIndex {
    LapIndex::new(i32::try_from(lap.get().saturating_sub(1)).unwrap_or(i32::MAX))
}

fn status_code(action: Action, solve: SolveStatus) -> i8 {
    match (action, solve) {
        (_, SolveStatus::MaxIterations) => MpcTelemetry::MAX_ITER,
        (_, SolveStatus::Infeasible) => MpcTelemetry::INFEASIBLE,
        (_, SolveStatus::Numerical) => MpcTelemetry::NUMERIC,
        (Action::Learned | Action::WarmUp, _) => MpcTelemetry::SOLVED,
        _ => MpcTelemetry::FALLBACK,
    }
}

#[expect(clippy::cast_possible_truncation, reason = "telemetry is in single precision")]
fn pred_point(track: &Track, t: f64, x: &State) -> PredPoint {
    let pose = track.to_global(&State { s: track.wrap(x.s), ..*x });
    PredPoint {
        t: t as f32,
        x: pose.x as f32,
        y: pose.y as f32,
        yaw: pose.psi as f32,
        vx: x.v_x as f32,
        vy: x.v_y as f32,
        yaw_rate: x.omega_z as f32,
        s: x.s as f32,
        e_y: x.e_y as f32,
        e_psi: x.e_psi as f32,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::sync::Arc;

    use controller::{Config, Measurement, Pose, Preset, Status};
    use vehicle_model::{Input, Plant, PlantParams};

    use super::*;

    #[test]
    fn the_margin_of_a_lap_is_that_of_the_body() {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let config = Config::derived(Preset::Race, &car, &track);
        let mut controller = Controller::new(config, car.clone(), Arc::clone(&track)).unwrap();
        let mut seen = LapSeen::new(&car, String::new());
        // On a straight, heading along it: the centre 20 mm less than half the width inside.
        let e_y = track.width_left(0.5) - 0.5 * car.width + 0.02;
        let state = State { v_x: 1.0, s: 0.5, e_y, ..State::default() };
        let pose = Pose::Frenet(State::default());
        let command = controller.step(&Measurement { time: 0.0, pose, applied: None });
        let status = Status { state, ..command.status };
        seen.add(&track, &Command { input: Input::default(), status }, false);
        assert_eq!(seen.violations, 1);
        assert!((seen.min_margin + 0.02).abs() < 1e-9, "{}", seen.min_margin);
    }

    #[test]
    fn the_terminal_cost_is_that_of_the_weights_and_points_sent_with_it() {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let mut config = Config::derived(Preset::Race, &car, &track);
        config.warm_up.laps = 2;
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let period = config.horizon.period;
        let mut plant =
            Plant::new(PlantParams::new(car.clone()), Arc::clone(&track), start).unwrap();
        let mut controller = Controller::new(config, car, track).unwrap();
        let mut learned = 0;
        for n in 0..450 {
            let pose = Pose::Frenet(plant.measure());
            let time = f64::from(n) * period;
            let command = controller.step(&Measurement { time, pose, applied: None });
            let step = HostTelemetry::default();
            let message = step_message(Header::default(), &controller, &command, &step);
            assert_eq!(message.slack.len(), 4);
            let warm_up = command.status.action == Action::WarmUp;
            assert_eq!(message.action == MpcTelemetry::WARM_UP, warm_up);
            assert_eq!(message.grip, controller.grip().map(|factor| factor as f32));
            assert_eq!((message.road_grip, message.filtered), (1.0, false));
            if command.status.action == Action::Learned {
                learned += 1;
                let total: f32 = message.ss_lambda.iter().sum();
                assert!((total - 1.0).abs() < 1e-4, "the weights' sum is {total}");
                let pairs = message.ss_cost.iter().zip(&message.ss_lambda);
                let terminal: f32 = pairs.map(|(cost, lambda)| cost * lambda).sum();
                let sent = message.terminal_cost;
                assert!((f64::from(terminal) - sent).abs() < 1e-3 * (1.0 + sent.abs()), "{sent}");
                assert!(message.terminal_slack_cost >= 0.0);
            } else {
                assert!(message.ss_lambda.iter().all(|lambda| lambda.is_nan()));
            }
            controller.prepare();
            plant.apply(command.input, period);
        }
        assert!(learned > 50, "{learned} steps");
    }
}
