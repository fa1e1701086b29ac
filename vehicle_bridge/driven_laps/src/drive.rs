//! From a recording to the steps a controller learns from.

use controller::learning::inverse::{self, Period};
use controller::{Config, DrivenStep, Pose};
use vehicle_model::track::wrap_angle;
use vehicle_model::{
    CarParams, Discretized, GlobalState, Input, Model, ModelKind, Outline, State, Track,
};

use super::inputs::Held;
use super::signal::{Signal, unwrapped};
use super::smooth::MIN_SAMPLES;
use super::{InputChoice, Recorded, Recording};

/// A gap is longer than this many intervals of the recording, and than this many periods.
const GAP_INTERVALS: f64 = 4.5;
const GAP_PERIODS: f64 = 1.5;
/// A car that is farther from where it was than this many times its way was carried.
const CARRIED: f64 = 3.0;

/// A drive on the grid of the control periods.
#[derive(Debug, Clone)]
pub struct ResampledDrive {
    /// One step a period.
    pub steps: Vec<DrivenStep>,
    /// Stretches without a gap.
    pub stretches: usize,
    /// States of the recording that stretches use.
    pub used: usize,
    /// Interval of the recording \[s\].
    pub interval: f64,
    /// Noise that was taken away: position \[m\], heading \[rad\], v_x, v_y \[m/s\], omega_z \[rad/s\].
    pub noise: [f64; 5],
    /// Whether velocities are derivatives of the pose.
    pub differentiated: bool,
    /// Where the inputs come from, in words.
    pub inputs: String,
    /// The laps from line to line.
    pub laps: Vec<LapAccount>,
}

/// One lap from line to line, with what was wrong with it.
#[derive(Debug, Clone, Copy)]
pub struct LapAccount {
    /// Time between the crossings of the line \[s\].
    pub lap_time: f64,
    /// Greatest overhang of the body beyond an edge; negative inside \[m\].
    pub overhang: f64,
    /// Where that was \[m\].
    pub s: f64,
    /// Where the car stood or turned round, if it did \[m\].
    pub stopped: Option<f64>,
}

impl LapAccount {
    /// Whether the lap is taken.
    #[must_use]
    pub fn fit(&self) -> bool {
        self.overhang <= 0.0 && self.stopped.is_none()
    }
}

/// Brings a recording to the periods of a configuration, in the frame of the track.
#[must_use]
pub fn drive(
    recording: &Recording,
    source: InputChoice,
    smoothing: bool,
    (config, car, track): (&Config, &CarParams, &Track),
) -> ResampledDrive {
    let states = &recording.states;
    let interval = median_interval(states);
    let period = config.horizon.period;
    let differentiated = states.iter().any(|state| state.velocities.is_none());
    let mut driven = ResampledDrive {
        steps: Vec::new(),
        stretches: 0,
        used: 0,
        interval,
        noise: [0.0; 5],
        differentiated,
        inputs: String::new(),
        laps: Vec::new(),
    };
    let gap = (GAP_INTERVALS * interval).max(GAP_PERIODS * period);
    let poses: Vec<GlobalState> = states.iter().map(|state| pose(state, track)).collect();
    let mut steers = Vec::new();
    let mut first = 0;
    for end in 1..=states.len() {
        let breaks = end == states.len()
            || states[end].time - states[end - 1].time > gap
            || carried(states, &poses, end, track);
        if !breaks {
            continue;
        }
        let range = first..end;
        first = end;
        if range.len() < MIN_SAMPLES {
            continue;
        }
        driven.stretches += 1;
        driven.used += range.len();
        let stretch = Stretch::new(
            &states[range.clone()],
            &poses[range],
            interval,
            (smoothing, differentiated),
        );
        for (total, noise) in driven.noise.iter_mut().zip(stretch.noise) {
            *total = total.max(noise);
        }
        stretch.sample(period, track, &mut driven.steps, &mut steers);
    }
    judge(&mut driven.steps, config, car, track);
    give_inputs(&mut driven, recording, source, &steers, (config, car, track));
    driven.laps = laps(&driven.steps, config, car, track);
    driven
}

pub(super) fn median_interval(states: &[Recorded]) -> f64 {
    let mut all: Vec<f64> =
        states.iter().zip(states.iter().skip(1)).map(|(a, b)| b.time - a.time).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(1.0)
}

