//! What the initial laps say about delay and lag of the actuators.
//!
//! Each period is divided into parts. The velocities at its end are linear in the mean inputs m_j of
//! the parts, `y = sum_j B_j m_j + e`, with y and B_j from the nominal model at the measured state. For
//! a delay tau and a time constant T the recorded commands give m_j exactly. Measurements are noisy and
//! the inputs of the initial laps are a feedback of them, so that e is no white noise:
//!
//! ```text
//! e_k = y_k - sum_j B_j m_j(tau, T) + A (1 - L) e_{k-1}
//! ```
//!
//! is the innovation of a stationary filter with a gain for each row, which is white for the true pair.
//! With normal innovations of unknown mean and variance in each row the log-likelihood is
//! `-n/2 sum_rows ln var_row(tau, T)`, with the gains that suit best, and without what another grip
//! than the nominal one explains.

use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, Discretized, Input, State, Track};

use super::{Commanded, Response};

/// Length of the parts \[s\]: a car's yaw rate follows its steering within 10 ms at low speed.
const PART: f64 = 0.01;
/// Parts of a period at most.
const PARTS: usize = 20;
/// Gains L.
const GAINS: [f64; 4] = [1.0, 0.4, 0.12, 0.03];
/// More grip.
const MORE: f64 = 1.05;
/// Periods evaluated in a piece.
const PIECE: usize = 3000;
/// Periods taken in at most.
const MOST: usize = 1500;

/// One period: how its end depends on what acted in it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Period {
    /// Index of the command given at its beginning.
    command: usize,
    /// State at its beginning, velocities at its end.
    from: State,
    to: [f64; 3],
    /// Velocities at its end without inputs.
    y: [f64; 3],
    /// Feedback of the velocities on themselves, A.
    a: [[f64; 3]; 3],
    /// What more grip would change.
    by_grip: [f64; 3],
}

/// Evidence collected in the initial laps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Trial {
    pub(super) commands: Vec<Commanded>,
    periods: Vec<Period>,
    /// B_j of the parts of each period.
    b: Vec<[[f64; 2]; 3]>,
}

/// Parts of a period of length `dt`.
fn parts(dt: f64) -> usize {
    ((dt / PART - 1e-6).ceil() as usize).clamp(1, PARTS)
}

/// Positions of first-order actuators at the beginning of each command, and at the end.
#[must_use]
pub fn positions(commands: &[Commanded], lag: f64, dt: f64) -> Vec<Input> {
    let left = if lag > 0.0 { libm::exp(-dt / lag) } else { 0.0 };
    let mut p = Input::default();
    let mut reached = vec![p];
    for Commanded { u, .. } in commands {
        p.a = u.a + (p.a - u.a) * left;
        p.delta = u.delta + (p.delta - u.delta) * left;
        reached.push(p);
    }
    reached
}

/// Mean inputs of the parts of each period.
struct Means {
    inputs: Vec<Input>,
    parts: usize,
}

impl Means {
    /// Of actuators that follow the commands so, as fast as the car's limits let them.
    fn new(commands: &[Commanded], response: Response, car: &CarParams, dt: f64) -> Self {
        let parts = parts(dt);
        let part = dt / parts as f64;
        // The command that acts from the beginning of a period on is so many back; within it the next
        // one takes over.
        let back = (response.delay / dt + 1e-9).floor();
        let switch = (response.delay - back * dt).max(0.0);
        let back = back as usize + 1;
        let command = |i: usize, back: usize| {
            let i = i.checked_sub(back);
            i.and_then(|i| commands.get(i)).map_or(Input::default(), |command| command.u)
        };
        let stretch = |length: f64| Stretch::new(response.lag, car, length);
        let (whole, cut) = (stretch(part), (switch / part).floor());
        let before = (switch - cut * part).clamp(0.0, part);
        let halves = [stretch(before), stretch(part - before)];
        let mut inputs = Vec::with_capacity(commands.len() * parts);
        let mut position = Input::default();
        for i in 0..commands.len() {
            let (old, new) = (command(i, back), command(i + 1, back));
            for j in 0..parts {
                if j != cut as usize {
                    let target = if j < cut as usize { old } else { new };
                    inputs.push(whole.moved(&mut position, target));
                    continue;
                }
                let first = halves[0].moved(&mut position, old);
                let second = halves[1].moved(&mut position, new);
                let share = before / part;
                let mean = |a: f64, b: f64| share * a + (1.0 - share) * b;
                let (a, delta) = (mean(first.a, second.a), mean(first.delta, second.delta));
                inputs.push(Input { a, delta });
            }
        }
        Self { inputs, parts }
    }

    fn of(&self, command: usize) -> &[Input] {
        &self.inputs[command * self.parts..(command + 1) * self.parts]
    }
}

/// A time for which one command acts.
struct Stretch {
    /// Shares of the way left at its end, and on average over it.
    left: f64,
    mean: f64,
    /// Greatest ways.
    most: Input,
}

