//! The variable table: names for the host, typed slots for the model.

use crate::unit;
use crate::variable::{Role, Variable, VariableType};

/// Place of a real variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Real(pub(crate) usize);
/// Place of an integer variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Integer(pub(crate) usize);
/// Place of a truth value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boolean(pub(crate) usize);
/// Place of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text(pub(crate) usize);

/// All variables of a model; a variable's value reference is its place in the table. Place 0 is
/// the simulation time, which FMI 3.0 importers read as an ordinary variable.
#[derive(Clone, Debug)]
pub struct VariableTable {
    variables: Vec<Variable>,
}

impl Default for VariableTable {
    fn default() -> Self {
        Self::new()
    }
}

impl VariableTable {
    /// A table that holds only `time`.
    #[must_use]
    pub fn new() -> Self {
        let time = Variable::real("time", Role::Time, unit::S, "Simulation time");
        Self { variables: vec![time] }
    }

    /// The variables, by value reference.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Appends a real variable.
    pub fn real(&mut self, name: &str, role: Role, unit: unit::Unit, text: &str) -> Real {
        self.add_real(Variable::real(name, role, unit, text))
    }

    /// Appends a real variable that was built with its range and start.
    pub fn add_real(&mut self, variable: Variable) -> Real {
        Real(self.push(variable, VariableType::Real))
    }

    /// Appends an integer variable.
    pub fn add_integer(&mut self, variable: Variable) -> Integer {
        Integer(self.push(variable, VariableType::Integer))
    }

    /// Appends a truth value.
    pub fn add_boolean(&mut self, variable: Variable) -> Boolean {
        Boolean(self.push(variable, VariableType::Boolean))
    }

    /// Appends a text.
    pub fn add_text(&mut self, variable: Variable) -> Text {
        Text(self.push(variable, VariableType::Text))
    }

    /// Sets smallest and largest values by name; an infinite one leaves the unit's extent.
    pub fn bound(&mut self, bounds: &[(&str, f64, f64)]) {
        let finite = |x: f64| x.is_finite().then_some(x);
        for variable in &mut self.variables {
            if let Some((_, min, max)) = bounds.iter().find(|row| row.0 == variable.name) {
                variable.min = finite(*min).or(variable.min);
                variable.max = finite(*max).or(variable.max);
            }
        }
    }

    fn push(&mut self, variable: Variable, kind: VariableType) -> usize {
        // What nothing else bounds is bounded by what is possible in its unit.
        let extent = variable.unit.map(|unit| unit.extent);
        let (min, max) = (variable.min.or(extent.map(|x| -x)), variable.max.or(extent));
        // The kind is what the caller's slot type promises, so it wins.
        self.variables.push(Variable { kind, min, max, ..variable });
        self.variables.len() - 1
    }
}
