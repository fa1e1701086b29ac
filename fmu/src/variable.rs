//! One variable of a model description.

use crate::unit::Unit;

/// Data type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableType {
    /// Double precision number: `Real` in FMI 2.0, `Float64` in FMI 3.0.
    Real,
    /// Signed 32-bit number: `Integer` in FMI 2.0, `Int32` in FMI 3.0.
    Integer,
    /// Truth value.
    Boolean,
    /// UTF-8 text.
    Text,
}

/// Who sets a variable, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The simulation time.
    Time,
    /// Set by the host until initialisation ends.
    Fixed,
    /// Set by the host before any step.
    Tunable,
    /// Set by the host before any step, from another model's output.
    Input,
    /// Computed by the model, constant between its internal steps.
    Discrete,
    /// Computed by the model, a continuous quantity.
    Output,
}

impl Role {
    /// Whether the host may set the variable at all.
    #[must_use]
    pub fn settable(self) -> bool {
        matches!(self, Self::Fixed | Self::Tunable | Self::Input)
    }

    /// Whether the variable is a parameter.
    #[must_use]
    pub fn parameter(self) -> bool {
        matches!(self, Self::Fixed | Self::Tunable)
    }

    /// Whether the model computes the variable.
    #[must_use]
    pub fn output(self) -> bool {
        matches!(self, Self::Discrete | Self::Output)
    }
}

/// One variable: everything the model description says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Structured name, for example `vehicle.v_x`.
    pub name: String,
    /// What it is, in one sentence.
    pub description: String,
    /// Data type.
    pub kind: VariableType,
    /// Causality and variability.
    pub role: Role,
    /// Unit of a real variable.
    pub unit: Option<Unit>,
    /// Start value; truth values are 0 or 1.
    pub start: f64,
    /// Start value of a text.
    pub text: String,
    /// Smallest meaningful value.
    pub min: Option<f64>,
    /// Largest meaningful value.
    pub max: Option<f64>,
    /// Usual magnitude.
    pub nominal: Option<f64>,
}

impl Variable {
    fn new(name: &str, kind: VariableType, role: Role, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            description: description.to_owned(),
            kind,
            role,
            unit: None,
            start: 0.0,
            text: String::new(),
            min: None,
            max: None,
            nominal: None,
        }
    }

    /// A real variable with its unit.
    #[must_use]
    pub fn real(name: &str, role: Role, unit: Unit, description: &str) -> Self {
        Self { unit: Some(unit), ..Self::new(name, VariableType::Real, role, description) }
    }

    /// An integer variable.
    #[must_use]
    pub fn integer(name: &str, role: Role, description: &str) -> Self {
        Self::new(name, VariableType::Integer, role, description)
    }

    /// A truth value.
    #[must_use]
    pub fn boolean(name: &str, role: Role, description: &str) -> Self {
        Self::new(name, VariableType::Boolean, role, description)
    }

    /// A text with its start value.
    #[must_use]
    pub fn text(name: &str, role: Role, start: &str, description: &str) -> Self {
        Self { text: start.to_owned(), ..Self::new(name, VariableType::Text, role, description) }
    }

    /// Sets the start value.
    #[must_use]
    pub fn start(self, start: f64) -> Self {
        Self { start, ..self }
    }

    /// Sets the smallest and largest value.
    #[must_use]
    pub fn range(self, min: f64, max: f64) -> Self {
        Self { min: Some(min), max: Some(max), ..self }
    }

    /// Sets the smallest value alone.
    #[must_use]
    pub fn at_least(self, min: f64) -> Self {
        Self { min: Some(min), ..self }
    }

    /// Sets the usual magnitude.
    #[must_use]
    pub fn nominal(self, nominal: f64) -> Self {
        Self { nominal: Some(nominal), ..self }
    }
}