fn pose(state: &Recorded, track: &Track) -> GlobalState {
    match state.pose {
        Pose::Global(pose) => pose,
        Pose::Frenet(x) => track.to_global(&x),
    }
}

/// Whether the car came to place `i` otherwise than by driving: a person put it back.
fn carried(states: &[Recorded], poses: &[GlobalState], i: usize, track: &Track) -> bool {
    let way = |i: usize| {
        let (from, to) = (&poses[i - 1], &poses[i]);
        (to.x - from.x).hypot(to.y - from.y) / (states[i].time - states[i - 1].time)
    };
    let speed = match states[i - 1].velocities.zip(states[i].velocities) {
        Some((before, now)) => before[0].abs().max(now[0].abs()),
        None if i >= 2 => way(i - 1),
        None => return false,
    };
    let moved = way(i) * (states[i].time - states[i - 1].time);
    let driven = speed * (states[i].time - states[i - 1].time);
    moved > CARRIED * driven + 0.1 * track.narrowest()
}

/// A stretch without gaps, as signals.
struct Stretch {
    /// x, y, psi.
    pose: [Signal; 3],
    /// v_x, v_y, omega_z.
    velocities: Option<[Signal; 3]>,
    steer: Option<Signal>,
    start: f64,
    noise: [f64; 5],
}

impl Stretch {
    fn new(
        states: &[Recorded],
        poses: &[GlobalState],
        interval: f64,
        (smoothing, differentiated): (bool, bool),
    ) -> Self {
        let times: Vec<f64> = states.iter().map(|state| state.time).collect();
        let signal = |values: &[f64]| Signal::new(&times, values, interval, smoothing);
        let of = |f: fn(&GlobalState) -> f64| poses.iter().map(f).collect::<Vec<f64>>();
        let pose = [signal(&of(|p| p.x)), signal(&of(|p| p.y)), signal(&unwrapped(&of(|p| p.psi)))];
        let velocities = (!differentiated).then(|| {
            std::array::from_fn(|i| {
                let values: Vec<f64> =
                    states.iter().filter_map(|state| Some(state.velocities?[i])).collect();
                signal(&values)
            })
        });
        let steers: Option<Vec<f64>> = states.iter().map(|state| state.steer).collect();
        let steer = steers.map(|values| Signal::new(&times, &values, interval, false));
        let position = pose[0].noise.max(pose[1].noise);
        let [v_x, v_y, omega_z] =
            velocities.as_ref().map_or([0.0; 3], |v: &[Signal; 3]| [0, 1, 2].map(|i| v[i].noise));
        let noise = [position, pose[2].noise, v_x, v_y, omega_z];
        Self { pose, velocities, steer, start: times[0], noise }
    }

    /// One step a period; where the steering angle was measured, its mean over the period.
    fn sample(
        &self,
        period: f64,
        track: &Track,
        steps: &mut Vec<DrivenStep>,
        steers: &mut Vec<Option<f64>>,
    ) {
        // A last state that comes early by the rounding of its time is one of this period.
        let count = ((self.pose[0].end() - self.start) / period + 1e-3) as usize + 1;
        let mut hint = None;
        for i in 0..count {
            let time = self.start + i as f64 * period;
            let [x, y, psi] = [0, 1, 2].map(|k| self.pose[k].at(time));
            let [v_x, v_y, omega_z] = match &self.velocities {
                Some(velocities) => [0, 1, 2].map(|k| velocities[k].at(time)),
                None => {
                    let [x, y, turn] = [0, 1, 2].map(|k| self.pose[k].rate(time));
                    let (sin, cos) = psi.sin_cos();
                    [x * cos + y * sin, y * cos - x * sin, turn]
                }
            };
            let global = GlobalState { x, y, psi: wrap_angle(psi), v_x, v_y, omega_z };
            let mut state = track.to_frenet(&global, hint);
            state.s = track.wrap(state.s);
            hint = Some(state.s);
            let u = Input::default();
            steps.push(DrivenStep { time, x: state, u, follows: i > 0, fit: true });
            steers.push(self.steer.as_ref().map(|steer| {
                let parts = 8;
                let at = |k: i32| steer.at(time + (f64::from(k) + 0.5) / f64::from(parts) * period);
                (0..parts).map(at).sum::<f64>() / f64::from(parts)
            }));
        }
    }
}

