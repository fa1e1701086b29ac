//! The two models that ship: the controller and the car.

mod controller;
mod vehicle;

pub use controller::{ControllerFmu, ControllerFmuState};
pub use vehicle::{VehicleFmu, VehicleState};
