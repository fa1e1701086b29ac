//! Controller and vehicle wired to each other: as SSP and as OSP system structure.
//!
//! Both FMUs name the signals between them alike, so every connection is from a name to itself.

use controller::{Config, Preset};
use vehicle_model::{CarParams, Track};

use crate::controller::ControllerFmu;
use crate::description::Description;
use crate::model::Model;
use crate::ship::{CONTROLLER, VEHICLE};
use crate::variable::{Kind, Role, Variable};
use crate::vehicle::VehicleFmu;
use crate::xml::{self, Attribute, Xml, number};

/// Communication step of the system in parallel exchange [s]. Each exchange delays a signal by
/// one step, so it is a tenth of the controller's period.
const STEP: f64 = 0.01;
const STOP: f64 = 60.0;
/// No step is repeated, so nothing is compared with it.
const TOLERANCE: f64 = 1e-4;
/// What OMSimulator calls the loop over both models.
const SOLVER: &str = "exchange";
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

/// `SystemStructure.ssd`, SSP 1.0.
pub(crate) fn ssd() -> String {
    let mut xml = Xml::new();
    let s = |text: &str| text.to_owned();
    xml.open(
        "ssd:SystemStructureDescription",
        &[
            ("xmlns:ssd", s("http://ssp-standard.org/SSP1/SystemStructureDescription")),
            ("xmlns:ssv", s("http://ssp-standard.org/SSP1/SystemStructureParameterValues")),
            ("xmlns:ssc", s("http://ssp-standard.org/SSP1/SystemStructureCommon")),
            ("version", s("1.0")),
            ("name", s("lmpc_race")),
        ],
    );
    xml.open("ssd:System", &[("name", s("race"))]);
    xml.open("ssd:Elements", &[]);
    component(&mut xml, NAMES[0], CONTROLLER, ControllerFmu::description());
    component(&mut xml, NAMES[1], VEHICLE, VehicleFmu::description());
    xml.close("ssd:Elements");
    xml.open("ssd:Connections", &[]);
    for (from, to, names) in connections() {
        for name in names {
            xml.leaf(
                "ssd:Connection",
                &[
                    ("startElement", s(from)),
                    ("startConnector", name.clone()),
                    ("endElement", s(to)),
                    ("endConnector", name),
                ],
            );
        }
    }
    xml.close("ssd:Connections");
    // OMSimulator 3 reads the attributes, OMSimulator 2 the element within.
    let solver = [
        ("name", s(SOLVER)),
        ("method", s("oms_ma")),
        ("fixedStepSize", number(STEP)),
        ("initialStepSize", number(STEP)),
        ("minimumStepSize", number(STEP)),
        ("maximumStepSize", number(STEP)),
        ("relativeTolerance", number(TOLERANCE)),
    ];
    open_modelica(&mut xml, &solver, |xml| {
        let master = ("description", s("oms-ma"));
        let tolerance = ("relativeTolerance", number(TOLERANCE));
        xml.leaf("oms:FixedStepMaster", &[master, ("stepSize", number(STEP)), tolerance]);
    });
    xml.close("ssd:System");
    units(&mut xml);
    xml.open("ssd:DefaultExperiment", &[("startTime", number(0.0)), ("stopTime", number(STOP))]);
    let result = [
        ("resultFile", s("lmpc_race.csv")),
        ("loggingInterval", number(0.0)),
        ("bufferSize", s("10")),
    ];
    open_modelica(&mut xml, &result, |_| ());
    xml.close("ssd:DefaultExperiment");
    xml.close("ssd:SystemStructureDescription");
    xml.finish()
}

/// What OMSimulator alone reads, for the element around it.
fn open_modelica(xml: &mut Xml, information: &[Attribute], inside: impl FnOnce(&mut Xml)) {
    xml.open("ssd:Annotations", &[]);
    xml.open("ssc:Annotation", &[("type", "org.openmodelica".to_owned())]);
    let schema = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
    xml.open("oms:Annotations", &[("xmlns:oms", schema.to_owned())]);
    xml.open("oms:SimulationInformation", information);
    inside(xml);
    xml.close("oms:SimulationInformation");
    xml.close("oms:Annotations");
    xml.close("ssc:Annotation");
    xml.close("ssd:Annotations");
}

/// Every unit of either model.
fn units(xml: &mut Xml) {
    let mut all = xml::units(ControllerFmu::description());
    all.extend(xml::units(VehicleFmu::description()));
    xml.open("ssd:Units", &[]);
    for unit in all.values() {
        xml::unit_definition(xml, unit, ["ssc:Unit", "ssc:BaseUnit"]);
    }
    xml.close("ssd:Units");
}

