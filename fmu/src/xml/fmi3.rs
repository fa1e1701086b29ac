//! `modelDescription.xml` of FMI 3.0.

use super::{Xml, default_experiment, log_categories, number, role, unit_definitions};
use crate::description::Description;
use crate::variable::{Role, Variable, VariableType};

pub(crate) fn model_description(d: &Description, token: &str) -> String {
    let mut xml = Xml::new();
    let on = || "true".to_owned();
    xml.open(
        "fmiModelDescription",
        &[
            ("fmiVersion", "3.0".to_owned()),
            ("modelName", d.model_name.to_owned()),
            ("instantiationToken", token.to_owned()),
            ("description", d.description.to_owned()),
            ("version", d.version.to_owned()),
            ("license", env!("CARGO_PKG_LICENSE").to_owned()),
            ("generationTool", format!("fmu_core {}", env!("CARGO_PKG_VERSION"))),
            ("variableNamingConvention", "structured".to_owned()),
        ],
    );
    xml.leaf(
        "CoSimulation",
        &[
            ("modelIdentifier", d.model_identifier.to_owned()),
            ("canHandleVariableCommunicationStepSize", on()),
            ("canGetAndSetFMUState", on()),
            ("canSerializeFMUState", on()),
        ],
    );
    unit_definitions(&mut xml, d);
    log_categories(&mut xml);
    default_experiment(&mut xml, d);
    xml.open("ModelVariables", &[]);
    for (reference, v) in d.table.variables().iter().enumerate() {
        variable(&mut xml, reference, v);
    }
    xml.close("ModelVariables");
    model_structure(&mut xml, d);
    xml.close("fmiModelDescription");
    xml.finish()
}

fn variable(xml: &mut Xml, reference: usize, v: &Variable) {
    let mut attributes = vec![
        ("name", v.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", v.description.clone()),
    ];
    // Only Float64 may be continuous, and it is so by default.
    attributes.extend(role(v.role));
    let limit = |x: Option<f64>| match (x, v.kind) {
        (None, _) => String::new(),
        (Some(x), VariableType::Integer) => format!("{x}"),
        (Some(x), _) => number(x),
    };
    let (name, start) = match v.kind {
        VariableType::Real => ("Float64", number(v.start)),
        VariableType::Integer => ("Int32", format!("{}", v.start)),
        VariableType::Boolean => ("Boolean", (v.start != 0.0).to_string()),
        VariableType::Text => ("String", String::new()),
    };
    if v.kind == VariableType::Real {
        attributes.push(("unit", v.unit.map_or("", |u| u.name).to_owned()));
    }
    if matches!(v.kind, VariableType::Real | VariableType::Integer) {
        attributes.push(("min", limit(v.min)));
        attributes.push(("max", limit(v.max)));
    }
    if v.kind == VariableType::Real {
        attributes.push(("nominal", limit(v.nominal)));
    }
    if v.role.settable() {
        attributes.push(("start", start));
    }
    if v.kind != VariableType::Text {
        xml.leaf(name, &attributes);
    } else {
        xml.open(name, &attributes);
        xml.text_start(&v.text);
        xml.close(name);
    }
}

/// Outputs never follow inputs within one instant: they change in a step. At initialisation
/// they follow from the parameters.
fn model_structure(xml: &mut Xml, d: &Description) {
    let of = |wanted: fn(Role) -> bool| {
        let variables = d.table.variables().iter().enumerate();
        let chosen = variables.filter(|(_, v)| wanted(v.role)).map(|(i, _)| i.to_string());
        chosen.collect::<Vec<String>>()
    };
    let (outputs, parameters) = (of(Role::output), of(Role::parameter));
    xml.open("ModelStructure", &[]);
    for output in &outputs {
        xml.raw(&format!("<Output valueReference=\"{output}\" dependencies=\"\"/>"));
    }
    for output in &outputs {
        let dependencies = ("dependencies", parameters.join(" "));
        xml.leaf("InitialUnknown", &[("valueReference", output.clone()), dependencies]);
    }
    xml.close("ModelStructure");
}
