//! What a page needs of a drive, from its messages.

use std::collections::VecDeque;

use lcm_types::{LapResult, MpcTelemetry, Setup, Track, VehicleState};
use network_watch::{Seen, Watch};
use racing::record::tyre_use;
use vehicle_model::{Input, SlipAngles, State};

use crate::lap::Sample;
use crate::laps::Laps;
use crate::reference::{Reference, Resolve, Wanted};
use crate::world::World;

/// Steps whose times are kept. \[-\]
const STEPS: usize = 1200;

/// The times of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepDurations {
    pub(crate) total_us: i32,
    pub(crate) build_us: i32,
    pub(crate) solve_us: i32,
    pub(crate) status: i8,
}

/// Everything so far. Memory is bounded: traces by the track, tables and rings by their sizes.
pub(crate) struct ViewModel {
    pub(crate) watch: Watch,
    resolve: Resolve,
    wanted: Wanted,
    /// The car and its time-optimal lap, once they are known.
    reference: Option<Reference>,
    pub(crate) world: Option<World>,
    /// Of `world`: grows with each change. \[-\]
    pub(crate) world_version: u64,
    pub(crate) laps: Option<Laps>,
    pub(crate) steps: VecDeque<StepDurations>,
    /// Steps so far, those that are not kept any more included. \[-\]
    pub(crate) steps_seen: u64,
    /// States so far. \[-\]
    pub(crate) states_seen: u64,
    /// Grows with each message. \[-\]
    pub(crate) version: u64,
    /// Why nothing more will come.
    pub(crate) ended: Option<String>,
}

impl ViewModel {
    pub(crate) fn new(resolve: Resolve) -> Self {
        Self {
            watch: Watch::default(),
            resolve,
            wanted: Wanted::default(),
            reference: None,
            world: None,
            world_version: 0,
            laps: None,
            steps: VecDeque::new(),
            steps_seen: 0,
            states_seen: 0,
            version: 0,
            ended: None,
        }
    }

    pub(crate) fn take(&mut self, channel: &str, payload: &[u8], arrival_ns: i64) {
        self.version += 1;
        match self.watch.take(channel, payload, arrival_ns) {
            Some(Seen::State(state)) => self.state(&state),
            Some(Seen::Step(step)) => self.step(&step),
            Some(Seen::Lap(lap)) => self.lap(&lap),
            Some(Seen::Track(track)) => self.track(&track),
            Some(Seen::Setup(setup)) => self.setup(setup),
            _ => {}
        }
    }

    fn track(&mut self, track: &Track) {
        if self.laps.is_some() && self.wanted.track_id == track.track_id {
            return;
        }
        if !(track.length.is_finite() && track.length > 0.0) {
            return;
        }
        self.laps = Some(Laps::new(track.length));
        self.wanted.track_id = track.track_id;
        self.wanted.track.clone_from(&track.name);
        self.look_up();
    }

    fn setup(&mut self, setup: Setup) {
        let wanted = Wanted { car_id: setup.car_id, car: setup.car, ..self.wanted.clone() };
        if wanted != self.wanted {
            self.wanted = wanted;
            self.look_up();
        }
    }

    fn look_up(&mut self) {
        let Some(track) = self.watch.track() else { return };
        self.reference = (self.resolve)(&self.wanted);
        self.world = Some(World::new(track, &self.wanted.car, self.reference.as_ref()));
        self.world_version += 1;
    }

    fn step(&mut self, step: &MpcTelemetry) {
        if self.steps.len() >= STEPS {
            self.steps.pop_front();
        }
        self.steps.push_back(StepDurations {
            total_us: step.total_us,
            build_us: step.build_us,
            solve_us: step.solve_us,
            status: step.status,
        });
        self.steps_seen += 1;
    }

    fn lap(&mut self, lap: &LapResult) {
        if let Some(laps) = self.laps.as_mut().filter(|_| lap.track_id == self.wanted.track_id) {
            laps.judge(lap);
        }
    }

    fn state(&mut self, state: &VehicleState) {
        self.states_seen += 1;
        let (Some((s, e_y, index)), Some(track)) = (self.watch.place(state), self.watch.track())
        else {
            return;
        };
        let width = |widths: &[f32]| widths.get(index).copied().map_or(f64::INFINITY, f64::from);
        let inside = e_y <= width(&track.w_left) && -e_y <= width(&track.w_right);
        let (use_f, use_r) = self.tyres(state);
        let report = self.watch.report();
        let sample = Sample {
            t: 0.0,
            s,
            x: state.x,
            y: state.y,
            v_x: state.vx,
            a: report.map_or(f64::NAN, |report| report.accel),
            delta: report.map_or(f64::NAN, |report| report.steer),
            use_f,
            use_r,
            support: self.watch.step().map_or(f64::NAN, |step| step.support_min.into()),
            limited: report.map_or(0, |report| report.limited),
        };
        let Some(laps) = self.laps.as_mut() else { return };
        if s.is_finite() && (0.0..=track.length).contains(&s) {
            let time_s = state.meas_mono_ns as f64 * 1e-9;
            laps.push(state.h.boot_id, time_s, state.frenet.lap, sample, inside);
        }
    }

    /// Shares of the largest lateral forces in use, front and rear. \[-\]
    pub(crate) fn tyres(&self, state: &VehicleState) -> (f64, f64) {
        let Some(Reference { car, .. }) = &self.reference else { return (f64::NAN, f64::NAN) };
        let x = State { v_x: state.vx, v_y: state.vy, omega_z: state.yaw_rate, ..State::default() };
        let delta = match self.watch.report() {
            Some(report) => report.steer,
            None if state.valid & VehicleState::STEER != 0 => state.steer,
            None => return (f64::NAN, f64::NAN),
        };
        let slip = SlipAngles::new(&x, &Input { a: 0.0, delta }, car);
        (tyre_use(&car.tyre_front, slip.front), tyre_use(&car.tyre_rear, slip.rear))
    }
}