impl Stretch {
    fn new(lag: f64, car: &CarParams, length: f64) -> Self {
        let rate = |rate: Option<f64>| rate.map_or(f64::INFINITY, |rate| rate * length);
        let most = Input { a: rate(car.a_rate_max), delta: rate(car.delta_rate_max) };
        if lag <= 0.0 || length <= 0.0 {
            return Self { left: f64::from(u8::from(length <= 0.0)), mean: 0.0, most };
        }
        let left = libm::exp(-length / lag);
        Self { left, mean: (1.0 - left) * lag / length, most }
    }

    /// Moves a position towards a command; gives the mean on the way.
    fn moved(&self, position: &mut Input, target: Input) -> Input {
        let axis = |position: &mut f64, target: f64, most: f64| {
            let from = *position;
            let way = (target - from) * (1.0 - self.left);
            if way.abs() <= most && (self.left > 0.0 || most.is_infinite()) {
                *position = from + way;
                return target + (from - target) * self.mean;
            }
            // At full rate: a ramp, and rest if it ends before the time does.
            let way = way.clamp(-most, most);
            *position = from + way;
            from + way - 0.5 * way * if self.left > 0.0 { 1.0 } else { way.abs() / most }
        };
        let a = axis(&mut position.a, target.a, self.most.a);
        let delta = axis(&mut position.delta, target.delta, self.most.delta);
        Input { a, delta }
    }
}

/// The model of a part of a period.
fn divided(model: &Discretized) -> Discretized {
    let mut nominal = model.model.clone();
    // A grip that was fitted with the inputs as commanded explains their delay.
    nominal.grip = [1.0; 2];
    Discretized {
        model: nominal,
        dt: model.dt / parts(model.dt) as f64,
        substeps: model.substeps.div_ceil(parts(model.dt)),
    }
}

impl Period {
    /// Linearises along these inputs of the parts; whether the result is finite.
    fn linearize(
        &mut self,
        part: &Discretized,
        track: &Track,
        inputs: &[Input],
        b: &mut [[[f64; 2]; 3]],
    ) -> bool {
        let mut x = self.from;
        let mut parts = [None; PARTS];
        for (linear, u) in parts.iter_mut().zip(inputs).take(b.len()) {
            let found = part.linearize(&x, u, track.road());
            x = State::from_vector(&found.next);
            *linear = Some(found);
        }
        let reached = [x.v_x, x.v_y, x.omega_z];
        self.y = [0, 1, 2].map(|row| self.to[row] - reached[row]);
        let mut through = nalgebra::Matrix6::identity();
        for (j, b) in b.iter_mut().enumerate().rev() {
            let (Some(linear), u) = (&parts[j], &inputs[j]) else { continue };
            let by_input = through * linear.b;
            for row in 0..3 {
                b[row] = [by_input[(row, 0)], by_input[(row, 1)]];
                self.y[row] += b[row][0] * u.a + b[row][1] * u.delta;
            }
            through *= linear.a;
        }
        self.a = [0, 1, 2].map(|row| [0, 1, 2].map(|column| through[(row, column)]));
        let mut grippy = part.clone();
        grippy.model.grip = part.model.grip.map(|grip| MORE * grip);
        let mut x = self.from;
        for u in inputs.iter().take(b.len()) {
            x = grippy.next(&x, u, track.road());
        }
        let more = [x.v_x, x.v_y, x.omega_z];
        self.by_grip = [0, 1, 2].map(|row| (more[row] - reached[row]) / (MORE - 1.0));
        let known = self.y.iter().chain(self.a.iter().flatten()).chain(&self.by_grip);
        let finite = known.into_iter().all(|v| v.is_finite());
        finite && b.iter().flatten().flatten().all(|v| v.is_finite())
    }
}

/// About what acted in a period, by the motion alone: where the tyres are linearised must not depend on
/// what is looked for.
fn acted(model: &Discretized, last: &State, now: &State) -> Input {
    let car = &model.model.params;
    let v = (0.5 * (last.v_x + now.v_x)).max(0.1);
    let omega = 0.5 * (last.omega_z + now.omega_z);
    let delta = libm::atan(car.wheelbase() * omega / v);
    let a = (now.v_x - last.v_x) / model.dt;
    Input { a: a.clamp(car.a_min, car.a_max), delta: delta.clamp(-car.delta_max, car.delta_max) }
}

impl Trial {
    /// Takes in how the car went on from `last` to `now` in the period of the last command.
    pub(super) fn add(&mut self, model: &Discretized, track: &Track, last: &State, now: &State) {
        let Some(command) = self.commands.len().checked_sub(1) else { return };
        if self.periods.len() == MOST {
            return;
        }
        let mut period = Period {
            command,
            from: *last,
            to: [now.v_x, now.v_y, now.omega_z],
            y: [0.0; 3],
            a: [[0.0; 3]; 3],
            by_grip: [0.0; 3],
        };
        let u = acted(model, last, now);
        let parts = parts(model.dt);
        let begin = self.b.len();
        self.b.resize(begin + parts, [[0.0; 2]; 3]);
        if period.linearize(&divided(model), track, &[u; PARTS], &mut self.b[begin..]) {
            self.periods.push(period);
        } else {
            self.b.truncate(begin);
        }
    }

