//! `runs.csv`: one line for each finished run.

use serde::{Deserialize, Serialize};

/// Key of a run.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TracksKey {
    /// Name of the car.
    pub car: String,
    /// Name of the track.
    pub track: String,
    /// The plant, as on the command line; `none` is the car as it is.
    pub plant: String,
    /// Seed.
    pub seed: u64,
    /// Fingerprint of everything that was set.
    pub settings: String,
}

/// One run. A column without a value is empty.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TracksRow {
    /// Name of the car.
    pub car: String,
    /// Name of the track.
    pub track: String,
    /// The plant.
    pub plant: String,
    /// Seed.
    pub seed: u64,
    /// Why the run failed, in one word; empty if it did not.
    pub failure: String,
    /// Learned laps finished.
    pub laps: u32,
    /// Fastest valid learned lap \[s\].
    pub best_lap_s: Option<f64>,
    /// Time of the optimal lap \[s\].
    pub optimum_s: Option<f64>,
    /// `best_lap_s` divided by `optimum_s`.
    pub ratio: Option<f64>,
    /// First learned lap within 5 % of the best.
    pub lap_within_5_percent: Option<u32>,
    /// Mean time of the warm-up laps \[s\].
    pub warm_up_lap_mean_s: Option<f64>,
    /// Greatest overhang of the body beyond an edge; negative is a distance kept \[m\].
    pub overhang_max_m: Option<f64>,
    /// Control steps.
    pub steps: u64,
    /// Steps in which a QP was given to a solver.
    pub solver_steps: u64,
    /// Of those, the steps that Clarabel solved.
    pub clarabel_steps: u64,
    /// Steps that fell back.
    pub fallbacks: u64,
    /// Steps whose input was cut to the car's limits.
    pub clipped: u64,
    /// Median processor time of the steps with a QP \[us\].
    pub step_median_us: Option<f64>,
    /// Processor time below which 99 % of the steps with a QP stay \[us\].
    pub step_p99_us: Option<f64>,
    /// Learned lap of the failure; 0 in a warm-up lap.
    pub fail_lap: Option<u32>,
    /// Time of the failure since the start \[s\].
    pub fail_time_s: Option<f64>,
    /// Where the car failed \[m\].
    pub fail_s_m: Option<f64>,
    /// Its speed there \[m/s\].
    pub fail_v_x_mps: Option<f64>,
    /// Its lateral deviation there \[m\].
    pub fail_e_y_m: Option<f64>,
    /// Its heading relative to the track there \[rad\].
    pub fail_e_psi_rad: Option<f64>,
    /// How far it was beyond the edge; negative inside \[m\].
    pub fail_beyond_m: Option<f64>,
    /// The failure in a sentence.
    pub fail_message: String,
    /// What the controller did in the last steps before it.
    pub fail_last_steps: String,
    /// Times of all learned laps, separated by spaces \[s\].
    pub lap_times_s: String,
    /// Fingerprint of everything that was set.
    pub settings: String,
}

impl TracksRow {
    /// A run that has not begun.
    #[must_use]
    pub fn new(key: &TracksKey) -> Self {
        Self {
            car: key.car.clone(),
            track: key.track.clone(),
            plant: key.plant.clone(),
            seed: key.seed,
            settings: key.settings.clone(),
            ..Self::default()
        }
    }

    /// Key of the run.
    #[must_use]
    pub fn key(&self) -> TracksKey {
        TracksKey {
            car: self.car.clone(),
            track: self.track.clone(),
            plant: self.plant.clone(),
            seed: self.seed,
            settings: self.settings.clone(),
        }
    }

    /// Measures the best lap against the optimum \[s\].
    pub fn rate(&mut self, optimum: Option<f64>) {
        self.optimum_s = optimum;
        self.ratio = self.best_lap_s.zip(optimum).map(|(best, optimum)| best / optimum);
    }

    /// Whether the run failed.
    #[must_use]
    pub fn failed(&self) -> bool {
        !self.failure.is_empty()
    }

    /// The run in a few words, for messages.
    #[must_use]
    pub fn title(&self) -> String {
        let plant = if self.plant == "none" { String::new() } else { format!(", {}", self.plant) };
        format!("{} on {}{plant}, seed {}", self.car, self.track, self.seed)
    }
}
