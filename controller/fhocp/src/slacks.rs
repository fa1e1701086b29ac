//! Slacks of the soft constraints, recovered from a trajectory.

use super::{Fhocp, Solution};

/// The least slack each soft constraint needs, by stage.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slacks {
    /// Lane, stages 1..N \[m\].
    pub lane: Vec<f64>,
    /// Front slip guard, stages 0..N-1 \[rad\].
    pub front: Vec<f64>,
    /// Rear slip guard, stages 1..N \[rad\].
    pub rear: Vec<f64>,
    /// Speed cap, stages 1..N [m/s].
    pub speed: Vec<f64>,
}

impl Slacks {
    /// The slacks of `solution`.
    #[must_use]
    pub fn of(problem: &Fhocp, solution: &Solution) -> Self {
        let mut slacks = Self::default();
        slacks.fill(problem, solution);
        slacks
    }

    /// The same into existing memory.
    pub fn fill(&mut self, problem: &Fhocp, solution: &Solution) {
        self.lane.clear();
        self.front.clear();
        self.rear.clear();
        self.speed.clear();
        for t in 0..problem.horizon() {
            let (x, next) = (&solution.x[t], &solution.x[t + 1]);
            let delta = solution.u[t][1];
            let e_y = next[5] + problem.lane_heading[t] * next[3];
            self.lane.push((problem.e_y_min[t] - e_y).max(e_y - problem.e_y_max[t]).max(0.0));
            let front_max = problem.front_max * problem.front_share[t];
            self.front.push((problem.front[t].angle(x, delta).abs() - front_max).max(0.0));
            let rear_max = problem.rear_max * problem.rear_share[t];
            self.rear.push((problem.rear[t].angle(next, 0.0).abs() - rear_max).max(0.0));
            self.speed.push((next[0] - problem.speed_max[t]).max(0.0));
        }
    }
}

/// Greatest entry, 0 if there is none.
#[must_use]
pub fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}
