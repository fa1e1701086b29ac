//! What is asked for.

/// How the time-optimal lap is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Distance the centre of gravity keeps from either edge \[m\].
    pub margin: f64,
    /// Largest scaled deviation of the plant from the solution over an interval.
    pub defect: f64,
    /// Starts that are tried, 1 to [`Options::MOST_STARTS`].
    pub starts: usize,
    /// Most intervals of the mesh.
    pub intervals: usize,
    /// Most steps of one solution.
    pub steps: usize,
}

impl Options {
    /// Number of different starts there are.
    pub const MOST_STARTS: usize = 4;

    /// The usual options with this margin \[m\].
    #[must_use]
    pub fn new(margin: f64) -> Self {
        Self { margin, defect: 1e-4, starts: 3, intervals: 8000, steps: 400 }
    }
}

/// What has been done so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SolveProgress {
    /// A start has been solved on the first mesh.
    Start {
        /// Which, from 0.
        index: usize,
        /// Steps it took.
        steps: usize,
        /// Its lap time; `None` if it did not converge \[s\].
        lap_time: Option<f64>,
    },
    /// The best one has been solved on a finer mesh.
    Refined {
        /// Intervals of the mesh.
        intervals: usize,
        /// Steps it took.
        steps: usize,
        /// Lap time \[s\].
        lap_time: f64,
        /// Largest scaled deviation over an interval.
        defect: f64,
    },
}