/// Which states a lap may have: the body inside the track, the car driving forward.
fn judge(steps: &mut [DrivenStep], config: &Config, car: &CarParams, track: &Track) {
    let outline = Outline::new(car);
    for step in steps {
        let inside = outline.overhang(track, &step.x) <= 0.0;
        step.fit = inside && !stopped(&step.x, config);
    }
}

/// Below the speed from which the controller can drive, or turned away from the track.
fn stopped(x: &State, config: &Config) -> bool {
    x.v_x < 0.25 * config.warm_up.speed || x.e_psi.abs() > std::f64::consts::FRAC_PI_2
}

fn give_inputs(
    driven: &mut ResampledDrive,
    recording: &Recording,
    source: InputChoice,
    steers: &[Option<f64>],
    (config, car, track): (&Config, &CarParams, &Track),
) {
    let period = config.horizon.period;
    let recorded = !recording.inputs.is_empty() && source != InputChoice::Reckoned;
    if recorded {
        let applied = match source {
            InputChoice::Applied => true,
            InputChoice::Commanded => false,
            _ => recording.applied,
        };
        let delay = config.delay.steps as f64 * period;
        let held = if applied {
            Held::reported(&recording.inputs)
        } else {
            Held::acting(&recording.inputs, delay, car)
        };
        let patience = (GAP_INTERVALS * driven.interval).max(GAP_PERIODS * period) + delay;
        let mut missing = 0;
        for step in &mut driven.steps {
            match held.mean(step.time, step.time + period, patience) {
                Some(input) => step.u = input,
                None => {
                    missing += 1;
                    step.fit = false;
                }
            }
        }
        let kind = if applied { "recorded, as they acted" } else { "recorded commands" };
        driven.inputs = if missing == 0 {
            kind.to_owned()
        } else {
            format!("{kind}; missing in {missing} of {} periods", driven.steps.len())
        };
        return;
    }
    let model = Model::new(ModelKind::Dynamic, car.clone());
    let model = Discretized { model, dt: period, substeps: config.horizon.substeps };
    let (mut periods, mut places) = (Vec::new(), Vec::new());
    for i in 1..driven.steps.len() {
        let (step, next) = (&driven.steps[i - 1], &driven.steps[i]);
        if next.follows && step.x.v_x > 0.0 {
            let next = [next.x.v_x, next.x.v_y, next.x.omega_z];
            periods.push(Period { x: step.x, next, delta: steers[i - 1] });
            places.push(i - 1);
        }
    }
    let (inputs, grip) = inverse::inputs(&model, track, &periods);
    for (place, input) in places.into_iter().zip(inputs) {
        driven.steps[place].u = input;
    }
    let steer = if periods.iter().all(|period| period.delta.is_some()) {
        "the acceleration reckoned from the states, the steering angle measured"
    } else {
        "reckoned from the states"
    };
    driven.inputs = format!("{steer}, with {grip:.2} times the car's grip");
}

/// The laps from line to line.
fn laps(steps: &[DrivenStep], config: &Config, car: &CarParams, track: &Track) -> Vec<LapAccount> {
    let (outline, length) = (Outline::new(car), track.length());
    let mut laps = Vec::new();
    let mut current: Option<(f64, LapAccount)> = None;
    for (i, step) in steps.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &steps[i]).filter(|_| step.follows);
        let ahead = before.map_or(0.0, |before| step.x.s - before.x.s);
        if before.is_none() || ahead > 0.5 * length {
            current = None;
        }
        if let Some(before) = before.filter(|_| ahead < -0.5 * length) {
            let share = (length - before.x.s) / (length - before.x.s + step.x.s);
            let line = before.time + share * (step.time - before.time);
            if let Some((start, lap)) = current.take() {
                laps.push(LapAccount { lap_time: line - start, ..lap });
            }
            let lap =
                LapAccount { lap_time: 0.0, overhang: f64::NEG_INFINITY, s: 0.0, stopped: None };
            current = Some((line, lap));
        }
        if let Some((_, lap)) = &mut current {
            let overhang = outline.overhang(track, &step.x);
            if overhang > lap.overhang {
                (lap.overhang, lap.s) = (overhang, step.x.s);
            }
            if stopped(&step.x, config) {
                lap.stopped.get_or_insert(step.x.s);
            }
        }
    }
    laps
}
