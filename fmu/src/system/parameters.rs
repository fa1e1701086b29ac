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
    let named = |of: &str, values: Vec<(String, Value)>| {
        values.into_iter().map(|(name, value)| (format!("{of}.{name}"), value)).collect::<Vec<_>>()
    };
    let values = [named(controller, names(car, track)), named(vehicle, of_vehicle(car, track))];
    document(ssp, car, &values.concat())
}

/// The parameter set of a car for the controller alone.
pub(crate) fn controller_parameters(ssp: Ssp, car: &str, track: &str) -> String {
    document(ssp, car, &names(car, track))
}

/// The parameter set of a car for the vehicle alone.
pub(crate) fn vehicle_parameters(ssp: Ssp, car: &str, track: &str) -> String {
    document(ssp, car, &of_vehicle(car, track))
}

fn names(car: &str, track: &str) -> Vec<(String, Value)> {
    let text = |name: &str, text: &str| (name.to_owned(), Value::Text(text.to_owned()));
    vec![text("param.car", car), text("param.track", track)]
}

/// With the speed at which the controller drives its initial laps.
fn of_vehicle(car: &str, track: &str) -> Vec<(String, Value)> {
    let speed = Value::Number(settings(car).warm_up.speed);
    [names(car, track), vec![("initial.v_x".to_owned(), speed)]].concat()
}

fn document(ssp: Ssp, name: &str, values: &[(String, Value)]) -> String {
    let mut xml = Xml::new();
    let space = ("xmlns:ssv", ssp.namespace("ParameterValues"));
    let common = ("xmlns:ssc", ssp.namespace("Common"));
    write(&mut xml, ssp, &[space, common], name, values);
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
