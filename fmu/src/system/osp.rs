//! The wired system for libcosim (Open Simulation Platform).

use super::{NAMES, STEP, connections};
use crate::ship::{CONTROLLER, VEHICLE};
use crate::xml::{Xml, number};

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
