//! A car on the L track with its controller: the loop that all closed-loop tests share.

use std::sync::Arc;

use controller::{Action, Command, Config, Controller, LapKind, LapResult, Measurement, Pose};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

/// Steps after which a lap that does not end is given up.
const LONGEST_LAP: usize = 500;

/// A simulated car, its controller and what they have done.
pub struct Drive {
    /// The controller.
    pub controller: Controller,
    /// The car.
    pub plant: Plant,
    /// Periods driven.
    pub steps: u32,
    /// Every finished lap.
    pub laps: Vec<LapResult>,
    /// Greatest |e_y| of the true car so far \[m\].
    pub widest: f64,
}

/// The shipped 1:10 car with this grip.
///
/// # Panics
/// If it does not ship any more.
#[must_use]
#[allow(clippy::expect_used)]
pub fn barc(mu: f64) -> CarParams {
    CarParams::builtin("barc").expect("ships with the crate").with_mu(mu)
}

/// The L track.
///
/// # Panics
/// If it does not ship any more.
#[must_use]
#[allow(clippy::expect_used)]
pub fn l_track() -> Arc<Track> {
    Arc::new(Track::builtin("l").expect("ships with the crate"))
}

impl Drive {
    /// The study's problem: the controller believes in mu 1.2, the car has 0.9. It starts on the
    /// line at warm-up speed.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self::of(config, barc(1.2), PlantParams::new(barc(0.9)))
    }

    /// Any nominal car and any simulated one.
    ///
    /// # Panics
    /// If configuration, cars and track do not fit together.
    #[must_use]
    #[allow(clippy::expect_used)]
    pub fn of(config: Config, nominal: CarParams, plant: PlantParams) -> Self {
        let start = State { v_x: config.warm_up.speed, ..State::default() };
        let controller = Controller::new(config, nominal, l_track()).expect("fits");
        let plant = Plant::new(plant, l_track(), start).expect("a valid car");
        Self { controller, plant, steps: 0, laps: Vec::new(), widest: 0.0 }
    }

    /// Time on the host's clock \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        f64::from(self.steps) * self.period()
    }

    /// What the sensors say now.
    pub fn measure(&mut self) -> Measurement {
        Measurement { time: self.time(), pose: Pose::Frenet(self.plant.measure()), applied: None }
    }

    /// One period.
    pub fn step(&mut self) -> Command {
        let measurement = self.measure();
        self.step_on(&measurement)
    }

    /// One period in which the controller gets `measurement`; the car drives on.
    pub fn step_on(&mut self, measurement: &Measurement) -> Command {
        let command = self.controller.step(measurement);
        self.assert_allowed(&command);
        self.laps.extend(command.status.finished);
        self.plant.apply(command.input, self.period());
        self.steps += 1;
        self.widest = self.widest.max(self.plant.truth().e_y.abs());
        command
    }

    /// Drives until `count` laps of this kind are finished.
    ///
    /// # Panics
    /// If a lap does not end.
    pub fn until(&mut self, kind: LapKind, count: usize) {
        let mut since_lap = 0;
        while self.of_kind(kind).count() < count {
            let before = self.laps.len();
            self.step();
            since_lap = if self.laps.len() > before { 0 } else { since_lap + 1 };
            assert!(since_lap < LONGEST_LAP, "no lap: {:?}", self.plant.truth());
        }
    }

    /// Drives until a step does this.
    ///
    /// # Panics
    /// If none does within the longest lap.
    pub fn until_action(&mut self, action: Action) -> Command {
        for _ in 0..LONGEST_LAP {
            let command = self.step();
            if command.status.action == action {
                return command;
            }
        }
        unreachable!("no {action:?} from {:?}", self.plant.truth())
    }

    /// Finished laps of one kind.
    pub fn of_kind(&self, kind: LapKind) -> impl Iterator<Item = &LapResult> {
        self.laps.iter().filter(move |lap| lap.kind == kind)
    }

    /// Times of the learning laps \[s\].
    #[must_use]
    pub fn lap_times(&self) -> Vec<f64> {
        self.of_kind(LapKind::Learning).map(|lap| lap.lap_time).collect()
    }

    /// Every command is finite and inside the car's limits.
    ///
    /// # Panics
    /// If it is not.
    pub fn assert_allowed(&self, command: &Command) {
        let (car, u) = (self.controller.car(), command.input);
        assert!(u.is_finite(), "{command:?}");
        assert!((car.a_min..=car.a_max).contains(&u.a), "{command:?}");
        assert!(u.delta.abs() <= car.delta_max, "{command:?}");
    }

    fn period(&self) -> f64 {
        self.controller.config().horizon.period
    }
}
