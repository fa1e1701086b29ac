//! Looking into an FMU, ours or anyone's.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Node};
use zip::ZipArchive;

use crate::pack::PackError;

/// What is inside an FMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inspection {
    /// Attributes of the model description's root element, in order.
    pub attributes: Vec<(String, String)>,
    /// Names and sizes \[bytes\] of all files.
    pub files: Vec<(String, u64)>,
    /// The variables, in the order of the model description.
    pub variables: Vec<VariableRow>,
    /// The model description.
    pub model_description: String,
}

/// One variable as its model description has it; what is absent is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct VariableRow {
    /// Name.
    pub name: String,
    /// Value reference.
    pub value_reference: String,
    /// Data type, as the version calls it.
    pub kind: String,
    /// Causality; `local` if absent, as the standard has it.
    pub causality: String,
    /// Variability.
    pub variability: String,
    /// Unit, its own or that of its declared type.
    pub unit: String,
    /// Start value.
    pub start: String,
    /// Smallest value, its own or that of its declared type.
    pub min: String,
    /// Largest value, its own or that of its declared type.
    pub max: String,
    /// What it is.
    pub description: String,
    /// Sizes of an array of FMI 3.0, as at the start; none for a scalar.
    pub dimensions: Vec<usize>,
}

/// Looks into an FMU of either version.
///
/// # Errors
/// [`PackError`] if the file cannot be read or holds no model description.
pub fn inspect(path: &Path) -> Result<Inspection, PackError> {
    let file_error = |source| PackError::File { path: path.to_owned(), source };
    let zip_error = |source| PackError::Zip { path: path.to_owned(), source };
    let mut archive = ZipArchive::new(File::open(path).map_err(file_error)?).map_err(zip_error)?;
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let file = archive.by_index(i).map_err(zip_error)?;
        files.push((file.name().to_owned(), file.size()));
    }
    let mut model_description = String::new();
    let mut member = archive.by_name("modelDescription.xml").map_err(zip_error)?;
    member.read_to_string(&mut model_description).map_err(file_error)?;
    let unclear = |reason| PackError::Description { path: path.to_owned(), reason };
    let document = Document::parse(&model_description).map_err(|e| unclear(e.to_string()))?;
    let root = document.root_element();
    if !root.has_tag_name("fmiModelDescription") {
        let found = root.tag_name().name();
        return Err(unclear(format!("root element {found}, expected fmiModelDescription")));
    }
    let attributes = root.attributes().map(|a| (a.name().to_owned(), a.value().to_owned()));
    let (attributes, variables) = (attributes.collect(), variables(root));
    Ok(Inspection { attributes, files, variables, model_description })
}

fn variables(root: Node<'_, '_>) -> Vec<VariableRow> {
    let child = |name: &str| root.children().find(|n| n.has_tag_name(name));
    let types = child("TypeDefinitions");
    let all = child("ModelVariables").into_iter().flat_map(|n| n.children());
    let mut rows: Vec<VariableRow> =
        all.clone().filter(Node::is_element).map(|n| row(n, types)).collect();
    // A size may be that of a structural parameter.
    for (i, variable) in all.filter(Node::is_element).enumerate() {
        let sizes = variable.children().filter(|n| n.has_tag_name("Dimension")).map(|size| {
            let named = size.attribute("valueReference");
            let of = |row: &&VariableRow| Some(row.value_reference.as_str()) == named;
            let start = rows.iter().find(of).map(|row| row.start.as_str());
            size.attribute("start").or(start).and_then(|start| start.parse().ok()).unwrap_or(0)
        });
        rows[i].dimensions = sizes.collect();
    }
    rows
}

fn row(variable: Node<'_, '_>, types: Option<Node<'_, '_>>) -> VariableRow {
    // FMI 2.0 keeps the type in a child; in FMI 3.0 the element is the type.
    let value = if variable.has_tag_name("ScalarVariable") {
        variable.first_element_child().unwrap_or(variable)
    } else {
        variable
    };
    let declared = value.attribute("declaredType").and_then(|name| {
        let mut all = types.into_iter().flat_map(|n| n.children());
        let own = all.find(|n| n.attribute("name") == Some(name))?;
        // Again: a child in FMI 2.0, the element itself in FMI 3.0.
        Some(if own.has_tag_name("SimpleType") { own.first_element_child()? } else { own })
    });
    let of = |node: Node<'_, '_>, key: &str| node.attribute(key).unwrap_or("").to_owned();
    let inherited = |key: &str| {
        let found = value.attribute(key).or_else(|| declared.and_then(|d| d.attribute(key)));
        found.unwrap_or("").to_owned()
    };
    // A text of FMI 3.0 starts in a child.
    let text = value.children().find(|n| n.has_tag_name("Start")).map(|n| of(n, "value"));
    let causality = variable.attribute("causality").unwrap_or("local").to_owned();
    VariableRow {
        name: of(variable, "name"),
        value_reference: of(variable, "valueReference"),
        kind: value.tag_name().name().to_owned(),
        causality,
        variability: of(variable, "variability"),
        unit: inherited("unit"),
        start: text.unwrap_or_else(|| of(value, "start")),
        min: inherited("min"),
        max: inherited("max"),
        description: of(variable, "description"),
        dimensions: Vec::new(),
    }
}
