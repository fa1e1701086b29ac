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

/// Replaces the filtered states of a lap's last samples, those that `steps` follow without a gap, by
/// smoothed ones. `steps` may reach one measurement past the lap's end.
pub(crate) fn smooth(samples: &mut [Sample], steps: &[Step], track: &Track) {
    let mut ahead: Option<(&Step, Vector6<f64>)> = None;
    let mut at = samples.len();
    for step in steps.iter().rev() {
        let mut x = step.x.to_vector();
        if let Some((next, correction)) = ahead {
            let Some(factor) = Matrix6::from(next.p_predicted).cholesky() else { return };
            let gain = factor.solve(&(Matrix6::from(next.a) * Matrix6::from(step.p))).transpose();
            x += gain * correction;
        }
        let smoothed = State::from_vector(&x);
        if !smoothed.is_finite() {
            return;
        }
        ahead = Some((step, difference(&smoothed, &Vector6::from(step.predicted), track)));
        // The measurement past the end is no sample of this lap.
        let own = at.checked_sub(1).filter(|i| samples[*i].x == step.x);
        let Some(i) = own else { if at == samples.len() { continue } else { return } };
        if let Some(before) = i.checked_sub(1)
            && samples[before].next.is_some()
        {
            samples[before].next = Some([smoothed.v_x, smoothed.v_y, smoothed.omega_z]);
        }
        let least = if i > 0 { 0.0 } else { samples[i].x.s.min(0.0) };
        let most = track.length() * (1.0 - 1e-12);
        samples[i].x = State { s: smoothed.s.clamp(least, most), ..smoothed };
        at = i;
    }
}
