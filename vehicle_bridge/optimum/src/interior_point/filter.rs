//! The filter of the line search: pairs of infeasibility and barrier value that no later iterate
//! may be worse than in both (Waechter and Biegler 2006, sec. 2.3).

/// Shares by which an iterate must improve.
const MARGIN: f64 = 1e-5;
/// Exponents and factor of the switching condition.
const ON_INFEASIBILITY: f64 = 1.1;
const ON_COST: f64 = 2.3;
/// Share of the predicted decrease that is asked for.
const ARMIJO: f64 = 1e-4;

/// Infeasibility and barrier value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) infeasibility: f64,
    pub(crate) barrier: f64,
}

/// The filter of one barrier parameter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Filter {
    corners: Vec<Point>,
    /// Infeasibility that no iterate may reach, and the one below which the cost decides.
    most: f64,
    little: f64,
}

/// Whether a trial point is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Refused,
    /// For its lower barrier value.
    ByCost,
    /// For lower infeasibility or barrier value; the filter grows.
    ByFilter,
}

impl Filter {
    /// An empty filter for a run that begins with this infeasibility.
    pub(crate) fn new(infeasibility: f64) -> Self {
        let start = infeasibility.max(1.0);
        Self { corners: Vec::new(), most: 1e4 * start, little: 1e-4 * start }
    }

    /// Forgets all corners.
    pub(crate) fn clear(&mut self) {
        self.corners.clear();
    }

    /// Whether no corner is better in both.
    pub(crate) fn admits(&self, trial: &Point) -> bool {
        trial.infeasibility < self.most
            && trial.barrier.is_finite()
            && self.corners.iter().all(|corner| {
                trial.infeasibility < corner.infeasibility || trial.barrier < corner.barrier
            })
    }

    /// Judges a trial point at `length` along a step whose barrier slope is `slope`.
    pub(crate) fn judge(&self, from: &Point, trial: &Point, slope: f64, length: f64) -> Verdict {
        if !self.admits(trial) {
            return Verdict::Refused;
        }
        // Rounding of the barrier value must not refuse steps near the solution.
        let rounding = 10.0 * f64::EPSILON * from.barrier.abs();
        let gains = slope < 0.0
            && length * (-slope).powf(ON_COST) > from.infeasibility.powf(ON_INFEASIBILITY);
        if gains && from.infeasibility <= self.little {
            let enough = trial.barrier - from.barrier - rounding <= ARMIJO * length * slope;
            return if enough { Verdict::ByCost } else { Verdict::Refused };
        }
        let better = trial.infeasibility <= (1.0 - MARGIN) * from.infeasibility
            || trial.barrier - rounding <= from.barrier - MARGIN * from.infeasibility;
        if better { Verdict::ByFilter } else { Verdict::Refused }
    }

    /// Adds the corner of an iterate that is left.
    pub(crate) fn add(&mut self, point: &Point) {
        self.corners.push(Point {
            infeasibility: (1.0 - MARGIN) * point.infeasibility,
            barrier: point.barrier - MARGIN * point.infeasibility,
        });
    }

    /// Least length worth trying along a step.
    pub(crate) fn shortest(&self, from: &Point, slope: f64) -> f64 {
        let mut least = MARGIN;
        if slope < 0.0 {
            least = least.min(MARGIN * from.infeasibility / -slope);
            if from.infeasibility <= self.little {
                least =
                    least.min(from.infeasibility.powf(ON_INFEASIBILITY) / (-slope).powf(ON_COST));
            }
        }
        (0.05 * least).max(1e-10)
    }
}
