//! Descriptions cut down to what the `fmi` crate reads of them.
//!
//! Its parser refuses legal FMI 3.0 descriptions: units, nominal values, quantities. It needs the
//! version, the token and the library's name alone, so it is given these alone; variables we
//! read ourselves.

use roxmltree::{Document, Node};

/// The description without variables, units and types.
///
/// # Errors
/// In words, if it is no XML or no co-simulation.
pub(super) fn reduce(description: &str) -> Result<String, String> {
    let document = Document::parse(description).map_err(|e| e.to_string())?;
    let root = document.root_element();
    let simulation = root
        .children()
        .find(|n| n.has_tag_name("CoSimulation"))
        .ok_or("it offers no co-simulation (model exchange alone cannot be driven)")?;
    let identifier = simulation.attribute("modelIdentifier").unwrap_or("");
    let head = ["fmiVersion", "modelName", "guid", "instantiationToken"];
    let head: String = head.iter().filter_map(|key| attribute(root, key)).collect();
    let simulation = format!("<CoSimulation modelIdentifier=\"{}\"/>", escape(identifier));
    let rest = "<ModelVariables/><ModelStructure/>";
    Ok(format!("<fmiModelDescription{head}>{simulation}{rest}</fmiModelDescription>"))
}

fn attribute(node: Node<'_, '_>, key: &str) -> Option<String> {
    node.attribute(key).map(|value| format!(" {key}=\"{}\"", escape(value)))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi::schema::fmi3::Fmi3ModelDescription;
    use fmi::schema::traits::FmiModelDescription as _;

    const LEGAL: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="a &amp; b"
        instantiationToken="{&quot;1&quot;}"><CoSimulation modelIdentifier="car"/><ModelVariables>
        <Float64 name="v" valueReference="1" causality="output" unit="km/h" displayUnit="mph"
        quantity="Velocity" nominal="10" unbounded="true" relativeQuantity="true"/>
        </ModelVariables><ModelStructure/></fmiModelDescription>"#;

    #[test]
    fn what_the_crate_refuses_it_reads_when_reduced() {
        assert!(Fmi3ModelDescription::deserialize(LEGAL).is_err(), "no need to reduce any more");
        let read = Fmi3ModelDescription::deserialize(&reduce(LEGAL).unwrap()).unwrap();
        assert_eq!(read.model_name, "a & b");
        assert_eq!(read.instantiation_token, "{\"1\"}");
        assert_eq!(read.co_simulation.unwrap().model_identifier, "car");
    }

    #[test]
    fn model_exchange_alone_is_refused_in_words() {
        let text = LEGAL.replace("CoSimulation", "ModelExchange");
        assert!(reduce(&text).unwrap_err().contains("co-simulation"));
    }
}
