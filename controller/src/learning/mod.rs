//! What is learned from the car's own laps: data, safe set, error model, grip.

pub(crate) mod bends;
pub(crate) mod braking;
pub mod dataset;
pub(crate) mod envelope;
pub(crate) mod grip;
pub(crate) mod grip_sums;
pub mod inverse;
pub mod regression;
mod ridge;
pub(crate) mod road_speed;
pub mod safe_set;
pub(crate) mod speed_limit;
