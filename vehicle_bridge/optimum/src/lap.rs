//! The result.

use vehicle_model::{Input, State};

/// A time-optimal lap.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// Lap time \[s\].
    pub lap_time: f64,
    /// Points along the lap in the order of driving; the first is repeated at the end, one lap
    /// and one lap time later.
    pub points: Vec<LapPoint>,
    /// How good it is.
    pub quality: Quality,
}

/// A point of the lap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LapPoint {
    /// Time since the line \[s\].
    pub time: f64,
    /// State of the car.
    pub x: State,
    /// Inputs that act; those of a car with slow actuators are their positions. Linear in s
    /// between points.
    pub u: Input,
}

/// How good a solution is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Largest deviation of the plant from the next point when it drives each interval from its
    /// first point, of v_x, v_y, omega_z, e_psi, s and e_y in their units.
    pub defect: [f64; 6],
    /// The largest of them, each divided by the typical size of its quantity.
    pub scaled_defect: f64,
    /// Violation of the scaled optimality conditions.
    pub optimality: f64,
    /// Intervals of the mesh.
    pub intervals: usize,
    /// Starts that converged.
    pub converged: usize,
    /// Starts tried.
    pub starts: usize,
    /// Lap time of the worst start that converged, on the first mesh \[s\].
    pub slowest_start: f64,
}
