//! Everything the controller carries from one step to the next.

use std::collections::VecDeque;
use std::sync::Arc;

use actuators::Estimation;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State, Track};

use crate::actuation::Drift;
use crate::config::Config;
use crate::filter::Estimate;
use crate::filter::Smoothing;
use crate::lap_end::{Derived, LapEnd};
use crate::lap_number::LapNumber;
use crate::learning::dataset::{Dataset, Lap};
use crate::learning::grip_sums::GripSums;
use crate::plan::Plan;
use crate::prediction_error::PredictionError;
use crate::recovery::Recovery;
use crate::road::Road;
use crate::status::LapKind;

/// State of the controller: cloning it is cheap however much was learned, as laps are shared.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Memory {
    pub(crate) dataset: Dataset,
    /// Fitted factors on front and rear mu.
    pub(crate) grip: [f64; 2],
    /// What noisy measurements say of the grip.
    pub(crate) grip_sums: GripSums,
    /// What the road has of that grip now.
    pub(crate) road: Road,
    /// Number of the lap in progress; 0 before the line is first crossed.
    pub(crate) lap: LapNumber,
    /// Whether the lap in progress is a learning lap.
    pub(crate) learning: bool,
    /// The initial laps have been learned from; until then the car goes on as in them.
    pub(crate) learned: bool,
    /// Learning laps completed.
    pub(crate) learned_laps: u32,
    /// Last measurement believed.
    pub(crate) last: Option<Last>,
    /// What the filter knows.
    pub(crate) estimate: Estimate,
    /// How far the car was from where its plans expected it.
    pub(crate) prediction_error: PredictionError,
    /// Measurements in a row that were refused as jumps.
    pub(crate) suspects: u32,
    /// Delay and lag of the actuators, as the initial laps show them.
    pub(crate) actuation: Estimation,
    /// A change of the delay since.
    pub(crate) drift: Drift,
    /// Inputs that do not act yet, oldest first.
    pub(crate) queue: VecDeque<Input>,
    /// Last input decided on: where the last command leads the actuators.
    pub(crate) u_prev: Input,
    /// Last command.
    pub(crate) command: Input,
    /// Latest plan.
    pub(crate) plan: Plan,
    /// Whether the plan already starts at the coming measurement.
    pub(crate) shifted: bool,
    /// Steps since the plan was optimal.
    pub(crate) plan_age: u32,
    /// Where the terminal state is expected in the coming step.
    pub(crate) query_s: f64,
    /// Input that continues the plan.
    pub(crate) plan_tail: Input,
    /// Laps of the safe set, best first.
    pub(crate) selected: Vec<usize>,
    /// The last closed lap, while it is smoothed.
    pub(crate) smoothing: Option<Smoothing>,
    /// What closed laps still require.
    pub(crate) lap_end: LapEnd,
    /// A piece of it was done in this period.
    pub(crate) learned_piece: bool,
    /// Ridge weight that the noise of the data asks for.
    pub(crate) ridge: f64,
    /// The laps that were not driven by this controller.
    pub(crate) inherited: Inherited,
    /// The car has driven since the controller began.
    pub(crate) underway: bool,
    /// The way back to the line after an incident, while it lasts.
    pub(crate) recovery: Option<Recovery>,
    /// Noise of the initial laps.
    pub(crate) rng: Pcg64,
    /// Made of the rest at lap end.
    #[serde(skip)]
    pub(crate) derived: Derived,
}

/// The first laps of the data, if they were loaded or adopted.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct Inherited {
    /// Number of them.
    pub(crate) laps: usize,
    /// Ridge weight that their noise asks for while the regression uses any of them.
    pub(crate) ridge: f64,
}

/// A measurement that was believed.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Last {
    pub(crate) time: f64,
    pub(crate) state: State,
}

impl Memory {
    pub(crate) fn new(config: &Config) -> Self {
        let mut memory = Self {
            dataset: Dataset::default(),
            grip: [1.0; 2],
            grip_sums: GripSums::default(),
            road: Road::default(),
            lap: LapNumber::default(),
            learning: false,
            learned: false,
            learned_laps: 0,
            last: None,
            estimate: Estimate::default(),
            prediction_error: PredictionError::default(),
            suspects: 0,
            actuation: Estimation::default(),
            drift: Drift::default(),
            queue: VecDeque::with_capacity(config.delay.steps + 1),
            u_prev: Input::default(),
            command: Input::default(),
            plan: Plan::default(),
            shifted: false,
            plan_age: 0,
            query_s: 0.0,
            plan_tail: Input::default(),
            selected: Vec::with_capacity(config.safe_set.laps + 1),
            smoothing: None,
            lap_end: LapEnd::default(),
            learned_piece: false,
            ridge: 0.0,
            inherited: Inherited::default(),
            underway: false,
            recovery: None,
            rng: Pcg64::seed_from_u64(config.warm_up.seed),
            derived: Derived { made: true, ..Derived::default() },
        };
        memory.queue.resize(config.delay.steps, Input::default());
        memory.dataset.current.samples.reserve(4096);
        memory
    }

    /// Whether there is enough to learn from: `count` valid laps, or one that somebody drove.
    pub(crate) fn initial_laps_done(&self, count: usize) -> bool {
        let driven = |lap: &Arc<Lap>| lap.result.valid && lap.result.kind == LapKind::Driven;
        self.dataset.laps.iter().any(driven) || self.valid_laps() >= count
    }

    /// Smooths so many samples of the last closed lap; gives how many there were.
    pub(crate) fn smooth(&mut self, most: usize, track: &Track) -> usize {
        let Some(smoothing) = &mut self.smoothing else { return 0 };
        let done = smoothing.advance(most, track);
        if smoothing.done()
            && let (Some(smoothing), Some(lap)) =
                (self.smoothing.take(), self.dataset.laps.last_mut())
        {
            let (samples, steps) = smoothing.finish();
            *lap = Arc::new(Lap { samples, ..(**lap).clone() });
            self.estimate.spare = steps;
        }
        done
    }

    /// Valid initial laps so far.
    pub(crate) fn valid_laps(&self) -> usize {
        self.dataset.laps.iter().filter(|lap| lap.result.valid).count()
    }

    /// Speed that the envelope allows at s, or that of a lap which the envelope does not know yet \[m/s\].
    ///
    /// Behind the line such a lap went on from the end of one that the envelope knows. Without it each plan
    /// across the line would have to brake by what the speed grew from lap to lap.
    pub(crate) fn supported_speed(&self, s: f64, length: f64) -> f64 {
        let new = self.dataset.speed_since(self.lap_end.learned, s.rem_euclid(length), length);
        self.derived.envelope.at(s).max(new)
    }

    /// The plan no longer fits where the car is.
    pub(crate) fn drop_plan(&mut self) {
        self.plan.clear();
        self.plan_age = 0;
    }
}
