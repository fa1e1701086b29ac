//! Parameter values: those built into the wired system and those of each car, as files (SSV).

use controller::{Config, Preset};

use super::{NAMES, Ssp};
use crate::description::Description;
use crate::table::Table;
use crate::variable::Kind;
use crate::xml::{Xml, number};

/// Cars with a parameter set, and a track that fits the car's size.
pub(crate) const CARS: [(&str, &str); 3] =
    [("barc", "l"), ("kart", "road_course"), ("iac", "road_course")];

/// A parameter's value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
}

/// The parameters a user of the wired system is most likely to change, with their start values.
pub(super) fn built_in(d: &Description) -> Vec<(String, Value)> {
    let wanted = ["param.track", "initial.v_x", "initial.e_y"];
    let chosen = d.table.variables().iter().filter(|v| wanted.contains(&v.name.as_str()));
    chosen.map(|v| (v.name.clone(), start(&d.table, &v.name))).collect()
}

fn start(table: &Table, name: &str) -> Value {
    let variable = table.variables().iter().find(|v| v.name == name);
    match variable.filter(|v| v.kind == Kind::Text) {
        Some(text) => Value::Text(text.text.clone()),
        None => Value::Number(variable.map_or(0.0, |v| v.start)),
    }
}

/// Settings of a car as the FMU's preset `race` takes them.
fn settings(car: &str) -> Config {
    let shipped = Config::of_car(car).and_then(|text| Config::from_toml(text).ok());
    shipped.unwrap_or_else(|| Config::preset(Preset::Race))
}

/// `<car>.ssv`: what both FMUs need to be told for a car, named as in the wired system.
pub(crate) fn parameter_set(ssp: Ssp, car: &str, track: &str) -> String {
    let [controller, vehicle] = NAMES;
    let text =
        |of: &str, name: &str, text: &str| (format!("{of}.{name}"), Value::Text(text.to_owned()));
    let speed = Value::Number(settings(car).warm_up.speed);
    let values = [
        text(controller, "param.car", car),
        text(controller, "param.track", track),
        text(vehicle, "param.car", car),
        text(vehicle, "param.track", track),
        (format!("{vehicle}.initial.v_x"), speed),
    ];
    let mut xml = Xml::new();
    let space = ("xmlns:ssv", ssp.namespace("ParameterValues"));
    let common = ("xmlns:ssc", ssp.namespace("Common"));
    write(&mut xml, ssp, &[space, common], car, &values);
    xml.finish()
}

/// A parameter set; its namespaces are declared here or around it.
pub(super) fn write(
    xml: &mut Xml,
    ssp: Ssp,
    namespaces: &[(&'static str, String)],
    name: &str,
    values: &[(String, Value)],
) {
    let mut attributes = namespaces.to_vec();
    attributes.push(("version", ssp.version().to_owned()));
    attributes.push(("name", name.to_owned()));
    xml.open("ssv:ParameterSet", &attributes);
    xml.open("ssv:Parameters", &[]);
    for (name, value) in values {
        xml.open("ssv:Parameter", &[("name", name.clone())]);
        match value {
            Value::Number(value) => xml.leaf(ssp.real("ssv"), &[("value", number(*value))]),
            Value::Text(value) => xml.leaf("ssv:String", &[("value", value.clone())]),
        }
        xml.close("ssv:Parameter");
    }
    xml.close("ssv:Parameters");
    xml.close("ssv:ParameterSet");
}
