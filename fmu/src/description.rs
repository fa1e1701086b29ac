//! Everything a model description says beside the variables.

use std::sync::OnceLock;

use crate::checksum;
use crate::table::VariableTable;
use crate::xml;

/// A group of variables to be connected as one plug (FMI 3.0 terminal).
#[derive(Clone, Debug)]
pub struct Terminal {
    /// Name of the terminal.
    pub name: &'static str,
    /// What it connects to.
    pub description: &'static str,
    /// Member name (equal on both sides of a connection) and variable name.
    pub members: Vec<(&'static str, String)>,
}

impl Terminal {
    /// What controller and vehicle connect by: `command` and `state`, each described from this side.
    #[must_use]
    pub fn pair(command: &'static str, state: &'static str) -> Vec<Self> {
        let of = |group: &str, names: &[&'static str]| {
            names.iter().map(|&name| (name, format!("{group}.{name}"))).collect()
        };
        let measured = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y", "x", "y", "psi"];
        vec![
            Self { name: "command", description: command, members: of("cmd", &["a", "delta"]) },
            Self { name: "state", description: state, members: of("vehicle", &measured) },
        ]
    }
}

/// Which version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

/// A file packed into `resources/`.
#[derive(Clone, Copy, Debug)]
pub struct Resource {
    /// File name below `resources/`.
    pub name: &'static str,
    /// Contents.
    pub bytes: &'static [u8],
}

/// Identity, variables and documents of a model.
#[derive(Debug)]
pub struct Description {
    /// Name shown to the user.
    pub model_name: &'static str,
    /// Name of the shared library; a C identifier.
    pub model_identifier: &'static str,
    /// What the model is, in one sentence.
    pub description: &'static str,
    /// Version of the model.
    pub version: &'static str,
    /// Proposed end of a simulation \[s\].
    pub stop_time: f64,
    /// Proposed communication step \[s\].
    pub step_size: f64,
    /// The variables.
    pub table: VariableTable,
    /// Groups to be connected as one.
    pub terminals: Vec<Terminal>,
    /// Files for `resources/`.
    pub resources: Vec<Resource>,
    /// The documentation page (HTML).
    pub documentation: &'static str,
    /// The icon (PNG); left out if empty.
    pub icon: &'static [u8],
    /// Filled at first use.
    pub token: OnceLock<String>,
}

impl Description {
    /// What both of our FMUs say, with these variables; names, terminals and documents are empty.
    pub(crate) fn shipped(table: VariableTable) -> Self {
        Self {
            model_name: "",
            model_identifier: "",
            description: "",
            version: env!("CARGO_PKG_VERSION"),
            stop_time: 60.0,
            step_size: 0.1,
            table,
            terminals: Vec::new(),
            resources: crate::documents::RESOURCES.to_vec(),
            documentation: "",
            icon: &[],
            token: OnceLock::new(),
        }
    }

    /// GUID (FMI 2.0) and instantiation token (FMI 3.0): a hash of the sources and of what names
    /// the variables. So description, library and saved states of different builds cannot be mixed
    /// up. No number is in it: what a machine makes of a number must not decide whether a library
    /// starts.
    #[must_use]
    pub fn token(&self) -> &str {
        self.token.get_or_init(|| {
            let mut text = format!("{} {}\n", self.model_identifier, self.version);
            for v in self.table.variables() {
                let unit = v.unit.map_or("", |u| u.name);
                text.push_str(&format!("{} {:?} {:?} {unit} {}\n", v.name, v.kind, v.role, v.text));
            }
            text.push_str(env!("LMPC_FMU_SOURCES"));
            checksum::guid(text.as_bytes())
        })
    }

    /// The file `modelDescription.xml` for a version of the standard.
    #[must_use]
    pub fn model_description(&self, version: Version) -> String {
        match version {
            Version::Fmi2 => xml::fmi2::model_description(self, self.token()),
            Version::Fmi3 => xml::fmi3::model_description(self, self.token()),
        }
    }

    /// The file `terminalsAndIcons.xml` of FMI 3.0, if the model has terminals.
    #[must_use]
    pub fn terminals_and_icons(&self) -> Option<String> {
        (!self.terminals.is_empty()).then(|| xml::terminals::terminals_and_icons(self))
    }
}
