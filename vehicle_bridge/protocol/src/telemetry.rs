//! What the controller tells of its work and of its track, as messages.

use controller::{Action, Command, Controller, LapResult as Finished, SolveStatus};
use lcm_types::{Header, LapResult, MpcTelemetry, PredPoint};
use vehicle_model::{NX, State, Track};

use super::convert;
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
pub struct Step {
    /// Number of the state that was answered. \[-\]
    pub state_seq: i64,
    /// Times of the step.
    pub time: StepTime,
    /// From the arrival of the state to the command. \[s\]
    pub total: f64,
    /// Steps that took longer than a period. \[-\]
    pub overruns: i32,
}

/// One step. The slacks are the largest along the plan: lane \[m\], front and rear slip \[rad\],
/// speed \[m/s\], and the cost of the terminal slack \[periods\]. What the controller does not
/// know (residuals, weights and laps of the safe set's points) is not a number, or -1.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "telemetry is in single precision")]
pub fn step_message(
    h: Header,
    controller: &Controller,
    command: &Command,
    step: &Step,
) -> MpcTelemetry {
    let status = &command.status;
    let (plan, set) = (controller.plan(), controller.safe_set());
    let period = controller.config().horizon.period;
    let micros = |seconds: f64| (seconds * 1e6).min(f64::from(i32::MAX)) as i32;
    let solve = step.time.phases[PHASES.len() - 1];
    let slack = [
        status.lane_slack,
        status.front_slip_slack,
        status.rear_slip_slack,
        status.speed_slack,
        status.terminal_slack,
    ];
    let at = |(i, x): (usize, &State)| pred_point(controller.track(), i as f64 * period, x);
    MpcTelemetry {
        h,
        state_seq: step.state_seq,
        lap: lap_number(status.lap),
        status: status_code(status.action, status.solve),
        iters: i32::try_from(status.iterations).unwrap_or(i32::MAX),
        sqp_steps: i32::from(status.solve != SolveStatus::NotRun),
        build_us: micros(step.time.phases[..PHASES.len() - 1].iter().sum()),
        solve_us: micros(solve),
        total_us: micros(step.total),
        deadline_us: micros(period),
        overruns: step.overruns,
        cost: status.cost,
        terminal_cost: f64::NAN,
        prim_res: f64::NAN,
        dual_res: f64::NAN,
        support_min: status.data_support_min as f32,
        support_mean: status.data_support_mean as f32,
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
        ss_lambda: vec![f32::NAN; set.points.len()],
        ss_lap: vec![-1; set.points.len()],
    }
}

/// The end of a lap.
#[must_use]
pub fn lap_message(h: Header, track_id: i64, lap: &Finished, seen: &LapSeen) -> LapResult {
    LapResult {
        h,
        track_id,
        lap: lap_number(lap.lap),
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
    /// Shortest valid lap so far; infinite before the first. \[s\]
    pub best_time: f64,
    /// Smallest distance of the centre of mass to the edge of the track. \[m\]
    pub min_margin: f64,
    /// Steps off the track. \[-\]
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
    /// Nothing yet.
    #[must_use]
    pub fn new(store_key: String) -> Self {
        Self {
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
        let margin = (track.width_left(x.s) - x.e_y).min(track.width_right(x.s) + x.e_y);
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
        *self = Self { best_time, ..Self::new(std::mem::take(&mut self.store_key)) };
    }
}

/// Laps of the network are counted from 0, the controller's from 1.
fn lap_number(lap: u32) -> i32 {
    i32::try_from(lap.saturating_sub(1)).unwrap_or(i32::MAX)
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
