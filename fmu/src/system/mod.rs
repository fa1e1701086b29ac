//! Controller and vehicle wired to each other: as SSP and as OSP system structure.
//!
//! Both FMUs name the signals between them alike, so every connection is from a name to itself.

mod osp;
mod parameters;
mod ssd;

pub(crate) use osp::osp_structure;
pub(crate) use parameters::{Element, SETS, ssv};
pub(crate) use ssd::{Ssp, ssd};

use crate::controller::ControllerFmu;
use crate::description::Description;
use crate::model::FmuModel;
use crate::variable::Role;
use crate::vehicle::VehicleFmu;

/// Communication step of the system in parallel exchange [s]. Each exchange delays a signal by
/// one step, so it is a tenth of the controller's period.
const STEP: f64 = 0.01;
const STOP: f64 = 60.0;
const NAMES: [&str; 2] = ["controller", "vehicle"];

/// Inputs of one model that the other one has as outputs.
fn wires(from: &Description, to: &Description) -> Vec<String> {
    let outputs = from.table.variables().iter().filter(|v| v.role.output());
    let outputs: Vec<&str> = outputs.map(|v| v.name.as_str()).collect();
    let inputs = to.table.variables().iter().filter(|v| v.role == Role::Input);
    inputs.map(|v| v.name.clone()).filter(|name| outputs.contains(&name.as_str())).collect()
}

/// From, to, and what is connected between them.
fn connections() -> [(&'static str, &'static str, Vec<String>); 2] {
    let (controller, vehicle) = (ControllerFmu::description(), VehicleFmu::description());
    let [c, v] = NAMES;
    [(c, v, wires(controller, vehicle)), (v, c, wires(vehicle, controller))]
}