    /// Linearises periods from the `first` on, `count` at most, along the inputs of a response.
    pub(super) fn linearize(
        &mut self,
        model: &Discretized,
        track: &Track,
        response: Response,
        (first, count): (usize, usize),
    ) {
        let means = Means::new(&self.commands, response, &model.model.params, model.dt);
        let (part, parts) = (divided(model), parts(model.dt));
        let places = self.periods.iter_mut().zip(self.b.chunks_mut(parts));
        for (period, b) in places.skip(first).take(count) {
            let mut anew = (*period, [[[0.0; 2]; 3]; PARTS]);
            let inputs = means.of(period.command);
            if anew.0.linearize(&part, track, inputs, &mut anew.1[..parts]) {
                *period = anew.0;
                b.copy_from_slice(&anew.1[..parts]);
            }
        }
    }

    /// Periods taken in.
    pub(super) fn count(&self) -> usize {
        self.periods.len()
    }

    /// Pairs that cost about what a piece of the work at a lap's end costs.
    pub(super) fn affordable(&self) -> usize {
        (PIECE / self.periods.len().max(1)).max(1)
    }

    /// Periods that are linearised for what so many samples cost.
    pub(super) fn linearizable(&self, samples: usize, dt: f64) -> usize {
        (samples / parts(dt)).max(1)
    }

    /// Log-likelihood of a response, with commands held for `dt`.
    pub(super) fn likelihood(&self, response: Response, car: &CarParams, dt: f64) -> f64 {
        let means = Means::new(&self.commands, response, car, dt);
        let mut along = [Sum::default(); GAINS.len()];
        let mut across = [[[Sum::default(); 2]; GAINS.len()]; GAINS.len()];
        let mut before = None;
        for (period, b) in self.periods.iter().zip(self.b.chunks(parts(dt))) {
            let mut e = period.y;
            for (b, mean) in b.iter().zip(means.of(period.command)) {
                for (e, b) in e.iter_mut().zip(b) {
                    *e -= b[0] * mean.a + b[1] * mean.delta;
                }
            }
            let carried = f64::from(u8::from(before == Some(period.command)));
            before = Some(period.command + 1);
            let now = [0, 1, 2].map(|row| [e[row], period.by_grip[row]]);
            let [[a, ..], [_, a_yy, a_yw], [_, a_wy, a_ww]] = period.a;
            for (sum, gain) in along.iter_mut().zip(GAINS) {
                let kept = carried * a * (1.0 - gain);
                sum.add([0, 1].map(|i| now[0][i] + kept * sum.last[i]));
            }
            for (across, gain_y) in across.iter_mut().zip(GAINS) {
                for ([y, w], gain_w) in across.iter_mut().zip(GAINS) {
                    let (from_y, from_w) = (carried * (1.0 - gain_y), carried * (1.0 - gain_w));
                    let last = [0, 1].map(|i| [from_y * y.last[i], from_w * w.last[i]]);
                    y.add([0, 1].map(|i| now[1][i] + a_yy * last[i][0] + a_yw * last[i][1]));
                    w.add([0, 1].map(|i| now[2][i] + a_wy * last[i][0] + a_ww * last[i][1]));
                }
            }
        }
        let count = self.periods.len() as f64;
        let log = |sum: &Sum| libm::log(sum.variance(count).max(1e-300));
        let least = f64::min;
        let along = along.iter().map(log).fold(f64::INFINITY, least);
        let pairs = across.iter().flatten().map(|[y, w]| log(y) + log(w));
        -0.5 * count * (along + pairs.fold(f64::INFINITY, least))
    }
}

/// Innovations e of one row, and what they would be for more grip g.
#[derive(Clone, Copy, Default)]
struct Sum {
    last: [f64; 2],
    e: f64,
    g: f64,
    ee: f64,
    eg: f64,
    gg: f64,
}

impl Sum {
    fn add(&mut self, now: [f64; 2]) {
        let [e, g] = now;
        self.last = now;
        self.e += e;
        self.g += g;
        self.ee += e * e;
        self.eg += e * g;
        self.gg += g * g;
    }

    /// Variance that neither a constant nor the grip explains.
    fn variance(&self, count: f64) -> f64 {
        let (e, g) = (self.e / count, self.g / count);
        let ee = self.ee / count - e * e;
        let gg = self.gg / count - g * g;
        let eg = self.eg / count - e * g;
        if gg > 1e-12 { ee - eg * eg / gg } else { ee }
    }
}
