//! Everything the controller carries from one step to the next.

use std::collections::VecDeque;
use std::sync::Arc;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State};

use crate::config::Config;
use crate::delay::DelayTrial;
use crate::filter::Estimate;
use crate::learning::dataset::{Dataset, Lap};
use crate::learning::envelope::{Envelope, NearMiss};
use crate::learning::regression::RegressionData;
use crate::plan::Plan;
use crate::recovery::Recovery;
use crate::status::LapKind;

/// State of the controller: cloning it is cheap however much was learned, as laps are shared.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Memory {
    pub(crate) dataset: Dataset,
    /// Fitted factors on front and rear mu.
    pub(crate) grip: [f64; 2],
    /// Number of the lap in progress; 0 before the line is first crossed.
    pub(crate) lap: u32,
    /// Whether the lap in progress is a learning lap.
    pub(crate) learning: bool,
    /// The initial laps have been learned from.
    pub(crate) learned: bool,
    /// Learning laps completed.
    pub(crate) learned_laps: u32,
    /// Last measurement believed.
    pub(crate) last: Option<Last>,
    /// What the filter knows.
    pub(crate) estimate: Estimate,
    /// Measurements in a row that were refused as jumps.
    pub(crate) suspects: u32,
    /// Delay found in the initial laps.
    pub(crate) delay: DelayTrial,
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
    /// A lap was closed and has not been learned from.
    pub(crate) lap_due: bool,
    /// The car has driven since the controller began.
    pub(crate) underway: bool,
    /// The way back to the line after an incident, while it lasts.
    pub(crate) recovery: Option<Recovery>,
    /// Noise of the initial laps.
    pub(crate) rng: Pcg64,
    /// Made of the rest at lap end.
    #[serde(skip)]
    pub(crate) derived: Arc<Derived>,
}

/// What follows from the laps; made anew when they change.
#[derive(Debug, Clone, Default)]
pub(crate) struct Derived {
    /// Laps of the safe set.
    pub(crate) selected: Vec<usize>,
    pub(crate) regression: RegressionData,
    pub(crate) envelope: Envelope,
    /// Near misses of the latest laps.
    pub(crate) near_misses: Vec<NearMiss>,
    /// Laps that were searched for them.
    pub(crate) searched: usize,
    /// Grip with which their residuals were computed.
    pub(crate) grip: [f64; 2],
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
            lap: 0,
            learning: false,
            learned: false,
            learned_laps: 0,
            last: None,
            estimate: Estimate::default(),
            suspects: 0,
            delay: DelayTrial::default(),
            queue: VecDeque::with_capacity(config.delay.steps + 1),
            u_prev: Input::default(),
            command: Input::default(),
            plan: Plan::default(),
            shifted: false,
            plan_age: 0,
            query_s: 0.0,
            plan_tail: Input::default(),
            lap_due: false,
            underway: false,
            recovery: None,
            rng: Pcg64::seed_from_u64(config.warm_up.seed),
            derived: Arc::default(),
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

    /// Valid initial laps so far.
    pub(crate) fn valid_laps(&self) -> usize {
        self.dataset.laps.iter().filter(|lap| lap.result.valid).count()
    }

    /// The plan no longer fits where the car is.
    pub(crate) fn drop_plan(&mut self) {
        self.plan.clear();
        self.plan_age = 0;
    }
}
