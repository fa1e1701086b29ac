//! Laps that somebody else drove as the first data D^0: a person, or another program.

use std::sync::Arc;

use vehicle_model::{Input, State};

use crate::controller::{Controller, Setup};
use crate::derive::Scales;
use crate::filter::ridge_of;
use crate::learning::dataset::{Lap, Sample};
use crate::memory::{Inherited, Memory};
use crate::status::{LapKind, LapResult};

/// One period of a recorded drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenStep {
    /// Time of the state, on any clock \[s\].
    pub time: f64,
    /// The state, s in [0, L).
    pub x: State,
    /// Mean input that acted over the period that begins with the state.
    pub u: Input,
    /// Whether the state lies one period after that of the step before.
    pub follows: bool,
    /// Whether a lap with this state may enter the safe set.
    pub fit: bool,
}

impl Controller {
    /// Takes over a recorded drive in place of what was learned so far, closes its laps at the line
    /// and learns from them. One lap that is fit as a whole takes the place of all initial laps.
    ///
    /// What was driven before the first line and behind the last one stays in the data of the
    /// regression, as do laps that are not fit; a state that is not fit is not learned from.
    /// Returns the laps that were closed.
    pub fn adopt(&mut self, steps: &[DrivenStep]) -> Vec<LapResult> {
        let length = self.setup.track.length();
        let mut memory = Memory::new(&self.setup.config);
        let mut closed = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            let before = i.checked_sub(1).map(|i| &steps[i]).filter(|_| step.follows);
            match before {
                None => begin(&mut memory, step),
                Some(before) => {
                    let current = &mut memory.dataset.current;
                    if let Some(last) = current.samples.last_mut() {
                        let learned = before.fit && step.fit;
                        last.next = learned.then_some([step.x.v_x, step.x.v_y, step.x.omega_z]);
                    }
                    let ahead = step.x.s - before.x.s;
                    if ahead > 0.5 * length {
                        // Backwards over the line: the lap in progress has lost its meaning.
                        memory.dataset.interrupt();
                    }
                    if ahead < -0.5 * length {
                        let share = (length - before.x.s) / (length - before.x.s + step.x.s);
                        let end = before.time + share * (step.time - before.time);
                        closed.extend(memory.dataset.close(memory.lap, LapKind::Driven, end));
                        memory.lap = memory.lap.next();
                    }
                }
            }
            let current = &mut memory.dataset.current;
            current.clean &= step.fit;
            current.samples.push(Sample { time: step.time, x: step.x, u: step.u, next: None });
        }
        if let Some(last) = steps.last() {
            close_part(&mut memory, last.time);
        }
        memory.learning = memory.initial_laps_done(self.setup.config.warm_up.laps);
        memory.inherited = Inherited {
            laps: memory.dataset.laps.len(),
            ridge: self.setup.ridge_for(&memory.dataset.laps, memory.grip),
        };
        self.memory = memory;
        self.apply_learned();
        self.finish_learning();
        self.prepared = false;
        closed
    }
}

impl Setup {
    /// Ridge weight that the noise of recorded laps asks for. What the model gets wrong changes slowly
    /// along a lap: the second differences of the targets are mostly noise, whose variance they hold
    /// six times.
    fn ridge_for(&self, laps: &[Arc<Lap>], grip: [f64; 2]) -> f64 {
        let (mut points, mut targets) = (Vec::new(), Vec::new());
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for lap in laps {
            for stretch in lap.samples.split(|sample| sample.next.is_none()) {
                let samples = stretch.iter().map(|sample| (sample, 1.0));
                self.targets(samples, grip, &mut points, &mut targets);
                for three in targets.windows(3) {
                    let second = |i: usize| three[0][i] - 2.0 * three[1][i] + three[2][i];
                    for (i, sum) in sum.iter_mut().enumerate() {
                        *sum += second(i).powi(2) / 6.0;
                    }
                    count += 1.0;
                }
            }
        }
        let variances = sum.map(|sum| sum / f64::max(count, 1.0));
        ridge_of(variances, &Scales::new(&self.car), self.config.horizon.period)
    }
}

