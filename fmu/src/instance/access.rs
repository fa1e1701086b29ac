//! Reading and writing variables, with every check the standards ask for.

use std::ffi::CString;

use super::{Instance, Phase};
use crate::model::FmuModel;
use crate::status::CallError;
use crate::variable::{Role, Variable, VariableType};

/// A C type that carries numbers or truth values.
pub(crate) trait Element: Copy {
    const KIND: VariableType;
    fn from_number(number: f64) -> Self;
    fn to_number(self) -> f64;
}

impl Element for f64 {
    const KIND: VariableType = VariableType::Real;
    fn from_number(number: f64) -> Self {
        number
    }
    fn to_number(self) -> f64 {
        self
    }
}

impl Element for i32 {
    const KIND: VariableType = VariableType::Integer;
    fn from_number(number: f64) -> Self {
        number as Self
    }
    fn to_number(self) -> f64 {
        f64::from(self)
    }
}

/// `fmi2Boolean`, an int that is false if and only if it is zero.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Boolean2(pub(crate) i32);

impl Element for Boolean2 {
    const KIND: VariableType = VariableType::Boolean;
    fn from_number(number: f64) -> Self {
        Self(i32::from(number != 0.0))
    }
    fn to_number(self) -> f64 {
        f64::from(self.0 != 0)
    }
}

/// `fmi3Boolean`, a C bool taken as a byte because a host may pass any bits.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Boolean3(pub(crate) u8);

impl Element for Boolean3 {
    const KIND: VariableType = VariableType::Boolean;
    fn from_number(number: f64) -> Self {
        Self(u8::from(number != 0.0))
    }
    fn to_number(self) -> f64 {
        f64::from(u8::from(self.0 != 0))
    }
}

impl<M: FmuModel> Instance<M> {
    /// Reads variables. Either all are written to `out` or none.
    pub(crate) fn get<T: Element>(
        &mut self,
        function: &str,
        references: &[u32],
        out: &mut [T],
    ) -> Result<(), CallError> {
        self.check_get(function, T::KIND, references)?;
        for (value, reference) in out.iter_mut().zip(references) {
            *value = T::from_number(match *reference {
                0 => self.core.time,
                other => self.core.values.numbers[other as usize],
            });
        }
        Ok(())
    }

    /// Reads texts; the pointers stay valid until the same variable is read again.
    pub(crate) fn get_texts(
        &mut self,
        function: &str,
        references: &[u32],
        out: &mut [*const std::ffi::c_char],
    ) -> Result<(), CallError> {
        self.check_get(function, VariableType::Text, references)?;
        for (value, reference) in out.iter_mut().zip(references) {
            let at = *reference as usize;
            let text = CString::new(self.core.values.texts[at].as_str()).unwrap_or_default();
            // A text read twice in one call must keep its first pointer.
            let kept = self.texts.entry(at).or_insert_with(|| text.clone());
            if *kept != text {
                *kept = text;
            }
            *value = kept.as_ptr();
        }
        Ok(())
    }

    /// Writes variables. Either all are set or none.
    pub(crate) fn set<T: Element>(
        &mut self,
        function: &str,
        references: &[u32],
        values: &[T],
    ) -> Result<(), CallError> {
        self.allow_set(function)?;
        for (reference, value) in references.iter().zip(values) {
            let variable = self.check_set(function, T::KIND, *reference)?;
            check_value(function, variable, value.to_number())?;
        }
        for (reference, value) in references.iter().zip(values) {
            self.core.values.numbers[*reference as usize] = value.to_number();
        }
        self.after_set(references);
        Ok(())
    }

    /// Writes texts. Either all are set or none.
    pub(crate) fn set_texts(
        &mut self,
        function: &str,
        references: &[u32],
        values: &[String],
    ) -> Result<(), CallError> {
        self.allow_set(function)?;
        for reference in references {
            self.check_set(function, VariableType::Text, *reference)?;
        }
        for (reference, value) in references.iter().zip(values) {
            self.core.values.texts[*reference as usize].clone_from(value);
        }
        self.after_set(references);
        Ok(())
    }

    fn check_get(
        &mut self,
        function: &str,
        kind: VariableType,
        references: &[u32],
    ) -> Result<(), CallError> {
        if self.core.phase == Phase::Dead {
            self.allow(function, &[])?;
        }
        let mut computed = false;
        for reference in references {
            let variable = find::<M>(function, kind, *reference)?;
            computed |= variable.role.output();
        }
        if computed && self.core.phase == Phase::Instantiated {
            return Err(CallError::Refused(format!(
                "{function}: outputs have no value before the initialisation mode"
            )));
        }
        if computed && self.core.phase == Phase::Initialization {
            self.ensure_model()?;
        }
        Ok(())
    }

    fn allow_set(&self, function: &str) -> Result<(), CallError> {
        self.allow(function, &[Phase::Instantiated, Phase::Initialization, Phase::Stepping])
    }

    fn check_set(
        &self,
        function: &str,
        kind: VariableType,
        reference: u32,
    ) -> Result<&'static Variable, CallError> {
        let variable = find::<M>(function, kind, reference)?;
        let name = &variable.name;
        if !variable.role.settable() {
            return Err(CallError::Refused(format!(
                "{function}: '{name}' is not for the host to set"
            )));
        }
        if self.core.phase == Phase::Stepping && variable.role == Role::Fixed {
            return Err(CallError::Refused(format!(
                "{function}: the fixed parameter '{name}' cannot change after initialisation"
            )));
        }
        Ok(variable)
    }

    /// Before the first step the model follows from the parameters, so a new one makes it stale.
    fn after_set(&mut self, references: &[u32]) {
        let variables = M::description().table.variables();
        let parameter = |r: &u32| variables[*r as usize].role.parameter();
        if self.core.phase != Phase::Stepping && references.iter().any(parameter) {
            self.model = None;
        }
    }
}

/// The variable of a value reference, if it has the type the function is for.
fn find<M: FmuModel>(
    function: &str,
    kind: VariableType,
    reference: u32,
) -> Result<&'static Variable, CallError> {
    let variables = M::description().table.variables();
    let Some(variable) = variables.get(reference as usize) else {
        return Err(CallError::Refused(format!(
            "{function}: unknown value reference {reference}; the last one is {}",
            variables.len() - 1
        )));
    };
    if variable.kind == kind {
        return Ok(variable);
    }
    let (name, found) = (&variable.name, variable.kind);
    Err(CallError::Refused(format!(
        "{function}: '{name}' (value reference {reference}) is of type {found:?}, not {kind:?}"
    )))
}

/// Parameters must lie in their range. Inputs only must be finite: a model saturates its inputs
/// and a loop must not break because a neighbour overshoots by a rounding error.
fn check_value(function: &str, variable: &Variable, value: f64) -> Result<(), CallError> {
    let name = &variable.name;
    if !value.is_finite() {
        return Err(CallError::Refused(format!("{function}: '{name}' cannot be {value}")));
    }
    let (min, max) =
        (variable.min.unwrap_or(f64::NEG_INFINITY), variable.max.unwrap_or(f64::INFINITY));
    if variable.role.parameter() && !(min..=max).contains(&value) {
        return Err(CallError::Refused(format!(
            "{function}: '{name}' = {value} is outside [{min}, {max}]"
        )));
    }
    Ok(())
}
