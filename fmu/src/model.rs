//! What a model must be able to do to become an FMU.

use std::path::Path;

use crate::description::Description;
use crate::log::Log;
use crate::status::Fault;
use crate::values::Values;

/// What the core hands a model during a call.
#[derive(Debug)]
pub struct Io<'a> {
    /// All variables; the model reads inputs and parameters and writes outputs.
    pub values: &'a mut Values,
    /// Folder of the unpacked resources, if the host named one.
    pub resources: Option<&'a Path>,
    /// Messages for the host.
    pub log: &'a mut Log,
}

/// One communication step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Start of the simulation \[s\].
    pub origin: f64,
    /// Time at the beginning of the step \[s\].
    pub begin: f64,
    /// Length of the step, positive and finite \[s\].
    pub size: f64,
}

impl Step {
    /// Time at the end of the step \[s\].
    #[must_use]
    pub fn end(&self) -> f64 {
        self.begin + self.size
    }
}

/// A model behind the FMI interfaces.
pub trait Model: Send + Sized + 'static {
    /// Everything that changes while the model runs. Taking an FMU state clones it, so large
    /// data that seldom changes belongs behind an `Arc`.
    type State: Clone + Send + 'static;

    /// Names, units and texts; built once per process.
    fn description() -> &'static Description;

    /// Builds the model from the parameters and writes the initial outputs. Called when
    /// initialisation ends, and before if the host reads an output during it.
    ///
    /// # Errors
    /// [`Fault::Failed`] with the reason, naming parameter and value.
    fn start(io: &mut Io<'_>) -> Result<Self, Fault>;

    /// Writes into the parameters what is in force: what a preset, a file or a name stands for, and
    /// what a number left alone became. Called once, when initialisation has ended.
    fn in_force(&mut self, _values: &mut Values) {}

    /// Moves from the beginning to the end of a step and writes the outputs of its end.
    ///
    /// # Errors
    /// [`Fault::Discard`] if a smaller step may succeed (the model must then be unchanged);
    /// [`Fault::Failed`] if the model cannot go on.
    fn step(&mut self, io: &mut Io<'_>, step: &Step) -> Result<(), Fault>;

    /// The simulation ends.
    fn end(&mut self, _io: &mut Io<'_>) {}

    /// The state now.
    fn state(&self) -> Self::State;

    /// Goes on from a state of a model started with the same fixed parameters, bit for bit.
    ///
    /// # Errors
    /// [`Fault::Refused`] if the state belongs to something else; nothing is changed then.
    fn resume(&mut self, state: &Self::State) -> Result<(), Fault>;

    /// A state as bytes.
    ///
    /// # Errors
    /// [`Fault::Refused`] if it cannot be written.
    fn save(state: &Self::State) -> Result<Vec<u8>, Fault>;

    /// Reads what [`Model::save`] wrote.
    ///
    /// # Errors
    /// [`Fault::Refused`] with the reason.
    fn load(bytes: &[u8]) -> Result<Self::State, Fault>;
}
