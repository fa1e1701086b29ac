//! `SystemStructure.ssd`: the wired system in SSP 1.0 and 2.0.

use super::parameters::{Value, values};
use super::{NAMES, STEP, STOP, connections};
use crate::controller::ControllerFmu;
use crate::description::Description;
use crate::model::FmuModel;
use crate::ship::{CONTROLLER, VEHICLE};
use crate::variable::{Role, Variable, VariableType};
use crate::vehicle::VehicleFmu;
use crate::xml::{self, Attribute, Xml, number};

/// No step is repeated, so nothing is compared with it.
const TOLERANCE: f64 = 1e-4;
/// What OMSimulator calls the loop over both models.
const SOLVER: &str = "exchange";

/// Version of the SSP standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ssp {
    /// SSP 1.0.
    V1,
    /// SSP 2.0, whose types are those of FMI 3.0.
    V2,
}

impl Ssp {
    pub(super) fn version(self) -> String {
        match self {
            Self::V1 => "1.0".to_owned(),
            Self::V2 => "2.0".to_owned(),
        }
    }

    /// The namespace of a part of the standard; SSP 2.0 kept those of SSP 1.0.
    pub(super) fn namespace(self, part: &str) -> String {
        format!("http://ssp-standard.org/SSP1/SystemStructure{part}")
    }

    /// Element of a real number, in the namespace with this prefix.
    pub(super) fn real(self, prefix: &str) -> &'static str {
        match (self, prefix) {
            (Self::V1, "ssv") => "ssv:Real",
            (Self::V1, _) => "ssc:Real",
            (Self::V2, "ssv") => "ssv:Float64",
            (Self::V2, _) => "ssc:Float64",
        }
    }
}

/// The description of the system.
pub(crate) fn ssd(ssp: Ssp) -> String {
    let mut xml = Xml::new();
    let s = |text: &str| text.to_owned();
    xml.open(
        "ssd:SystemStructureDescription",
        &[
            ("xmlns:ssd", ssp.namespace("Description")),
            ("xmlns:ssv", ssp.namespace("ParameterValues")),
            ("xmlns:ssc", ssp.namespace("Common")),
            ("version", ssp.version()),
            ("name", s("lmpc_race")),
        ],
    );
    xml.open("ssd:System", &[("name", s("race"))]);
    xml.open("ssd:Elements", &[]);
    component(&mut xml, ssp, NAMES[0], CONTROLLER, ControllerFmu::description());
    component(&mut xml, ssp, NAMES[1], VEHICLE, VehicleFmu::description());
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

fn component(xml: &mut Xml, ssp: Ssp, name: &str, file: &str, d: &Description) {
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
        connector(xml, ssp, variable);
    }
    xml.close("ssd:Connectors");
    xml.open("ssd:ParameterBindings", &[]);
    xml.open("ssd:ParameterBinding", &[]);
    xml.open("ssd:ParameterValues", &[]);
    let set = [("version", ssp.version()), ("name", "initialValues".to_owned())];
    values(xml, ssp, &set, &initial(d));
    xml.close("ssd:ParameterValues");
    xml.close("ssd:ParameterBinding");
    xml.close("ssd:ParameterBindings");
    open_modelica(xml, &[("name", SOLVER.to_owned())], |_| ());
    xml.close("ssd:Component");
}

fn connector(xml: &mut Xml, ssp: Ssp, variable: &Variable) {
    let kind = match variable.role {
        Role::Input => "input",
        role if role.output() => "output",
        _ => "parameter",
    };
    xml.open("ssd:Connector", &[("name", variable.name.clone()), ("kind", kind.to_owned())]);
    let unit = ("unit", variable.unit.map_or("", |u| u.name).to_owned());
    match (variable.kind, ssp) {
        (VariableType::Real, _) => xml.leaf(ssp.real("ssc"), &[unit]),
        (VariableType::Integer, Ssp::V1) => xml.leaf("ssc:Integer", &[]),
        (VariableType::Integer, Ssp::V2) => xml.leaf("ssc:Int32", &[]),
        (VariableType::Boolean, _) => xml.leaf("ssc:Boolean", &[]),
        (VariableType::Text, _) => xml.leaf("ssc:String", &[]),
    }
    xml.close("ssd:Connector");
}

/// The parameters a user of the wired system is most likely to change, with their start values.
fn initial(d: &Description) -> Vec<(String, Value)> {
    let wanted = ["param.track", "initial.v_x", "initial.e_y"];
    let variables = d.table.variables().iter();
    variables
        .filter(|v| wanted.contains(&v.name.as_str()))
        .map(|v| {
            let text = v.kind == VariableType::Text;
            let value = if text { Value::Text(v.text.clone()) } else { Value::Number(v.start) };
            (v.name.clone(), value)
        })
        .collect()
}
