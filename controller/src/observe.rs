//! From a measurement to a believed state: refusal, lap counting, recording.

use vehicle_model::track::wrap_angle;
use vehicle_model::{Input, State, Track};

use crate::config::Config;
use crate::filter::{Filter, Prediction, Smoothing};
use crate::lap_number::LapNumber;
use crate::learning::dataset::Sample;
use crate::memory::{Last, Memory};
use crate::status::{LapKind, LapResult, Measurement, Pose, Reason};

/// Doubtful measurements in a row after which what they say is believed.
const SUSPECTS: u32 = 3;
/// Share of the distance driven that a measurement may deviate from dead reckoning.
const JUMP_SHARE: f64 = 0.1;
/// More than any tyre or wing can do, less than a broken sensor says [m/s^2].
const HARDEST: f64 = 50.0;

/// What is known of the car's shape and track when a measurement comes in.
pub(crate) struct Observer<'a> {
    pub(crate) config: &'a Config,
    pub(crate) track: &'a Track,
    /// The wheelbase: a deviation up to this is no jump [m].
    pub(crate) jump_floor: f64,
    pub(crate) filter: Option<&'a Filter>,
    /// What the filter expects one period after the last measurement.
    pub(crate) prediction: Option<&'a Prediction>,
}

/// A believed measurement.
pub(crate) struct Observation {
    pub(crate) state: State,
    pub(crate) reason: Reason,
    pub(crate) finished: Option<LapResult>,
    /// The line was crossed: frames move by one lap.
    pub(crate) crossed: bool,
}

