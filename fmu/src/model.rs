//! What a model must be able to do to become an FMU.

use std::path::Path;

use crate::description::Description;
use crate::log::CallLog;
use crate::status::CallError;
use crate::values::VariableValues;

/// What the core hands a model during a call.
#[derive(Debug)]
pub struct Io<'a> {
    /// All variables; the model reads inputs and parameters and writes outputs.
    pub values: &'a mut VariableValues,
    /// Folder of the unpacked resources, if the host named one.
    pub resources: Option<&'a Path>,
    /// Messages for the host.
    pub log: &'a mut CallLog,
}

/// One communication step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommunicationStep {
    /// Start of the simulation \[s\].
    pub origin: f64,
    /// Time at the beginning of the step \[s\].
    pub begin: f64,
    /// Length of the step, positive and finite \[s\].
    pub size: f64,
}

impl CommunicationStep {
    /// Time at the end of the step \[s\].
    #[must_use]
    pub fn end(&self) -> f64 {
        self.begin + self.size
    }
}

/// A model behind the FMI interfaces.
pub trait FmuModel: Send + Sized + 'static {
    /// Everything that changes while the model runs. Taking an FMU state clones it, so large
    /// data that seldom changes belongs behind an `Arc`.
    type State: Clone + Send + 'static;

    /// Names, units and texts; built once per process.
    fn description() -> &'static Description;

    /// Builds the model from the parameters and writes the initial outputs. Called when
    /// initialisation ends, and before if the host reads an output during it.
    ///
    /// # Errors
    /// [`CallError::Failed`] with the reason, naming parameter and value.
    fn start(io: &mut Io<'_>) -> Result<Self, CallError>;

    /// Writes into the parameters what is in force: what a preset, a file or a name stands for, and
    /// what a number left alone became. Called once, when initialisation has ended.
    fn in_force(&mut self, _values: &mut VariableValues) {}

    /// Moves from the beginning to the end of a step and writes the outputs of its end.
    ///
    /// # Errors
    /// [`CallError::Discard`] if a smaller step may succeed (the model must then be unchanged);
    /// [`CallError::Failed`] if the model cannot go on.
    fn step(&mut self, io: &mut Io<'_>, step: &CommunicationStep) -> Result<(), CallError>;

    /// The simulation ends.
    fn end(&mut self, _io: &mut Io<'_>) {}

    /// The state now.
    fn state(&self) -> Self::State;

    /// Goes on from a state of a model started with the same fixed parameters, bit for bit.
    ///
    /// # Errors
    /// [`CallError::Refused`] if the state belongs to something else; nothing is changed then.
    fn resume(&mut self, state: &Self::State) -> Result<(), CallError>;

    /// A state as bytes.
    ///
    /// # Errors
    /// [`CallError::Refused`] if it cannot be written.
    fn save(state: &Self::State) -> Result<Vec<u8>, CallError>;

    /// Reads what [`FmuModel::save`] wrote.
    ///
    /// # Errors
    /// [`CallError::Refused`] with the reason.
    fn load(bytes: &[u8]) -> Result<Self::State, CallError>;
}
