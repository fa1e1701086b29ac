//! The values behind the variables.

use crate::table::{Boolean, Integer, Real, Text, VariableTable};

/// Current values of all variables. Numbers and truth values share one vector, so that copying
/// it before a step and putting it back after a failed one costs next to nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableValues {
    pub(crate) numbers: Vec<f64>,
    pub(crate) texts: Vec<String>,
}

impl VariableValues {
    /// The start values of a table.
    #[must_use]
    pub fn start(table: &VariableTable) -> Self {
        let variables = table.variables();
        Self {
            numbers: variables.iter().map(|v| v.start).collect(),
            texts: variables.iter().map(|v| v.text.clone()).collect(),
        }
    }

    /// Value of a real variable.
    #[must_use]
    pub fn real(&self, slot: Real) -> f64 {
        self.numbers[slot.0]
    }

    /// Value of an integer variable.
    #[must_use]
    pub fn integer(&self, slot: Integer) -> i32 {
        // Every i32 is exact in f64 and only i32 values are ever stored here.
        self.numbers[slot.0] as i32
    }

    /// Value of a truth value.
    #[must_use]
    pub fn boolean(&self, slot: Boolean) -> bool {
        self.numbers[slot.0] != 0.0
    }

    /// Value of a text.
    #[must_use]
    pub fn text(&self, slot: Text) -> &str {
        &self.texts[slot.0]
    }

    /// Sets a real variable; meant for outputs.
    pub fn set_real(&mut self, slot: Real, value: f64) {
        self.numbers[slot.0] = value;
    }

    /// Sets an integer variable.
    pub fn set_integer(&mut self, slot: Integer, value: i32) {
        self.numbers[slot.0] = f64::from(value);
    }

    /// Sets a truth value.
    pub fn set_boolean(&mut self, slot: Boolean, value: bool) {
        self.numbers[slot.0] = f64::from(u8::from(value));
    }
}