impl Observer<'_> {
    /// Believes or refuses a measurement; a believed one is recorded.
    pub(crate) fn observe(
        &self,
        memory: &mut Memory,
        measurement: &Measurement,
    ) -> Result<Observation, Reason> {
        let state = self.frenet(memory, measurement).ok_or(Reason::NonFinite)?;
        let time = measurement.time;
        let Some(last) = memory.last else {
            return Ok(self.begin(memory, time, state, Reason::None));
        };
        let periods = (time - last.time) / self.config.horizon.period;
        if periods < -1e-6 {
            // One that comes late is refused; a clock that was set back is believed in the end,
            // or the last command would stand for ever.
            if self.doubtful(memory) {
                return Err(Reason::TimeNotAdvancing);
            }
            memory.dataset.current.from_line = false;
            return Ok(self.begin(memory, time, state, Reason::TimeGap));
        }
        if periods < 1e-6 {
            return Err(Reason::TimeNotAdvancing);
        }
        if self.jumped(&last, time, &state) {
            if self.doubtful(memory) {
                return Err(Reason::Jump);
            }
            return Ok(self.begin(memory, time, state, Reason::Jump));
        }
        memory.suspects = 0;
        let gap = !(0.5..1.5).contains(&periods);
        let state = self.filtered(memory, state, gap);
        self.complete_last_sample(memory, &state, measurement.applied, gap);
        let ahead = state.s - last.state.s;
        let half = 0.5 * self.track.length();
        let crossed = ahead < -half;
        if ahead > half {
            // Backwards over the line: the lap in progress has lost its meaning.
            memory.dataset.interrupt();
            memory.drop_plan();
        }
        let finished = crossed.then(|| self.cross(memory, &last, time, &state)).flatten();
        if crossed && gap {
            // When the new lap began is a guess.
            memory.dataset.interrupt();
        }
        self.record(memory, time, state);
        let reason = if gap { Reason::TimeGap } else { Reason::None };
        Ok(Observation { state, reason, finished, crossed })
    }

    fn frenet(&self, memory: &Memory, measurement: &Measurement) -> Option<State> {
        if !measurement.time.is_finite() || measurement.applied.is_some_and(|u| !u.is_finite()) {
            return None;
        }
        let mut pose = measurement.pose;
        if self.filter.is_some_and(Filter::blind) {
            // Velocities nobody measured are those of before.
            let x = memory.last.map(|last| last.state).unwrap_or_default();
            match &mut pose {
                Pose::Frenet(to) => (to.v_x, to.v_y, to.omega_z) = (x.v_x, x.v_y, x.omega_z),
                Pose::Global(to) => (to.v_x, to.v_y, to.omega_z) = (x.v_x, x.v_y, x.omega_z),
            }
        }
        let mut state = match pose {
            Pose::Frenet(state) if state.is_finite() => state,
            Pose::Global(global) if global.is_finite() => {
                self.track.to_frenet(&global, memory.last.map(|last| last.state.s))
            }
            _ => return None,
        };
        state.s = self.track.wrap(state.s);
        state.e_psi = wrap_angle(state.e_psi);
        state.is_finite().then_some(state)
    }

    /// The filter's estimate, or the measurement itself where there is no filter.
    fn filtered(&self, memory: &mut Memory, measured: State, anew: bool) -> State {
        let Some(filter) = self.filter else { return measured };
        let estimate = &mut memory.estimate;
        match (self.prediction, &memory.last) {
            (Some(prediction), Some(last)) if !anew => {
                filter.update(estimate, &last.state, prediction, &measured, self.track)
            }
            _ => filter.begin(estimate, &measured),
        }
    }

    /// Counts a doubtful measurement; whether it is still to be refused.
    fn doubtful(&self, memory: &mut Memory) -> bool {
        memory.suspects += 1;
        memory.suspects < SUSPECTS
    }

    /// Starts recording at a place not connected with what came before.
    fn begin(&self, memory: &mut Memory, time: f64, state: State, reason: Reason) -> Observation {
        let first = memory.last.is_none();
        let state = self.filtered(memory, state, true);
        let near_line = state.s < 0.02 * self.track.length();
        memory.suspects = 0;
        memory.drop_plan();
        memory.dataset.interrupt();
        if first {
            let current = &mut memory.dataset.current;
            current.start_time = time;
            current.from_line = near_line;
            current.clean = near_line;
            memory.lap = LapNumber::new(u32::from(near_line));
        }
        self.record(memory, time, state);
        Observation { state, reason, finished: None, crossed: false }
    }

    /// Whether the state is farther from dead reckoning than any car can drive. In the global
    /// frame: there a curvature step of the centre line makes no step.
    fn jumped(&self, last: &Last, time: f64, state: &State) -> bool {
        let dt = time - last.time;
        let (from, to) = (self.track.to_global(&last.state), self.track.to_global(state));
        let turned = (to.omega_z - from.omega_z).abs() * self.jump_floor;
        // A car that spins keeps its velocity and turns its frame: both readings are true ones.
        let (sin, cos) = libm::sincos(to.psi - from.psi);
        let (v_x, v_y) = (to.v_x * cos - to.v_y * sin, to.v_x * sin + to.v_y * cos);
        let pushed = libm::hypot(to.v_x - from.v_x, to.v_y - from.v_y)
            .min(libm::hypot(v_x - from.v_x, v_y - from.v_y));
        if pushed.max(turned) > HARDEST * dt.max(self.config.horizon.period) {
            return true;
        }
        // Along a bend, or straight on sideways.
        let missed_with = |turned: f64| {
            let (sin, cos) = libm::sincos(from.psi + turned);
            let x = from.x + dt * (from.v_x * cos - from.v_y * sin);
            let y = from.y + dt * (from.v_x * sin + from.v_y * cos);
            libm::hypot(to.x - x, to.y - y)
        };
        let missed = missed_with(0.5 * dt * from.omega_z).min(missed_with(0.0));
        let driven = dt * libm::hypot(from.v_x, from.v_y).max(libm::hypot(to.v_x, to.v_y));
        let periods = (dt / self.config.horizon.period).max(1.0);
        let allowed = self.jump_floor * periods + JUMP_SHARE * driven;
        missed > allowed || missed.is_nan()
    }

    fn complete_last_sample(
        &self,
        memory: &mut Memory,
        state: &State,
        applied: Option<Input>,
        gap: bool,
    ) {
        let current = &mut memory.dataset.current;
        if gap {
            current.clean = false;
        }
        let Some(sample) = current.samples.last_mut() else { return };
        if let Some(applied) = applied {
            sample.u = applied;
        }
        let taught = !gap && !current.spoiled;
        sample.next = taught.then_some([state.v_x, state.v_y, state.omega_z]);
    }

    /// Closes the lap at the interpolated crossing of the line.
    fn cross(
        &self,
        memory: &mut Memory,
        last: &Last,
        time: f64,
        state: &State,
    ) -> Option<LapResult> {
        let before = self.track.length() - last.state.s;
        let share = before / (before + state.s);
        let end_time = last.time + share * (time - last.time);
        let kind = if memory.learning { LapKind::Learning } else { LapKind::Warmup };
        // Of a lap of a few samples only.
        memory.smooth(usize::MAX, self.track);
        let finished = memory.dataset.close(memory.lap, kind, end_time);
        self.begin_smoothing(memory);
        if finished.is_some_and(|lap| lap.valid && lap.kind == LapKind::Learning) {
            memory.learned_laps += 1;
        }
        memory.lap = memory.lap.next();
        memory.learning |= memory.initial_laps_done(self.config.warm_up.laps);
        finished
    }

    /// Leaves the lap just closed to be smoothed, if it was filtered.
    fn begin_smoothing(&self, memory: &mut Memory) {
        let estimate = &mut memory.estimate;
        let Some(last) = estimate.steps.last().cloned() else { return };
        let steps = std::mem::replace(&mut estimate.steps, std::mem::take(&mut estimate.spare));
        // The measurement behind the line belongs to the lap that begins.
        estimate.steps.push(last);
        let samples = memory.dataset.laps.last().map(|lap| lap.samples.clone());
        memory.smoothing = samples.map(|samples| Smoothing::new(samples, steps));
    }

    fn record(&self, memory: &mut Memory, time: f64, state: State) {
        memory.last = Some(Last { time, state });
        let current = &mut memory.dataset.current;
        let outside = state.e_y > self.track.width_left(state.s)
            || state.e_y < -self.track.width_right(state.s);
        if outside {
            current.clean = false;
        }
        current.samples.push(Sample { time, x: state, u: Input::default(), next: None });
    }
}