/// Begins a stretch that nothing connects with what came before.
fn begin(memory: &mut Memory, step: &DrivenStep) {
    close_part(memory, step.time);
    let current = &mut memory.dataset.current;
    current.start_time = step.time;
    current.follows = false;
    current.from_line = false;
    current.clean = false;
}

/// Keeps a lap that was not finished as data of the regression, and as what the lap before led to.
fn close_part(memory: &mut Memory, time: f64) {
    if memory.dataset.current.samples.is_empty() {
        return;
    }
    memory.dataset.interrupt();
    memory.dataset.close(memory.lap, LapKind::Driven, time);
    memory.lap = memory.lap.next();
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, Normal};
    use vehicle_model::{CarParams, Track};

    use super::*;
    use crate::config::Config;
    use crate::presets::Preset;

    /// Laps that the nominal model drives slowly along the centre line, with noise on its velocities.
    fn adopted(sigma: f64) -> Controller {
        let track = Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let config = Config::derived(Preset::Race, &car, &track);
        let dt = config.horizon.period;
        let mut controller = Controller::new(config, car, track.clone()).unwrap();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
        let noise = Normal::new(0.0, sigma).unwrap();
        let wheelbase = controller.setup.car.wheelbase();
        let mut x = State { v_x: 1.0, ..State::default() };
        let steps: Vec<DrivenStep> = (0..1500)
            .map(|i| {
                let mut seen = State { s: track.wrap(x.s), ..x };
                seen.v_x += noise.sample(&mut rng);
                let bend = (wheelbase * track.kappa(x.s)).atan();
                let delta = bend - 1.5 * x.e_y - 0.8 * x.e_psi;
                let u = Input { a: 1.0 - x.v_x, delta };
                let step =
                    DrivenStep { time: f64::from(i) * dt, x: seen, u, follows: i > 0, fit: true };
                x = controller.setup.model.next(&x, &u, track.road());
                step
            })
            .collect();
        assert!(controller.adopt(&steps).len() > 3);
        controller
    }

    /// n_{t+1} - A n_t: second differences of it have (1 + (2 + a)^2 + (1 + 2 a)^2 + a^2) sigma^2.
    #[test]
    fn noise_of_adopted_laps_asks_for_a_ridge() {
        let (quiet, sigma) = (adopted(1e-12).memory.ridge, 0.05);
        assert!(quiet < 1e-6, "{quiet}");
        let controller = adopted(sigma);
        let Setup { car, track, model, .. } = &controller.setup;
        let x = State { v_x: 1.0, ..State::default() };
        let a = model.linearize(&x, &Input::default(), track.road()).a[(0, 0)];
        let factor = 1.0 + (2.0 + a).powi(2) + (1.0 + 2.0 * a).powi(2) + a * a;
        let variances = [sigma * sigma * factor / 6.0, 0.0, 0.0];
        let expected = ridge_of(variances, &Scales::new(car), model.dt);
        let ridge = controller.memory.ridge;
        assert!((ridge / expected - 1.0).abs() < 0.1, "{ridge}, expected {expected}");
        assert_eq!(controller.setup.regression.ridge, ridge);
    }

    #[test]
    fn learned_data_keep_the_ridge_while_their_laps_are_searched() {
        let teacher = adopted(0.05);
        let mut pupil = adopted(1e-12);
        pupil.load(&teacher.save()).unwrap();
        assert_eq!(pupil.memory.ridge, teacher.memory.ridge);
        assert!(pupil.memory.ridge > 0.1);
        let searched = pupil.setup.config.regression.laps;
        for own in 1..=searched {
            let lap = pupil.memory.dataset.laps[0].clone();
            pupil.memory.dataset.laps.push(lap);
            pupil.finish_learning();
            let kept = pupil.memory.ridge == teacher.memory.ridge;
            assert_eq!(kept, own < searched, "after {own} laps of its own");
        }
    }
}
