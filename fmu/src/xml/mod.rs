//! Model descriptions, written from the same table that drives get and set.

pub(crate) mod fmi2;
pub(crate) mod fmi3;
pub(crate) mod terminals;
mod writer;

pub(crate) use writer::{Attribute, Xml, number};

use std::collections::BTreeMap;

use crate::description::Description;
use crate::log::CATEGORIES;
use crate::unit::Unit;
use crate::variable::Role;

/// Units used by the table, by name.
pub(crate) fn units(description: &Description) -> BTreeMap<&'static str, Unit> {
    let variables = description.table.variables().iter();
    variables.filter_map(|v| v.unit).map(|u| (u.name, u)).collect()
}

fn unit_definitions(xml: &mut Xml, description: &Description) {
    xml.open("UnitDefinitions", &[]);
    for unit in units(description).values() {
        unit_definition(xml, unit, ["Unit", "BaseUnit"]);
    }
    xml.close("UnitDefinitions");
}

/// One unit; `names` are those of its element and of the one within.
pub(crate) fn unit_definition(xml: &mut Xml, unit: &Unit, names: [&str; 2]) {
    xml.open(names[0], &[("name", unit.name.to_owned())]);
    let mut attributes = Vec::new();
    for (name, exponent) in [("kg", unit.kg), ("m", unit.m), ("s", unit.s), ("rad", unit.rad)] {
        if exponent != 0 {
            attributes.push((name, exponent.to_string()));
        }
    }
    if unit.factor != 1.0 {
        attributes.push(("factor", number(unit.factor)));
    }
    xml.leaf(names[1], &attributes);
    xml.close(names[0]);
}

fn log_categories(xml: &mut Xml) {
    xml.open("LogCategories", &[]);
    for (name, text) in CATEGORIES {
        xml.leaf("Category", &[("name", name.to_owned()), ("description", text.to_owned())]);
    }
    xml.close("LogCategories");
}

fn default_experiment(xml: &mut Xml, description: &Description) {
    xml.leaf(
        "DefaultExperiment",
        &[
            ("startTime", number(0.0)),
            ("stopTime", number(description.stop_time)),
            ("stepSize", number(description.step_size)),
        ],
    );
}

/// Causality, variability and initial, equal in both versions.
fn role(role: Role) -> [(&'static str, String); 3] {
    let (causality, variability, initial) = match role {
        Role::Time => ("independent", "continuous", ""),
        Role::Fixed => ("parameter", "fixed", "exact"),
        Role::Tunable => ("parameter", "tunable", "exact"),
        Role::Input => ("input", "continuous", ""),
        Role::Discrete => ("output", "discrete", "calculated"),
        Role::Output => ("output", "continuous", "calculated"),
    };
    [
        ("causality", causality.to_owned()),
        ("variability", variability.to_owned()),
        ("initial", initial.to_owned()),
    ]
}
