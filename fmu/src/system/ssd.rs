//! `SystemStructure.ssd`: the wired system in SSP 1.0 and 2.0.
//!
//! OMSimulator 3 wants identifiers as names of the description, the system and its components, and
//! its master algorithm in an annotation of the system.

use super::parameters::{built_in, write};
use super::{NAMES, STEP, STOP, connections};
use crate::controller::ControllerFmu;
use crate::description::Description;
use crate::model::Model;
use crate::ship::{CONTROLLER, VEHICLE};
use crate::variable::{Kind, Role, Variable};
use crate::vehicle::VehicleFmu;
use crate::xml::{self, Xml, number};

/// Version of the SSP standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ssp {
    /// SSP 1.0.
    V1,
    /// SSP 2.0, whose types are those of FMI 3.0.
    V2,
}

impl Ssp {
    pub(super) fn version(self) -> &'static str {
        match self {
            Self::V1 => "1.0",
            Self::V2 => "2.0",
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

/// What OMSimulator keeps its annotations in.
const OMS: &str =
    "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";

/// The description of the system.
pub(crate) fn ssd(ssp: Ssp) -> String {
    let mut xml = Xml::new();
    xml.open(
        "ssd:SystemStructureDescription",
        &[
            ("xmlns:ssd", ssp.namespace("Description")),
            ("xmlns:ssv", ssp.namespace("ParameterValues")),
            ("xmlns:ssc", ssp.namespace("Common")),
            ("xmlns:oms", OMS.to_owned()),
            ("version", ssp.version().to_owned()),
            ("name", "lmpc_race".to_owned()),
        ],
    );
    system(&mut xml, ssp);
    units(&mut xml);
    xml.leaf("ssd:DefaultExperiment", &[("startTime", number(0.0)), ("stopTime", number(STOP))]);
    xml.close("ssd:SystemStructureDescription");
    xml.finish()
}

fn system(xml: &mut Xml, ssp: Ssp) {
    xml.open("ssd:System", &[("name", "race".to_owned())]);
    xml.open("ssd:Elements", &[]);
    component(xml, ssp, NAMES[0], CONTROLLER, ControllerFmu::description());
    component(xml, ssp, NAMES[1], VEHICLE, VehicleFmu::description());
    xml.close("ssd:Elements");
    xml.open("ssd:Connections", &[]);
    for (from, to, names) in connections() {
        for name in names {
            xml.leaf(
                "ssd:Connection",
                &[
                    ("startElement", from.to_owned()),
                    ("startConnector", name.clone()),
                    ("endElement", to.to_owned()),
                    ("endConnector", name),
                ],
            );
        }
    }
    xml.close("ssd:Connections");
    xml.open("ssd:Annotations", &[]);
    xml.open("ssc:Annotation", &[("type", "org.openmodelica".to_owned())]);
    xml.open("oms:Annotations", &[]);
    xml.open("oms:SimulationInformation", &[]);
    xml.leaf(
        "oms:FixedStepMaster",
        &[("description", "oms-ma".to_owned()), ("stepSize", number(STEP))],
    );
    xml.close("oms:SimulationInformation");
    xml.close("oms:Annotations");
    xml.close("ssc:Annotation");
    xml.close("ssd:Annotations");
    xml.close("ssd:System");
}

/// Every unit a connector names.
fn units(xml: &mut Xml) {
    let both = [ControllerFmu::description(), VehicleFmu::description()];
    let all = xml::units(both.iter().flat_map(|d| d.table.variables()));
    xml.open("ssd:Units", &[]);
    for unit in all.values() {
        xml.open("ssc:Unit", &[("name", unit.name.to_owned())]);
        xml.leaf("ssc:BaseUnit", &xml::base_unit(unit));
        xml.close("ssc:Unit");
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
    write(xml, ssp, &[], "initialValues", &built_in(d));
    xml.close("ssd:ParameterValues");
    xml.close("ssd:ParameterBinding");
    xml.close("ssd:ParameterBindings");
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
        (Kind::Real, _) => xml.leaf(ssp.real("ssc"), &[unit]),
        (Kind::Integer, Ssp::V1) => xml.leaf("ssc:Integer", &[]),
        (Kind::Integer, Ssp::V2) => xml.leaf("ssc:Int32", &[]),
        (Kind::Boolean, _) => xml.leaf("ssc:Boolean", &[]),
        (Kind::Text, _) => xml.leaf("ssc:String", &[]),
    }
    xml.close("ssd:Connector");
}
