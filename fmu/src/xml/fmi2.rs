//! `modelDescription.xml` of FMI 2.0.

use super::{Xml, default_experiment, log_categories, number, role, unit_definitions};
use crate::description::Description;
use crate::variable::{Variable, VariableType};

pub(crate) fn model_description(d: &Description, token: &str) -> String {
    let mut xml = Xml::new();
    let on = || "true".to_owned();
    xml.open(
        "fmiModelDescription",
        &[
            ("fmiVersion", "2.0".to_owned()),
            ("modelName", d.model_name.to_owned()),
            ("guid", token.to_owned()),
            ("description", d.description.to_owned()),
            ("version", d.version.to_owned()),
            ("license", env!("CARGO_PKG_LICENSE").to_owned()),
            ("generationTool", format!("fmu_core {}", env!("CARGO_PKG_VERSION"))),
            ("variableNamingConvention", "structured".to_owned()),
            ("numberOfEventIndicators", "0".to_owned()),
        ],
    );
    xml.leaf(
        "CoSimulation",
        &[
            ("modelIdentifier", d.model_identifier.to_owned()),
            ("canHandleVariableCommunicationStepSize", on()),
            ("canNotUseMemoryManagementFunctions", on()),
            ("canGetAndSetFMUstate", on()),
            ("canSerializeFMUstate", on()),
        ],
    );
    unit_definitions(&mut xml, d);
    log_categories(&mut xml);
    default_experiment(&mut xml, d);
    xml.open("ModelVariables", &[]);
    for (reference, variable) in d.table.variables().iter().enumerate() {
        scalar_variable(&mut xml, reference, variable);
    }
    xml.close("ModelVariables");
    model_structure(&mut xml, d);
    xml.close("fmiModelDescription");
    xml.finish()
}

fn scalar_variable(xml: &mut Xml, reference: usize, variable: &Variable) {
    let mut attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", variable.description.clone()),
    ];
    attributes.extend(role(variable.role));
    let settable = variable.role.settable();
    let limit = |x: Option<f64>| match (x, variable.kind) {
        (None, _) => String::new(),
        (Some(x), VariableType::Integer) => format!("{x}"),
        (Some(x), _) => number(x),
    };
    let (name, start) = match variable.kind {
        VariableType::Real => ("Real", number(variable.start)),
        VariableType::Integer => ("Integer", format!("{}", variable.start)),
        VariableType::Boolean => ("Boolean", (variable.start != 0.0).to_string()),
        VariableType::Text => ("String", variable.text.clone()),
    };
    let mut value = Vec::new();
    if variable.kind == VariableType::Real {
        value.push(("unit", variable.unit.map_or("", |u| u.name).to_owned()));
    }
    if matches!(variable.kind, VariableType::Real | VariableType::Integer) {
        value.push(("min", limit(variable.min)));
        value.push(("max", limit(variable.max)));
    }
    if variable.kind == VariableType::Real {
        value.push(("nominal", limit(variable.nominal)));
    }
    xml.open("ScalarVariable", &attributes);
    match (settable, variable.kind) {
        // An empty text is a start value too, so it cannot be left out.
        (true, VariableType::Text) if start.is_empty() => xml.raw("<String start=\"\"/>"),
        (true, _) => {
            value.push(("start", start));
            xml.leaf(name, &value);
        }
        (false, _) => xml.leaf(name, &value),
    }
    xml.close("ScalarVariable");
}

/// Outputs never follow inputs within one instant: they change in a step. At initialisation
/// they follow from the parameters.
fn model_structure(xml: &mut Xml, d: &Description) {
    let variables = d.table.variables().iter().enumerate();
    // Indices into ModelVariables count from one.
    let index = |(i, _): (usize, &Variable)| (i + 1).to_string();
    let outputs: Vec<String> =
        variables.clone().filter(|(_, v)| v.role.output()).map(index).collect();
    let parameters: Vec<String> =
        variables.filter(|(_, v)| v.role.parameter()).map(index).collect();
    xml.open("ModelStructure", &[]);
    xml.open("Outputs", &[]);
    for output in &outputs {
        xml.raw(&format!("<Unknown index=\"{output}\" dependencies=\"\"/>"));
    }
    xml.close("Outputs");
    xml.open("InitialUnknowns", &[]);
    for output in &outputs {
        xml.leaf("Unknown", &[("index", output.clone()), ("dependencies", parameters.join(" "))]);
    }
    xml.close("InitialUnknowns");
    xml.close("ModelStructure");
}