fn component(xml: &mut Xml, name: &str, file: &str, d: &Description) {
    xml.open(
        "ssd:Component",
        &[
            ("name", name.to_owned()),
            ("type", "application/x-fmu-sharedlibrary".to_owned()),
            ("source", format!("resources/{file}")),
            ("implementation", "CoSimulation".to_owned()),
        ],
    );
    xml.open("ssd:Connectors", &[]);
    let connected = |v: &&Variable| v.role.output() || v.role.settable();
    for variable in d.table.variables().iter().filter(connected) {
        let kind = match variable.role {
            Role::Input => "input",
            role if role.output() => "output",
            _ => "parameter",
        };
        xml.open("ssd:Connector", &[("name", variable.name.clone()), ("kind", kind.to_owned())]);
        let unit = ("unit", variable.unit.map_or("", |u| u.name).to_owned());
        match variable.kind {
            Kind::Real => xml.leaf("ssc:Real", &[unit]),
            Kind::Integer => xml.leaf("ssc:Integer", &[]),
            Kind::Boolean => xml.leaf("ssc:Boolean", &[]),
            Kind::Text => xml.leaf("ssc:String", &[]),
        }
        xml.close("ssd:Connector");
    }
    xml.close("ssd:Connectors");
    xml.open("ssd:ParameterBindings", &[]);
    xml.open("ssd:ParameterBinding", &[]);
    xml.open("ssd:ParameterValues", &[]);
    let set = [("version", "1.0".to_owned()), ("name", "initialValues".to_owned())];
    xml.open("ssv:ParameterSet", &set);
    xml.open("ssv:Parameters", &[]);
    for (name, value) in parameters(d) {
        xml.open("ssv:Parameter", &[("name", name)]);
        match value {
            Value::Number(value) => xml.leaf("ssv:Real", &[("value", number(value))]),
            Value::Text(value) => xml.leaf("ssv:String", &[("value", value)]),
        }
        xml.close("ssv:Parameter");
    }
    xml.close("ssv:Parameters");
    xml.close("ssv:ParameterSet");
    xml.close("ssd:ParameterValues");
    xml.close("ssd:ParameterBinding");
    xml.close("ssd:ParameterBindings");
    open_modelica(xml, &[("name", SOLVER.to_owned())], |_| ());
    xml.close("ssd:Component");
}

/// `NAME.ssv`, SSP 1.0: an external parameter set for the wired system that puts a car on a track.
pub(crate) fn ssv(set: &ParameterSet) -> String {
    let mut xml = Xml::new();
    let s = |text: &str| text.to_owned();
    xml.open(
        "ssv:ParameterSet",
        &[
            ("xmlns:ssv", s("http://ssp-standard.org/SSP1/SystemStructureParameterValues")),
            ("xmlns:ssc", s("http://ssp-standard.org/SSP1/SystemStructureCommon")),
            ("version", s("1.0")),
            ("name", s(set.car)),
        ],
    );
    xml.open("ssv:Parameters", &[]);
    let [controller, vehicle] = NAMES;
    let mut parameter = |element: &str, name: &str, kind: &str, value: String| {
        xml.open("ssv:Parameter", &[("name", format!("{element}.{name}"))]);
        xml.leaf(kind, &[("value", value)]);
        xml.close("ssv:Parameter");
    };
    for element in [controller, vehicle] {
        parameter(element, "param.track", "ssv:String", s(set.track));
        parameter(element, "param.car", "ssv:String", s(set.car));
    }
    parameter(vehicle, "initial.v_x", "ssv:Real", number(set.speed()));
    xml.close("ssv:Parameters");
    xml.close("ssv:ParameterSet");
    xml.finish()
}

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

enum Value {
    Number(f64),
    Text(String),
}

/// The parameters a user of the wired system is most likely to change, with their start values.
fn parameters(d: &Description) -> Vec<(String, Value)> {
    let wanted = ["param.track", "initial.v_x", "initial.e_y"];
    let variables = d.table.variables().iter();
    variables
        .filter(|v| wanted.contains(&v.name.as_str()))
        .map(|v| {
            let text = v.kind == Kind::Text;
            let value = if text { Value::Text(v.text.clone()) } else { Value::Number(v.start) };
            (v.name.clone(), value)
        })
        .collect()
}

/// `OspSystemStructure.xml` for libcosim, with the FMUs in `folder`.
pub(crate) fn osp_structure(folder: &str) -> String {
    let mut xml = Xml::new();
    xml.open(
        "OspSystemStructure",
        &[
            ("xmlns", "http://opensimulationplatform.com/MSMI/OSPSystemStructure".to_owned()),
            ("version", "0.1".to_owned()),
        ],
    );
    xml.raw(&format!("<BaseStepSize>{}</BaseStepSize>", number(STEP)));
    xml.raw("<Algorithm>fixedStep</Algorithm>");
    xml.open("Simulators", &[]);
    for (name, file) in NAMES.iter().zip([CONTROLLER, VEHICLE]) {
        let source = ("source", format!("{folder}/{file}"));
        xml.leaf("Simulator", &[("name", (*name).to_owned()), source, ("stepSize", number(STEP))]);
    }
    xml.close("Simulators");
    xml.open("Connections", &[]);
    for (from, to, names) in connections() {
        for name in names {
            xml.open("VariableConnection", &[]);
            for end in [from, to] {
                let simulator = ("simulator", end.to_owned());
                xml.leaf("Variable", &[simulator, ("name", name.clone())]);
            }
            xml.close("VariableConnection");
        }
    }
    xml.close("Connections");
    xml.close("OspSystemStructure");
    xml.finish()
}
