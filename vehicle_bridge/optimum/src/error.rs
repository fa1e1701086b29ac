//! Why there is no time-optimal lap.

use vehicle_model::ModelError;

/// Why no time-optimal lap was found.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The margin leaves no room between the edges.
    #[error(
        "at s = {s:.2} m the track is {width:.3} m wide, which leaves nothing between two margins \
         of {margin:.3} m; choose a smaller margin"
    )]
    TooNarrow {
        /// Where \[m\].
        s: f64,
        /// Distance from edge to edge there \[m\].
        width: f64,
        /// Distance to keep from each edge \[m\].
        margin: f64,
    },
    /// The car's parameters are out of range.
    #[error("the car cannot be used")]
    Car(#[source] ModelError),
    /// An option is out of range.
    #[error("{name} is {found}; expected {expected}")]
    Option {
        /// Which.
        name: &'static str,
        /// Its value.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// No start led to a solution.
    #[error(
        "none of {starts} starts converged; the best one still violates the optimality conditions \
         by {error:.1e} (expected at most {tolerance:.0e}) at a lap time of {lap_time:.3} s. The \
         car may be unable to follow the track: compare the tightest radius with what it steers"
    )]
    NotConverged {
        /// Number of starts.
        starts: usize,
        /// Violation of the scaled optimality conditions where the best start ended.
        error: f64,
        /// What was to be reached.
        tolerance: f64,
        /// Lap time there, of no meaning beyond diagnosis \[s\].
        lap_time: f64,
    },
    /// The plant does not confirm the solution.
    #[error(
        "driven by the simulated car, the solution deviates by {defect:.1e} (scaled) at s = {s:.2} \
         m; expected at most {tolerance:.0e}. Allow a finer mesh"
    )]
    Defect {
        /// Largest scaled deviation over an interval.
        defect: f64,
        /// Where the interval begins \[m\].
        s: f64,
        /// What was to be reached.
        tolerance: f64,
    },
}
