//! `terminalsAndIcons.xml` of FMI 3.0.

use super::Xml;
use crate::description::Description;

pub(crate) fn terminals_and_icons(d: &Description) -> String {
    let mut xml = Xml::new();
    xml.open("fmiTerminalsAndIcons", &[("fmiVersion", "3.0".to_owned())]);
    xml.open("Terminals", &[]);
    for terminal in &d.terminals {
        xml.open(
            "Terminal",
            &[
                ("name", terminal.name.to_owned()),
                ("matchingRule", "plug".to_owned()),
                ("description", terminal.description.to_owned()),
            ],
        );
        for (member, variable) in &terminal.members {
            xml.leaf(
                "TerminalMemberVariable",
                &[
                    ("variableName", variable.clone()),
                    ("memberName", (*member).to_owned()),
                    ("variableKind", "signal".to_owned()),
                ],
            );
        }
        xml.close("Terminal");
    }
    xml.close("Terminals");
    xml.close("fmiTerminalsAndIcons");
    xml.finish()
}
