//! What goes into a control step and what comes out of it.

use fhocp::{Backend, SolveStatus};
use serde::{Deserialize, Serialize};
use vehicle_model::{GlobalState, Input, State};

use crate::lap_number::LapNumber;

/// Where the car is: in the track's frame or in the global one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Pose {
    /// Frenet state.
    Frenet(State),
    /// Global pose with body velocities; the controller projects it onto its track.
    Global(GlobalState),
}

/// One measurement of the car.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Time of the measurement on the host's clock; only differences count \[s\].
    pub time: f64,
    /// The state.
    pub pose: Pose,
    /// The input that really acted since the last measurement, where the car reports it.
    /// Without it the controller takes the one it commanded, after its configured delay.
    pub applied: Option<Input>,
}

/// What a control step did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Action {
    /// An initial lap: centre-line tracking with excitation.
    #[default]
    WarmUp,
    /// The first input of the FHOCP's solution.
    Learned,
    /// The previous plan, shifted to now.
    ShiftedPlan,
    /// Centre-line tracking at warm-up speed.
    Tracking,
    /// Braking along the centre line.
    Braking,
    /// Slowly back to the centre line after an incident; [`Status::reason`] names it.
    Recovering,
}

impl Action {
    /// Number of the action in FMU outputs and messages: its place in the list above, from 0.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// Why the step did what it did, if not the normal course.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Reason {
    /// Nothing unusual.
    #[default]
    None,
    /// The QP was not solved; see [`Status::solve`].
    SolverFailed,
    /// The measurement holds a value that is not finite.
    NonFinite,
    /// Time did not advance since the last step.
    TimeNotAdvancing,
    /// Less than 0.5 or at least 1.5 periods passed since the last step, or the clock was set back.
    TimeGap,
    /// The state jumped farther than the car can drive in the time passed.
    Jump,
    /// The centre of gravity is beyond a track edge by more than a quarter of the track's width.
    OffTrack,
    /// The car points more than 90 degrees away from the track.
    WrongWay,
    /// The car stands or creeps, so that the learned model cannot be used.
    Standstill,
    /// No lap has been recorded to learn from.
    NoSafeSet,
    /// The car slides across its own heading.
    Spin,
    /// The car points across the track where driving is to begin.
    Askew,
}

impl Reason {
    /// Number of the reason in FMU outputs and messages: its place in the list above, from 0.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// Kind of a lap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LapKind {
    /// Initial lap by centre-line tracking.
    Warmup,
    /// Driven by the learning controller.
    Learning,
    /// Initial lap that somebody else drove.
    Driven,
}

/// A finished lap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LapResult {
    /// Number of the lap.
    pub lap: LapNumber,
    /// Kind.
    pub kind: LapKind,
    /// Lap time between the interpolated crossings of the line \[s\].
    pub lap_time: f64,
    /// Whether the whole lap was inside the track, with complete data; only such laps enter the
    /// safe set.
    pub valid: bool,
}

/// What a step did, why, and how far it can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Status {
    /// What was done.
    pub action: Action,
    /// Why, if not the normal course.
    pub reason: Reason,
    /// How the solver ended.
    pub solve: SolveStatus,
    /// Which solver that was; none if no problem was given to one in this step. With
    /// `solver.method = "structured"`, Clarabel means that it took over.
    pub solver: Option<Backend>,
    /// Iterations of the solver.
    pub iterations: u32,
    /// Number of the current lap.
    pub lap: LapNumber,
    /// State used, in the track's frame (the last good one if the measurement was refused).
    pub state: State,
    /// Optimal cost of the FHOCP in steps.
    pub cost: f64,
    /// Largest lane slack along the plan \[m\].
    pub lane_slack: f64,
    /// Largest front slip-guard slack along the plan \[rad\].
    pub front_slip_slack: f64,
    /// Largest rear slip-guard slack along the plan \[rad\].
    pub rear_slip_slack: f64,
    /// Largest speed-cap slack along the plan [m/s].
    pub speed_slack: f64,
    /// Part of `cost`: the cost-to-go of the terminal state, J' lambda, in steps.
    pub cost_to_go: f64,
    /// Part of `cost`: the penalty e' E e of the terminal slack e, in steps.
    pub terminal_slack_cost: f64,
    /// Sum of the kernel weights at the worst supported point of the horizon: 0 means that the
    /// nominal model stands alone there.
    pub data_support_min: f64,
    /// Mean over the horizon of the sum of the kernel weights.
    pub data_support_mean: f64,
    /// Share of the fitted grip that the road has now, 1 for all of it: below 1 after a fall of grip.
    pub road_grip: f64,
    /// How much later commands act than was estimated or configured, in whole periods; below 0 for sooner,
    /// 0 while no change is clear \[s\].
    pub delay_change: f64,
    /// Whether the input was cut to the car's limits.
    pub clipped: bool,
    /// The lap that this measurement finished.
    pub finished: Option<LapResult>,
}

/// The outcome of a control step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Command {
    /// Input to apply, always finite and inside the car's limits.
    pub input: Input,
    /// What was done and why.
    pub status: Status,
}

/// Phases of a step, for hosts that measure time: the controller itself has no clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// Reading the measurement: projection, lap counting, recording.
    Project,
    /// Jacobians of the nominal model along the shifted plan.
    Linearize,
    /// Error regression along the shifted plan.
    Regress,
    /// Safe set around the predicted terminal state.
    SafeSet,
    /// Assembly and solution of the QP.
    Solve,
}

/// Called when a phase of the step begins and ends.
pub trait Probe {
    /// A phase begins.
    fn begin(&mut self, phase: Phase);
    /// That phase ends.
    fn end(&mut self, phase: Phase);
}

impl Probe for () {
    fn begin(&mut self, _: Phase) {}
    fn end(&mut self, _: Phase) {}
}
