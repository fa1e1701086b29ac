//! The predicted trajectory, and z_bar: the last solution shifted by one period, along which the next problem is
//! linearised.
//!
//! ```text
//! z_bar_t = (x*_{t+1}, u*_{t+1})      t = 0..N-2
//! u_bar_{N-1} = X_u lambda*           the inputs of the safe-set points, weighted as their states
//! x_bar_N     = f(x*_N, u_bar_{N-1})
//! ```

use serde::{Deserialize, Serialize};
use vehicle_model::{Input, State};

/// States x_0..x_N and inputs u_0..u_{N-1}; s continues past the line.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Plan {
    /// States, N + 1; empty if there is no plan.
    pub x: Vec<State>,
    /// Inputs, N.
    pub u: Vec<Input>,
}

impl Plan {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Room for `steps` inputs.
    pub(crate) fn with_capacity(steps: usize) -> Self {
        Self { x: Vec::with_capacity(steps + 1), u: Vec::with_capacity(steps) }
    }

    pub(crate) fn clear(&mut self) {
        self.x.clear();
        self.u.clear();
    }

    /// Moves the plan by one period; `extend` gives the new last state.
    pub(crate) fn shift(&mut self, last: Input, extend: impl FnOnce(&State, &Input) -> State) {
        let Some(end) = self.x.last().copied() else { return };
        self.x.rotate_left(1);
        self.u.rotate_left(1);
        let n = self.u.len();
        self.u[n - 1] = last;
        self.x[n] = extend(&end, &last);
    }

    /// Moves the frame by one lap as the car crosses the line.
    pub(crate) fn cross_line(&mut self, length: f64) {
        for x in &mut self.x {
            x.s -= length;
        }
    }
}
