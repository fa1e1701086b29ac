//! Smoothing of a closed lap (Rauch, Tung, Striebel), so that what is learned uses what came after.
//!
//! ```text
//! C = P_k A' (P^-_{k+1})^-1          x^s_k = x_k + C (x^s_{k+1} - x^-_{k+1})
//! ```

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};
use vehicle_model::{State, Track};

use super::{Prediction, difference};
use crate::learning::dataset::Sample;

/// What the filter did at a measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Step {
    /// A of the period before.
    a: [[f64; 6]; 6],
    /// x^-.
    predicted: [f64; 6],
    /// P^-.
    p_predicted: [[f64; 6]; 6],
    /// x.
    x: State,
    /// P.
    p: [[f64; 6]; 6],
}

impl Step {
    pub(super) fn new(
        prediction: &Prediction,
        p_predicted: &Matrix6<f64>,
        x: &State,
        p: &Matrix6<f64>,
    ) -> Self {
        Self {
            a: prediction.a.into(),
            predicted: prediction.next.into(),
            p_predicted: (*p_predicted).into(),
            x: *x,
            p: (*p).into(),
        }
    }
}

/// The smoothing of a closed lap, backward and in pieces: the filtered states of its last samples, those
/// that steps follow without a gap, are replaced by smoothed ones.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Smoothing {
    samples: Vec<Sample>,
    /// They may reach one measurement past the lap's end.
    steps: Vec<Step>,
    /// Steps, and samples, yet to be smoothed.
    left: usize,
    at: usize,
    /// Correction of the step behind those that are left, relative to its prediction.
    ahead: Option<[f64; 6]>,
}

impl Smoothing {
    /// Of a lap's samples.
    pub(crate) fn new(samples: Vec<Sample>, steps: Vec<Step>) -> Self {
        Self { left: steps.len(), at: samples.len(), samples, steps, ahead: None }
    }

    /// Whether nothing is left to do.
    pub(crate) fn done(&self) -> bool {
        self.left == 0
    }

    /// The smoothed samples, and the steps' memory, empty.
    pub(crate) fn finish(mut self) -> (Vec<Sample>, Vec<Step>) {
        self.steps.clear();
        (self.samples, self.steps)
    }

    /// Smooths so many steps more; gives how many there were.
    pub(crate) fn advance(&mut self, most: usize, track: &Track) -> usize {
        let count = most.min(self.left);
        for _ in 0..count {
            self.left -= 1;
            if self.smooth(track).is_none() {
                self.left = 0;
                break;
            }
        }
        count
    }

    /// Smooths the last step that is left; none where nothing before it can be.
    fn smooth(&mut self, track: &Track) -> Option<()> {
        let step = &self.steps[self.left];
        let mut x = step.x.to_vector();
        if let (Some(next), Some(correction)) = (self.steps.get(self.left + 1), self.ahead) {
            let factor = Matrix6::from(next.p_predicted).cholesky()?;
            let gain = factor.solve(&(Matrix6::from(next.a) * Matrix6::from(step.p))).transpose();
            x += gain * Vector6::from(correction);
        }
        let smoothed = State::from_vector(&x);
        if !smoothed.is_finite() {
            return None;
        }
        let correction = difference(&smoothed, &Vector6::from(step.predicted), track);
        self.ahead = Some(correction.into());
        let samples = &mut self.samples;
        // The measurement past the end is no sample of this lap.
        let Some(i) = self.at.checked_sub(1).filter(|i| samples[*i].x == step.x) else {
            return (self.at == samples.len()).then_some(());
        };
        if let Some(before) = i.checked_sub(1)
            && samples[before].next.is_some()
        {
            samples[before].next = Some([smoothed.v_x, smoothed.v_y, smoothed.omega_z]);
        }
        let least = if i > 0 { 0.0 } else { samples[i].x.s.min(0.0) };
        let most = track.length() * (1.0 - 1e-12);
        samples[i].x = State { s: smoothed.s.clamp(least, most), ..smoothed };
        self.at = i;
        Some(())
    }
}
