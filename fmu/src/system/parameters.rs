//! Parameter sets that put a car on a track, as files (SSV).

use controller::{Config, Preset};
use vehicle_model::{CarParams, Track};

use super::{NAMES, Ssp};
use crate::xml::{Attribute, Xml, number};

/// A car and a track it fits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParameterSet {
    pub(crate) car: &'static str,
    track: &'static str,
}

/// The parameter sets that ship.
pub(crate) const SETS: [ParameterSet; 3] = [
    ParameterSet { car: "barc", track: "l" },
    ParameterSet { car: "kart", track: "road_course" },
    ParameterSet { car: "iac", track: "road_course" },
];

impl ParameterSet {
    /// The car starts at the speed of the controller's initial laps [m/s].
    fn speed(&self) -> f64 {
        let (car, track) = (CarParams::builtin(self.car), Track::builtin(self.track));
        let config = match (&car, &track) {
            (Ok(car), Some(track)) => Config::derived(Preset::Race, car, track),
            _ => Config::default(),
        };
        config.warm_up.speed
    }
}

/// A parameter's value.
pub(super) enum Value {
    Number(f64),
    Text(String),
}

/// Whom a parameter set is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    /// Both, as elements of the wired system.
    System,
    /// The controller's FMU alone.
    Controller,
    /// The vehicle's FMU alone.
    Vehicle,
}

/// `NAME.ssv`: an external parameter set that puts a car on a track.
pub(crate) fn ssv(ssp: Ssp, set: &ParameterSet, element: Element) -> String {
    let text = |text: &str| Value::Text(text.to_owned());
    let [controller, vehicle] = match element {
        Element::System => NAMES.map(|name| format!("{name}.")),
        _ => [String::new(), String::new()],
    };
    let mut all = Vec::new();
    let prefixes = [(Element::Controller, &controller), (Element::Vehicle, &vehicle)];
    for (_, prefix) in prefixes.iter().filter(|(of, _)| [*of, Element::System].contains(&element)) {
        all.push((format!("{prefix}param.track"), text(set.track)));
        all.push((format!("{prefix}param.car"), text(set.car)));
    }
    if element != Element::Controller {
        all.push((format!("{vehicle}initial.v_x"), Value::Number(set.speed())));
    }
    let attributes = [
        ("xmlns:ssv", ssp.namespace("ParameterValues")),
        ("xmlns:ssc", ssp.namespace("Common")),
        ("version", ssp.version()),
        ("name", set.car.to_owned()),
    ];
    let mut xml = Xml::new();
    values(&mut xml, ssp, &attributes, &all);
    xml.finish()
}

/// A parameter set with these attributes.
pub(super) fn values(xml: &mut Xml, ssp: Ssp, set: &[Attribute], all: &[(String, Value)]) {
    xml.open("ssv:ParameterSet", set);
    xml.open("ssv:Parameters", &[]);
    for (name, value) in all {
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
