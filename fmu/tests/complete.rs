//! The descriptions leave nothing out.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use fmu_core::{ControllerFmu, FmuModel, Role, VariableType, VehicleFmu};

fn check<M: FmuModel>() {
    for v in M::description().table.variables() {
        assert!(!v.description.is_empty(), "{}: no description", v.name);
        if v.role == Role::Time || !matches!(v.kind, VariableType::Real | VariableType::Integer) {
            continue;
        }
        assert_eq!(v.unit.is_some(), v.kind == VariableType::Real, "{}: unit", v.name);
        let range = v.min.unwrap()..=v.max.unwrap();
        assert!(range.contains(&v.start), "{}: start {} not in {range:?}", v.name, v.start);
    }
}

#[test]
fn every_number_has_a_unit_a_range_and_a_start_within_it() {
    check::<ControllerFmu>();
    check::<VehicleFmu>();
}
